//! `simdop.Scene`.

use crate::arrays::{array, matrix, pose};
use crate::body::PyBody;
use crate::error::OrRaise;
use crate::geometry::{Geometry, Node};
use crate::pair::query;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use simdop::Pose;
use simdop::query::Pair;
use simdop::scene::{Body, BodyId, Groups, Scene};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Many bodies, each at a pose in the world.
///
/// ``add`` returns the number that identifies a body. Verdicts are exact for the given world poses, up to the rounding
/// of relative poses, about 1e-14 of the coordinates: bodies closer than this count as meeting.
#[pyclass(frozen, name = "Scene", module = "simdop", weakref)]
#[derive(Debug, Default)]
pub(crate) struct PyScene(RwLock<Placed>);

/// A scene, and the bodies that it was made of.
#[derive(Clone, Debug, Default)]
struct Placed {
    scene: Scene<'static, Node>,
    bodies: BTreeMap<u64, (Arc<Geometry>, f64)>,
}

/// A body of two scenes that are tested against each other.
#[derive(Clone, Debug)]
struct Member {
    number: u64,
    geometry: Arc<Geometry>,
    radius: f64,
    world: Pose,
}

/// Two bodies that meet, by their numbers, and their primitives.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Hit {
    pub(crate) numbers: [u64; 2],
    pub(crate) pair: Pair,
}

/// The least distance of two bodies.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Nearest {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// The bodies, and their closest points in the world.
    pub(crate) witness: Option<(Hit, [[f64; 3]; 2])>,
}

/// A query of a scene.
#[derive(Copy, Clone, Debug)]
enum Ask {
    Within { margin: f64, limit: usize },
    Clearance { tolerance: f64, cutoff: f64 },
}

#[derive(Debug)]
enum Told {
    Hits(Vec<Hit>),
    Nearest(Nearest),
}

/// Answers a question with the numbers that `number` has for bodies.
fn ask(scene: &Scene<'_, Node>, ask: Ask, number: impl Fn(BodyId) -> (bool, u64)) -> PyResult<Told> {
    let hit = |a, b, pair: Pair| {
        let ((is_other, a), (_, b)) = (number(a), number(b));
        let swapped = Hit { numbers: [b, a], pair: Pair { a: pair.b, b: pair.a } };
        (is_other, if is_other { swapped } else { Hit { numbers: [a, b], pair } })
    };
    match ask {
        Ask::Within { margin, limit } => {
            let mut hits = Vec::new();
            let found = scene.for_each_hit(&query(), margin, |found| {
                hits.push(hit(found.a, found.b, found.pair).1);
                if hits.len() < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            let _without_budget = found.or_raise()?;
            Ok(Told::Hits(hits))
        }
        Ask::Clearance { tolerance, cutoff } => {
            let near = scene.clearance(&query(), tolerance, cutoff).or_raise()?;
            let witness = near.witness.map(|witness| {
                let (is_swapped, hit) = hit(witness.hit.a, witness.hit.b, witness.hit.pair);
                (hit, if is_swapped { [witness.b, witness.a] } else { [witness.a, witness.b] })
            });
            Ok(Told::Nearest(Nearest { lower: near.lower, upper: near.upper, witness }))
        }
    }
}

/// Answers a question about the bodies of one list and those of another.
fn ask_between(ours: &[Member], theirs: &[Member], question: Ask) -> PyResult<Told> {
    let mut scene = Scene::new();
    let mut numbers = BTreeMap::new();
    for (members, is_other) in [(ours, false), (theirs, true)] {
        let groups = if is_other { Groups { of: 2, against: 1 } } else { Groups { of: 1, against: 2 } };
        for member in members {
            let body = Body::new(member.geometry.shared()).with_radius(member.radius).with_groups(groups);
            numbers.insert(scene.insert(body, &member.world).or_raise()?, (is_other, member.number));
        }
    }
    ask(&scene, question, |id| numbers[&id])
}

impl PyScene {
    fn read(&self) -> RwLockReadGuard<'_, Placed> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Placed> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks the scene.
    pub(crate) fn with_scene<T>(&self, ask: impl FnOnce(&Scene<'static, Node>) -> T) -> T {
        ask(&self.read().scene)
    }

    fn members(&self) -> PyResult<Vec<Member>> {
        let placed = self.read();
        let member = |(&number, (geometry, radius)): (&u64, &(Arc<Geometry>, f64))| {
            let world = *placed.scene.world_pose(BodyId::from_bits(number)).or_raise()?;
            Ok(Member { number, geometry: Arc::clone(geometry), radius: *radius, world })
        };
        placed.bodies.iter().map(member).collect()
    }

    fn ask(&self, py: Python<'_>, question: Ask, other: Option<&Self>) -> PyResult<Told> {
        py.detach(|| match other {
            None => ask(&self.read().scene, question, |id| (false, id.to_bits())),
            // One after the other, since both may be one scene with one lock.
            Some(other) => ask_between(&self.members()?, &other.members()?, question),
        })
    }

    fn hits(&self, py: Python<'_>, margin: f64, limit: usize, other: Option<&Self>) -> PyResult<Vec<Hit>> {
        match self.ask(py, Ask::Within { margin, limit }, other)? {
            Told::Hits(hits) => Ok(hits),
            Told::Nearest(_) => unreachable!("a margin was asked for"),
        }
    }
}

#[pymethods]
impl PyScene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Add a body at a pose in the world, (4, 4), and return its number.
    ///
    /// Two bodies meet if their distance is at most the sum of their radii. Two fixed bodies are not tested against
    /// each other. ``of`` and ``against`` are bit sets of groups: two bodies are tested if each is in a group that the
    /// other is tested against.
    #[pyo3(signature = (body, pose = None, *, radius = 0.0, fixed = false, of = u32::MAX, against = u32::MAX))]
    fn add(
        &self,
        body: &PyBody,
        pose: Option<&Bound<'_, PyAny>>,
        radius: f64,
        fixed: bool,
        of: u32,
        against: u32,
    ) -> PyResult<u64> {
        let world = self::pose(pose, "pose")?;
        let new = Body::new(body.0.shared()).with_radius(radius).with_groups(Groups { of, against });
        let mut placed = self.write();
        let number = placed.scene.insert(if fixed { new.fixed() } else { new }, &world).or_raise()?.to_bits();
        placed.bodies.insert(number, (Arc::clone(&body.0), radius));
        Ok(number)
    }

    /// Remove a body. Bodies attached to it stay where they are.
    fn remove(&self, number: u64) -> PyResult<()> {
        let mut placed = self.write();
        placed.scene.remove(BodyId::from_bits(number)).or_raise()?;
        placed.bodies.remove(&number);
        Ok(())
    }

    /// Place a body at another pose in the world, and move the bodies attached to it along.
    #[pyo3(name = "move")]
    fn place(&self, number: u64, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let world = self::pose(Some(pose), "pose")?;
        self.write().scene.place(BodyId::from_bits(number), &world).or_raise()
    }

    /// The pose of a body in the world, (4, 4).
    fn pose<'py>(&self, py: Python<'py>, number: u64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let world = *self.read().scene.world_pose(BodyId::from_bits(number)).or_raise()?;
        Ok(matrix(py, &world))
    }

    /// The body with a number.
    fn body(&self, number: u64) -> PyResult<PyBody> {
        let placed = self.read();
        placed.scene.world_pose(BodyId::from_bits(number)).or_raise()?;
        let (geometry, _) = &placed.bodies[&number];
        Ok(PyBody(Arc::clone(geometry)))
    }

    /// Attach a body to another, with which it moves.
    fn attach(&self, number: u64, to: u64) -> PyResult<()> {
        self.write().scene.attach(BodyId::from_bits(number), BodyId::from_bits(to)).or_raise()
    }

    /// Detach a body, which stays where it is.
    fn detach(&self, number: u64) -> PyResult<()> {
        self.write().scene.detach(BodyId::from_bits(number)).or_raise()
    }

    /// No longer test two bodies against each other.
    fn allow_collision(&self, a: u64, b: u64) -> PyResult<()> {
        self.write().scene.allow_collision(BodyId::from_bits(a), BodyId::from_bits(b)).or_raise()
    }

    /// Test two bodies against each other again.
    fn forbid_collision(&self, a: u64, b: u64) -> PyResult<()> {
        self.write().scene.forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b)).or_raise()
    }

    /// The numbers of all bodies.
    #[getter]
    fn numbers(&self) -> Vec<u64> {
        self.read().bodies.keys().copied().collect()
    }

    /// An independent scene with the same bodies.
    fn copy(&self) -> Self {
        Self(RwLock::new(self.read().clone()))
    }

    /// Whether any two tested bodies come within ``margin`` of each other; or, with ``other``, any body of this scene
    /// and any of the other. Between two scenes every pair is tested.
    #[pyo3(signature = (margin = 0.0, *, other = None))]
    fn collide(&self, py: Python<'_>, margin: f64, other: Option<PyRef<'_, Self>>) -> PyResult<bool> {
        Ok(!self.hits(py, margin, 1, other.as_deref())?.is_empty())
    }

    /// The pairs of bodies that come within ``margin`` of each other, by their numbers, each once: a list of
    /// two-tuples. With ``other``, the second number belongs to the other scene.
    #[pyo3(signature = (margin = 0.0, *, other = None))]
    fn pairs(
        &self,
        py: Python<'_>,
        margin: f64,
        other: Option<PyRef<'_, Self>>,
    ) -> PyResult<Vec<(u64, u64)>> {
        let hits = self.hits(py, margin, usize::MAX, other.as_deref())?;
        Ok(hits.iter().map(|hit| (hit.numbers[0], hit.numbers[1])).collect())
    }

    /// The least distance of any two tested bodies, up to ``cutoff``. ``tolerance`` is that of ``Body.distance``.
    #[pyo3(signature = (*, tolerance = 0.0, cutoff = f64::INFINITY, other = None))]
    fn clearance(
        &self,
        py: Python<'_>,
        tolerance: f64,
        cutoff: f64,
        other: Option<PyRef<'_, Self>>,
    ) -> PyResult<PyClearance> {
        match self.ask(py, Ask::Clearance { tolerance, cutoff }, other.as_deref())? {
            Told::Nearest(nearest) => Ok(PyClearance { nearest, gradient: None }),
            Told::Hits(_) => unreachable!("a distance was asked for"),
        }
    }

    fn __len__(&self) -> usize {
        self.read().bodies.len()
    }

    // A scene is never false, even if it is empty.
    fn __bool__(&self) -> bool {
        true
    }

    fn __contains__(&self, number: u64) -> bool {
        self.read().bodies.contains_key(&number)
    }

    fn __repr__(&self) -> String {
        format!("Scene({} bodies)", self.read().bodies.len())
    }
}

/// The least distance of two bodies of a scene.
#[pyclass(frozen, name = "Clearance", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyClearance {
    pub(crate) nearest: Nearest,
    pub(crate) gradient: Option<Vec<f64>>,
}

#[pymethods]
impl PyClearance {
    /// Lower bound, in the bodies' unit; the cutoff if no two bodies are nearer.
    #[getter]
    const fn lower(&self) -> f64 {
        self.nearest.lower
    }

    /// Upper bound: the distance of ``bodies``. Zero if and only if two meet; infinite without bodies.
    #[getter]
    const fn upper(&self) -> f64 {
        self.nearest.upper
    }

    /// The numbers of the two bodies, or None.
    #[getter]
    fn bodies(&self) -> Option<(u64, u64)> {
        self.nearest.witness.map(|(hit, _)| (hit.numbers[0], hit.numbers[1]))
    }

    /// Their closest primitives, or None.
    #[getter]
    fn indices(&self) -> Option<(u32, u32)> {
        self.nearest.witness.map(|(hit, _)| (hit.pair.a, hit.pair.b))
    }

    /// Their closest points in the world, without the bodies' radii, or None.
    #[getter]
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn points<'py>(&self, py: Python<'py>) -> Option<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
        self.nearest.witness.map(|(_, [a, b])| (array(py, a.to_vec()), array(py, b.to_vec())))
    }

    /// In a planning scene, the derivative of the distance with respect to each variable, (n,): zero without points, or
    /// if they coincide. None in other scenes.
    #[getter]
    fn gradient<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gradient.as_ref().map(|gradient| array(py, gradient.clone()))
    }

    /// The upper bound.
    const fn __float__(&self) -> f64 {
        self.nearest.upper
    }

    fn __repr__(&self) -> String {
        let bounds = format!("{} ..= {}", self.nearest.lower, self.nearest.upper);
        match self.nearest.witness {
            Some((hit, _)) => {
                format!("Clearance({bounds}, bodies {} and {})", hit.numbers[0], hit.numbers[1])
            }
            None => format!("Clearance({bounds})"),
        }
    }
}
