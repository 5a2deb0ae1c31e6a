//! Errors, with the file and the place in it.

use core::fmt;
use simdop::cloud::{CloudError, SearchError};
use simdop::construct::{BuildError, CoverError};
use simdop::hierarchy::{FormatError, NodeType, VerifyError};
use simdop::mesh_io::{FileError, FilePlace};
use simdop::packing::PackError;
#[cfg(feature = "robot")]
use simdop::planning::PlanningError;
use std::path::PathBuf;

#[derive(Debug)]
pub(crate) enum Error {
    /// Reading or writing failed.
    Io { path: PathBuf, error: std::io::Error },
    /// The contents of a file are invalid.
    Content { path: PathBuf, fault: FileError },
    /// The bytes of a tree are invalid.
    Tree { path: PathBuf, error: FormatError },
    /// A plane of a tree does not bound its primitives.
    Verify { path: PathBuf, error: VerifyError },
    /// A mesh cannot be built.
    Build { name: String, error: BuildError },
    /// A mesh cannot be covered with spheres.
    Cover { name: String, error: CoverError },
    /// A mesh cannot be filled with spheres.
    Pack { name: String, error: PackError },
    /// Points cannot become a cloud.
    PointCloud { name: String, error: CloudError },
    /// A range search in a cloud fails.
    Search { name: String, error: SearchError },
    /// A robot cannot be loaded, placed or moved.
    #[cfg(feature = "robot")]
    Planning(PlanningError),
    #[cfg(feature = "report")]
    /// All corners of a mesh coincide, so that it has no size to scale distances by.
    NoSize { name: String },
    #[cfg(feature = "report")]
    /// One body does not meet the other along any of the lines.
    NoContact { a: String, b: String, lines: usize },
    /// An option that cannot be applied.
    Option { option: &'static str, problem: String },
    /// The node type of a tree differs from that of the other body, or from the options.
    OtherNode { name: String, has: NodeType, asked: NodeType },
    /// A command that this build does not include.
    #[cfg(not(all(feature = "report", feature = "robot", feature = "selftest")))]
    Feature(&'static str),
    /// A trial of the self-test cannot be run.
    #[cfg(feature = "selftest")]
    SelfTest { name: String, problem: String },
    /// Writing to the standard output failed.
    Output(std::io::Error),
}

impl Error {
    pub(crate) fn content(path: impl Into<PathBuf>) -> impl FnOnce(FileError) -> Self {
        let path = path.into();
        |fault| Self::Content { path, fault }
    }

    /// A build option that has no effect, since there is nothing to build.
    pub(crate) fn idle(option: &'static str, name: &impl fmt::Display) -> Self {
        Self::Option {
            option,
            problem: format!("{name} is a tree and stays as it is: `simdop build` makes another of it"),
        }
    }

    pub(crate) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        |error| Self::Io { path, error }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Content { path, fault } => {
                let (path, problem) = (path.display(), &fault.problem);
                match fault.place {
                    FilePlace::Line(number) => write!(f, "{path}, line {number}: {problem}"),
                    FilePlace::Byte(offset) => write!(f, "{path}, byte {offset}: {problem}"),
                    FilePlace::Nowhere => write!(f, "{path}: {problem}"),
                }
            }
            #[cfg(not(feature = "all-nodes"))]
            Self::Tree { path, error: error @ FormatError::OtherNode { .. } } => write!(
                f,
                "{}: {error}, which needs the feature `all-nodes`: `cargo install --path cli --features all-nodes`",
                path.display()
            ),
            Self::Tree { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Verify { path, error } => write!(f, "{}: not conservative: {error}", path.display()),
            Self::Build { name, error } => write!(f, "{name}: {error}"),
            Self::Cover { name, error } => write!(f, "{name}: {error}"),
            Self::Pack { name, error } => write!(f, "{name}: {error}"),
            Self::PointCloud { name, error } => write!(f, "{name}: {error}"),
            Self::Search { name, error } => write!(f, "{name}: {error}"),
            #[cfg(feature = "robot")]
            Self::Planning(error) => error.fmt(f),
            #[cfg(feature = "report")]
            Self::NoSize { name } => {
                write!(f, "{name}: all corners are one point: there is no size to measure distances by")
            }
            #[cfg(feature = "report")]
            Self::NoContact { a, b, lines } => {
                write!(f, "{a} does not touch {b} along any of {lines} lines")
            }
            Self::Option { option, problem } => write!(f, "{option}: {problem}"),
            Self::OtherNode { name, has, asked } => {
                write!(f, "{name}: the tree has {has}, the query {asked}: `simdop build` makes another of it")
            }
            #[cfg(not(all(feature = "report", feature = "robot", feature = "selftest")))]
            Self::Feature(name) => write!(
                f,
                "`simdop {name}` needs the feature `{name}`: `cargo install --path cli --features {name}`"
            ),
            #[cfg(feature = "selftest")]
            Self::SelfTest { name, problem } => write!(f, "{name}: {problem}"),
            Self::Output(error) => write!(f, "standard output: {error}"),
        }
    }
}
