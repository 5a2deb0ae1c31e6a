//! Edges: do bodies meet anywhere on their way?
//!
//! An interval of time is asked about at its middle. A pair of bodies that are farther apart there than they can come nearer
//! within half of the interval ([`Motion::motion_bound_between`]) is free in all of it; two that meet there are a hit; of all others,
//! both halves are asked about. Long intervals come first, and in each the pairs that are deepest, so that most hits are found
//! soon.

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

/// Memory for edges, lent by the caller.
#[derive(Debug)]
pub struct MotionMemory<'m> {
    /// Twice as many as bodies move.
    pub poses: &'m mut [Pose],
    /// For pairs in intervals that wait: as many as there are pairs of bodies near each other, twice, and more where these come
    /// close. What there is no room for stays unresolved.
    pub waiting: &'m mut [MotionHit],
}

/// What became of an edge.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum MotionVerdict {
    /// No two bodies that are asked meet at any time from 0 to 1.
    Free,
    /// Two bodies meet at this time. It need not be the first.
    Hit {
        /// The bodies.
        hit: SceneHit,
        /// When.
        time: f64,
    },
    /// No hit was found; but before this interval of time nothing meets, and within it something may.
    Unresolved {
        /// When it begins.
        from: f64,
        /// When it ends: not more than the resolution later, if neither budget nor room ended the query.
        to: f64,
    },
}

/// A verdict on an edge, and what it cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct MotionAnswer {
    /// The verdict.
    pub verdict: MotionVerdict,
    /// At how many times the bodies were placed.
    pub times: u64,
    /// Pairs of bodies that were asked about, once for each time.
    pub pairs: u64,
    /// The work for these pairs.
    pub stats: QueryStats,
}

impl MotionAnswer {
    fn new() -> Self {
        Self { verdict: MotionVerdict::Free, times: 0, pairs: 0, stats: QueryStats::default() }
    }

    /// Whether all bodies are certainly free of those that they are asked against, all the way.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self.verdict, MotionVerdict::Free)
    }
}

impl<N: Lanes> Scene<'_, N> {
    /// Do any two bodies that are asked against each other meet at any time of a motion of some of them, and of what is
    /// attached to these? All others stand still. **Free is certain for all times**, not for samples of them.
    ///
    /// `moving` names the bodies that the motion numbers from 0. No interval of time shorter than `resolution` is halved: what
    /// comes so near that this would be needed is unresolved. The query's hint is not heeded; its budget is for all pairs and
    /// times together. Afterwards the bodies stand where they stood.
    ///
    /// # Errors
    /// [`SceneError`]: a body that is not there, or is attached; not as many bodies or poses as the motion needs
    /// ([`SceneError::Motion`]); a pose on the way; a resolution that is not above 0 ([`SceneError::Tolerance`]).
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

    /// The same question at some times only: at those that divide 0 to 1 into `parts` evenly, both ends among them, in an order
    /// that halves the longest gaps first, until one is a hit. The verdict is never [`MotionVerdict::Free`]: between the times,
    /// nothing is known.
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

    /// Notes where the moving bodies stand, and what moves with them. The poses on the way, and those.
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

/// How much nearer two bodies, and what is at most `beyond` away from the balls around them, may come to each other within a
/// span of a motion than they are. Infinite where it overflows.
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

/// A way that overflows may be no number: then it is longer than all. None is negative.
fn finite_or_infinite(path: f64) -> f64 {
    if (0.0..=MAX_COORDINATE).contains(&path) { path } else { f64::INFINITY }
}
