//! Queries of two bodies of any kind.
//!
//! Trees are tested directly, and so is a shape against a tree. In the other pairs, the body that must be the second is
//! the first, or there is a cloud: a scene of the two decides, which places either in the frame of the other, with a
//! margin for the rounding of the inverse pose.

use crate::error::{OrRaise, raise_as, raised};
use crate::geometry::Node;
use pyo3::prelude::*;
use simdop::node::Aabb16;
use simdop::query::{Answer, Distance, Hint, Pair, Verdict, Witness};
use simdop::scene::{Body, BodyId, BodyTree, Scene, SceneError, SceneHit, SceneMemory, SceneVerdict, Slot};
use simdop::{Isa, Pose, Query};
use std::ops::ControlFlow;
use std::sync::LazyLock;

type View<'t> = BodyTree<'t, Node>;

/// A query on the best instruction set of this machine, which is detected once.
pub(crate) fn query() -> Query {
    static ISA: LazyLock<Isa> = LazyLock::new(Isa::detect);
    Query::new(*ISA)
}

/// Evaluates one of four expressions: for two trees, a shape and a tree, two shapes, or any other pair.
macro_rules! with_pair {
    (
        ($of_a:expr, $of_b:expr), |$a:ident, $b:ident|
        $trees:expr, $beside:expr, $shapes:expr, $others:expr $(,)?
    ) => {
        match ($of_a, $of_b) {
            (BodyTree::Mesh($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Mesh($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Mesh($a), BodyTree::Shapes($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Shapes($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Shapes($b)) => $trees,
            (BodyTree::Shape($a), BodyTree::Mesh($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Spheres($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Shapes($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Shape($b)) => $shapes,
            ($a, $b) => $others,
        }
    };
}

/// Whether two bodies meet.
pub(crate) fn collide(a: &View<'_>, b: &View<'_>, pose: &Pose) -> PyResult<Answer> {
    let query = query();
    Ok(with_pair!(
        (a, b),
        |a, b| query.collide(a, b, pose),
        query.collide_shape(a, b, pose),
        query.collide_shapes(a, b, pose),
        within_in_scene(a, b, pose, 0.0)?,
    ))
}

/// Whether two bodies come within a margin of each other.
pub(crate) fn within(a: &View<'_>, b: &View<'_>, pose: &Pose, margin: f64) -> PyResult<Answer> {
    let query = query();
    Ok(with_pair!(
        (a, b),
        |a, b| query.within(a, b, pose, margin).or_raise()?,
        query.within_shape(a, b, pose, margin).or_raise()?,
        query.within_shapes(a, b, pose, margin).or_raise()?,
        within_in_scene(a, b, pose, margin)?,
    ))
}

/// How a distance is searched for.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Search {
    pub(crate) tolerance: f64,
    pub(crate) cutoff: f64,
}

/// The distance of two bodies that are nearer than the cutoff.
pub(crate) fn distance(a: &View<'_>, b: &View<'_>, pose: &Pose, search: Search) -> PyResult<Distance> {
    let (query, Search { tolerance, cutoff }) = (query(), search);
    Ok(with_pair!(
        (a, b),
        |a, b| query.distance_up_to(a, b, pose, tolerance, cutoff).or_raise()?,
        query.distance_shape(a, b, pose, tolerance, cutoff).or_raise()?,
        query.distance_shapes(a, b, pose, tolerance, cutoff).or_raise()?,
        distance_in_scene(a, b, pose, search)?,
    ))
}

/// Up to `limit` pairs of primitives that meet.
pub(crate) fn contacts(a: &View<'_>, b: &View<'_>, pose: &Pose, limit: usize) -> PyResult<Vec<Pair>> {
    let (query, mut pairs) = (query(), Vec::new());
    if limit == 0 {
        return Ok(pairs);
    }
    let visit = |pair| {
        pairs.push(pair);
        if pairs.len() < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    with_pair!(
        (a, b),
        |a, b| _ = query.for_each_pair(a, b, pose, visit),
        _ = query.for_each_pair_shape(a, b, pose, visit),
        pairs.extend(query.collide_shapes(a, b, pose).hit()),
        match (a, b) {
            // From the shape's side, with the same bodies: which of them moves does not matter to a pair that meets.
            (tree, BodyTree::Shape(_)) if !matches!(tree, BodyTree::PointCloud(_)) => {
                let inverse = Pose::relative(&Pose::IDENTITY, pose).or_raise()?;
                let reversed = contacts(b, tree, inverse.pose(), limit)?;
                pairs.extend(reversed.into_iter().map(|Pair { a, b }| Pair { a: b, b: a }));
            }
            _ => pairs.extend(within_in_scene(a, b, pose, 0.0)?.hit()),
        },
    );
    Ok(pairs)
}

/// A query of the scene of two bodies. Also passes it the id of the first.
fn in_scene<T>(
    a: &View<'_>,
    b: &View<'_>,
    pose: &Pose,
    ask: impl FnOnce(&Scene<'_, Node>, BodyId) -> Result<T, SceneError>,
) -> PyResult<T> {
    if let (BodyTree::PointCloud(_), BodyTree::PointCloud(_)) = (a, b) {
        return Err(raise_as::<raised::BodyError>(
            "two clouds cannot be tested against each other".to_owned(),
        ));
    }
    let (mut slots, mut boxes, mut rows) = ([const { Slot::EMPTY }; 2], [Aabb16::EMPTY], [0; 2]);
    let memory = SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows };
    let mut scene = Scene::in_memory(memory).or_raise()?;
    let id = scene.insert(Body::new(a.clone()), pose).or_raise()?;
    scene.insert(Body::new(b.clone()), &Pose::IDENTITY).or_raise()?;
    ask(&scene, id).or_raise()
}

/// The primitives of a hit, that of the first body first.
fn pair(hit: &SceneHit, first: BodyId) -> Pair {
    let Pair { a, b } = hit.pair;
    if hit.a == first { Pair { a, b } } else { Pair { a: b, b: a } }
}

fn within_in_scene(a: &View<'_>, b: &View<'_>, pose: &Pose, margin: f64) -> PyResult<Answer> {
    in_scene(a, b, pose, |scene, id| {
        let answer = scene.within(&query(), margin)?;
        let verdict = match answer.verdict {
            SceneVerdict::Free => Verdict::Free,
            SceneVerdict::Hit(hit) => Verdict::Hit(pair(&hit, id)),
            SceneVerdict::Unknown => Verdict::Unknown { lower: 0.0, upper: f64::INFINITY },
        };
        Ok(Answer { verdict, stats: answer.stats, hint: Hint::NONE })
    })
}

fn distance_in_scene(a: &View<'_>, b: &View<'_>, pose: &Pose, search: Search) -> PyResult<Distance> {
    in_scene(a, b, pose, |scene, id| {
        let near = scene.clearance(&query(), search.tolerance, search.cutoff)?;
        let witness = near.witness.map(|witness| {
            let (a, b) = if witness.hit.a == id { (witness.a, witness.b) } else { (witness.b, witness.a) };
            Witness { pair: pair(&witness.hit, id), a, b }
        });
        Ok(Distance {
            lower: near.lower,
            upper: near.upper,
            witness,
            completion: near.completion,
            stats: near.stats,
            hint: Hint::NONE,
        })
    })
}
