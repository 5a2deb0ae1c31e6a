//! What can go wrong on a device.

use alloc::string::String;
use core::fmt;

/// Why a device did not do what it was to. The library, and other devices, can be used as before.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no adapter, or none that may be used.
    NoAdapter {
        /// What the system said.
        reason: String,
    },
    /// The adapter's limits are too small for the kernels.
    Limit {
        /// The limit's name in WebGPU.
        name: &'static str,
        /// What the kernels need.
        needed: u64,
        /// What the adapter has.
        available: u64,
    },
    /// The adapter gave no device.
    NoDevice {
        /// What it said.
        reason: String,
    },
    /// More than one buffer of this device can hold.
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many of them.
        count: usize,
        /// Bytes of the largest buffer that they need.
        bytes: u64,
        /// Bytes of the largest buffer that the device binds.
        limit: u64,
    },
    /// The device's memory does not suffice.
    OutOfMemory {
        /// Bytes that were to be allocated.
        bytes: u64,
    },
    /// The device was lost: unplugged, reset, destroyed, or stopped by the system's watchdog.
    Lost,
    /// The device objects to what it was told to do: a defect of this library or of the driver.
    Device {
        /// What it said.
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
