//! One pose or many, on one thread or several, without the interpreter's lock.

use crate::arrays::{Poses, array, table};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use simdop::Pose;

/// The answer for one pose, or those for many.
#[derive(Debug)]
pub(crate) enum Answers<T> {
    One(T),
    Many(Vec<T>),
}

impl<T> Answers<T> {
    pub(crate) fn map<U>(self, of: impl Fn(T) -> U) -> Answers<U> {
        match self {
            Self::One(found) => Answers::One(of(found)),
            Self::Many(found) => Answers::Many(found.into_iter().map(of).collect()),
        }
    }

    /// A number or a truth value, or an array of them.
    pub(crate) fn values<V: numpy::Element + for<'py> IntoPyObject<'py>>(
        &self,
        py: Python<'_>,
        value: impl Fn(&T) -> V,
    ) -> PyResult<Py<PyAny>> {
        match self {
            Self::One(found) => value(found).into_py_any(py),
            Self::Many(found) => Ok(array(py, found.iter().map(value).collect()).into_any().unbind()),
        }
    }

    /// K numbers, or an array of them.
    pub(crate) fn rows<const K: usize>(
        &self,
        py: Python<'_>,
        row: impl Fn(&T) -> [f64; K],
    ) -> PyResult<Py<PyAny>> {
        match self {
            Self::One(found) => Ok(array(py, row(found).to_vec()).into_any().unbind()),
            Self::Many(found) => Ok(table(py, found.iter().map(row).collect())?.into_any().unbind()),
        }
    }

    /// Number of answers for many poses.
    pub(crate) fn len(&self, what: &str) -> PyResult<usize> {
        match self {
            Self::One(_) => Err(PyTypeError::new_err(format!("the {what} at one pose has no length"))),
            Self::Many(found) => Ok(found.len()),
        }
    }

    /// A number for one pose; `otherwise` is the error text for many.
    pub(crate) fn float(&self, otherwise: &'static str, number: impl Fn(&T) -> f64) -> PyResult<f64> {
        match self {
            Self::One(found) => Ok(number(found)),
            Self::Many(_) => Err(PyTypeError::new_err(otherwise)),
        }
    }
}

/// Fewer poses are not worth a thread.
const LEAST_SHARE: usize = 16;

/// The number of threads for a user's request: 0 stands for all cores.
fn threads(asked: usize) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    if asked == 0 { cores() } else { asked }
}

/// The answer for each pose, in order; or the first error.
pub(crate) fn each<T: Send>(
    py: Python<'_>,
    poses: &Poses,
    asked: usize,
    ask: impl Fn(&Pose) -> PyResult<T> + Sync,
) -> PyResult<Answers<T>> {
    match poses {
        Poses::One(pose) => Ok(Answers::One(py.detach(|| ask(pose))?)),
        Poses::Many(poses) => Ok(Answers::Many(py.detach(|| all(poses, asked, &ask))?)),
    }
}

/// The results for all items, in order; or the first error.
pub(crate) fn all<I: Sync, T: Send>(
    items: &[I],
    asked: usize,
    ask: &(impl Fn(&I) -> PyResult<T> + Sync),
) -> PyResult<Vec<T>> {
    all_with(items, asked, &|| (), &|(), item| ask(item))
}

/// As `all`, with memory that each thread allocates once.
pub(crate) fn all_with<I: Sync, T: Send, M>(
    items: &[I],
    asked: usize,
    memory: &(impl Fn() -> M + Sync),
    ask: &(impl Fn(&mut M, &I) -> PyResult<T> + Sync),
) -> PyResult<Vec<T>> {
    let run = move |items: &[I]| {
        let mut memory = memory();
        items.iter().map(|item| ask(&mut memory, item)).collect::<PyResult<Vec<T>>>()
    };
    let threads = threads(asked).min(items.len().div_ceil(LEAST_SHARE));
    if threads <= 1 {
        return run(items);
    }
    let share = items.len().div_ceil(threads);
    std::thread::scope(|scope| {
        let shares: Vec<_> = items.chunks(share).map(|items| scope.spawn(move || run(items))).collect();
        let mut results = Vec::with_capacity(items.len());
        for share in shares {
            results.extend(share.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
        }
        Ok(results)
    })
}
