//! A tree at a pose in the frame of one shape. The library tests a shape against a tree in the tree's frame only, and
//! a scene computes the inverse pose with a margin for its rounding: so the two are a scene.

use crate::body::{Node, View};
use crate::error::Failure;
use simdop::low_level::key::Storage;
use simdop::node::Aabb16;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::{Answer, Distance, Hint, Lanes, Pair, Query, Verdict, Witness};
use simdop::scene::{Body, BodyId, Scene, SceneError, SceneHit, SceneMemory, SceneVerdict, Slot};

/// A query of the scene of a tree and a shape. Also passes it the tree's id.
fn in_scene<S: Storage, T>(
    tree: View<'_, S>,
    shape: &Shape,
    pose: &Pose,
    ask: impl FnOnce(&Scene<'_, Node<S>>, BodyId) -> Result<T, SceneError>,
) -> Result<T, Failure>
where
    Node<S>: Lanes,
{
    let (mut slots, mut boxes, mut rows) = ([const { Slot::EMPTY }; 2], [Aabb16::EMPTY], [0; 2]);
    let mut scene = Scene::in_memory(SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows })?;
    let id = scene.insert(Body::new(tree), pose)?;
    scene.insert(Body::new(*shape), &Pose::IDENTITY)?;
    Ok(ask(&scene, id)?)
}

/// The primitives of a hit, that of the tree first.
fn pair(hit: &SceneHit, tree: BodyId) -> Pair {
    let Pair { a, b } = hit.pair;
    if hit.a == tree { Pair { a, b } } else { Pair { a: b, b: a } }
}

/// [`Query::within`].
pub(crate) fn within<S: Storage>(
    query: &Query,
    tree: View<'_, S>,
    shape: &Shape,
    pose: &Pose,
    margin: f64,
) -> Result<Answer, Failure> {
    in_scene(tree, shape, pose, |scene, id| {
        let answer = scene.within(query, margin)?;
        let verdict = match answer.verdict {
            SceneVerdict::Free => Verdict::Free,
            SceneVerdict::Hit(hit) => Verdict::Hit(pair(&hit, id)),
            SceneVerdict::Unknown => Verdict::Unknown { lower: 0.0, upper: f64::INFINITY },
        };
        Ok(Answer { verdict, stats: answer.stats, hint: Hint::NONE })
    })
}

/// [`Query::distance_up_to`].
pub(crate) fn distance<S: Storage>(
    query: &Query,
    tree: View<'_, S>,
    shape: &Shape,
    pose: &Pose,
    tolerance: f64,
    cutoff: f64,
) -> Result<Distance, Failure> {
    in_scene(tree, shape, pose, |scene, id| {
        let near = scene.clearance(query, tolerance, cutoff)?;
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
