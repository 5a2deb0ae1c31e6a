//! The queries of edges.

use super::answer::MotionAnswer;
#[cfg(doc)]
use super::answer::MotionVerdict;
use super::queue::{MotionHit, MotionQueue};
use super::search::MotionSearch;
use crate::motion::Motion;
use crate::pose::Pose;
use crate::query::{Lanes, Query, ToleranceError};
use crate::scene::body::BodyId;
use crate::scene::error::SceneError;
use crate::scene::placement::Scene;
use core::num::NonZeroU32;

/// Memory for edges, borrowed from the caller.
#[derive(Debug)]
pub struct MotionMemory<'m> {
    /// Two poses for each moving body.
    pub poses: &'m mut [Pose],
    /// Pending pairs, each with an interval of time: twice as many as there are pairs of nearby bodies, and more where
    /// these come close. Pairs that do not fit stay unresolved.
    pub waiting: &'m mut [MotionHit],
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
