//! The range of numbers on a device.

use crate::exact::power_of_two;

/// The largest absolute value of a coordinate on a device: 2^60.
pub const FARTHEST: f32 = power_of_two(60) as f32;

/// The least square of a radius on a device: 2^-76.
pub const LEAST_SQUARE: f32 = power_of_two(-76) as f32;

/// The device's squares are exact if they are at least this. If one is less, the exact square is less too.
pub(super) const SURE_SQUARE: f32 = 2.0 * LEAST_SQUARE;
