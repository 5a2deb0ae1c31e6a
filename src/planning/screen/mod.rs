//! Decides sixteen configurations at a time by cheap, conservative bounds.
//!
//! Spheres cover each body of the robot, and other spheres lie inside it ([`links`]). Kinematics in lanes give their
//! positions in sixteen configurations, up to a bound of the error ([`chain`]). Clearance grids hold everything that
//! stands still ([`grid`]), so one look-up per sphere says that it is free, that it meets something, or neither. If two
//! bodies both move, the spheres of one are looked up in a grid around the other; if their relative pose depends on few
//! joints, a [`table`] comes first.
//!
//! The scene decides each pair of bodies that stays open in a lane. So the verdicts are those of the scene: if the
//! bounds say free, the bodies are farther apart than the rounding of the scene's poses; if they say that the bodies
//! meet, the penetration is deeper than that rounding.

mod apart;
mod blocks;
mod bodies;
mod chain;
mod decide;
mod doubts;
mod field;
mod grid;
mod lanes;
mod levers;
mod links;
mod robot;
mod rows;
mod spans;
mod standing;
mod table;
#[cfg(test)]
mod tests;
mod whole;

pub(super) use bodies::ScreenedScene;
pub(super) use doubts::{Doubts, LaneVerdicts, MotionByBounds, OpenPair};
pub(super) use lanes::LANES;
pub(super) use robot::RobotBounds;
pub(super) use whole::Screen;
