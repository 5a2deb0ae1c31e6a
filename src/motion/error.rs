//! Errors of motions.

use crate::pose::PoseError;
use core::fmt;

/// Why a motion or its robot is invalid.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum MotionError {
    /// A joint is on a link that does not come before it, or a body is on a link that does not exist.
    NoSuchLink {
        /// Index of the joint; bodies are counted after all joints.
        index: usize,
        /// The link given.
        link: u32,
    },
    /// A joint follows a variable that has no limits.
    NoSuchVariable {
        /// Index of the joint.
        joint: usize,
        /// The variable given.
        variable: u32,
    },
    /// The limits of a variable are not finite, or the lower exceeds the upper.
    Limits {
        /// The variable.
        variable: usize,
    },
    /// An axis is zero or not finite.
    NoDirection,
    /// A number is not finite.
    NotFinite,
    /// The number of values differs from the number of variables, or a slice is too short.
    Length {
        /// Number given.
        given: usize,
        /// Number needed; for the length of a slice, the least.
        needed: usize,
    },
    /// A value is outside the limits of its variable.
    OutOfLimits {
        /// The variable.
        variable: usize,
        /// Its value.
        given: f64,
    },
    /// A pose of the motion is invalid.
    Pose(PoseError),
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchLink { index, link } => {
                write!(f, "joint or body {index} is on link {link}, which does not come before it")
            }
            Self::NoSuchVariable { joint, variable } => {
                write!(f, "joint {joint} is moved by variable {variable}, which has no limits")
            }
            Self::Limits { variable } => write!(f, "the limits of variable {variable} are not an interval"),
            Self::NoDirection => {
                f.write_str("an axis must be a vector of finite numbers that are not all zero")
            }
            Self::NotFinite => f.write_str("a number of a motion is not finite"),
            Self::Length { given, needed } => {
                write!(f, "{given} values or places are given, {needed} needed")
            }
            Self::OutOfLimits { variable, given } => {
                write!(f, "the value {given} of variable {variable} is outside its limits")
            }
            Self::Pose(error) => write!(f, "a pose on the way: {error}"),
        }
    }
}

impl core::error::Error for MotionError {}

impl From<PoseError> for MotionError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}
