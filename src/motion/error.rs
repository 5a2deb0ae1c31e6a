//! What motions refuse.

use crate::pose::PoseError;
use core::fmt;

/// Why there is no such motion.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum MotionError {
    /// A joint is on a link that does not come before it, or a body on a link that is none.
    NoSuchLink {
        /// Index of the joint, or of the body behind all joints.
        index: usize,
        /// The link that it names.
        link: u32,
    },
    /// A joint is moved by a variable that has no limits.
    NoSuchVariable {
        /// Index of the joint.
        joint: usize,
        /// The variable that it names.
        variable: u32,
    },
    /// The limits of a variable are not numbers, or the lower is above the upper.
    Limits {
        /// The variable.
        variable: usize,
    },
    /// An axis is no direction: zero, or not finite.
    NoDirection,
    /// A number is not finite.
    NotFinite,
    /// There are more or fewer values than variables, or less room than is needed.
    Length {
        /// How many were given.
        given: usize,
        /// How many there have to be, at least if it is room.
        needed: usize,
    },
    /// A value is outside of the limits of its variable.
    OutOfLimits {
        /// The variable.
        variable: usize,
        /// Its value.
        given: f64,
    },
    /// A pose on the way is none.
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
            Self::Limits { variable } => write!(f, "the limits of variable {variable} are no interval"),
            Self::NoDirection => {
                f.write_str("an axis must be a vector of finite numbers that are not all zero")
            }
            Self::NotFinite => f.write_str("a number of a motion is not finite"),
            Self::Length { given, needed } => {
                write!(f, "{given} values or places are given, {needed} needed")
            }
            Self::OutOfLimits { variable, given } => {
                write!(f, "the value {given} of variable {variable} is outside of its limits")
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
