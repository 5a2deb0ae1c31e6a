//! What the traversal asks of a node type: the same questions for 1vs16 and 4vs4.

use crate::frame::{Frame, Point};
use crate::hierarchy::Header;
use crate::kernel::{Kernel, Query};
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
    fn map(pose: &Pose, a: &Header, b: &Frame) -> Self::Map;
    #[doc(hidden)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map) -> Self::Query;
    /// All used lanes of the query against all lanes of `self`. Returns the number of kernel calls too.
    #[doc(hidden)]
    fn overlap_all<E: Kernel>(&self, kernel: E, query: &Self::Query, used: u16) -> (Rows, u64);
    /// The body in lane 0 of the query against all lanes of `self`.
    #[doc(hidden)]
    fn overlap_first<E: Kernel>(&self, kernel: E, query: &Self::Query) -> u16;
    /// The corners' planes, in lane 0.
    #[doc(hidden)]
    fn query_of_corners(b: &Frame, corners: &[Point]) -> Self::Query;
    /// The planes of child `lane`, in lane 0.
    #[doc(hidden)]
    fn query_of_lane(&self, lane: usize) -> Self::Query;
    /// The bodies of a query as the children of a node. The links stay unused: for a kernel, not for a walk.
    #[doc(hidden)]
    fn node_of_query(query: &Self::Query) -> Self;
}

fn query_of_planes<const W: usize, const K: usize>(key: impl Fn(usize) -> i16) -> Query<W, K> {
    core::array::from_fn(|j| [!key(j ^ 1); W])
}

fn planes_of_query<const W: usize, const K: usize>(query: &Query<W, K>) -> [[i16; W]; K] {
    core::array::from_fn(|j| query[j ^ 1].map(|code| !code))
}

macro_rules! impl_lanes {
    ($node:ident, $arity:literal, $realign:ident) => {
        impl<const K: usize> Lanes for $node<K>
        where
            Self: bytemuck::Pod,
        {
            type Map = Realignment<K>;
            type Query = Query<$arity, K>;

            fn map(pose: &Pose, a: &Header, b: &Frame) -> Self::Map {
                Realignment::new(pose, a, b)
            }

            #[inline(always)]
            fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map) -> Self::Query {
                kernel.$realign(map, self)
            }

            #[inline(always)]
            fn overlap_all<E: Kernel>(&self, kernel: E, query: &Self::Query, used: u16) -> (Rows, u64) {
                $node::all(self, kernel, query, used)
            }

            #[inline(always)]
            fn overlap_first<E: Kernel>(&self, kernel: E, query: &Self::Query) -> u16 {
                $node::first(self, kernel, query)
            }

            fn query_of_corners(b: &Frame, corners: &[Point]) -> Self::Query {
                let planes: [Key; K] = planes_of_corners(b, corners);
                query_of_planes(|j| planes[j].code())
            }

            fn query_of_lane(&self, lane: usize) -> Self::Query {
                query_of_planes(|j| self.planes[j][lane])
            }

            fn node_of_query(query: &Self::Query) -> Self {
                Self { planes: planes_of_query(query), ..Self::EMPTY }
            }
        }
    };
}

impl_lanes!(Node16, 16, realign_16);
impl_lanes!(Node4, 4, realign_4);

impl<const K: usize> Node16<K> {
    #[inline(always)]
    fn all<E: Kernel>(&self, kernel: E, query: &Query<16, K>, used: u16) -> (Rows, u64) {
        let mut rows = [0; 16];
        for (lane, row) in rows.iter_mut().enumerate() {
            if used >> lane & 1 != 0 {
                *row = kernel.overlap_1v16(query, lane, self);
            }
        }
        (rows, used.count_ones().into())
    }

    #[inline(always)]
    fn first<E: Kernel>(&self, kernel: E, query: &Query<16, K>) -> u16 {
        kernel.overlap_1v16(query, 0, self)
    }
}

impl<const K: usize> Node4<K> {
    #[inline(always)]
    fn all<E: Kernel>(&self, kernel: E, query: &Query<4, K>, used: u16) -> (Rows, u64) {
        let pairs = kernel.overlap_4v4(query, self);
        let mut rows = [0; 16];
        for (lane, row) in rows.iter_mut().take(4).enumerate() {
            if used >> lane & 1 != 0 {
                *row = pairs >> (4 * lane) & 0xf;
            }
        }
        (rows, 1)
    }

    #[inline(always)]
    fn first<E: Kernel>(&self, kernel: E, query: &Query<4, K>) -> u16 {
        kernel.overlap_4v4(query, self) & 0xf
    }
}
