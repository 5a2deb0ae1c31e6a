//! The memory of one thread.

use super::PlanningNode;
use super::screen::Doubts;
use crate::motion::LinkFrame;
use crate::pose::Pose;
use crate::range::Point;
use crate::scene::{MotionHit, Scene};
use alloc::vec::Vec;

/// Capacity for pending pairs of bodies in intervals of time. Motions of a robot of 42 bodies among a dozen objects
/// need less.
const WAITING: usize = 8192;

/// Memory for the queries of one thread: a copy of the scene in which the robot moves, with the trees shared.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The stamp of the copied scene.
    pub(super) stamp: u64,
    pub(super) scene: Scene<'static, PlanningNode>,
    /// Whether all bodies of the robot were placed once.
    pub(super) is_placed: bool,
    pub(super) links: Vec<LinkFrame>,
    /// Two poses for each body of the robot.
    pub(super) poses: Vec<Pose>,
    /// Values of all variables: now, and at both ends of a motion.
    pub(super) values: [Vec<f64>; 3],
    pub(super) waiting: Vec<MotionHit>,
    /// The derivatives of a point with respect to each variable.
    pub(super) derivatives: Vec<Point>,
    /// Memory for sixteen configurations.
    pub(super) doubts: Option<Doubts>,
}

impl Workspace {
    /// Pending pairs of a motion.
    pub(super) fn reserve_motion(&mut self) {
        self.waiting.resize(WAITING, MotionHit::EMPTY);
    }
}
