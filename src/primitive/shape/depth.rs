//! Certain bounds of the depth of two shapes that meet, in `f64`.
use super::{Point, Shape};
/// Bounds of the least translation of A that separates two shapes.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Depth {
    /// No shorter translation separates them.
    pub(crate) lower: f64,
    /// Moved by `direction * upper`, A is apart from B or touches it.
    pub(crate) upper: f64,
    /// Of unit length.
    pub(crate) direction: Point,
}
