//! Errors in the description of a robot.

use crate::motion::MotionError;
use crate::pose::PoseError;
use crate::primitive::shape::ShapeError;
use alloc::string::String;
use core::fmt;

/// Why a description is not a valid robot.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum RobotError {
    /// The text is not a URDF or SRDF file.
    Format {
        /// The parser's message.
        problem: String,
    },
    /// An SRDF file names a link that the robot does not have.
    UnknownLink {
        /// The line of the file, counted from 1.
        line: u32,
        /// The link.
        link: String,
    },
    /// An SRDF file names a joint that the robot does not have, or a group that is not defined before.
    UnknownMember {
        /// The line of the file, counted from 1.
        line: u32,
        /// The joint or group.
        name: String,
    },
    /// The number of geometries differs from the number of the robot's bodies.
    Bodies {
        /// Number given.
        given: usize,
        /// Number needed.
        needed: usize,
    },
    /// A joint names a link that does not exist.
    NoSuchLink {
        /// The joint.
        joint: String,
        /// The link.
        link: String,
    },
    /// The links are not a tree with one root: joints form a cycle, two joints lead to one link, or a link is not
    /// connected.
    NoTree {
        /// A link at fault.
        link: String,
    },
    /// A joint has more than one degree of freedom: it is floating, planar or spherical. Instead of such a joint at the
    /// root, set the pose of the base ([`Kinematics::with_base`](crate::motion::Kinematics::with_base)).
    Kind {
        /// The joint.
        joint: String,
    },
    /// A joint mimics one that does not exist, does not move, or itself mimics another.
    Mimic {
        /// The joint.
        joint: String,
    },
    /// A joint that moves has an invalid axis or limits.
    Joint {
        /// The joint.
        joint: String,
        /// What is wrong with it.
        error: MotionError,
    },
    /// An origin is not a valid pose.
    Pose {
        /// The joint or link with this origin.
        of: String,
        /// What is wrong with it.
        error: PoseError,
    },
    /// A length of a shape is out of range.
    Shape {
        /// The link.
        link: String,
        /// What is wrong with it.
        error: ShapeError,
    },
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format { problem } => write!(f, "not a robot's description: {problem}"),
            Self::Bodies { given, needed } => write!(f, "{given} geometries for {needed} bodies"),
            Self::UnknownLink { line, link } => write!(f, "line {line}: the robot has no link {link}"),
            Self::UnknownMember { line, name } => {
                write!(f, "line {line}: the robot has no joint {name}, and no group of this name precedes")
            }
            Self::NoSuchLink { joint, link } => {
                write!(f, "joint {joint} names the link {link}, which does not exist")
            }
            Self::NoTree { link } => write!(f, "the links are no tree: see {link}"),
            Self::Kind { joint } => {
                write!(f, "joint {joint} is floating, planar or spherical: joints need a single axis")
            }
            Self::Mimic { joint } => write!(f, "joint {joint} mimics one that does not move by itself"),
            Self::Joint { joint, error } => write!(f, "joint {joint}: {error}"),
            Self::Pose { of, error } => write!(f, "the origin of {of}: {error}"),
            Self::Shape { link, error } => write!(f, "link {link}: {error}"),
        }
    }
}

impl core::error::Error for RobotError {}
