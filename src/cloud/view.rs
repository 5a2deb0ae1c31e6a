//! A borrowed cloud.

use crate::exact::power_of_two;
use crate::frame::{BodyBounds, Frame};
use crate::node::{Aabb16, Box3, Bucket};
use crate::vector::length;

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

    /// Indices of points are below this. Equals the number of points that the cloud was built from, unless room was
    /// added.
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.capacity as usize
    }

    /// The nodes, breadth first: children come after their parent, and levels are contiguous.
    #[must_use]
    pub const fn nodes(&self) -> &'a [Aabb16] {
        self.nodes
    }

    /// The buckets, in the order of the tree's lanes.
    #[must_use]
    pub const fn buckets(&self) -> &'a [Bucket] {
        self.buckets
    }

    /// The maximum number of points per bucket when the tree was built.
    #[must_use]
    pub const fn bucket_size(&self) -> u32 {
        self.bucket_size
    }

    /// Bounds about the centre of the bounding box. Zero if there are no points.
    pub(crate) fn extent(&self) -> BodyBounds {
        let Box3 { lower, upper } = self.bounds();
        let ends = [0, 1, 2].map(|i| [f64::from(lower[i]), f64::from(upper[i])]);
        let centre = ends.map(|[low, high]| 0.5 * low + 0.5 * high);
        let grown = 1.0 + power_of_two(-20);
        let half = [0, 1, 2].map(|i| (ends[i][1] - centre[i]).max(centre[i] - ends[i][0]) * grown);
        // At scale 1/2, the half width of any cloud is a finite `f32`.
        let half_width = half.map(|x| ((0.5 * x) as f32).next_up());
        BodyBounds {
            frame: Frame { centre, exponent: -1 },
            max_coordinate: ends.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs())),
            radius: length(&half) * grown,
            half_width,
            max_plane: half_width.iter().fold(0.0, |most: f32, x| most.max(*x)),
        }
    }

    /// The bounding box of all points; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Box3 {
        self.nodes.first().map_or(Box3::EMPTY, Aabb16::bounds)
    }
}
