//! What the traversal asks of a node type: the same questions for 1vs16 and 4vs4.

use crate::frame::{Frame, Point};
use crate::hierarchy::Header;
use crate::kernel::{Kernel, Query, SEPARATED};
use crate::key::Key;
use crate::node::{Node, Node4, Node16};
use crate::pose::Pose;
use crate::realign::{Realignment, planes_of_corners};

/// Row i: the children of B that child i of A overlaps.
pub(crate) type Rows = [u16; 16];

/// A node type that can be queried. Implemented by [`Node16`] and [`Node4`] only.
pub trait Lanes: Node {
    /// Re-alignment into the other body's frame.
    type Map: Copy + core::fmt::Debug;
    /// Planes of as many bodies as there are lanes, in query form.
    type Query: Copy + core::fmt::Debug;
    #[doc(hidden)]
    const NO_QUERY: Self::Query;

    #[doc(hidden)]
    fn map(pose: &Pose, a: &Header, b: &Frame) -> Self::Map;
    #[doc(hidden)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map) -> Self::Query;
    /// The bodies in the `wanted` lanes of the query against all lanes of `self`; other rows are zero. Returns the number of kernel
    /// calls too.
    #[doc(hidden)]
    fn overlap_rows<E: Kernel>(&self, kernel: E, query: &Self::Query, wanted: u16) -> (Rows, u64);
    /// The corners' planes, in lane 0.
    #[doc(hidden)]
    fn query_of_corners(b: &Frame, corners: &[Point]) -> Self::Query;
    /// Which bodies of the query child `lane` of `self` overlaps.
    #[doc(hidden)]
    fn overlap_column<E: Kernel>(&self, kernel: E, query: &Self::Query, lane: usize) -> u16;
}

fn query_of_planes<const W: usize, const K: usize>(key: impl Fn(usize) -> i16) -> Query<W, K> {
    core::array::from_fn(|j| [!key(j ^ 1); W])
}

macro_rules! impl_lanes {
    ($node:ident, $arity:literal, $realign:ident) => {
        impl<const K: usize> Lanes for $node<K>
        where
            Self: bytemuck::Pod,
        {
            type Map = Realignment<K>;
            type Query = Query<$arity, K>;
            const NO_QUERY: Self::Query = [[SEPARATED; $arity]; K];

            fn map(pose: &Pose, a: &Header, b: &Frame) -> Self::Map {
                Realignment::new(pose, a, b)
            }

            #[inline(always)]
            fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map) -> Self::Query {
                kernel.$realign(map, self)
            }

            #[inline(always)]
            fn overlap_rows<E: Kernel>(&self, kernel: E, query: &Self::Query, wanted: u16) -> (Rows, u64) {
                $node::rows(self, kernel, query, wanted)
            }

            fn query_of_corners(b: &Frame, corners: &[Point]) -> Self::Query {
                let planes: [Key; K] = planes_of_corners(b, corners);
                query_of_planes(|j| planes[j].code())
            }

            #[inline(always)]
            fn overlap_column<E: Kernel>(&self, kernel: E, query: &Self::Query, lane: usize) -> u16 {
                $node::column(self, kernel, query, lane)
            }
        }
    };
}

impl_lanes!(Node16, 16, realign_16);
impl_lanes!(Node4, 4, realign_4);

impl<const K: usize> Node16<K> {
    #[inline(always)]
    fn rows<E: Kernel>(&self, kernel: E, query: &Query<16, K>, wanted: u16) -> (Rows, u64) {
        let mut rows = [0; 16];
        let mut left = wanted;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            rows[lane] = kernel.overlap_1v16(query, lane, self);
        }
        (rows, wanted.count_ones().into())
    }

    #[inline(always)]
    fn column<E: Kernel>(&self, kernel: E, query: &Query<16, K>, lane: usize) -> u16 {
        kernel.overlap_16v1(query, self, lane)
    }
}

impl<const K: usize> Node4<K> {
    #[inline(always)]
    fn rows<E: Kernel>(&self, kernel: E, query: &Query<4, K>, wanted: u16) -> (Rows, u64) {
        let pairs = kernel.overlap_4v4(query, self);
        let mut rows = [0; 16];
        for (lane, row) in rows.iter_mut().take(4).enumerate() {
            if wanted >> lane & 1 != 0 {
                *row = pairs >> (4 * lane) & 0xf;
            }
        }
        (rows, 1)
    }

    #[inline(always)]
    fn column<E: Kernel>(&self, kernel: E, query: &Query<4, K>, lane: usize) -> u16 {
        let pairs = kernel.overlap_4v4(query, self) >> lane;
        (0..4).fold(0, |mask, i| mask | (pairs >> (4 * i) & 1) << i)
    }
}
