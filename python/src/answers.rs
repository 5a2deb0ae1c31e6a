//! Results of distance and penetration queries.

use crate::batch::Answers;
use pyo3::prelude::*;
use simdop::query::{Distance, Penetration};

/// The distance of two bodies at one pose, or at each of n poses.
///
/// For one pose all attributes are numbers and arrays of the shape (3,); for n poses they have one more dimension.
#[pyclass(frozen, name = "Distance", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyDistance(Answers<Found>);

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

impl From<Answers<Distance>> for PyDistance {
    fn from(distances: Answers<Distance>) -> Self {
        Self(distances.map(Found::from))
    }
}

#[pymethods]
impl PyDistance {
    /// Lower bound, in the bodies' unit. Infinite if a body is empty; the cutoff or more if the bodies are farther
    /// apart than that.
    #[getter]
    fn lower(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.lower)
    }

    /// Upper bound: the distance of the two points. Zero if and only if the bodies meet. Infinite without points.
    #[getter]
    fn upper(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.upper)
    }

    /// The closest point of A, in the frame of B. NaN if a body is empty or farther away than the cutoff.
    #[getter]
    fn point_a(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.a)
    }

    /// The closest point of B, in its frame.
    #[getter]
    fn point_b(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.b)
    }

    /// Index of A's closest primitive; -1 without one.
    #[getter]
    fn index_a(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.pair[0])
    }

    /// Index of B's closest primitive.
    #[getter]
    fn index_b(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.pair[1])
    }

    fn __len__(&self) -> PyResult<usize> {
        self.0.len("distance")
    }

    /// The upper bound.
    fn __float__(&self) -> PyResult<f64> {
        self.0.float("the distances at several poses are no float: see Distance.upper", |found| found.upper)
    }

    fn __repr__(&self) -> String {
        match &self.0 {
            Answers::One(Found { lower, upper, a, b, pair }) => {
                let [p, q] = pair;
                format!("Distance({lower} ..= {upper}, from {a:?} to {b:?}, primitives {p} and {q})")
            }
            Answers::Many(found) => {
                let least = found.iter().map(|found| found.upper).fold(f64::INFINITY, f64::min);
                format!("Distance(at {} poses, least {least})", found.len())
            }
        }
    }
}

/// The volume that two bodies of spheres have in common, at one pose or at each of n poses.
///
/// For one pose all attributes are numbers and arrays of the shape (3,); for n poses they have one more dimension.
#[pyclass(frozen, name = "Penetration", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyPenetration(pub(crate) Answers<Penetration>);

#[pymethods]
impl PyPenetration {
    /// The common volume, in the bodies' unit cubed, summed over all pairs of spheres.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.volume)
    }

    /// The direction in which A is pushed, in the frame of B. Its length is 1 if all pairs of spheres have the same
    /// direction.
    #[getter]
    fn direction(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.direction)
    }

    /// The centroid of the common volume, in the frame of B. NaN if there is none.
    #[getter]
    fn point(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.point.unwrap_or([f64::NAN; 3]))
    }

    /// Number of pairs of spheres that meet.
    #[getter]
    fn pairs(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.pairs)
    }

    fn __repr__(&self) -> String {
        match &self.0 {
            Answers::One(Penetration { volume, direction, pairs, .. }) => {
                format!("Penetration(volume {volume}, direction {direction:?}, {pairs} pairs of spheres)")
            }
            Answers::Many(found) => {
                let most = found.iter().map(|found| found.volume).fold(0.0, f64::max);
                format!("Penetration(at {} poses, greatest volume {most})", found.len())
            }
        }
    }
}
