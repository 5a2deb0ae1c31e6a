//! The memory of one thread.

use super::Node;
use super::error::PlanningError;
use super::scene::PlanningScene;
use crate::motion::LinkFrame;
use crate::pose::Pose;
use crate::scene::{MotionHit, Scene};
use alloc::vec;
use alloc::vec::Vec;

/// Pending pairs of bodies in intervals of time. Motions of a robot of 42 bodies among a dozen objects need less.
const WAITING: usize = 8192;

/// Memory for the queries of one thread: a copy of the scene in which the robot moves, with the trees shared.
#[derive(Clone, Debug)]
pub struct Workspace {
    stamp: u64,
    pub(super) scene: Scene<'static, Node>,
    pub(super) links: Vec<LinkFrame>,
    /// Two for each body of the robot.
    pub(super) poses: Vec<Pose>,
    /// Values of all variables: now, and at both ends of a motion.
    pub(super) values: [Vec<f64>; 3],
    pub(super) waiting: Vec<MotionHit>,
}

impl Workspace {
    pub(super) fn new(scene: &PlanningScene) -> Self {
        let variables = scene.robot.robot().variables.len();
        Self {
            stamp: scene.stamp,
            scene: scene.scene.clone(),
            links: vec![LinkFrame::EMPTY; scene.robot.robot().joints.len() + 1],
            poses: vec![Pose::IDENTITY; 2 * scene.links.len()],
            values: [(); 3].map(|()| vec![0.0; variables]),
            waiting: Vec::new(),
        }
    }

    /// Copies the scene if it is not the one that the workspace served last.
    pub(super) fn serve(&mut self, scene: &PlanningScene) {
        if self.stamp != scene.stamp {
            let waiting = core::mem::take(&mut self.waiting);
            *self = Self { waiting, ..Self::new(scene) };
        }
    }

    /// Places the robot.
    pub(super) fn go_to(&mut self, scene: &PlanningScene, values: &[f64]) -> Result<(), PlanningError> {
        self.serve(scene);
        let [all, ..] = &mut self.values;
        scene.complete(values, all)?;
        scene.kinematics()?.go_to(all, &mut self.links, &mut self.poses)?;
        for (&id, pose) in scene.links.iter().zip(&self.poses) {
            self.scene.place(id, pose)?;
        }
        Ok(())
    }

    /// Pending pairs of a motion.
    pub(super) fn reserve_motion(&mut self) {
        self.waiting.resize(WAITING, MotionHit::EMPTY);
    }
}
