//! Queries of a scene.

use super::{simdop_body_id, simdop_scene, with_scene};
use crate::boundary::{answered, given, guarded};
use crate::error::simdop_error;
use crate::query::{query, simdop_completion, simdop_pair, simdop_query_stats, simdop_verdict};
use simdop::scene::{SceneAnswer, SceneDistance, SceneHit, SceneSignedDistance, SceneVerdict};
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// The id that stands for no body.
pub const SIMDOP_NO_BODY: simdop_body_id = u64::MAX;

/// Two bodies that meet, and two of their primitives that meet; SIMDOP_NO_BODY and SIMDOP_NO_PRIMITIVE if there are
/// none.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_hit {
    /// One of the bodies.
    pub a: simdop_body_id,
    /// The other.
    pub b: simdop_body_id,
    /// Their primitives.
    pub pair: simdop_pair,
}

/// The answer of simdop_scene_collide() and simdop_scene_within().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_answer {
    /// Whether the bodies of any tested pair meet, or come within the margin.
    pub verdict: simdop_verdict,
    /// For a hit: the first one found.
    pub hit: simdop_scene_hit,
    /// Pairs of bodies whose boxes were near each other, and which were tested.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: simdop_query_stats,
}

/// The answer of simdop_scene_clearance(): the smallest distance of two bodies lies in lower ..= upper.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_scene_clearance_answer {
    /// Whether the bounds are as close to each other as requested. They hold in any case.
    pub completion: simdop_completion,
    /// Lower bound: the cutoff, if no two bodies are nearer.
    pub lower: f64,
    /// Upper bound. Infinite if no two bodies nearer than the cutoff were found. 0 if and only if two meet.
    pub upper: f64,
    /// If `upper` is finite: bodies at that distance, and their primitives.
    pub hit: simdop_scene_hit,
    /// The closest point of `hit.a`'s primitive in the world, up to rounding. Ignores the body's radius. NaN if there
    /// is no hit.
    pub point_a: [f64; 3],
    /// The closest point of `hit.b`'s primitive.
    pub point_b: [f64; 3],
    /// Pairs of bodies tested.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: simdop_query_stats,
}

/// The answer of simdop_scene_each_hit().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_hits {
    /// How the query ended: unless it is complete, hits may be missing.
    pub completion: simdop_completion,
    /// Pairs of bodies tested.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: simdop_query_stats,
}

/// Called with each hit. Returns 0 to go on, anything else to stop. It must return, without an exception or a
/// longjmp(), and must not change the scene, which it may query.
pub type simdop_on_hit =
    Option<unsafe extern "C" fn(user: *mut c_void, hit: *const simdop_scene_hit) -> c_int>;

impl simdop_scene_hit {
    pub(super) const NONE: Self = Self { a: SIMDOP_NO_BODY, b: SIMDOP_NO_BODY, pair: simdop_pair::NONE };
}

impl From<SceneHit> for simdop_scene_hit {
    fn from(hit: SceneHit) -> Self {
        Self { a: hit.a.to_bits(), b: hit.b.to_bits(), pair: hit.pair.into() }
    }
}

impl From<SceneAnswer> for simdop_scene_answer {
    fn from(answer: SceneAnswer) -> Self {
        let verdict = match answer.verdict {
            SceneVerdict::Free => simdop_verdict::Free,
            SceneVerdict::Hit(_) => simdop_verdict::Hit,
            SceneVerdict::Unknown => simdop_verdict::Unknown,
        };
        let hit = answer.hit().map_or(simdop_scene_hit::NONE, simdop_scene_hit::from);
        Self { verdict, hit, pairs: answer.pairs, stats: answer.stats.into() }
    }
}

/// The answer of simdop_scene_signed_clearance(): the least signed distance of two bodies lies in lower ..= upper.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_scene_signed_answer {
    /// Complete, or out of budget: then the bounds may be loose, but are valid.
    pub completion: simdop_completion,
    /// Lower bound: the cutoff, if no two bodies are nearer. If some meet, minus the upper bound of their depth.
    pub lower: f64,
    /// Upper bound. Infinite if no two bodies nearer than the cutoff were found. If some meet, minus the lower bound of
    /// their depth, which is 0 if their interiors are unknown.
    pub upper: f64,
    /// If `upper` is finite: the bodies that penetrate each other the deepest, or the nearest ones, and their
    /// primitives.
    pub hit: simdop_scene_hit,
    /// The point of `hit.a`'s primitive in the world: the nearest to `hit.b`, or the last one in contact with `hit.b`
    /// while `hit.a` moves out along the normal. Ignores the body's radius. NaN if there is no hit.
    pub point_a: [f64; 3],
    /// The point of `hit.b`'s primitive.
    pub point_b: [f64; 3],
    /// The unit vector in the world along which `hit.a` moves out of `hit.b`. Zeros if none is known.
    pub normal: [f64; 3],
    /// Pairs of bodies tested.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: simdop_query_stats,
}

impl From<SceneSignedDistance> for simdop_scene_signed_answer {
    fn from(answer: SceneSignedDistance) -> Self {
        let witness = answer.witness;
        Self {
            completion: answer.completion.into(),
            lower: answer.lower,
            upper: answer.upper,
            hit: witness.map_or(simdop_scene_hit::NONE, |witness| witness.hit.into()),
            point_a: witness.map_or([f64::NAN; 3], |witness| witness.a),
            point_b: witness.map_or([f64::NAN; 3], |witness| witness.b),
            normal: witness.map_or([0.0; 3], |witness| witness.normal),
            pairs: answer.pairs,
            stats: answer.stats.into(),
        }
    }
}

impl From<SceneDistance> for simdop_scene_clearance_answer {
    fn from(answer: SceneDistance) -> Self {
        let witness = answer.witness;
        Self {
            completion: answer.completion.into(),
            lower: answer.lower,
            upper: answer.upper,
            hit: witness.map_or(simdop_scene_hit::NONE, |witness| witness.hit.into()),
            point_a: witness.map_or([f64::NAN; 3], |witness| witness.a),
            point_b: witness.map_or([f64::NAN; 3], |witness| witness.b),
            pairs: answer.pairs,
            stats: answer.stats.into(),
        }
    }
}

/// Do the bodies of any tested pair meet? Stops after `budget` visits, summed over all pairs.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_collide(
    scene: Option<&simdop_scene>,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || {
        let scene = &given(scene, "scene")?.scene;
        Ok(with_scene!(scene, |scene| scene.collide(&query(budget)))?.into())
    })
}

/// Do the bodies of any tested pair come within `margin`, 0 to 2^300, in the world? Otherwise like
/// simdop_scene_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_within(
    scene: Option<&simdop_scene>,
    margin: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || {
        let scene = &given(scene, "scene")?.scene;
        Ok(with_scene!(scene, |scene| scene.within(&query(budget), margin))?.into())
    })
}

/// What is the smallest distance between the bodies of any tested pair, up to `cutoff`, which may be infinite?
/// `tolerance` limits the gap between the bounds relative to the distance between primitives, before the radii are
/// subtracted. Otherwise like simdop_scene_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_clearance(
    scene: Option<&simdop_scene>,
    tolerance: f64,
    cutoff: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_clearance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let scene = &given(scene, "scene")?.scene;
        Ok(with_scene!(scene, |scene| scene.clearance(&query(budget), tolerance, cutoff))?.into())
    })
}

/// What is the least signed distance between the bodies of any tested pair, up to `cutoff`: the least distance, or
/// minus the greatest penetration depth if bodies meet? Otherwise like simdop_scene_clearance().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_signed_clearance(
    scene: Option<&simdop_scene>,
    tolerance: f64,
    cutoff: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_signed_answer>>,
) -> simdop_error {
    answered(answer, || {
        let scene = &given(scene, "scene")?.scene;
        Ok(with_scene!(scene, |scene| scene.signed_clearance(&query(budget), tolerance, cutoff))?.into())
    })
}

/// Calls `on_hit` with `user` once for each tested pair of bodies that come within `margin`. Otherwise like
/// simdop_scene_within().
///
/// # Safety
/// `user`, which may be NULL, is what `on_hit` expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_each_hit(
    scene: Option<&simdop_scene>,
    margin: f64,
    budget: u64,
    on_hit: simdop_on_hit,
    user: *mut c_void,
    hits: Option<&mut MaybeUninit<simdop_scene_hits>>,
) -> simdop_error {
    guarded(|| {
        let (scene, hits) = (&given(scene, "scene")?.scene, given(hits, "hits")?);
        let on_hit = given(on_hit, "on_hit")?;
        let visit = |hit: SceneHit| {
            // SAFETY: the caller guarantees that `user` is what the function expects; the hit lives during the call.
            match unsafe { on_hit(user, &hit.into()) } {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let (completion, pairs, stats) =
            with_scene!(scene, |scene| scene.for_each_hit(&query(budget), margin, visit))?;
        hits.write(simdop_scene_hits { completion: completion.into(), pairs, stats: stats.into() });
        Ok(())
    })
}
