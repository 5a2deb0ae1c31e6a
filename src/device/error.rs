//! Errors of devices.

use alloc::string::String;
use core::fmt;

/// Why a device operation failed. The library and other devices remain usable.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no usable adapter.
    NoAdapter {
        /// The system's message.
        reason: String,
    },
    /// The adapter's limits are too small for the kernels.
    Limit {
        /// The limit's name in WebGPU.
        name: &'static str,
        /// The value that the kernels need.
        needed: u64,
        /// The value that the adapter has.
        available: u64,
    },
    /// The adapter did not provide a device.
    NoDevice {
        /// The adapter's message.
        reason: String,
    },
    /// The data exceeds the largest buffer of the device.
    TooLarge {
        /// The name of the elements.
        what: &'static str,
        /// The number of elements.
        count: usize,
        /// Size of the required buffer in bytes.
        bytes: u64,
        /// Size of the largest buffer that the device binds, in bytes.
        limit: u64,
    },
    /// The device is out of memory.
    OutOfMemory {
        /// Bytes requested.
        bytes: u64,
    },
    /// The device was lost: unplugged, reset, destroyed, or stopped by the system's watchdog.
    Lost,
    /// The device reported an error: a defect of this library or of the driver.
    Device {
        /// The device's message.
        reason: String,
    },
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter { reason } => write!(f, "no adapter: {reason}"),
            Self::Limit { name, needed, available } => {
                write!(f, "the adapter's limit {name} is {available}, must be {needed}")
            }
            Self::NoDevice { reason } => write!(f, "no device: {reason}"),
            Self::TooLarge { what, count, bytes, limit } => {
                write!(f, "{count} {what} need a buffer of {bytes} bytes, the device binds {limit}")
            }
            Self::OutOfMemory { bytes } => write!(f, "the device has no room for {bytes} bytes"),
            Self::Lost => f.write_str("the device was lost"),
            Self::Device { reason } => write!(f, "the device objects: {reason}"),
        }
    }
}

impl core::error::Error for DeviceError {}
