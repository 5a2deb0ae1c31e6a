//! What is asked of a scene.

use super::{simdop_body_id, simdop_scene};
use crate::boundary::{answered, given, guarded};
use crate::error::simdop_error;
use crate::query::{query, simdop_completion, simdop_pair, simdop_query_stats, simdop_verdict};
use simdop::scene::{SceneAnswer, SceneDistance, SceneHit, SceneVerdict};
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// The id of a body where there is none.
pub const SIMDOP_NO_BODY: simdop_body_id = u64::MAX;

/// Two bodies that meet, and where; SIMDOP_NO_BODY and SIMDOP_NO_PRIMITIVE where there are none.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_hit {
    /// One of the bodies.
    pub a: simdop_body_id,
    /// The other.
    pub b: simdop_body_id,
    /// Primitives of theirs.
    pub pair: simdop_pair,
}

/// The answer of simdop_scene_collide() and simdop_scene_within().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_answer {
    /// Whether any two bodies that are asked against each other meet, or come within the margin.
    pub verdict: simdop_verdict,
    /// Of a hit: the first that was found.
    pub hit: simdop_scene_hit,
    /// Pairs of bodies whose boxes were near each other, and which were asked about.
    pub pairs: u64,
    /// The work for these pairs.
    pub stats: simdop_query_stats,
}

/// The answer of simdop_scene_clearance(): the least distance of any two bodies lies in lower ..= upper.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_scene_clearance_answer {
    /// Whether the bounds are as near to each other as was asked. They hold in any case.
    pub completion: simdop_completion,
    /// Lower bound: the cutoff, if no two are nearer.
    pub lower: f64,
    /// Upper bound: infinite if no two were found that are nearer than the cutoff. 0 if and only if two meet.
    pub upper: f64,
    /// Bodies that are `upper` apart, and their primitives, if that is finite.
    pub hit: simdop_scene_hit,
    /// Where the primitives are closest: the point of `hit.a`'s in the world, up to rounding. A body's radius is not heeded.
    /// NaN if there is no hit.
    pub point_a: [f64; 3],
    /// The point of `hit.b`'s.
    pub point_b: [f64; 3],
    /// Pairs of bodies that were asked about.
    pub pairs: u64,
    /// The work for these pairs.
    pub stats: simdop_query_stats,
}

/// What simdop_scene_each_hit() came to.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_scene_hits {
    /// How it ended: hits may be missing unless it is complete.
    pub completion: simdop_completion,
    /// Pairs of bodies that were asked about.
    pub pairs: u64,
    /// The work for these pairs.
    pub stats: simdop_query_stats,
}

/// Is called with each hit: 0 goes on, anything else stops. It must return, without an exception or a longjmp(), and must not
/// change the scene, which it may ask.
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

/// Do any two bodies meet that are asked against each other? Gives up after `budget` visits for all pairs together.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_collide(
    scene: Option<&simdop_scene>,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || Ok(given(scene, "scene")?.scene.collide(&query(budget))?.into()))
}

/// Do any two bodies that are asked against each other come within `margin`, 0 to 2^300, in the world? Otherwise as
/// simdop_scene_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_within(
    scene: Option<&simdop_scene>,
    margin: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || Ok(given(scene, "scene")?.scene.within(&query(budget), margin)?.into()))
}

/// How near do two bodies come that are asked against each other, up to `cutoff`, which may be infinite? The bounds are as near
/// to each other as `tolerance`, relative to the distance between primitives, before radii are taken off. Otherwise as
/// simdop_scene_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_clearance(
    scene: Option<&simdop_scene>,
    tolerance: f64,
    cutoff: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_scene_clearance_answer>>,
) -> simdop_error {
    answered(answer, || Ok(given(scene, "scene")?.scene.clearance(&query(budget), tolerance, cutoff)?.into()))
}

/// Calls `on_hit` with `user` and every two bodies that are asked against each other and come within `margin`, each two once.
/// Otherwise as simdop_scene_within().
///
/// # Safety
/// `user`, which may be NULL, is what `on_hit` takes it for.
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
        let (completion, pairs, stats) = scene.for_each_hit(&query(budget), margin, |hit| {
            // SAFETY: `user` is what the function takes it for, by the caller's promise; the hit is there during the call.
            match unsafe { on_hit(user, &hit.into()) } {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        })?;
        hits.write(simdop_scene_hits { completion: completion.into(), pairs, stats: stats.into() });
        Ok(())
    })
}
