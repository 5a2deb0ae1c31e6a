//! Points, and the range of their coordinates.
//!
//! Every coordinate of a body is zero or has a magnitude in [`MIN_COORDINATE`] `..=` [`MAX_COORDINATE`]. Coordinates
//! moved by a pose are at most [`MAX_MOVED`]. So no exact predicate underflows or overflows: the error analysis in
//! [`crate::primitive::triangle`] relies on these bounds.

/// A point in a body's own coordinates and unit.
pub type Point = [f64; 3];

/// The largest magnitude of a coordinate of a body, and of a component of a translation: 2^300.
pub const MAX_COORDINATE: f64 = f64::from_bits((1023 + 300) << 52);

/// The largest magnitude of a coordinate moved by a pose: 2^302. A rotation maps a vertex of the cube of all points
/// to at most sqrt(3) 2^300 on an axis, and the translation adds at most 2^300.
pub const MAX_MOVED: f64 = 4.0 * MAX_COORDINATE;

/// The smallest magnitude of a nonzero coordinate: 2^-250.
pub const MIN_COORDINATE: f64 = f64::from_bits((1023 - 250) << 52);

/// Sets coordinates below [`MIN_COORDINATE`] to zero, so that no exact predicate can underflow.
#[inline]
pub(crate) fn flush(x: f64) -> f64 {
    if x.abs() < MIN_COORDINATE { 0.0 } else { x }
}
