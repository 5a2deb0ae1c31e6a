//! What is split, and how.

use super::aabb::{Aabb, Measure};
use crate::range::Point;

pub(super) const AXES: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What to split.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Primitives<'a> {
    pub(in crate::construct) boxes: &'a [Aabb],
    pub(in crate::construct) centroids: &'a [Point],
}

/// How to split.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Plan {
    pub(in crate::construct) arity: usize,
    pub(in crate::construct) leaf_size: usize,
    pub(in crate::construct) measure: Measure,
    /// How often the lanes of a node exchange primitives after its cuts.
    pub(in crate::construct) passes: usize,
}
