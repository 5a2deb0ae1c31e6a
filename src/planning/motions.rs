//! Queries of straight motions in the joints.

use super::PlanningNode;
use super::angles::shorter_way;
use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::motion::{JointMotion, MotionError};
use crate::scene::{MotionAnswer, MotionMemory, MotionVerdict, Scene, SceneError};
use alloc::vec::Vec;
use core::num::NonZeroU32;

/// Of [`PlanningScene::free_share`].
const SHARE: f64 = 1.0 / 1024.0;

impl PlanningScene {
    /// Is the straight motion from one configuration to another free at all times
    /// ([`Scene::check_motion`])? Continuous joints take the shorter way around.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`], for either end.
    pub fn check_motion(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
    ) -> Result<MotionAnswer, PlanningError> {
        self.along(workspace, ends, |scene, motion, memory| {
            scene.check_motion(&self.query, &self.links, motion, self.resolution, memory)
        })
    }

    /// As [`PlanningScene::check_motion`], at samples only, `parts + 1` of them, which proves nothing about the times
    /// between them ([`Scene::check_motion_discrete`]).
    ///
    /// # Errors
    /// As [`PlanningScene::check_motion`].
    pub fn check_motion_discrete(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
        parts: NonZeroU32,
    ) -> Result<MotionAnswer, PlanningError> {
        self.along(workspace, ends, |scene, motion, memory| {
            scene.check_motion_discrete(&self.query, &self.links, motion, parts, memory)
        })
    }

    /// Which motions are certainly free at all times? Each has the values of its start and then those of its end. Runs
    /// on several threads with the feature `rayon`, with the same answers.
    ///
    /// # Errors
    /// [`PlanningError::Values`] if the number of values is not a multiple of twice the number of variables; as
    /// [`PlanningScene::check_motion`].
    pub fn free_motions(&self, motions: &[f64]) -> Result<Vec<bool>, PlanningError> {
        self.on_threads(motions, 2 * self.variables(), |workspace, motions, free| {
            self.check_motions(workspace, motions, free)
        })
    }

    /// As [`PlanningScene::free_motions`], on this thread: writes to `free`, which has a place for each motion, whether
    /// it is certainly free. Without heap, as [`PlanningScene::check_states`].
    ///
    /// # Errors
    /// As [`PlanningScene::free_motions`].
    pub fn check_motions(
        &self,
        workspace: &mut Workspace,
        motions: &[f64],
        free: &mut [bool],
    ) -> Result<(), PlanningError> {
        let length = 2 * self.variables();
        Self::check_count(motions, length, free.len())?;
        for (free, ends) in free.iter_mut().zip(motions.chunks(length)) {
            let (from, to) = ends.split_at(self.variables());
            *free = self.check_motion(workspace, [from, to])?.is_free();
        }
        Ok(())
    }

    /// Which share of a straight motion, from its start, is certainly free at all times? 1 if all of it is. Otherwise
    /// the motion to [`PlanningScene::between`] at this share is, and a hit or an unresolved time is at most 1/1024 of
    /// the motion later. 0 if not even the start is free.
    ///
    /// # Errors
    /// As [`PlanningScene::check_motion`].
    pub fn free_share(&self, workspace: &mut Workspace, ends: [&[f64]; 2]) -> Result<f64, PlanningError> {
        let [from, to] = ends;
        let is_free_to = |workspace: &mut Workspace, share| {
            let there = self.between(from, to, share)?;
            Ok::<_, PlanningError>(self.check_motion(workspace, [from, &there])?.is_free())
        };
        let mut high = match self.check_motion(workspace, ends)?.verdict {
            MotionVerdict::Free => return Ok(1.0),
            // Nothing meets before it, up to the rounding of the configuration there.
            MotionVerdict::Unresolved { from: time, .. } if is_free_to(workspace, time)? => return Ok(time),
            MotionVerdict::Hit { time, .. } | MotionVerdict::Unresolved { from: time, .. } => time,
        };
        let mut low = 0.0;
        while high - low > SHARE {
            let middle = low + 0.5 * (high - low);
            (low, high) = if is_free_to(workspace, middle)? { (middle, high) } else { (low, middle) };
        }
        Ok(low)
    }

    fn along(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
        check: impl FnOnce(
            &mut Scene<'static, PlanningNode>,
            &mut JointMotion<'_>,
            &mut MotionMemory<'_>,
        ) -> Result<MotionAnswer, SceneError>,
    ) -> Result<MotionAnswer, PlanningError> {
        self.serve(workspace);
        workspace.reserve_motion();
        let Workspace { scene, links, poses, values: [now, from, to], waiting, .. } = workspace;
        self.complete(ends[0], from)?;
        self.complete(ends[1], to)?;
        let kinematics = self.kinematics();
        kinematics.check(from)?;
        kinematics.check(to)?;
        for (variable, is_continuous) in self.robot.robot().continuous.iter().enumerate() {
            if *is_continuous {
                (from[variable], to[variable]) = shorter_way(from[variable], to[variable]);
            }
        }
        let mut motion = JointMotion::new(kinematics, [from, to], now, links)?;
        Ok(check(scene, &mut motion, &mut MotionMemory { poses, waiting })?)
    }

    /// The configuration at a share, from 0 to 1, of the straight motion between two others.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is not one value for each variable.
    pub fn between(&self, a: &[f64], b: &[f64], share: f64) -> Result<Vec<f64>, PlanningError> {
        self.check_lengths(a, b)?;
        let value = |i: usize| {
            let (from, to) = self.shorter(i, a[i], b[i]);
            // Rounding may push the sum beyond the ends.
            (from + share * (to - from)).clamp(from.min(to), from.max(to))
        };
        Ok((0..self.variables()).map(value).collect())
    }

    /// The distance of two configurations in the joints, where continuous joints take the shorter way around.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is not one value for each variable.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> Result<f64, PlanningError> {
        self.check_lengths(a, b)?;
        let square = |i: usize| {
            let (from, to) = self.shorter(i, a[i], b[i]);
            (to - from) * (to - from)
        };
        Ok(libm::sqrt((0..self.variables()).map(square).sum()))
    }
}

impl PlanningScene {
    fn check_lengths(&self, a: &[f64], b: &[f64]) -> Result<(), PlanningError> {
        let needed = self.variables();
        match [a.len(), b.len()].into_iter().find(|given| *given != needed) {
            Some(given) => Err(MotionError::Length { given, needed }.into()),
            None => Ok(()),
        }
    }

    /// The ends of the motion of the i-th variable that is planned for.
    fn shorter(&self, i: usize, from: f64, to: f64) -> (f64, f64) {
        if self.robot.robot().continuous[self.variables[i]] { shorter_way(from, to) } else { (from, to) }
    }
}
