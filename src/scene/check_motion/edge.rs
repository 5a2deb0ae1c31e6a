//! The motion queries of a scene.

use super::answer::MotionAnswer;
#[cfg(doc)]
use super::answer::MotionVerdict;
#[cfg(feature = "planning")]
use super::queue::{Interval, Unresolved};
use super::queue::{MotionHit, MotionQueue};
use super::search::MotionSearch;
use crate::motion::Motion;
use crate::pose::Pose;
use crate::query::{Lanes, Query, ToleranceError};
use crate::scene::body::BodyId;
use crate::scene::error::SceneError;
use crate::scene::placement::Scene;
use core::num::NonZeroU32;

/// Memory for motion queries, borrowed from the caller.
#[derive(Debug)]
pub struct MotionMemory<'m> {
    /// Two poses for each moving body.
    pub poses: &'m mut [Pose],
    /// Pending pairs, each with an interval of time: two for each pair of nearby bodies, and more if these come close.
    /// Pairs that do not fit stay unresolved.
    pub waiting: &'m mut [MotionHit],
}

/// Checks a resolution of motions.
pub(crate) fn check_resolution(resolution: f64) -> Result<(), SceneError> {
    if resolution.is_nan() || resolution <= 0.0 {
        return Err(SceneError::Tolerance(ToleranceError { given: resolution }));
    }
    Ok(())
}

impl<N: Lanes> Scene<'_, N> {
    /// Do any two tested bodies meet at any time of a motion? The motion moves the `moving` bodies and all bodies
    /// attached to them; all others stand still. **Free is certain for all times**, not only for samples.
    ///
    /// `moving` lists the bodies in the order in which the motion numbers them. No interval of time shorter than
    /// `resolution` is halved: pairs too close to certify at this resolution are unresolved. Ignores the query's hint;
    /// its budget covers all pairs and times together. Afterwards the bodies are where they were.
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
        check_resolution(resolution)?;
        let queue = MotionQueue::new(memory.waiting);
        self.search_motion((query, moving, motion), memory.poses, |search| search.run(resolution, queue))
    }

    /// As [`Scene::check_motion`], but only for some pairs of bodies, each in an interval of time, sorted by interval.
    /// All others are known to be free.
    #[cfg(feature = "planning")]
    pub(crate) fn check_pending(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        motion: &mut impl Motion,
        resolution: f64,
        memory: &mut MotionMemory<'_>,
        pending: impl Iterator<Item = ([BodyId; 2], Interval)>,
    ) -> Result<MotionAnswer, SceneError> {
        let (mut queue, mut unresolved) = (MotionQueue::new(memory.waiting), Unresolved(None));
        self.search_motion((query, moving, motion), memory.poses, |search| {
            for ([a, b], Interval(interval)) in pending {
                let (i, j) = search.scene.place_to_ask(a, b)?;
                let pair = MotionHit { a: i as u32, b: j as u32, interval };
                if search.scene.is_asked(a, b)? && !queue.push(pair) {
                    unresolved.add(interval);
                }
            }
            search.run_pending(resolution, queue, unresolved)
        })
    }

    /// Tests a motion at one time. The verdict is never [`MotionVerdict::Free`].
    #[cfg(feature = "planning")]
    pub(crate) fn check_motion_at(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        motion: &mut impl Motion,
        time: f64,
        memory: &mut MotionMemory<'_>,
    ) -> Result<MotionAnswer, SceneError> {
        self.search_motion((query, moving, motion), memory.poses, |search| search.at(time))
    }

    /// Tests a motion at discrete times only: those that divide 0 to 1 into `parts` equal parts, both ends included.
    /// The search halves the longest gaps first, and stops at the first hit. The verdict is never
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
        self.search_motion((query, moving, motion), memory.poses, |search| search.sample(parts))
    }

    /// Searches a motion. Afterwards the bodies are where they were.
    #[inline(always)]
    fn search_motion<M: Motion>(
        &mut self,
        (query, moving, motion): (&Query, &[BodyId], &mut M),
        poses: &mut [Pose],
        search: impl FnOnce(MotionSearch<'_, '_, '_, N, M>) -> Result<MotionAnswer, SceneError>,
    ) -> Result<MotionAnswer, SceneError> {
        let (poses, before) = self.set_out(moving, motion.bodies(), poses)?;
        let answer = search(MotionSearch { scene: self, query, moving, motion, poses });
        self.place_all(moving, before)?;
        answer
    }

    /// Sets the carriers of all bodies, and saves the poses of the moving ones. Returns memory for the poses of the
    /// motion, and the saved poses.
    pub(in crate::scene) fn set_out<'m>(
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
