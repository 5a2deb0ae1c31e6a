//! Errors of scenes.

use super::body::BodyId;
#[cfg(doc)]
use super::{Scene, boxes_for, rows_for};
use crate::motion::MotionError;
use crate::pose::PoseError;
use crate::query::ToleranceError;
#[cfg(doc)]
use crate::range::MAX_COORDINATE;
use core::fmt;

/// Why a scene rejects its input.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum SceneError {
    /// The caller's memory has no room for another body.
    Full,
    /// The caller's memory is too small for the number of its slots.
    Memory {
        /// Number of slots.
        bodies: usize,
        /// Number of boxes needed: [`boxes_for`].
        boxes: usize,
        /// Number of words needed: [`rows_for`].
        rows: usize,
    },
    /// There are too few boxes or words for the configurations.
    Configurations {
        /// Number of boxes needed: the scene's room.
        boxes: usize,
        /// Number of words needed: one for each sixteen configurations.
        words: usize,
    },
    /// Two clouds cannot be tested against each other.
    TwoClouds {
        /// One of them.
        id: BodyId,
    },
    /// The body was removed, or belongs to another scene.
    NoSuchBody {
        /// The id given.
        id: BodyId,
    },
    /// A body's radius is negative, NaN or beyond [`MAX_COORDINATE`].
    Radius {
        /// The value given.
        given: f64,
    },
    /// The pose is farther from a rotation than [`Scene::TOLERANCE`], or its position exceeds
    /// [`Scene::MAX_TRANSLATION`].
    Pose(PoseError),
    /// The body is attached to another, and is placed with it.
    IsAttached {
        /// The body.
        id: BodyId,
    },
    /// The body would be attached to itself, directly or not.
    Cycle {
        /// The body.
        id: BodyId,
    },
    /// Both bodies of the pair are the same.
    NoPair {
        /// The body.
        id: BodyId,
    },
    /// The number of bodies given differs from the motion's, or there are fewer than twice as many poses.
    Motion {
        /// Number of bodies that the motion moves.
        bodies: usize,
        /// Number of bodies given.
        given: usize,
        /// Number of poses given.
        poses: usize,
    },
    /// A motion or its robot is invalid: its values, its limits, or one of its poses.
    Path(MotionError),
    /// A margin, cutoff, tolerance or resolution is out of range.
    Tolerance(ToleranceError),
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("the scene's memory has no slot for another body"),
            Self::Memory { bodies, boxes, rows } => {
                write!(f, "{bodies} slots need {boxes} nodes of boxes and {rows} rows")
            }
            Self::Configurations { boxes, words } => {
                write!(f, "the configurations need {boxes} boxes and {words} words")
            }
            Self::TwoClouds { id } => {
                write!(f, "body {} is a cloud, which is not tested against another cloud", id.index)
            }
            Self::NoSuchBody { id } => {
                write!(f, "body {} is not, or no longer, in the scene", id.index)
            }
            Self::Radius { given } => {
                write!(f, "a body's radius of {given}: must be finite and not negative")
            }
            Self::Pose(error) => write!(f, "a pose in the world: {error}"),
            Self::IsAttached { id } => {
                write!(f, "body {} is attached to another, and placed with it", id.index)
            }
            Self::Cycle { id } => write!(f, "body {} would be attached to itself", id.index),
            Self::NoPair { id } => write!(f, "body {} cannot form a pair with itself", id.index),
            Self::Motion { bodies, given, poses } => {
                write!(f, "a motion of {bodies} bodies: {given} are named, and {poses} poses are given")
            }
            Self::Path(error) => error.fmt(f),
            Self::Tolerance(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SceneError {}

impl From<PoseError> for SceneError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

impl From<ToleranceError> for SceneError {
    fn from(error: ToleranceError) -> Self {
        Self::Tolerance(error)
    }
}

impl From<MotionError> for SceneError {
    fn from(error: MotionError) -> Self {
        Self::Path(error)
    }
}
