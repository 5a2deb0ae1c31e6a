//! A cloud that is borrowed.

use crate::node::{Aabb16, Box3, Bucket};

/// A cloud to search. Small and `Copy`.
#[derive(Copy, Clone, Debug)]
pub struct CloudRef<'a> {
    /// Breadth first; the root is the first.
    pub(super) nodes: &'a [Aabb16],
    /// In the order of the tree's lanes.
    pub(super) buckets: &'a [Bucket],
    pub(super) points: u32,
    pub(super) capacity: u32,
    pub(super) bucket_size: u32,
}

impl<'a> CloudRef<'a> {
    /// The number of points.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.points as usize
    }

    /// Whether there is no point.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// Indices of points are below this. The number of points that it was built of, if none were inserted or removed.
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.capacity as usize
    }

    /// The nodes, breadth first: the children of a node come after it, and levels are contiguous.
    #[must_use]
    pub const fn nodes(&self) -> &'a [Aabb16] {
        self.nodes
    }

    /// The buckets, in the order of the tree's lanes.
    #[must_use]
    pub const fn buckets(&self) -> &'a [Bucket] {
        self.buckets
    }

    /// Points in a bucket, at most, when the tree was built.
    #[must_use]
    pub const fn bucket_size(&self) -> u32 {
        self.bucket_size
    }

    /// Around all points; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Box3 {
        self.nodes.first().map_or(Box3::EMPTY, Aabb16::bounds)
    }
}
