//! Errors of clouds on a GPU.

use super::super::{CloudError, SearchError};
use crate::device::DeviceError;
use core::fmt;

/// Why a search or a refit on a device fails.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum DeviceCloudError {
    /// The device failed or has too little memory.
    Device(DeviceError),
    /// The same error as on the CPU.
    PointCloud(CloudError),
    /// The same error as on the CPU.
    Search(SearchError),
    /// The squared radius of a query is below 2^-76, where a device may flush relevant numbers to 0. Search on the
    /// CPU instead.
    Radius {
        /// Index of the query.
        query: u32,
    },
    /// A coordinate is beyond 2^60, so squares of differences may be infinite, which a device need not support.
    /// Search on the CPU instead.
    Range {
        /// "point" or "query".
        what: &'static str,
        /// Its index.
        index: u32,
    },
    /// A query and the others of its packet have so many buckets in range that the system might stop the device.
    /// Search on the CPU instead.
    Endless {
        /// Index of a query of the packet.
        query: u32,
    },
    /// The device computes other distances than the CPU, because it fuses operations or rounds differently.
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
