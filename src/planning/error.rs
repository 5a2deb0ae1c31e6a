//! Errors of planning scenes and of the files of robots.

use crate::construct::BuildError;
use crate::mesh_io::{FileError, FilePlace};
use crate::motion::MotionError;
use crate::robot::RobotError;
use crate::scene::SceneError;
use alloc::boxed::Box;
use alloc::string::String;
use core::fmt;
use std::path::PathBuf;

/// Why a robot cannot be loaded, or a planning scene rejects its input.
#[derive(Debug)]
#[non_exhaustive]
pub enum PlanningError {
    /// A file cannot be read.
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// A URDF or SRDF file is invalid.
    Robot {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: RobotError,
    },
    /// A mesh file is invalid.
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        error: FileError,
    },
    /// A mesh cannot become a body.
    Build {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: BuildError,
    },
    /// The body of a link cannot be loaded.
    Link {
        /// The link.
        link: String,
        /// Why.
        error: Box<Self>,
    },
    /// The robot has no link of this name, or the link has no body.
    NoLink {
        /// The name given.
        name: String,
    },
    /// The robot has no group of joints of this name.
    NoGroup {
        /// The name given.
        name: String,
    },
    /// A body of the robot was given where only an object can be: it can be neither moved nor removed.
    IsRobot {
        /// The body's name.
        name: String,
    },
    /// The number of values is not a multiple of the number of variables.
    Values {
        /// Number of values given.
        given: usize,
        /// Number of variables.
        variables: usize,
    },
    /// The longest motion of a plan is not positive.
    Step {
        /// The value given.
        given: f64,
    },
    /// The width of the cells of bounds is not positive and finite.
    Cell {
        /// The value given.
        given: f64,
    },
    /// A body, a pose, a value of a joint, or a tolerance is invalid.
    Scene(SceneError),
}

impl fmt::Display for PlanningError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Robot { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Mesh { path, error: FileError { place: FilePlace::Nowhere, problem } } => {
                write!(f, "{}: {problem}", path.display())
            }
            Self::Mesh { path, error } => write!(f, "{}, {error}", path.display()),
            Self::Build { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Link { link, error } => write!(f, "link {link}: {error}"),
            Self::NoLink { name } => write!(f, "the robot has no link {name} with a body"),
            Self::NoGroup { name } => write!(f, "the robot has no group of joints {name}"),
            Self::IsRobot { name } => write!(f, "{name} is a body of the robot, which only its joints move"),
            Self::Values { given, variables } => {
                write!(f, "{given} values are not a multiple of {variables}, one for each variable")
            }
            Self::Step { given } => write!(f, "a plan's step of {given}: must be positive"),
            Self::Cell { given } => write!(f, "cells of width {given}: must be positive and finite"),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PlanningError {}

impl From<SceneError> for PlanningError {
    fn from(error: SceneError) -> Self {
        Self::Scene(error)
    }
}

impl From<MotionError> for PlanningError {
    fn from(error: MotionError) -> Self {
        Self::Scene(error.into())
    }
}
