//! What is wrong with the description of a robot.

use crate::motion::MotionError;
use crate::pose::PoseError;
use alloc::string::String;
use core::fmt;

/// Why a description is no robot.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum RobotError {
    /// The text is not a URDF or SRDF file.
    Format {
        /// What its reader says.
        problem: String,
    },
    /// A joint names a link that there is not.
    NoSuchLink {
        /// The joint.
        joint: String,
        /// The link.
        link: String,
    },
    /// There is not one link that all others hang on: joints form a cycle, or two lead to one link, or to none.
    NoTree {
        /// A link at fault.
        link: String,
    },
    /// A joint can move in more than one way: floating, planar or spherical. Such a robot stands in the world by the pose of
    /// its base.
    Kind {
        /// The joint.
        joint: String,
    },
    /// A joint mimics one that there is not, or that does not move, or that itself mimics one.
    Mimic {
        /// The joint.
        joint: String,
    },
    /// A joint that moves has an axis or limits that are none.
    Joint {
        /// The joint.
        joint: String,
        /// What is wrong with it.
        error: MotionError,
    },
    /// An origin is no pose.
    Pose {
        /// The joint or link that it is of.
        of: String,
        /// What is wrong with it.
        error: PoseError,
    },
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format { problem } => write!(f, "not a robot's description: {problem}"),
            Self::NoSuchLink { joint, link } => {
                write!(f, "joint {joint} names the link {link}, which there is not")
            }
            Self::NoTree { link } => write!(f, "the links are no tree: see {link}"),
            Self::Kind { joint } => {
                write!(f, "joint {joint} is floating, planar or spherical: only those with one axis can be")
            }
            Self::Mimic { joint } => write!(f, "joint {joint} mimics one that does not move by itself"),
            Self::Joint { joint, error } => write!(f, "joint {joint}: {error}"),
            Self::Pose { of, error } => write!(f, "the origin of {of}: {error}"),
        }
    }
}

impl core::error::Error for RobotError {}
