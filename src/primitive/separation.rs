//! The distance between two primitives.

use crate::range::Point;

/// The distance between two primitives, and their closest points.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Separation {
    /// Lower bound of the distance.
    pub lower: f64,
    /// Upper bound of the distance: 0 if and only if the two meet.
    pub upper: f64,
    /// The point of the first that is closest to the second, up to rounding of its coordinates.
    pub a: Point,
    /// The closest point of the second.
    pub b: Point,
}
