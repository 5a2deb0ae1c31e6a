//! Arrays of numpy, checked and converted.
//!
//! Numbers of any type, order and alignment are accepted; contiguous rows of the right type are read in place. The
//! input of a query is copied first, since the query releases the interpreter's lock, and other threads may write to
//! the array.

use crate::error::{OrRaise, named, raise_as, raised};
use numpy::{
    Element, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use simdop::Pose;

/// A row of `[R|t]`, and the whole matrix.
type Matrix = [f64; 16];

/// The array of an argument in C order, aligned and with elements of type `T`; converted if necessary.
///
/// `kinds` are numpy's letters of the element types that may be converted.
fn in_rows<'py, T: Element>(
    given: &Bound<'py, PyAny>,
    name: &str,
    kinds: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    if let Ok(array) = given.cast::<PyArrayDyn<T>>()
        && array.is_c_contiguous()
        && array.data().is_aligned()
    {
        return Ok(array.try_readonly()?);
    }
    let numpy = given.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (given,))?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    let is_empty = array.getattr("size")?.extract::<usize>()? == 0;
    let is_number = kinds.contains(&kind) || is_empty && kind == "f";
    if !is_number {
        let wanted = if kinds.contains('f') { "numbers" } else { "integers" };
        return Err(PyTypeError::new_err(format!("{name} must be {wanted}, not an array of {dtype}")));
    }
    let options = PyDict::new(given.py());
    options.set_item("dtype", T::get_dtype(given.py()))?;
    options.set_item("requirements", ["C", "A"])?;
    let array = numpy.call_method("require", (array,), Some(&options))?;
    Ok(array.cast_into::<PyArrayDyn<T>>()?.try_readonly()?)
}

fn shape_error(name: &str, wanted: &str, shape: &[usize]) -> PyErr {
    let shape: Vec<_> = shape.iter().map(usize::to_string).collect();
    raise_as::<raised::ArrayError>(format!("{name} must have the shape {wanted}, not ({})", shape.join(", ")))
}

/// An array of N rows of K numbers, copied.
pub(crate) fn rows<const K: usize>(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; K]>> {
    let array = in_rows::<f64>(given, name, "fiub")?;
    check_rows(array.shape(), K, name)?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

/// As [`rows`], in single precision.
pub(crate) fn single_rows<const K: usize>(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f32; K]>> {
    let array = in_rows::<f32>(given, name, "fiub")?;
    check_rows(array.shape(), K, name)?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

fn check_rows(shape: &[usize], k: usize, name: &str) -> PyResult<()> {
    match *shape {
        [_, columns] if columns == k => Ok(()),
        // An empty list has no second dimension.
        [0] => Ok(()),
        _ => Err(shape_error(name, &format!("(n, {k})"), shape)),
    }
}

/// An array of N numbers, copied.
pub(crate) fn vector(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let array = in_rows::<f64>(given, name, "fiub")?;
    if array.ndim() != 1 {
        return Err(shape_error(name, "(n,)", array.shape()));
    }
    Ok(array.as_slice()?.to_vec())
}

/// An array of N rows of `columns` numbers, copied.
pub(crate) fn rows_of(given: &Bound<'_, PyAny>, columns: usize, name: &str) -> PyResult<Vec<Vec<f64>>> {
    let array = in_rows::<f64>(given, name, "fiub")?;
    check_rows(array.shape(), columns, name)?;
    let numbers = array.as_slice()?;
    // Rows without columns are rows, too.
    let count = array.shape()[0];
    Ok((0..count).map(|row| numbers[row * columns..(row + 1) * columns].to_vec()).collect())
}

/// K numbers.
pub(crate) fn numbers<const K: usize>(given: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; K]> {
    let array = in_rows::<f64>(given, name, "fiub")?;
    match array.as_slice()?.try_into() {
        Ok(numbers) if array.ndim() == 1 => Ok(numbers),
        _ => Err(shape_error(name, &format!("({K},)"), array.shape())),
    }
}

/// An array of N triangles, three indices each.
pub(crate) fn triangles(given: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[u32; 3]>> {
    if let Ok(array) = given.cast::<PyArrayDyn<u32>>()
        && array.is_c_contiguous()
        && array.data().is_aligned()
    {
        check_rows(array.shape(), 3, name)?;
        return Ok(array.try_readonly()?.as_slice()?.as_chunks().0.to_vec());
    }
    let array = in_rows::<i64>(given, name, "iu")?;
    check_rows(array.shape(), 3, name)?;
    let index = |&i: &i64| {
        u32::try_from(i).map_err(|_| {
            raise_as::<raised::ArrayError>(format!(
                "{name} must be indices of vertices, from 0 to 2^32 - 1, not {i}"
            ))
        })
    };
    let indices: Vec<u32> = array.as_slice()?.iter().map(index).collect::<PyResult<_>>()?;
    Ok(indices.as_chunks().0.to_vec())
}

/// One pose, or many.
pub(crate) enum Poses {
    One(Pose),
    Many(Vec<Pose>),
}

/// Poses from an array of the shape (4, 4) or (n, 4, 4); the identity if there is none.
pub(crate) fn poses(given: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Poses> {
    let Some(given) = given else { return Ok(Poses::One(Pose::IDENTITY)) };
    let array = in_rows::<f64>(given, name, "fiub")?;
    let matrices = array.as_slice()?.as_chunks::<16>().0;
    match *array.shape() {
        [4, 4] => Ok(Poses::One(pose_of(&matrices[0])?)),
        [_, 4, 4] => {
            let mut poses = Vec::with_capacity(matrices.len());
            for (i, matrix) in matrices.iter().enumerate() {
                poses.push(
                    pose_of(matrix).map_err(|error| named(given.py(), &error, &format!("{name}[{i}]")))?,
                );
            }
            Ok(Poses::Many(poses))
        }
        [0] => Ok(Poses::Many(Vec::new())),
        _ => Err(shape_error(name, "(4, 4) or (n, 4, 4)", array.shape())),
    }
}

/// One pose from an array of the shape (4, 4); the identity if there is none.
pub(crate) fn pose(given: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Pose> {
    match poses(given, name)? {
        Poses::One(pose) => Ok(pose),
        Poses::Many(poses) => Err(shape_error(name, "(4, 4)", &[poses.len(), 4, 4])),
    }
}

fn pose_of(matrix: &Matrix) -> PyResult<Pose> {
    let [x, y, z, last] = [0, 4, 8, 12].map(|i| [matrix[i], matrix[i + 1], matrix[i + 2], matrix[i + 3]]);
    if last != [0.0, 0.0, 0.0, 1.0] {
        let message = format!(
            "the last row of a pose must be 0 0 0 1, not {} {} {} {}",
            last[0], last[1], last[2], last[3]
        );
        return Err(raise_as::<raised::PoseError>(message));
    }
    Pose::from_rows([x, y, z]).or_raise()
}

/// A 4x4 matrix.
pub(crate) fn matrix<'py>(py: Python<'py>, pose: &Pose) -> Bound<'py, PyArray2<f64>> {
    let (rows, t) = (pose.rows(), pose.translation());
    let row = |i: usize| vec![rows[i][0], rows[i][1], rows[i][2], t[i]];
    let rows = [row(0), row(1), row(2), vec![0.0, 0.0, 0.0, 1.0]];
    PyArray2::from_vec2(py, &rows).unwrap_or_else(|_| unreachable!("all rows have four numbers"))
}

/// An array of the shape (n,), which takes over the memory.
pub(crate) fn array<T: Element>(py: Python<'_>, items: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, items)
}

/// An array of the shape (n, K).
pub(crate) fn table<T: Element + Copy, const K: usize>(
    py: Python<'_>,
    rows: Vec<[T; K]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, K])
}
