//! Queries of straight motions in the joints.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::motion::JointMotion;
use crate::scene::{MotionAnswer, MotionMemory};
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
use core::num::NonZeroU32;

impl PlanningScene {
    /// Is the straight motion from one configuration to another free at all times
    /// ([`Scene::check_motion`](crate::Scene::check_motion))? Continuous joints take the shorter way around.
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
    /// between them ([`Scene::check_motion_discrete`](crate::Scene::check_motion_discrete)).
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
        self.on_threads(motions, 2 * self.variables(), |workspace, values| {
            let (from, to) = values.split_at(self.variables());
            Ok(self.check_motion(workspace, [from, to])?.is_free())
        })
    }

    fn along(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
        check: impl FnOnce(
            &mut crate::Scene<'static, super::Node>,
            &mut JointMotion<'_>,
            &mut MotionMemory<'_>,
        ) -> Result<MotionAnswer, crate::scene::SceneError>,
    ) -> Result<MotionAnswer, PlanningError> {
        workspace.serve(self);
        workspace.reserve_motion();
        let Workspace { scene, links, poses, values: [now, from, to], waiting, .. } = workspace;
        self.complete(ends[0], from)?;
        self.complete(ends[1], to)?;
        let kinematics = self.kinematics()?;
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

    /// The distance of two configurations in the joints, where continuous joints take the shorter way around.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is not one value for each variable.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> Result<f64, PlanningError> {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        self.complete(a, &mut from)?;
        self.complete(b, &mut to)?;
        let continuous = &self.robot.robot().continuous;
        let square = |&variable: &usize| {
            let (mut p, mut q) = (from[variable], to[variable]);
            if continuous[variable] {
                (p, q) = shorter_way(p, q);
            }
            (q - p) * (q - p)
        };
        Ok(libm::sqrt(self.variables.iter().map(square).sum()))
    }
}

/// The ends of the shorter way between two angles: the first within half a turn of 0, and the second within half a turn
/// of the first. Up to rounding of 2^-50.
fn shorter_way(from: f64, to: f64) -> (f64, f64) {
    let near = |angle: f64| angle - TAU * libm::round(angle / TAU);
    let start = near(from).clamp(-PI, PI);
    (start, start + near(to - from).clamp(-PI, PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_way_is_at_most_half_a_turn() {
        for i in -20..=20 {
            for j in -20..=20 {
                let (from, to) = (f64::from(i) * 0.3, f64::from(j) * 0.3);
                let (p, q) = shorter_way(from, to);
                assert!(p.abs() <= PI + 1e-12 && (q - p).abs() <= PI);
                for (angle, same) in [(from, p), (to, q)] {
                    let turns = (angle - same) / TAU;
                    assert!((turns - turns.round()).abs() < 1e-12, "{from} {to}");
                }
            }
        }
    }
}
