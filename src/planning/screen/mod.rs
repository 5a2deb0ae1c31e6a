//! Verdicts of sixteen configurations at a time by bounds that are cheap and certain.
//!
//! Each body of the robot is covered by spheres, and some spheres are inside of it ([`links`]). Where they are in
//! sixteen configurations, up to a bound of the error, follows from kinematics in lanes ([`chain`]). Everything that
//! stands still is in clearance grids ([`grid`]), so that one look-up a sphere says free, met, or neither. Of two bodies
//! that both move, one has a grid of its own, which the spheres of the other are looked up in; a [`table`] comes first
//! where their relative pose depends on few joints.
//!
//! Whatever stays open is a pair of bodies in a lane, and goes to the scene. So verdicts are those of the scene: where
//! the bounds say free, the bodies are farther apart than the rounding of the scene's poses, and where they say met,
//! deeper in each other.

mod apart;
mod blocks;
mod bodies;
mod chain;
mod decide;
mod field;
mod grid;
mod lanes;
mod links;
mod robot;
mod standing;
mod table;
#[cfg(test)]
mod tests;
mod whole;

pub(super) use bodies::ScreenedScene;
pub(super) use decide::{Doubts, LaneVerdicts, OpenPair};
pub(super) use lanes::LANES;
pub(super) use robot::RobotBounds;
pub(super) use whole::Screen;
