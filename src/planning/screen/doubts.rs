//! What the bounds leave undecided in sixteen configurations, or in spans of a motion, and memory for it.

use super::chain::LaneFrame;
use super::lanes::{LANES, Lane16, Point16};
use crate::scene::BodyId;
use alloc::vec::Vec;

/// An undecided pair: bodies that may meet.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Doubt {
    /// A body against all bodies of a field, which stand still.
    Field { field: usize, asked: usize },
    /// Two bodies of the robot.
    Pair { pair: usize },
    /// A pair with a table.
    Table { pair: usize },
}

/// Memory for sixteen configurations, and what the bounds leave undecided.
#[derive(Clone, Debug)]
pub(in crate::planning) struct Doubts {
    pub(super) frames: Vec<LaneFrame>,
    /// The centres of the spheres around whole bodies.
    pub(super) wholes: Vec<Point16>,
    pub(super) doubts: Vec<(Doubt, u16)>,
    /// Values of each variable.
    pub(in crate::planning) values: Vec<[f64; LANES]>,
    /// Memory for a motion.
    pub(super) motion: MotionSpans,
}

/// Lanes in which the robot is certainly free, and those in which it certainly meets something.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::planning) struct LaneVerdicts {
    pub(in crate::planning) free: u16,
    pub(in crate::planning) hit: u16,
}

/// A body that the robot moves, and the index of the robot's body that it is, or is attached to.
pub(in crate::planning) type MovedBody = (BodyId, usize);

/// Bodies that the scene must decide.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::planning) enum OpenPair<'s> {
    /// A moving body against bodies that stand still.
    Standing(MovedBody, &'s [BodyId]),
    /// Two moving bodies.
    Own([MovedBody; 2]),
}

/// A pair of bodies that is undecided in an interval of time.
pub(super) type OpenSpan = (Doubt, u32);

/// A pair of bodies in doubt.
#[derive(Copy, Clone, Debug)]
pub(super) struct SpanDoubt {
    pub(super) doubt: Doubt,
    /// The lanes in whose spans the pair is in doubt.
    pub(super) lanes: u16,
    /// The lanes among these in which it is in doubt at the middle.
    pub(super) now: u16,
}

/// A motion, and memory for it.
#[derive(Clone, Debug)]
pub(in crate::planning) struct MotionSpans {
    /// Values of all variables.
    pub(super) ends: [Vec<f64>; 2],
    /// How much each joint changes.
    pub(super) changes: Vec<f32>,
    /// The length of the motion in cells of each pair's table.
    pub(super) along: Vec<f32>,
    /// The interval of each lane, and half of its length.
    pub(super) intervals: [u32; LANES],
    pub(super) spans: Lane16,
    /// How far each body moves ([`super::levers::Levers::go_to`]).
    pub(super) moved: Vec<Lane16>,
    /// Bodies that were placed in the lanes.
    pub(super) is_placed: Vec<bool>,
    pub(super) doubts: Vec<SpanDoubt>,
    /// Pairs that may meet at a time.
    pub(super) at_times: Vec<(Doubt, f64)>,
    /// Intervals to be halved.
    pub(super) waiting: [Vec<OpenSpan>; 2],
    pub(super) open: Vec<OpenSpan>,
}

impl MotionSpans {
    pub(super) fn ends(&self) -> [&[f64]; 2] {
        self.ends.each_ref().map(|end| &end[..])
    }
}

/// The bounds' verdict on a motion.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(in crate::planning) enum MotionByBounds {
    Free,
    /// Bodies meet at this time.
    Hit(f64),
    /// The open pairs of bodies decide.
    Open,
    /// The scene decides.
    Unknown,
}
