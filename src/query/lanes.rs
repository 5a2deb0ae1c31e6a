//! What the traversal asks of a node type: the same questions for 1vs16 and 4vs4.

use super::gaps::{self, Entries};
use crate::frame::{Extent, Frame};
use crate::kernel::{Kernel, SEPARATED, Turned};
use crate::key::Key;
use crate::node::{Dop, Node, Node4, Node16};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::realign::{Realignment, planes_of};

/// Which pairs of children overlap.
#[derive(Copy, Clone, Default, Debug)]
pub struct Rows {
    /// Row i: the children of B that child i of A overlaps.
    pub(crate) rows: [u16; 16],
    /// Bit i: row i has a bit.
    pub(crate) pending: u16,
}

impl Rows {
    /// Puts fewer bits in a row.
    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, bits: u16) {
        self.rows[row & 15] = bits;
        self.pending &= !(u16::from(bits == 0) << (row & 15));
    }
}

/// A node type that can be queried. Implemented by [`Node16`] and [`Node4`] only.
pub trait Lanes: Dop {
    /// Re-alignment into the other body's frame.
    type Map: Copy + core::fmt::Debug;
    /// Turned planes of as many bodies as there are lanes.
    type Turned: Copy + core::fmt::Debug;
    /// The least supports of one body.
    type Lows: Copy + core::fmt::Debug;
    #[doc(hidden)]
    const NO_TURNED: Self::Turned;
    #[doc(hidden)]
    const NO_LOWS: Self::Lows;

    #[doc(hidden)]
    fn map(pose: &Pose, a: &Extent, b: &Frame) -> Self::Map;
    #[doc(hidden)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map, turned: &mut Self::Turned);
    /// The bodies in the `wanted` lanes of `turned` against all lanes of `self`; other rows are zero. Returns
    /// the number of kernel calls too.
    #[doc(hidden)]
    fn overlap_rows<E: Kernel>(&self, kernel: E, turned: &Self::Turned, wanted: u16) -> (Rows, u64);
    /// Puts the planes of everything within `margin` of moved primitives into lane 0 of `turned`.
    #[doc(hidden)]
    fn aim<P: Primitive>(
        turned: &mut Self::Turned,
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        margin: f64,
    );
    /// Turned planes shall hold everything within `margin` of the body.
    #[doc(hidden)]
    fn widen(map: &mut Self::Map, b: &Frame, margin: f64);
    /// How far each child of `self`, turned as `turned`, is from child `lane` of `b`.
    #[doc(hidden)]
    fn gaps_of_query(&self, turned: &Self::Turned, b: &Self, lane: usize) -> Entries;
    /// How far body `lane` of `turned` is from each child of `self`.
    #[doc(hidden)]
    fn gaps_of_node(&self, turned: &Self::Turned, lane: usize) -> Entries;
    /// The least supports of moved primitives, whose coordinates and the frame's centre `reach` bounds.
    #[doc(hidden)]
    fn lows<P: Primitive>(b: &Frame, items: &[P::Item], reach: f64) -> Self::Lows;
    /// How far the body with these least supports is from each child of `self`.
    #[doc(hidden)]
    fn gaps_of_lows(&self, lows: &Self::Lows) -> Entries;
    /// A node whose lane 0 has the planes of all of `self`.
    #[doc(hidden)]
    #[must_use]
    fn hull(&self) -> Self;
    /// Which bodies of `turned` child `lane` of `self` overlaps.
    #[doc(hidden)]
    fn overlap_column<E: Kernel>(&self, kernel: E, turned: &Self::Turned, lane: usize) -> u16;
    /// Which bodies of `turned` all of `self` overlaps, and the number of kernel calls.
    #[doc(hidden)]
    fn overlap_hull<E: Kernel>(&self, kernel: E, turned: &Self::Turned) -> (u16, u64);
}

macro_rules! impl_lanes {
    ($node:ident, $arity:literal, $realign:ident) => {
        impl<const K: usize> Lanes for $node<K>
        where
            Self: bytemuck::Pod,
        {
            type Map = Realignment<K>;
            type Turned = Turned<$arity, K>;
            type Lows = gaps::Lows<K>;
            const NO_LOWS: Self::Lows = [0.0; K];
            const NO_TURNED: Self::Turned = [[SEPARATED; $arity]; K];

            #[inline(always)]
            fn map(pose: &Pose, a: &Extent, b: &Frame) -> Self::Map {
                Realignment::new(pose, a, b)
            }

            #[inline(always)]
            fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map, turned: &mut Self::Turned) {
                kernel.$realign(map, self, turned);
            }

            #[inline(always)]
            fn overlap_rows<E: Kernel>(&self, kernel: E, turned: &Self::Turned, wanted: u16) -> (Rows, u64) {
                $node::rows(self, kernel, turned, wanted)
            }

            #[inline(always)]
            fn aim<P: Primitive>(
                turned: &mut Self::Turned,
                b: &Frame,
                items: impl Iterator<Item = P::Item>,
                margin: f64,
            ) {
                let planes: [Key; K] = planes_of::<P, K>(b, items, margin);
                for (j, plane) in planes.into_iter().enumerate() {
                    turned[j ^ 1][0] = !plane.code();
                }
            }

            fn widen(map: &mut Self::Map, b: &Frame, margin: f64) {
                map.widen(margin * b.scale());
            }

            #[inline(always)]
            fn gaps_of_query(&self, turned: &Self::Turned, b: &Self, lane: usize) -> Entries {
                gaps::gaps(turned, 0, |j| gaps::decode(!b.planes[j][lane % $arity]), &self.child)
            }

            #[inline(always)]
            fn gaps_of_node(&self, turned: &Self::Turned, lane: usize) -> Entries {
                gaps::gaps(&self.planes, -1, |j| gaps::decode(turned[j][lane % $arity]), &self.child)
            }

            #[inline(always)]
            fn lows<P: Primitive>(b: &Frame, items: &[P::Item], reach: f64) -> Self::Lows {
                gaps::lows_of::<P, K>(b, items, reach)
            }

            #[inline(always)]
            fn gaps_of_lows(&self, lows: &Self::Lows) -> Entries {
                gaps::gaps(&self.planes, -1, |j| lows[j], &self.child)
            }

            fn hull(&self) -> Self {
                let mut whole = Self::EMPTY;
                for (j, plane) in gaps::hull(&self.planes).into_iter().enumerate() {
                    whole.planes[j][0] = plane;
                }
                whole
            }

            #[inline(always)]
            fn overlap_column<E: Kernel>(&self, kernel: E, turned: &Self::Turned, lane: usize) -> u16 {
                $node::column(self, kernel, turned, lane)
            }

            #[inline(always)]
            fn overlap_hull<E: Kernel>(&self, kernel: E, turned: &Self::Turned) -> (u16, u64) {
                $node::against_hull(self, kernel, turned)
            }
        }
    };
}

impl_lanes!(Node16, 16, realign_16);
impl_lanes!(Node4, 4, realign_4);

impl<const K: usize> Node16<K> {
    #[inline(always)]
    fn rows<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>, wanted: u16) -> (Rows, u64) {
        let mut found = Rows::default();
        let mut left = wanted;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let row = kernel.overlap_1v16(turned, lane, self);
            found.rows[lane] = row;
            found.pending |= u16::from(row != 0) << lane;
        }
        (found, wanted.count_ones().into())
    }

    #[inline(always)]
    fn column<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>, lane: usize) -> u16 {
        kernel.overlap_16v1(turned, self, lane)
    }

    #[inline(always)]
    fn against_hull<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>) -> (u16, u64) {
        (kernel.overlap_16v_hull(turned, self), 1)
    }
}

impl<const K: usize> Node4<K> {
    #[inline(always)]
    fn rows<E: Kernel>(&self, kernel: E, turned: &Turned<4, K>, wanted: u16) -> (Rows, u64) {
        let pairs = kernel.overlap_4v4(turned, self);
        let mut found = Rows::default();
        for (lane, row) in found.rows.iter_mut().take(4).enumerate() {
            if wanted >> lane & 1 != 0 {
                *row = pairs >> (4 * lane) & 0xf;
                found.pending |= u16::from(*row != 0) << lane;
            }
        }
        (found, 1)
    }

    /// One call of 4vs4 says as much.
    #[inline(always)]
    fn against_hull<E: Kernel>(&self, _: E, _: &Turned<4, K>) -> (u16, u64) {
        (u16::MAX, 0)
    }

    #[inline(always)]
    fn column<E: Kernel>(&self, kernel: E, turned: &Turned<4, K>, lane: usize) -> u16 {
        let pairs = kernel.overlap_4v4(turned, self) >> lane;
        (0..4).fold(0, |mask, i| mask | (pairs >> (4 * i) & 1) << i)
    }
}
