//! Nodes: the links and the bounding volumes of their children.
//!
//! [`Node`] is what every kind of node has: a fixed number of lanes, each with a link. [`Dop`] adds the planes of
//! k-DOPs, which [`DopNode`] holds for [`Node16`] and [`Node4`]. A tree may have the [`NormalSlab`]s of its lanes
//! beside its nodes, or for spheres their bounding balls ([`Ball16`]). Trees over moving points have nodes of boxes,
//! [`Aabb16`], and [`Bucket`]s.

mod aabb;
mod ball;
mod dop;
mod link;
mod normal_slab;

pub use aabb::{Aabb16, Box3, Bucket};
pub use ball::{Ball16, BoundingBall};
pub use dop::{Alignment, Arity, DopNode, Node4, Node16};
#[cfg(feature = "gpu")]
pub(crate) use link::INDEX;
pub use link::{Child, Link, MAX_LEAF_SIZE, Width};
#[cfg(feature = "gpu")]
pub(crate) use link::{FIRST, LEAF_BIT};
pub use normal_slab::NormalSlab;

pub use crate::key::{Fixed, Half, Storage, StorageKind};

use crate::key::Key;
use crate::range::Point;

mod sealed {
    pub trait Sealed {}
}

/// A node: the links of its lanes. Implemented by [`Node16`] and [`Node4`] only.
pub trait Node: bytemuck::Pod + Send + Sync + sealed::Sealed + core::fmt::Debug {
    /// How the planes are stored.
    type Storage: Storage;
    /// Number of planes of a child.
    const K: usize;
    /// Number of lanes.
    const ARITY: usize;
    /// A node of unused lanes.
    const EMPTY: Self;

    /// The links of all lanes.
    fn children(&self) -> &[Child];
    /// Sets the link of `lane`.
    fn set_child(&mut self, lane: usize, child: Child);
}

/// A node whose volumes are k-DOPs.
pub trait Dop: Node {
    /// The directions of the planes.
    const DIRECTIONS: &'static [Point];

    /// The code of plane `j` of child `lane`.
    fn plane(&self, j: usize, lane: usize) -> i16;
    /// Raises plane `j` of child `lane` to bound `key` too.
    fn raise_plane(&mut self, j: usize, lane: usize, key: Key<Self::Storage>);
    /// The value of plane `j` of child `lane`, in steps of the frame.
    #[inline(always)]
    fn value(&self, j: usize, lane: usize) -> f32 {
        Self::Storage::value(self.plane(j, lane))
    }
}

impl Width {
    /// The width of child `lane` of a node.
    pub(crate) fn of_lane<N: Dop>(node: &N, lane: usize) -> Self {
        let slab = |s: usize| node.value(2 * s, lane) + node.value(2 * s + 1, lane);
        Self::of((slab(0) + slab(1)) + slab(2))
    }
}
