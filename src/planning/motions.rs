//! Queries of straight motions in the joints.

use super::PlanningNode;
use super::angles::shorter_way;
use super::error::PlanningError;
use super::scene::PlanningScene;
use super::screen::{Doubts, MotionByBounds, OpenPair, Screen};
use super::workspace::Workspace;
use crate::motion::{JointMotion, MotionError};
use crate::scene::{MotionAnswer, MotionMemory, MotionVerdict, Scene, SceneError, check_resolution};
use crate::vector::sqrt;
use alloc::vec::Vec;
use core::num::NonZeroU32;

/// The resolution of [`PlanningScene::free_share`].
const SHARE: f64 = 1.0 / 1024.0;

impl PlanningScene {
    /// Is the straight motion from one configuration to another free at all times ([`Scene::check_motion`])? Continuous
    /// joints rotate the shorter way around.
    ///
    /// After [`PlanningScene::use_bounds`], bounds decide most motions, with the same verdict. The reported hit may
    /// then differ, the statistics cover only the scene's share of the work, and a motion that was unresolved may be
    /// free.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`], for either end.
    pub fn check_motion(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
    ) -> Result<MotionAnswer, PlanningError> {
        match self.motion_by_bounds(workspace, ends)? {
            MotionByBounds::Free => Ok(MotionAnswer::new()),
            MotionByBounds::Hit(time) => self.along(workspace, |scene, motion, memory| {
                scene.check_motion_at(&self.query, &self.links, motion, time, memory)
            }),
            MotionByBounds::Open => self.check_open(workspace),
            MotionByBounds::Unknown => self.check_motion_in_scene(workspace),
        }
    }

    /// Whether a motion is certainly free at all times: as [`PlanningScene::check_motion`], but if bounds show a hit,
    /// without a search for the two bodies that meet.
    ///
    /// # Errors
    /// As [`PlanningScene::check_motion`].
    pub fn is_motion_free(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
    ) -> Result<bool, PlanningError> {
        match self.motion_by_bounds(workspace, ends)? {
            MotionByBounds::Free => Ok(true),
            MotionByBounds::Hit(_) => Ok(false),
            MotionByBounds::Open => Ok(self.check_open(workspace)?.is_free()),
            MotionByBounds::Unknown => Ok(self.check_motion_in_scene(workspace)?.is_free()),
        }
    }

    /// As [`PlanningScene::check_motion`], but only at `parts + 1` samples, which prove nothing about the times between
    /// them ([`Scene::check_motion_discrete`]).
    ///
    /// # Errors
    /// As [`PlanningScene::check_motion`].
    pub fn check_motion_discrete(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
        parts: NonZeroU32,
    ) -> Result<MotionAnswer, PlanningError> {
        self.set_ends(workspace, ends)?;
        self.along(workspace, |scene, motion, memory| {
            scene.check_motion_discrete(&self.query, &self.links, motion, parts, memory)
        })
    }

    /// Which motions are certainly free at all times? `motions` holds the values of each motion's start and then of its
    /// end. Runs on several threads with the feature `rayon`, with the same answers.
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
    /// it is certainly free. Allocates as [`PlanningScene::check_states`] does.
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
            *free = self.is_motion_free(workspace, [from, to])?;
        }
        Ok(())
    }

    /// How much of a straight motion, as a fraction from its start, is certainly free at all times? 1 for the whole
    /// motion, and 0 if not even the start is free. Otherwise the motion to [`PlanningScene::between`] at this fraction
    /// is free, and a hit or an unresolved time follows after at most 1/1024 of the motion.
    ///
    /// # Errors
    /// As [`PlanningScene::check_motion`].
    pub fn free_share(&self, workspace: &mut Workspace, ends: [&[f64]; 2]) -> Result<f64, PlanningError> {
        let [from, to] = ends;
        let is_free_to = |workspace: &mut Workspace, share| {
            let there = self.between(from, to, share)?;
            self.is_motion_free(workspace, [from, &there])
        };
        let mut high = match self.check_motion(workspace, ends)?.verdict {
            MotionVerdict::Free => return Ok(1.0),
            // Nothing meets before this time, up to the rounding of the configuration there.
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

    /// Checks the motion between the ends in the workspace without bounds.
    fn check_motion_in_scene(&self, workspace: &mut Workspace) -> Result<MotionAnswer, PlanningError> {
        self.along(workspace, |scene, motion, memory| {
            scene.check_motion(&self.query, &self.links, motion, self.resolution, memory)
        })
    }

    /// Checks what bounds leave open of the motion between the ends in the workspace.
    fn check_open(&self, workspace: &mut Workspace) -> Result<MotionAnswer, PlanningError> {
        let Some((screen, doubts)) = self.screen.as_ref().zip(workspace.doubts.take()) else {
            return self.check_motion_in_scene(workspace);
        };
        let answer = self.along(workspace, |scene, motion, memory| {
            let pending = screen.open_spans(&doubts).flat_map(|(pair, interval)| {
                let (id, others, own) = match pair {
                    OpenPair::Standing((id, _), others) => (id, others, None),
                    OpenPair::Own([(id, _), (other, _)]) => (id, &[][..], Some(other)),
                };
                others.iter().copied().chain(own).map(move |other| ([id, other], interval))
            });
            scene.check_pending(&self.query, &self.links, motion, self.resolution, memory, pending)
        });
        workspace.doubts = Some(doubts);
        answer
    }

    /// Writes the ends to the workspace, and decides what bounds decide.
    fn motion_by_bounds(
        &self,
        workspace: &mut Workspace,
        ends: [&[f64]; 2],
    ) -> Result<MotionByBounds, PlanningError> {
        self.set_ends(workspace, ends)?;
        let Some(screen) = self.screen.as_ref().filter(|_| self.query.budget() == u64::MAX) else {
            return Ok(MotionByBounds::Unknown);
        };
        check_resolution(self.resolution)?;
        let Some(mut doubts) = workspace.doubts.take() else { return Ok(MotionByBounds::Unknown) };
        let verdict = self.decide_by_bounds(workspace, screen, &mut doubts);
        workspace.doubts = Some(doubts);
        verdict
    }

    fn decide_by_bounds(
        &self,
        workspace: &mut Workspace,
        screen: &Screen,
        doubts: &mut Doubts,
    ) -> Result<MotionByBounds, PlanningError> {
        let (isa, [_, from, to]) = (self.query.isa(), &workspace.values);
        let mut verdict = screen.start_motion(isa, [from, to], doubts);
        for step in Screen::STEPS {
            if verdict != MotionByBounds::Open {
                break;
            }
            if let Some(time) = self.time_of_a_hit(workspace, screen.pairs_at_times(doubts))? {
                return Ok(MotionByBounds::Hit(time));
            }
            verdict = step(screen, isa, doubts);
        }
        Ok(verdict)
    }

    /// A time at which one of the pairs meets, in the motion between the values in the workspace.
    fn time_of_a_hit<'s>(
        &self,
        workspace: &mut Workspace,
        pairs: impl Iterator<Item = (OpenPair<'s>, f64)>,
    ) -> Result<Option<f64>, PlanningError> {
        let mut pairs = pairs.peekable();
        while let Some(&(_, time)) = pairs.peek() {
            let [now, from, to] = &mut workspace.values;
            for (now, (from, to)) in now.iter_mut().zip(from.iter().zip(&*to)) {
                *now = from + time * (to - from);
            }
            let is_now = |pair: &(OpenPair<'s>, f64)| pair.1.to_bits() == time.to_bits();
            let of_time = core::iter::from_fn(|| pairs.next_if(is_now).map(|pair| pair.0));
            if !self.are_pairs_free(workspace, of_time)? {
                return Ok(Some(time));
            }
        }
        Ok(None)
    }

    /// Writes the values of all variables at both ends to the workspace.
    fn set_ends(&self, workspace: &mut Workspace, ends: [&[f64]; 2]) -> Result<(), PlanningError> {
        self.serve(workspace);
        let [_, from, to] = &mut workspace.values;
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
        Ok(())
    }

    /// Asks the scene of the motion between the ends in the workspace.
    fn along(
        &self,
        workspace: &mut Workspace,
        check: impl FnOnce(
            &mut Scene<'static, PlanningNode>,
            &mut JointMotion<'_>,
            &mut MotionMemory<'_>,
        ) -> Result<MotionAnswer, SceneError>,
    ) -> Result<MotionAnswer, PlanningError> {
        workspace.reserve_motion();
        let Workspace { scene, links, poses, values: [now, from, to], waiting, .. } = workspace;
        let kinematics = self.kinematics();
        let mut motion = JointMotion::new(kinematics, [from, to], now, links)?;
        Ok(check(scene, &mut motion, &mut MotionMemory { poses, waiting })?)
    }

    /// The configuration at a fraction, from 0 to 1, of the straight motion between two others.
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

    /// The distance of two configurations in joint space, where continuous joints rotate the shorter way around.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is not one value for each variable.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> Result<f64, PlanningError> {
        self.check_lengths(a, b)?;
        Ok(sqrt(self.squared_distance(a, b)))
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

    /// The square of [`PlanningScene::distance`].
    pub(super) fn squared_distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let square = |(i, (&from, &to))| {
            let (from, to) = self.shorter(i, from, to);
            (to - from) * (to - from)
        };
        a.iter().zip(b).enumerate().map(square).sum()
    }

    /// The ends of the i-th planned variable's motion.
    fn shorter(&self, i: usize, from: f64, to: f64) -> (f64, f64) {
        if self.robot.robot().continuous[self.variables[i]] { shorter_way(from, to) } else { (from, to) }
    }
}
