//! Edges: do bodies meet anywhere along a motion?
//!
//! The search tests each interval of time at its middle. If a pair is farther apart there than the motion bound over
//! half of the interval ([`Motion::motion_bound_between`]), it is free in the whole interval. If it meets there, that
//! is a hit. Otherwise the search tests both halves. Long intervals come first, and within each the deepest pairs, so
//! that most hits are found early.

mod queue;
mod search;

pub use queue::MotionHit;

use super::{BodyId, Scene, SceneError, SceneHit, Slot};
use crate::motion::{CarriedBall, Motion};
use crate::pose::Pose;
use crate::query::{Lanes, Query, QueryStats, ToleranceError};
use crate::range::MAX_COORDINATE;
use core::num::NonZeroU32;
use queue::MotionQueue;
use search::MotionSearch;

/// Memory for edges, borrowed from the caller.
#[derive(Debug)]
pub struct MotionMemory<'m> {
    /// Two poses for each moving body.
    pub poses: &'m mut [Pose],
    /// Pending pairs, each with an interval of time: twice as many as there are pairs of nearby bodies, and more where
    /// these come close. Pairs that do not fit stay unresolved.
    pub waiting: &'m mut [MotionHit],
}

/// The verdict on an edge.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum MotionVerdict {
    /// No two tested bodies meet at any time from 0 to 1.
    Free,
    /// Two bodies meet at this time, which need not be the first.
    Hit {
        /// The bodies.
        hit: SceneHit,
        /// The time of the hit.
        time: f64,
    },
    /// No hit was found. Nothing meets before this interval of time, but within it bodies may meet.
    Unresolved {
        /// Start of the interval.
        from: f64,
        /// End of the interval: at most the resolution later, unless the budget or the memory ran out.
        to: f64,
    },
}

/// A verdict on an edge, and its cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct MotionAnswer {
    /// The verdict.
    pub verdict: MotionVerdict,
    /// Number of times at which the bodies were placed.
    pub times: u64,
    /// Number of pairs of bodies tested, counted once for each time.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: QueryStats,
}

impl MotionAnswer {
    fn new() -> Self {
        Self { verdict: MotionVerdict::Free, times: 0, pairs: 0, stats: QueryStats::default() }
    }

    /// Whether all tested pairs are certainly free along the whole motion.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self.verdict, MotionVerdict::Free)
    }
}

impl<N: Lanes> Scene<'_, N> {
    /// Do any two tested bodies meet at any time of a motion? The motion moves the `moving` bodies and all bodies
    /// attached to them; all others stand still. **Free is certain for all times**, not for samples of them.
    ///
    /// `moving` lists the bodies in the order in which the motion numbers them. No interval of time shorter than
    /// `resolution` is halved: pairs that come too near to certify at this resolution are unresolved. Ignores the
    /// query's hint; its budget covers all pairs and times together. Afterwards the bodies are where they were.
    ///
    /// # Errors
    /// [`SceneError`]: a body is missing or attached to another; the numbers of bodies or poses do not match the motion
    /// ([`SceneError::Motion`]); a pose of the motion is invalid; the resolution is not above 0
    /// ([`SceneError::Tolerance`]).
    pub fn check_motion(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        motion: &mut impl Motion,
        resolution: f64,
        memory: &mut MotionMemory<'_>,
    ) -> Result<MotionAnswer, SceneError> {
        if resolution.is_nan() || resolution <= 0.0 {
            return Err(SceneError::Tolerance(ToleranceError { given: resolution }));
        }
        let (poses, before) = self.set_out(moving, motion.bodies(), memory.poses)?;
        let queue = MotionQueue::new(memory.waiting);
        let answer = MotionSearch { scene: self, query, moving, motion, poses }.run(resolution, queue);
        self.place_all(moving, before)?;
        answer
    }

    /// Tests a motion at discrete times only: those that divide 0 to 1 into `parts` equal parts, both ends included.
    /// The order halves the longest gaps first, and the first hit ends the search. The verdict is never
    /// [`MotionVerdict::Free`]: nothing is certain between the samples.
    ///
    /// # Errors
    /// As [`Scene::check_motion`].
    pub fn check_motion_discrete(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        motion: &mut impl Motion,
        parts: NonZeroU32,
        memory: &mut MotionMemory<'_>,
    ) -> Result<MotionAnswer, SceneError> {
        let (poses, before) = self.set_out(moving, motion.bodies(), memory.poses)?;
        let answer = MotionSearch { scene: self, query, moving, motion, poses }.sample(parts);
        self.place_all(moving, before)?;
        answer
    }

    /// Sets the carriers of all bodies, and saves the poses of the moving ones. Returns room for the poses of the
    /// motion, and the saved poses.
    pub(super) fn set_out<'m>(
        &mut self,
        moving: &[BodyId],
        bodies: usize,
        poses: &'m mut [Pose],
    ) -> Result<(&'m mut [Pose], &'m mut [Pose]), SceneError> {
        if moving.len() != bodies || poses.len() / 2 < bodies {
            return Err(SceneError::Motion { bodies, given: moving.len(), poses: poses.len() });
        }
        self.set_carriers(moving)?;
        let (now, before) = poses[..2 * bodies].split_at_mut(bodies);
        for (pose, &id) in before.iter_mut().zip(moving) {
            *pose = *self.world_pose(id)?;
        }
        Ok((now, before))
    }
}

/// Upper bound of how much two bodies, and all points at most `beyond` away from the balls around them, approach each
/// other within a span of a motion. Infinite on overflow.
pub(super) fn motion_bound_of_pair<N>(
    motion: &impl Motion,
    [a, b]: [&Slot<'_, N>; 2],
    beyond: f64,
    span: f64,
) -> f64 {
    let [(carrier_a, ball_a), (carrier_b, ball_b)] = [a, b].map(|slot| {
        let ball = slot.size.ball(&slot.world);
        (slot.carrier.map(|i| i as usize), CarriedBall { radius: ball.radius + beyond, ..ball })
    });
    finite_or_infinite(match (carrier_a, carrier_b) {
        (None, None) => 0.0,
        (Some(i), None) => motion.motion_bound(i, &ball_a, span),
        (None, Some(j)) => motion.motion_bound(j, &ball_b, span),
        (Some(i), Some(j)) => motion.motion_bound_between((i, &ball_a), (j, &ball_b), span),
    })
}

/// Maps a bound that overflows, to infinity or NaN, to infinity. A negative bound is invalid, and becomes infinite too.
fn finite_or_infinite(path: f64) -> f64 {
    if (0.0..=MAX_COORDINATE).contains(&path) { path } else { f64::INFINITY }
}
