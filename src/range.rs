//! The numbers that the library computes with: points, and the range of their coordinates.
//!
//! Every coordinate of a body is zero or has a magnitude in [`MIN_COORDINATE`] `..=` [`MAX_COORDINATE`],
//! every one that a pose has moved at most [`MAX_MOVED`]. Then no exact predicate under- or overflows: see
//! [`crate::primitive::triangle`], whose error analysis asks for these bounds.

/// A point in a body's own coordinates and unit.
pub type Point = [f64; 3];

/// The largest magnitude of a coordinate of a body, and of a translation: 2^300.
pub const MAX_COORDINATE: f64 = f64::from_bits((1023 + 300) << 52);

/// The largest magnitude of a coordinate that a pose has moved: 2^302. A rotation takes a corner of the cube
/// of all points to sqrt(3) 2^300 on an axis, the translation another 2^300 away.
pub const MAX_MOVED: f64 = 4.0 * MAX_COORDINATE;

/// The smallest magnitude of a coordinate that is not zero: 2^-250.
pub const MIN_COORDINATE: f64 = f64::from_bits((1023 - 250) << 52);

/// Coordinates below [`MIN_COORDINATE`] count as zero, so that no exact predicate can underflow.
#[inline]
pub(crate) fn flush(x: f64) -> f64 {
    if x.abs() < MIN_COORDINATE { 0.0 } else { x }
}
