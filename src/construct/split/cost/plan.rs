//! The input and the settings of a splitter.

use super::aabb::{Aabb, Measure};
use crate::range::Point;

pub(super) const AXES: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The primitives.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Primitives<'a> {
    pub(in crate::construct) boxes: &'a [Aabb],
    pub(in crate::construct) centroids: &'a [Point],
}

/// The settings.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Plan {
    pub(in crate::construct) arity: usize,
    pub(in crate::construct) leaf_size: usize,
    pub(in crate::construct) measure: Measure,
    /// Passes in which the lanes of a node exchange primitives after its cuts.
    pub(in crate::construct) passes: usize,
}
