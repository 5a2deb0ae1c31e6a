//! `simdop.PlanningScene`.

use crate::arrays::{array, pose, rows_of, single_rows, table, vector};
use crate::batch::all_with;
use crate::body::PyBody;
use crate::error::{OrRaise, raise_as, raised};
use crate::scene::{Hit, Nearest, PyClearance};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use simdop::planning::{PlanSettings, PlanningScene, RobotFiles, Workspace};
use simdop::robot::LinkShapes;
use simdop::scene::{Body, BodyId};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// A robot among objects, queried by the values of its joints.
///
/// ``urdf`` and ``srdf`` are files; the SRDF file lists the pairs of links that are not tested, and groups of joints.
/// With ``group``, only the joints of this group are planned for; the other variables keep their values in ``rest``,
/// which has one for each variable of the robot. Meshes that are closed, or have no hole wider than ``cap``, are
/// solids. A configuration is an array of values, (n,), one for each variable that is planned for, in radians and the
/// robot's unit of length.
///
/// Free is certain: no two tested bodies meet, and along an edge at no time. Intervals of time as short as
/// ``resolution`` that cannot be decided count as not free.
#[pyclass(frozen, name = "PlanningScene", module = "simdop", weakref)]
#[derive(Debug)]
pub(crate) struct PyPlanningScene {
    scene: RwLock<PlanningScene>,
    /// Memory that no thread uses now.
    idle: Mutex<Vec<Workspace>>,
}

/// The memory of one thread, which is returned when this is dropped.
pub(crate) struct Borrowed<'s> {
    owner: &'s PyPlanningScene,
    workspace: Option<Workspace>,
}

impl Borrowed<'_> {
    pub(crate) const fn get(&mut self) -> &mut Workspace {
        match &mut self.workspace {
            Some(workspace) => workspace,
            None => unreachable!(),
        }
    }
}

impl Drop for Borrowed<'_> {
    fn drop(&mut self) {
        self.owner.idle().extend(self.workspace.take());
    }
}

impl PyPlanningScene {
    fn of(scene: PlanningScene) -> Self {
        Self { scene: RwLock::new(scene), idle: Mutex::default() }
    }

    /// Do not hold the lock while creating or reading Python objects: that can run other Python code, also on other
    /// threads, which may wait for the scene in turn.
    pub(crate) fn read(&self) -> RwLockReadGuard<'_, PlanningScene> {
        self.scene.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, PlanningScene> {
        self.scene.write().unwrap_or_else(PoisonError::into_inner)
    }

    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Workspace>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn workspace(&self, scene: &PlanningScene) -> Borrowed<'_> {
        let idle = self.idle().pop();
        Borrowed { owner: self, workspace: Some(idle.unwrap_or_else(|| scene.workspace())) }
    }
}

#[pymethods]
impl PyPlanningScene {
    #[new]
    #[pyo3(signature = (
        urdf, srdf = None, *, group = None, rest = None, visual = false, cap = 0.0, base = None, resolution = 1e-6
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn new(
        py: Python<'_>,
        urdf: PathBuf,
        srdf: Option<PathBuf>,
        group: Option<&str>,
        rest: Option<&Bound<'_, PyAny>>,
        visual: bool,
        cap: f64,
        base: Option<&Bound<'_, PyAny>>,
        resolution: f64,
    ) -> PyResult<Self> {
        let base = base.map(|base| pose(Some(base), "base")).transpose()?;
        let rest = rest.map(|rest| vector(rest, "rest")).transpose()?;
        if group.is_none() && rest.is_some() {
            let message = "rest is for the variables outside of a group: give group, too".to_owned();
            return Err(raise_as::<raised::PlanningError>(message));
        }
        py.detach(|| {
            let shapes = if visual { LinkShapes::Visual } else { LinkShapes::Collision };
            let files = RobotFiles::new(urdf).shapes(shapes).cap(cap);
            let files = match srdf {
                Some(srdf) => files.srdf(srdf),
                None => files,
            };
            let mut scene =
                PlanningScene::new(files.load().or_raise()?).or_raise()?.with_resolution(resolution);
            if let Some(base) = base {
                scene.place_base(&base).or_raise()?;
            }
            if let Some(group) = group {
                let middle = scene.limits().iter().map(|[low, high]| 0.0_f64.clamp(*low, *high));
                let rest = rest.unwrap_or_else(|| middle.collect());
                scene.select_group(group, &rest).or_raise()?;
            }
            Ok(Self::of(scene))
        })
    }

    /// Add an object at a pose in the world, and return its number. Two fixed bodies are not tested against each other;
    /// an object that will be attached must not be fixed.
    #[pyo3(signature = (name, body, pose = None, *, radius = 0.0, fixed = true))]
    fn add(
        &self,
        name: &str,
        body: &PyBody,
        pose: Option<&Bound<'_, PyAny>>,
        radius: f64,
        fixed: bool,
    ) -> PyResult<u64> {
        let world = self::pose(pose, "pose")?;
        let new = Body::new(body.0.shared()).with_radius(radius);
        let new = if fixed { new.fixed() } else { new };
        Ok(self.write().insert(name, new, &world).or_raise()?.to_bits())
    }

    /// Remove an object.
    fn remove(&self, number: u64) -> PyResult<()> {
        self.write().remove(BodyId::from_bits(number)).or_raise().map(drop)
    }

    /// Place an object at another pose in the world.
    #[pyo3(name = "move")]
    fn place(&self, number: u64, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let world = self::pose(Some(pose), "pose")?;
        self.write().place(BodyId::from_bits(number), &world).or_raise()
    }

    /// Attach an object to a link, at their relative pose when the joints have these values. It moves with the link,
    /// and may touch the links named in ``touched``.
    #[pyo3(signature = (number, link, values, touched = vec![]))]
    fn attach(
        &self,
        number: u64,
        link: &str,
        values: &Bound<'_, PyAny>,
        touched: Vec<String>,
    ) -> PyResult<()> {
        let values = vector(values, "values")?;
        let touched: Vec<_> = touched.iter().map(String::as_str).collect();
        self.write().attach(BodyId::from_bits(number), link, &values, &touched).or_raise()
    }

    /// Detach an object, and place it at a pose in the world.
    fn detach(&self, number: u64, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let world = self::pose(Some(pose), "pose")?;
        self.write().detach(BodyId::from_bits(number), &world).or_raise()
    }

    /// No longer test two bodies against each other.
    fn allow_collision(&self, a: u64, b: u64) -> PyResult<()> {
        self.write().allow_collision(BodyId::from_bits(a), BodyId::from_bits(b)).or_raise()
    }

    /// Test two bodies against each other.
    fn forbid_collision(&self, a: u64, b: u64) -> PyResult<()> {
        self.write().forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b)).or_raise()
    }

    /// Decide most configurations and edges by conservative bounds: verdicts stay the same, and queries of many
    /// configurations or edges take a fraction of the time. The bounds use a grid of distances to what stands still,
    /// with cells of this width in meters, such as 0.02, one byte each. The first call takes seconds for a robot with
    /// many pairs of links.
    fn use_bounds(&self, py: Python<'_>, cell: f64) -> PyResult<()> {
        py.detach(|| self.write().use_bounds(cell)).or_raise()
    }

    /// Bytes of the cells of ``use_bounds``; None if the bounds do not apply.
    #[getter]
    fn bound_bytes(&self) -> Option<usize> {
        self.read().bound_bytes()
    }

    /// The number of the first body of a link.
    fn link(&self, name: &str) -> PyResult<u64> {
        Ok(self.read().link(name).or_raise()?.to_bits())
    }

    /// The name of a body; empty if there is none with this number.
    fn name(&self, number: u64) -> String {
        self.read().name(BodyId::from_bits(number)).to_owned()
    }

    /// An independent scene with the same robot and objects.
    fn copy(&self) -> Self {
        Self::of(self.read().clone())
    }

    /// Lower and upper limits of the variables that are planned for, (n, 2).
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let limits = self.read().limits().to_vec();
        table(py, limits)
    }

    /// The names of the joints of the variables that are planned for.
    #[getter]
    fn variables(&self) -> Vec<String> {
        self.read().variable_names().map(str::to_owned).collect()
    }

    /// Whether each variable that is planned for belongs to a continuous joint, which rotates the shorter way around in
    /// motions, (n,).
    #[getter]
    fn continuous<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let continuous = {
            let scene = self.read();
            (0..scene.variables()).map(|variable| scene.is_continuous(variable)).collect()
        };
        array(py, continuous)
    }

    /// The names of the robot's bodies: those of their links, with a number for all but the first body of a link.
    #[getter]
    fn links(&self) -> Vec<String> {
        self.read().robot().names().to_vec()
    }

    /// The numbers of the objects, by their names.
    #[getter]
    fn objects(&self) -> BTreeMap<String, u64> {
        self.read().objects().iter().map(|(id, name)| (name.clone(), id.to_bits())).collect()
    }

    /// The names of the groups of joints of the SRDF file.
    #[getter]
    fn groups(&self) -> Vec<String> {
        self.read().robot().groups().iter().map(|group| group.name.clone()).collect()
    }

    /// Number of variables that are planned for.
    fn __len__(&self) -> usize {
        self.read().variables()
    }

    // A scene is never false, even if its robot does not move.
    fn __bool__(&self) -> bool {
        true
    }

    /// Whether no two tested bodies come within ``margin`` of each other.
    #[pyo3(signature = (values, *, margin = 0.0))]
    fn is_free(&self, py: Python<'_>, values: &Bound<'_, PyAny>, margin: f64) -> PyResult<bool> {
        let values = vector(values, "values")?;
        py.detach(|| {
            let scene = self.read();
            Ok(scene.within(self.workspace(&scene).get(), &values, margin).or_raise()?.is_free())
        })
    }

    /// Whether each of m configurations, (m, n), is free: an array of m booleans, computed on ``threads`` threads, 0
    /// for one per core.
    #[pyo3(signature = (configurations, *, margin = 0.0, threads = 1))]
    fn free<'py>(
        &self,
        py: Python<'py>,
        configurations: &Bound<'py, PyAny>,
        margin: f64,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let variables = self.read().variables();
        let rows = rows_of(configurations, variables, "configurations")?;
        let free = py.detach(|| {
            let scene = self.read();
            all_with(&rows, threads, &|| self.workspace(&scene), &|workspace, values| {
                Ok(scene.within(workspace.get(), values, margin).or_raise()?.is_free())
            })
        })?;
        Ok(array(py, free))
    }

    /// Whether the straight motion from one configuration to another is free at all times.
    fn edge_is_free(
        &self,
        py: Python<'_>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        let (start, end) = (vector(start, "start")?, vector(end, "end")?);
        py.detach(|| {
            let scene = self.read();
            scene.is_motion_free(self.workspace(&scene).get(), [&start, &end]).or_raise()
        })
    }

    /// The fraction of the straight motion from one configuration to another, from its start, that is free at all
    /// times: 1 for the whole motion, 0 if not even the start is free. The motion to ``start + share * (end - start)``
    /// is free, and a time that is not known to be free follows after at most 1/1024 of the whole motion.
    fn free_share(&self, py: Python<'_>, start: &Bound<'_, PyAny>, end: &Bound<'_, PyAny>) -> PyResult<f64> {
        let (start, end) = (vector(start, "start")?, vector(end, "end")?);
        py.detach(|| {
            let scene = self.read();
            scene.free_share(self.workspace(&scene).get(), [&start, &end]).or_raise()
        })
    }

    /// Whether each of m straight motions, from ``starts`` to ``ends``, (m, n) each, is free at all times.
    #[pyo3(signature = (starts, ends, *, threads = 1))]
    fn free_edges<'py>(
        &self,
        py: Python<'py>,
        starts: &Bound<'py, PyAny>,
        ends: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let variables = self.read().variables();
        let (starts, ends) = (rows_of(starts, variables, "starts")?, rows_of(ends, variables, "ends")?);
        if starts.len() != ends.len() {
            let message = format!("there are {} starts and {} ends", starts.len(), ends.len());
            return Err(raise_as::<raised::ArrayError>(message));
        }
        let edges: Vec<_> = starts.into_iter().zip(ends).collect();
        let free = py.detach(|| {
            let scene = self.read();
            all_with(&edges, threads, &|| self.workspace(&scene), &|workspace, (start, end)| {
                scene.is_motion_free(workspace.get(), [start, end]).or_raise()
            })
        })?;
        Ok(array(py, free))
    }

    /// A path of straight motions from ``start``, (n,), to ``goal``, which are free at all times: (m, n)
    /// configurations, or None if none was found.
    ///
    /// ``step`` is the longest motion that extends a tree of the search, as a distance in joint space; the search ends
    /// after ``configurations`` random ones. Then ``shortcuts`` straight motions are tried to shorten the path. The
    /// same ``seed`` gives the same path on every machine.
    #[pyo3(signature = (start, goal, *, step = 1.0, configurations = 100_000, shortcuts = 100, seed = 1))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn plan<'py>(
        &self,
        py: Python<'py>,
        start: &Bound<'py, PyAny>,
        goal: &Bound<'py, PyAny>,
        step: f64,
        configurations: u32,
        shortcuts: u32,
        seed: u64,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let (start, goal) = (vector(start, "start")?, vector(goal, "goal")?);
        let settings = PlanSettings { step, configurations, shortcuts, seed };
        let found = py.detach(|| {
            let scene = self.read();
            scene.plan(self.workspace(&scene).get(), &start, &[&goal], &settings).or_raise()
        })?;
        if !found.is_found() {
            return Ok(None);
        }
        let shape = [found.path.len(), start.len()];
        Ok(Some(array(py, found.path.concat()).reshape(shape)?))
    }

    /// The names of all pairs of bodies that come within ``margin`` of each other in a configuration.
    #[pyo3(signature = (values, *, margin = 0.0))]
    fn hits(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyAny>,
        margin: f64,
    ) -> PyResult<Vec<(String, String)>> {
        let values = vector(values, "values")?;
        py.detach(|| {
            let scene = self.read();
            let hits = scene.hits(self.workspace(&scene).get(), &values, margin).or_raise()?;
            Ok(hits.iter().map(|hit| (scene.name(hit.a).to_owned(), scene.name(hit.b).to_owned())).collect())
        })
    }

    /// Whether each of m points of the world, (m, 3), is within ``margin`` of the robot in a configuration, or inside
    /// it. Remove these points from a scan before it becomes an obstacle. Attached objects are parts of the robot. A
    /// point that is not finite is not near.
    #[pyo3(signature = (values, points, *, margin = 0.0))]
    fn near_robot<'py>(
        &self,
        py: Python<'py>,
        values: &Bound<'py, PyAny>,
        points: &Bound<'py, PyAny>,
        margin: f64,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let (values, points) = (vector(values, "values")?, single_rows::<3>(points, "points")?);
        let near = py.detach(|| {
            let scene = self.read();
            scene.near_robot(self.workspace(&scene).get(), &values, &points, margin).or_raise()
        })?;
        Ok(array(py, near))
    }

    /// The least distance between two tested bodies, up to ``cutoff``, with its gradient. ``tolerance`` is that of
    /// ``Body.distance``.
    #[pyo3(signature = (values, *, tolerance = 0.0, cutoff = f64::INFINITY))]
    fn clearance(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyAny>,
        tolerance: f64,
        cutoff: f64,
    ) -> PyResult<PyClearance> {
        let values = vector(values, "values")?;
        py.detach(|| {
            let scene = self.read();
            let mut borrowed = self.workspace(&scene);
            let near = scene.clearance(borrowed.get(), &values, tolerance, cutoff).or_raise()?;
            let mut gradient = vec![0.0; scene.variables()];
            if let Some(witness) = &near.witness {
                scene.clearance_gradient(borrowed.get(), witness, &mut gradient).or_raise()?;
            }
            let witness = near.witness.map(|witness| {
                let numbers = [witness.hit.a.to_bits(), witness.hit.b.to_bits()];
                (Hit { numbers, pair: witness.hit.pair }, [witness.a, witness.b])
            });
            let nearest = Nearest { lower: near.lower, upper: near.upper, witness };
            Ok(PyClearance { nearest, gradient: Some(gradient) })
        })
    }

    fn __repr__(&self) -> String {
        let scene = self.read();
        let (links, objects) = (scene.links().len(), scene.objects().len());
        format!(
            "PlanningScene({} variables, {links} bodies of the robot, {objects} objects)",
            scene.variables()
        )
    }
}
