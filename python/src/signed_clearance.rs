//! Signed clearances of scenes, with gradients with respect to the joints.

use crate::arrays::{array, matrix, rows_of, vector};
use crate::batch::all_with;
use crate::body::PyBody;
use crate::error::OrRaise;
use crate::geometry::Geometry;
use crate::pair::query_within;
use crate::planning::PyPlanningScene;
use crate::scene::PyScene;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use simdop::scene::SceneSignedDistance;

/// The least signed distance of two bodies of a scene: minus their depth where they meet.
#[pyclass(frozen, name = "SignedClearance", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PySignedClearance {
    found: SceneSignedDistance,
    gradient: Option<Vec<f64>>,
}

#[pymethods]
impl PySignedClearance {
    /// Lower bound, in the bodies' unit; the cutoff if no two bodies are nearer. If bodies meet: minus the upper bound
    /// of their depth.
    #[getter]
    const fn lower(&self) -> f64 {
        self.found.lower
    }

    /// Upper bound. If bodies meet: minus the lower bound of their depth. Infinite without bodies.
    #[getter]
    const fn upper(&self) -> f64 {
        self.found.upper
    }

    /// The numbers of the two bodies that penetrate each other the deepest, or of the nearest two if none meet; or
    /// None.
    #[getter]
    fn bodies(&self) -> Option<(u64, u64)> {
        self.found.witness.map(|witness| (witness.hit.a.to_bits(), witness.hit.b.to_bits()))
    }

    /// Their points in the world, without the bodies' radii, (3,) each, or None: the closest, or the last ones in
    /// contact while the first body moves out of the other along the normal.
    #[getter]
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn points<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
        self.found.witness.map(|witness| (array(py, witness.a.to_vec()), array(py, witness.b.to_vec())))
    }

    /// The unit vector in the world along which the first body moves out of the other, (3,), or None. Zeros if unknown.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.found.witness.map(|witness| array(py, witness.normal.to_vec()))
    }

    /// In a planning scene, the derivative of the signed distance with respect to each variable, (n,): zero without
    /// bodies. None in other scenes.
    #[getter]
    fn gradient<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gradient.as_ref().map(|gradient| array(py, gradient.clone()))
    }

    /// The upper bound of a distance; the lower bound if bodies meet.
    fn __float__(&self) -> f64 {
        value(&self.found)
    }

    fn __repr__(&self) -> String {
        let bounds = format!("{} ..= {}", self.found.lower, self.found.upper);
        match self.bodies() {
            Some((a, b)) => format!("SignedClearance({bounds}, bodies {a} and {b})"),
            None => format!("SignedClearance({bounds})"),
        }
    }
}

/// The number whose gradient is computed.
const fn value(found: &SceneSignedDistance) -> f64 {
    if found.upper > 0.0 { found.upper } else { found.lower }
}

#[pymethods]
impl PyScene {
    /// The least signed distance of any two tested bodies, up to ``cutoff``: the least distance, or if bodies meet,
    /// minus the greatest penetration depth. ``tolerance`` is that of ``Body.distance``, ``budget`` that of
    /// ``Body.depth``, for all pairs together.
    #[pyo3(signature = (*, tolerance = 0.0, cutoff = f64::INFINITY, budget = None))]
    fn signed_clearance(
        &self,
        py: Python<'_>,
        tolerance: f64,
        cutoff: f64,
        budget: Option<u64>,
    ) -> PyResult<PySignedClearance> {
        py.detach(|| {
            let found = self.with_scene(|scene| {
                scene.signed_clearance(&query_within(budget), tolerance, cutoff).or_raise()
            })?;
            Ok(PySignedClearance { found, gradient: None })
        })
    }
}

/// Values and gradients of several configurations.
type Sampled<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);
/// A body's name, itself, and its pose.
type Placed<'py> = (String, PyBody, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl PyPlanningScene {
    /// The least signed distance of any two tested bodies at a configuration, (n,), up to ``cutoff``, with its
    /// gradient: the least distance, or if bodies meet, minus the greatest penetration depth. ``tolerance`` is that of
    /// ``Body.distance``.
    ///
    /// Raises ``PlanningError``, ``ArrayError`` or ``TypeError``.
    #[pyo3(signature = (values, *, tolerance = 0.0, cutoff = f64::INFINITY))]
    fn signed_clearance(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyAny>,
        tolerance: f64,
        cutoff: f64,
    ) -> PyResult<PySignedClearance> {
        let values = vector(values, "values")?;
        py.detach(|| {
            let scene = self.read();
            let mut gradient = vec![0.0; scene.variables()];
            let mut memory = self.workspace(&scene);
            let found =
                scene.signed_clearance(memory.get(), &values, tolerance, cutoff, &mut gradient).or_raise()?;
            Ok(PySignedClearance { found, gradient: Some(gradient) })
        })
    }

    /// ``signed_clearance`` of m configurations, (m, n), for an optimiser: the values, (m,), and their gradients,
    /// (m, n).
    ///
    /// A value is the upper bound of a distance, the lower bound if bodies meet, or the cutoff if no two bodies are
    /// nearer. Computed on ``threads`` threads, 0 for one per core.
    #[pyo3(signature = (configurations, *, tolerance = 0.0, cutoff = f64::INFINITY, threads = 1))]
    fn signed_clearances<'py>(
        &self,
        py: Python<'py>,
        configurations: &Bound<'py, PyAny>,
        tolerance: f64,
        cutoff: f64,
        threads: usize,
    ) -> PyResult<Sampled<'py>> {
        let variables = self.read().variables();
        let rows = rows_of(configurations, variables, "configurations")?;
        let found = py.detach(|| {
            let scene = self.read();
            all_with(&rows, threads, &|| self.workspace(&scene), &|memory, values| {
                let mut gradient = vec![0.0; variables];
                let found = scene
                    .signed_clearance(memory.get(), values, tolerance, cutoff, &mut gradient)
                    .or_raise()?;
                let value = if found.witness.is_some() { value(&found) } else { found.lower };
                Ok((value, gradient))
            })
        })?;
        let (values, gradients): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        let shape = [values.len(), variables];
        Ok((array(py, values), array(py, gradients.concat()).reshape(shape)?))
    }

    /// All bodies at their poses in a configuration, (n,): a list of names, bodies and poses in the world, (4, 4);
    /// first those of the robot, in the order of ``links``, then the objects. For pictures.
    fn placed<'py>(&self, py: Python<'py>, values: &Bound<'py, PyAny>) -> PyResult<Vec<Placed<'py>>> {
        let values = vector(values, "values")?;
        let placed: Vec<_> = {
            let scene = self.read();
            let placed = scene.placed(self.workspace(&scene).get(), &values).or_raise()?;
            placed.into_iter().map(|(id, tree, pose)| (scene.name(id).to_owned(), tree, pose)).collect()
        };
        let body = |tree| PyBody::from(Geometry::of_tree(tree));
        Ok(placed.into_iter().map(|(name, tree, pose)| (name, body(tree), matrix(py, &pose))).collect())
    }
}
