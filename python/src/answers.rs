//! What distance and penetration queries return.

use crate::arrays::{array, table};
use pyo3::prelude::*;
use simdop::query::{Distance, Penetration};

/// The distance of two bodies at one pose, or at each of n poses.
///
/// Of one pose all attributes are numbers and arrays of the shape (3,); of n poses there is one more dimension.
#[pyclass(frozen, name = "Distance", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyDistance {
    found: Vec<Found>,
    is_one: bool,
}

#[derive(Copy, Clone, Debug)]
struct Found {
    lower: f64,
    upper: f64,
    a: [f64; 3],
    b: [f64; 3],
    pair: [i64; 2],
}

impl From<Distance> for Found {
    fn from(distance: Distance) -> Self {
        let witness = distance.witness;
        Self {
            lower: distance.lower,
            upper: distance.upper,
            a: witness.map_or([f64::NAN; 3], |witness| witness.a),
            b: witness.map_or([f64::NAN; 3], |witness| witness.b),
            pair: witness.map_or([-1; 2], |witness| [witness.pair.a.into(), witness.pair.b.into()]),
        }
    }
}

impl PyDistance {
    pub(crate) fn one(distance: Distance) -> Self {
        Self { found: vec![distance.into()], is_one: true }
    }

    pub(crate) fn many(distances: Vec<Distance>) -> Self {
        Self { found: distances.into_iter().map(Found::from).collect(), is_one: false }
    }

    /// A number, or an array of them.
    fn numbers(&self, py: Python<'_>, number: impl Fn(&Found) -> f64) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(number(&self.found[0]).into_pyobject(py)?.into_any().unbind());
        }
        Ok(array(py, self.found.iter().map(number).collect()).into_any().unbind())
    }

    /// A point, or an array of them.
    fn points(&self, py: Python<'_>, point: impl Fn(&Found) -> [f64; 3]) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(array(py, point(&self.found[0]).to_vec()).into_any().unbind());
        }
        Ok(table(py, self.found.iter().map(point).collect())?.into_any().unbind())
    }

    fn indices(&self, py: Python<'_>, which: usize) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(self.found[0].pair[which].into_pyobject(py)?.into_any().unbind());
        }
        Ok(array(py, self.found.iter().map(|found| found.pair[which]).collect()).into_any().unbind())
    }
}

#[pymethods]
impl PyDistance {
    /// Lower bound, in the bodies' unit. Infinite if a body is empty; at least the cutoff beyond it.
    #[getter]
    fn lower(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.numbers(py, |found| found.lower)
    }

    /// Upper bound: the distance of the two points. Zero if and only if the bodies meet. Infinite without points.
    #[getter]
    fn upper(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.numbers(py, |found| found.upper)
    }

    /// The closest point of A, in the frame of B. NaN if a body is empty or farther away than the cutoff.
    #[getter]
    fn point_a(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.points(py, |found| found.a)
    }

    /// The closest point of B, in its frame.
    #[getter]
    fn point_b(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.points(py, |found| found.b)
    }

    /// Index of A's closest primitive; -1 without one.
    #[getter]
    fn index_a(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.indices(py, 0)
    }

    /// Index of B's closest primitive.
    #[getter]
    fn index_b(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.indices(py, 1)
    }

    fn __len__(&self) -> PyResult<usize> {
        if self.is_one {
            return Err(pyo3::exceptions::PyTypeError::new_err("the distance at one pose has no length"));
        }
        Ok(self.found.len())
    }

    /// The upper bound.
    fn __float__(&self) -> PyResult<f64> {
        if self.is_one {
            return Ok(self.found[0].upper);
        }
        Err(pyo3::exceptions::PyTypeError::new_err(
            "the distances at several poses are no float: see Distance.upper",
        ))
    }

    fn __repr__(&self) -> String {
        if self.is_one {
            let Found { lower, upper, a, b, pair } = self.found[0];
            return format!(
                "Distance({lower} ..= {upper}, from {a:?} to {b:?}, primitives {} and {})",
                pair[0], pair[1]
            );
        }
        let least = self.found.iter().map(|found| found.upper).fold(f64::INFINITY, f64::min);
        format!("Distance(at {} poses, least {least})", self.found.len())
    }
}

/// The volume that two bodies of spheres have in common, at one pose or at each of n poses.
///
/// Of one pose all attributes are numbers and arrays of the shape (3,); of n poses there is one more dimension.
#[pyclass(frozen, name = "Penetration", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyPenetration {
    found: Vec<Penetration>,
    is_one: bool,
}

impl PyPenetration {
    pub(crate) const fn new(found: Vec<Penetration>, is_one: bool) -> Self {
        Self { found, is_one }
    }

    fn points(&self, py: Python<'_>, point: impl Fn(&Penetration) -> [f64; 3]) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(array(py, point(&self.found[0]).to_vec()).into_any().unbind());
        }
        Ok(table(py, self.found.iter().map(point).collect())?.into_any().unbind())
    }
}

#[pymethods]
impl PyPenetration {
    /// The common volume, in the bodies' unit cubed, summed over all pairs of spheres.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(self.found[0].volume.into_pyobject(py)?.into_any().unbind());
        }
        Ok(array(py, self.found.iter().map(|found| found.volume).collect()).into_any().unbind())
    }

    /// The direction in which A is pushed, in the frame of B. Its length is 1 if all pairs of spheres agree.
    #[getter]
    fn direction(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.points(py, |found| found.direction)
    }

    /// The middle of the common volume, in the frame of B. NaN if there is none.
    #[getter]
    fn point(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.points(py, |found| found.point.unwrap_or([f64::NAN; 3]))
    }

    /// Number of pairs of spheres that meet.
    #[getter]
    fn pairs(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        if self.is_one {
            return Ok(self.found[0].pairs.into_pyobject(py)?.into_any().unbind());
        }
        Ok(array(py, self.found.iter().map(|found| found.pairs).collect()).into_any().unbind())
    }

    fn __repr__(&self) -> String {
        if self.is_one {
            let Penetration { volume, direction, pairs, .. } = self.found[0];
            return format!(
                "Penetration(volume {volume}, direction {direction:?}, {pairs} pairs of spheres)"
            );
        }
        let most = self.found.iter().map(|found| found.volume).fold(0.0, f64::max);
        format!("Penetration(at {} poses, greatest volume {most})", self.found.len())
    }
}
