//! What a scene refuses.

use super::BodyId;
#[cfg(doc)]
use super::{Scene, boxes_for, rows_for};
use crate::motion::MotionError;
use crate::pose::PoseError;
use crate::query::ToleranceError;
#[cfg(doc)]
use crate::range::MAX_COORDINATE;
use core::fmt;

/// Why a scene does not take what it is given.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum SceneError {
    /// There is no room for another body in the memory that was lent.
    Full,
    /// The memory that was lent is too small for as many bodies as it has slots for.
    Memory {
        /// Slots.
        bodies: usize,
        /// Nodes of boxes that are needed: [`boxes_for`].
        boxes: usize,
        /// Words that are needed: [`rows_for`].
        rows: usize,
    },
    /// Less was lent than many configurations need.
    Configurations {
        /// Boxes that are needed: the scene's room.
        boxes: usize,
        /// Words that are needed: one for sixteen configurations.
        words: usize,
    },
    /// Clouds are not asked against each other.
    TwoClouds {
        /// One of them.
        id: BodyId,
    },
    /// The body was removed, or is of another scene.
    NoSuchBody {
        /// The id given.
        id: BodyId,
    },
    /// A body's radius is negative, NaN or beyond [`MAX_COORDINATE`].
    Radius {
        /// The value given.
        given: f64,
    },
    /// The pose is farther from a rotation than [`Scene::TOLERANCE`], or farther away than [`Scene::MAX_TRANSLATION`].
    Pose(PoseError),
    /// A body that is attached is placed with what it is attached to.
    IsAttached {
        /// The body.
        id: BodyId,
    },
    /// A body would be attached to itself.
    Cycle {
        /// The body.
        id: BodyId,
    },
    /// A pair of one body.
    NoPair {
        /// The body.
        id: BodyId,
    },
    /// As many bodies as a motion moves have to be named, and twice as many poses lent.
    Motion {
        /// How many bodies the motion moves.
        bodies: usize,
        /// How many were named.
        given: usize,
        /// How many poses were lent.
        poses: usize,
    },
    /// A motion or its robot is none: values and limits, or a pose on the way.
    Path(MotionError),
    /// A margin, cutoff or tolerance is negative, NaN or too great.
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
                write!(f, "body {} is a cloud, and is not asked against another one", id.index)
            }
            Self::NoSuchBody { id } => {
                write!(f, "there is no body {} in the scene, or not any more", id.index)
            }
            Self::Radius { given } => {
                write!(f, "a body's radius of {given}: must be finite and not negative")
            }
            Self::Pose(error) => write!(f, "a pose in the world: {error}"),
            Self::IsAttached { id } => {
                write!(f, "body {} is attached to another, and placed with it", id.index)
            }
            Self::Cycle { id } => write!(f, "body {} would be attached to itself", id.index),
            Self::NoPair { id } => write!(f, "body {} is no pair with itself", id.index),
            Self::Motion { bodies, given, poses } => {
                write!(f, "a motion of {bodies} bodies: {given} are named, and {poses} poses lent")
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
