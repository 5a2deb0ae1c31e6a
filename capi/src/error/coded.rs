//! The error code of each error of the library.

use super::{Failure, simdop_error};
use simdop::cloud::{CloudError, SearchError};
use simdop::construct::{BuildError, CoverError};
use simdop::hierarchy::{FormatError, VerifyError};
use simdop::motion::MotionError;
use simdop::packing::PackError;
#[cfg(feature = "planning")]
use simdop::planning::PlanningError;
use simdop::pose::PoseError;
use simdop::primitive::shape::ShapeError;
use simdop::query::ToleranceError;
#[cfg(feature = "urdf")]
use simdop::robot::RobotError;
use simdop::scene::SceneError;
use std::fmt::Display;

/// An error of the library that has a code.
pub(crate) trait Coded: Display {
    fn code(&self) -> simdop_error;
}

impl<E: Coded> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::new(error.code(), error.to_string())
    }
}

// The library's enumerations may grow, and some of their errors concern features that this interface does not offer.
// Those map to `Other`.

impl Coded for PoseError {
    fn code(&self) -> simdop_error {
        match self {
            Self::NotFinite => simdop_error::PoseNotFinite,
            Self::TooFar => simdop_error::PoseTooFar,
            Self::NotOrthonormal { .. } => simdop_error::PoseNotOrthonormal,
            Self::Mirrored => simdop_error::PoseMirrored,
            Self::NotUnit { .. } => simdop_error::PoseNotUnit,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for FormatError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Misaligned => simdop_error::Misaligned,
            Self::NotATree => simdop_error::BytesNotATree,
            Self::Version { .. } => simdop_error::BytesVersion,
            Self::OtherPrimitive { .. } => simdop_error::BytesOtherPrimitive,
            Self::OtherNode { .. } => simdop_error::BytesOtherNode,
            Self::OtherStorage { .. } => simdop_error::BytesOtherStorage,
            Self::Truncated { .. } => simdop_error::BytesTruncated,
            Self::TooLong { .. } => simdop_error::BytesTooLong,
            Self::Header { .. } => simdop_error::BytesHeader,
            Self::Node { .. } => simdop_error::BytesNode,
            Self::Vertex { .. } => simdop_error::BytesVertex,
            Self::Primitive { .. } => simdop_error::BytesPrimitive,
            Self::Source { .. } => simdop_error::BytesSource,
            Self::Part { .. } => simdop_error::BytesPart,
            Self::Caps { .. } => simdop_error::BytesCaps,
            Self::Packing { .. } => simdop_error::BytesPacking,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for BuildError {
    fn code(&self) -> simdop_error {
        match self {
            Self::TooLarge { .. } => simdop_error::TooLarge,
            Self::Vertex { .. } => simdop_error::BuildVertex,
            Self::Radius { .. } => simdop_error::BuildRadius,
            Self::TooSmall => simdop_error::BuildTooSmall,
            Self::Primitive { .. } => simdop_error::BuildPrimitive,
            Self::Open { .. } => simdop_error::BuildOpen,
            Self::Hole { .. } => simdop_error::BuildHole,
            Self::TooManyCaps { .. } => simdop_error::BuildTooManyCaps,
            Self::Packing { .. } => simdop_error::BuildPacking,
            Self::NotInside { .. } => simdop_error::BuildNotInside,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for ShapeError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Length { .. } => simdop_error::ShapeLength,
            Self::Coordinate { .. } => simdop_error::ShapeCoordinate,
            Self::NoDirection => simdop_error::ShapeNoDirection,
            Self::Unbounded => simdop_error::ShapeUnbounded,
            Self::NotPerpendicular { .. } => simdop_error::ShapeNotPerpendicular,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for ToleranceError {
    fn code(&self) -> simdop_error {
        simdop_error::Tolerance
    }
}

impl Coded for MotionError {
    fn code(&self) -> simdop_error {
        match self {
            Self::NoSuchLink { .. } => simdop_error::MotionNoSuchLink,
            Self::NoSuchVariable { .. } => simdop_error::MotionNoSuchVariable,
            Self::Limits { .. } => simdop_error::MotionLimits,
            Self::NoDirection => simdop_error::MotionNoDirection,
            Self::NotFinite => simdop_error::MotionNotFinite,
            Self::Length { .. } => simdop_error::MotionLength,
            Self::OutOfLimits { .. } => simdop_error::MotionOutOfLimits,
            Self::Pose(error) => error.code(),
            _ => simdop_error::Other,
        }
    }
}

impl Coded for VerifyError {
    fn code(&self) -> simdop_error {
        simdop_error::BytesVolume
    }
}

impl Coded for CloudError {
    fn code(&self) -> simdop_error {
        match self {
            Self::TooMany { .. } => simdop_error::TooLarge,
            Self::Point { .. } => simdop_error::CloudPoint,
            Self::BucketSize { .. } => simdop_error::CloudBucketSize,
            Self::Positions { .. } => simdop_error::CloudPositions,
            Self::Index { .. } => simdop_error::CloudIndex,
            Self::Full => simdop_error::CloudFull,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for SearchError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Radius { .. } => simdop_error::SearchRadius,
            Self::Query { .. } => simdop_error::SearchQuery,
            Self::Length { .. } | Self::Buffer { .. } => simdop_error::Buffer,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for PackError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Empty => simdop_error::PackEmpty,
            Self::Mesh(error) => error.code(),
            Self::Open { .. } => simdop_error::BuildOpen,
            Self::Flat => simdop_error::PackFlat,
            Self::Cancelled => simdop_error::PackStopped,
            _ => simdop_error::Other,
        }
    }
}

impl Coded for CoverError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Error { .. } => simdop_error::CoverError,
            Self::TooMany => simdop_error::CoverTooMany,
            Self::Mesh(error) => error.code(),
            _ => simdop_error::Other,
        }
    }
}

#[cfg(feature = "urdf")]
impl Coded for RobotError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Format { .. } => simdop_error::DescriptionFormat,
            Self::NoSuchLink { .. } => simdop_error::DescriptionNoSuchLink,
            Self::UnknownLink { .. } | Self::UnknownMember { .. } => simdop_error::DescriptionNoSuchName,
            Self::NoTree { .. } => simdop_error::DescriptionNoTree,
            Self::Kind { .. } => simdop_error::DescriptionKind,
            Self::Mimic { .. } => simdop_error::DescriptionMimic,
            Self::Joint { error, .. } => error.code(),
            Self::Pose { error, .. } => error.code(),
            Self::Shape { error, .. } => error.code(),
            _ => simdop_error::Other,
        }
    }
}

#[cfg(feature = "planning")]
impl Coded for PlanningError {
    fn code(&self) -> simdop_error {
        match self {
            Self::Io { .. } => simdop_error::PlannerFile,
            Self::Robot { error, .. } => error.code(),
            Self::Mesh { .. } => simdop_error::PlannerMesh,
            Self::Build { error, .. } => error.code(),
            Self::Link { error, .. } => error.code(),
            Self::NoLink { .. } => simdop_error::PlannerNoLink,
            Self::NoGroup { .. } => simdop_error::PlannerNoGroup,
            Self::IsRobot { .. } => simdop_error::PlannerIsRobot,
            Self::Values { .. } => simdop_error::MotionLength,
            Self::Step { .. } => simdop_error::PlannerStep,
            Self::Cell { .. } => simdop_error::PlannerCell,
            Self::Scene(error) => error.code(),
            _ => simdop_error::Other,
        }
    }
}

impl Coded for SceneError {
    fn code(&self) -> simdop_error {
        match self {
            Self::NoSuchBody { .. } => simdop_error::SceneNoSuchBody,
            Self::Radius { .. } => simdop_error::SceneRadius,
            Self::Pose(error) => error.code(),
            Self::IsAttached { .. } => simdop_error::SceneIsAttached,
            Self::Cycle { .. } => simdop_error::SceneCycle,
            Self::NoPair { .. } => simdop_error::SceneNoPair,
            Self::TwoClouds { .. } => simdop_error::SceneTwoClouds,
            Self::Motion { .. } => simdop_error::MotionBodies,
            Self::Path(error) => error.code(),
            Self::Tolerance(error) => error.code(),
            _ => simdop_error::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::last_error;

    #[test]
    fn an_error_without_a_code_keeps_its_message() {
        assert_eq!(Failure::from(BuildError::Cancelled).keep(), simdop_error::Other);
        assert_eq!(last_error(), BuildError::Cancelled.to_string());
    }

    /// C cannot cause this error: the robot determines the number of values.
    #[test]
    fn a_wrong_number_of_values_has_a_code() {
        let error = MotionError::Length { given: 1, needed: 2 };
        assert_eq!(Failure::from(error).keep(), simdop_error::MotionLength);
        assert_eq!(last_error(), error.to_string());
        assert_eq!(Failure::from(SceneError::Path(error)).keep(), simdop_error::MotionLength);
    }
}
