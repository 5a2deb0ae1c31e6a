//! Penetration depths and signed distances of two bodies.

use crate::arrays::{numbers, poses};
use crate::batch::{Answers, each};
use crate::body::PyBody;
use crate::pair;
use pyo3::prelude::*;
use simdop::query::{Completion, DepthInterval, SignedDistance};

/// The penetration depth of two bodies, at one pose or at each of n poses: the length of the shortest translation that
/// separates them, which lies in ``lower`` to ``upper``.
///
/// For one pose all attributes are numbers and arrays of the shape (3,); for n poses they have one more dimension.
#[pyclass(frozen, name = "Depth", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyDepth(Answers<DepthInterval>);

#[pymethods]
impl PyDepth {
    /// Lower bound, in the bodies' unit: after every shorter translation the bodies meet. Zero if they are free, or if
    /// their interiors are unknown.
    #[getter]
    fn lower(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.lower)
    }

    /// Upper bound: the length of ``translation``. Zero if and only if the bodies are free. Infinite if no translation
    /// was found.
    #[getter]
    fn upper(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.upper)
    }

    /// After this translation of A, in the frame of B, the bodies are free, or touch up to rounding. Zeros if none was
    /// found.
    #[getter]
    fn translation(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.translation)
    }

    /// Whether the search was not cut short by the budget. The bounds are valid in either case.
    #[getter]
    fn is_complete(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.completion == Completion::Complete)
    }

    fn __len__(&self) -> PyResult<usize> {
        self.0.len("depth")
    }

    // A depth is never false.
    fn __bool__(&self) -> bool {
        true
    }

    /// The upper bound.
    fn __float__(&self) -> PyResult<f64> {
        self.0.float("the depth at several poses is no float", |found| found.upper)
    }

    fn __repr__(&self) -> String {
        match &self.0 {
            Answers::One(DepthInterval { lower, upper, translation, .. }) => {
                format!("Depth({lower} ..= {upper}, translation {translation:?})")
            }
            Answers::Many(found) => {
                let most = found.iter().map(|found| found.upper).fold(0.0, f64::max);
                format!("Depth(at {} poses, greatest {most})", found.len())
            }
        }
    }
}

/// The distance of two bodies, or minus their depth, at one pose or at each of n poses. It lies in ``lower`` to
/// ``upper``.
///
/// For one pose all attributes are numbers and arrays of the shape (3,) or (6,); for n poses they have one more
/// dimension.
#[pyclass(frozen, name = "SignedDistance", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PySignedDistance(Answers<SignedDistance>);

#[pymethods]
impl PySignedDistance {
    /// Lower bound, in the bodies' unit. If the bodies meet: minus the upper bound of their depth.
    #[getter]
    fn lower(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.lower)
    }

    /// Upper bound. If the bodies meet: minus the lower bound of their depth.
    #[getter]
    fn upper(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.values(py, |found| found.upper)
    }

    /// The unit vector along which a translation of A raises the distance the fastest, in the frame of B. Zeros if none
    /// is known.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.normal)
    }

    /// The point of A, in the frame of B: the nearest to B, or the last one in contact with B while A moves out along
    /// the normal.
    #[getter]
    fn point_a(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.a)
    }

    /// The point of B.
    #[getter]
    fn point_b(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.b)
    }

    /// The derivative with respect to the pose: three numbers for a translation of A along the axes of B, then three
    /// for a rotation of A about these axes, through the origin of B, per radian. If the bodies meet, it is that of
    /// ``lower``.
    #[getter]
    fn gradient(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.0.rows(py, |found| found.gradient)
    }

    fn __len__(&self) -> PyResult<usize> {
        self.0.len("signed distance")
    }

    // A distance is never false.
    fn __bool__(&self) -> bool {
        true
    }

    /// The upper bound of a distance. If the bodies meet: the lower bound, which is minus the length of a separating
    /// translation.
    fn __float__(&self) -> PyResult<f64> {
        self.0.float("the signed distance at several poses is no float", |found| {
            if found.upper > 0.0 { found.upper } else { found.lower }
        })
    }

    fn __repr__(&self) -> String {
        match &self.0 {
            Answers::One(SignedDistance { lower, upper, normal, .. }) => {
                format!("SignedDistance({lower} ..= {upper}, normal {normal:?})")
            }
            Answers::Many(found) => {
                let least = found.iter().map(|found| found.lower).fold(f64::INFINITY, f64::min);
                format!("SignedDistance(at {} poses, least {least})", found.len())
            }
        }
    }
}

#[pymethods]
impl PyBody {
    /// The penetration depth of this body, placed by ``pose`` in the frame of ``other``, in ``other``: bounds of the
    /// length of the shortest translation that separates them.
    ///
    /// For two shapes or hulls, and for a half-space and any body, it is known to rounding. For solid meshes, spheres
    /// and several shapes the bounds are certain: a translation after which the bodies are free, and the radius of a
    /// ball of translations after which they are not. The interior of a cloud is unknown, and so is that of a surface
    /// paired with a mesh: then the lower bound is 0.
    ///
    /// Parameters
    /// ----------
    /// other : Body
    /// pose : (4, 4) or (n, 4, 4) array, by default the identity
    /// budget : int, optional
    ///     The maximum number of visits, some 1,000 per millisecond. Without it, the search ends by itself.
    /// threads : int
    ///     For n poses; 0 for one per core.
    ///
    /// Raises
    /// ------
    /// ``BodyError`` for two clouds; ``ArrayError``, ``PoseError``, ``TypeError``
    #[pyo3(signature = (other, pose = None, *, budget = None, threads = 1))]
    fn depth(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        budget: Option<u64>,
        threads: usize,
    ) -> PyResult<PyDepth> {
        let poses = poses(pose, "pose")?;
        let query = pair::query_within(budget);
        let found = each(py, &poses, threads, |pose| pair::depth(&query, &self.0, &other.0, pose))?;
        Ok(PyDepth(found))
    }

    /// How far this body, placed by ``pose`` in the frame of ``other``, must move along ``direction``, (3,), until it
    /// no longer meets ``other``, however much farther it moves: a float, or for n poses an array of n.
    ///
    /// An upper bound, which exceeds the least such translation by at most about 2^-30 of it. Zero if the two do
    /// not meet, infinite if they do and the direction is zero.
    #[pyo3(signature = (other, direction, pose = None, *, threads = 1))]
    fn depth_along(
        &self,
        py: Python<'_>,
        other: &Self,
        direction: &Bound<'_, PyAny>,
        pose: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<Py<PyAny>> {
        let (poses, direction) = (poses(pose, "pose")?, numbers(direction, "direction")?);
        let (a, b) = (self.0.view(), other.0.view());
        let found = each(py, &poses, threads, |pose| pair::depth_along(&a, &b, pose, direction))?;
        found.values(py, |depth| *depth)
    }

    /// The distance from this body, placed by ``pose`` in the frame of ``other``, to ``other``, or minus their
    /// ``depth`` if they meet, with its derivative with respect to the pose.
    ///
    /// ``tolerance`` limits the gap between the bounds of a distance, or of the depth of hulls and shapes, relative to
    /// it; ``budget`` is that of ``depth``. Raises ``ToleranceError``, or as ``depth``.
    #[pyo3(signature = (other, pose = None, *, tolerance = 0.0, budget = None, threads = 1))]
    fn signed_distance(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        tolerance: f64,
        budget: Option<u64>,
        threads: usize,
    ) -> PyResult<PySignedDistance> {
        let poses = poses(pose, "pose")?;
        let query = pair::query_within(budget);
        let ask = |pose: &_| pair::signed_distance(&query, &self.0, &other.0, pose, tolerance);
        Ok(PySignedDistance(each(py, &poses, threads, ask)?))
    }
}
