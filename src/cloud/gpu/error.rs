//! What can go wrong with a cloud on a device.

use super::super::{CloudError, SearchError};
use crate::device::DeviceError;
use core::fmt;

/// Why a device does not search, or a cloud on it is not changed.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum DeviceCloudError {
    /// The device has failed, or has too little memory.
    Device(DeviceError),
    /// Wrong on the CPU too.
    PointCloud(CloudError),
    /// Wrong on the CPU too.
    Search(SearchError),
    /// The radius of a query is so small that its square is below 2^-76, where a device may take for zero what is not. The CPU
    /// searches there.
    Radius {
        /// Index of the query.
        query: u32,
    },
    /// A coordinate is beyond 2^60, so that squares of differences may be infinite, which a device need not know. The CPU searches there.
    Range {
        /// "point" or "query".
        what: &'static str,
        /// Its index.
        index: u32,
    },
    /// A query and those beside it have so many buckets within their reach that a device might be stopped on the way. The
    /// CPU searches there.
    Endless {
        /// Index of a query.
        query: u32,
    },
    /// The device computes other distances than the CPU: it fuses operations, or rounds them otherwise.
    Arithmetic,
}

impl fmt::Display for DeviceCloudError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(error) => error.fmt(f),
            Self::PointCloud(error) => error.fmt(f),
            Self::Search(error) => error.fmt(f),
            Self::Radius { query } => write!(f, "the radius of query {query} is too small for a device"),
            Self::Range { what, index } => write!(f, "{what} {index} is too far away for a device"),
            Self::Endless { query } => {
                write!(f, "query {query} has too many buckets within its reach for a device")
            }
            Self::Arithmetic => f.write_str("the device rounds distances otherwise than the CPU"),
        }
    }
}

impl core::error::Error for DeviceCloudError {}

impl From<DeviceError> for DeviceCloudError {
    fn from(error: DeviceError) -> Self {
        Self::Device(error)
    }
}

impl From<CloudError> for DeviceCloudError {
    fn from(error: CloudError) -> Self {
        Self::PointCloud(error)
    }
}

impl From<SearchError> for DeviceCloudError {
    fn from(error: SearchError) -> Self {
        Self::Search(error)
    }
}
