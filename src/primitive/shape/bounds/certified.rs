//! Certified bounds for two shapes.

use crate::range::Point;

/// Bounds of the distance between two shapes.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Certified {
    /// Above 0 only if the two are certainly apart.
    pub(crate) lower: f64,
    /// 0 only if they certainly meet.
    pub(crate) upper: f64,
    /// A point of the first shape that is `upper` from the second, up to rounding.
    pub(crate) a: Point,
    /// The point of the second shape.
    pub(crate) b: Point,
}

/// Bounds of the least translation of A that separates two shapes.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Depth {
    /// No shorter translation separates them.
    pub lower: f64,
    /// Moved by `direction * upper`, A is apart from B or touches it, up to the rounding of the direction's length.
    pub upper: f64,
    /// Of unit length.
    pub direction: Point,
}
