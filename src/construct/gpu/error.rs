//! Errors of builds on a device.

use crate::construct::error::BuildError;
use crate::device::DeviceError;
use core::fmt;

/// Why a tree was not built on a device.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum GpuError {
    /// The device failed.
    Device(DeviceError),
    /// The splitter does not run on devices: only [`crate::construct::Splitter::BatchNeuralGas`] does.
    Splitter,
    /// The mesh is invalid, or the build was cancelled.
    Build(BuildError),
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(error) => error.fmt(f),
            Self::Splitter => f.write_str("only Batch Neural Gas runs on devices"),
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for GpuError {}

impl From<DeviceError> for GpuError {
    fn from(error: DeviceError) -> Self {
        Self::Device(error)
    }
}

impl From<BuildError> for GpuError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}
