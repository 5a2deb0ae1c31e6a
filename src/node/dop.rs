//! Nodes of k-DOPs, planes by column: sixteen children for 1vs16, four for 4vs4.
//!
//! | | [`Node16`] | [`Node4`] |
//! |---|---|---|
//! | plane `j` of child `i` at byte | `32 j + 2 i` | `8 j + 2 i` |
//! | link of child `i` at byte | `32 K + 4 i` | `8 K + 4 i` |
//! | size, k = 6 / 14 / 18 / 26 / 32 | 256 / 512 / 640 / 896 / 1088 | 64 / 128 / 160 / 224 / 272 |
//!
//! Planes `2 s` and `2 s + 1` form slab `s`. In a `Node16` they share one 64-byte line: one zmm, two ymm or four q
//! registers.

use super::{Child, Dop, Node, sealed};
use crate::directions::Directions;
use crate::key::{EMPTY, Fixed, Key, Storage};
use crate::range::Point;
use core::marker::PhantomData;

/// `W` children with `K` planes each, in storage `S`.
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(C)]
pub struct DopNode<const W: usize, const K: usize, S = Fixed>
where
    Arity<W>: Alignment,
{
    /// `planes[j][i]`: key of plane `j` of child `i`, [`Key::EMPTY`] in unused lanes.
    pub planes: [[i16; W]; K],
    /// The links of the lanes.
    pub child: [Child; W],
    alignment: [<Arity<W> as Alignment>::Unit; 0],
    storage: PhantomData<S>,
}

/// Sixteen children. Its slabs start on cache lines.
pub type Node16<const K: usize, S = Fixed> = DopNode<16, K, S>;

/// Four children.
pub type Node4<const K: usize, S = Fixed> = DopNode<4, K, S>;

/// The possible numbers of lanes of a node, 4 and 16, as types.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Arity<const W: usize>;

/// The alignment of nodes with this number of lanes. Implemented by `Arity<16>` and `Arity<4>` only.
pub trait Alignment: sealed::Sealed {
    #[doc(hidden)]
    type Unit: Copy + PartialEq + Send + Sync + core::fmt::Debug + 'static;
}

/// A cache line.
#[doc(hidden)]
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(align(64))]
pub struct LineAlignment;

/// A register of the narrowest instruction set.
#[doc(hidden)]
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(align(16))]
pub struct VectorAlignment;

impl sealed::Sealed for Arity<16> {}
impl sealed::Sealed for Arity<4> {}

impl Alignment for Arity<16> {
    type Unit = LineAlignment;
}

impl Alignment for Arity<4> {
    type Unit = VectorAlignment;
}

impl<const W: usize, const K: usize, S> DopNode<W, K, S>
where
    Arity<W>: Alignment,
{
    /// A node with these planes and links.
    #[inline(always)]
    #[must_use]
    pub const fn new(planes: [[i16; W]; K], child: [Child; W]) -> Self {
        Self { planes, child, alignment: [], storage: PhantomData }
    }
}

impl<const W: usize, const K: usize, S> sealed::Sealed for DopNode<W, K, S> where Arity<W>: Alignment {}

impl<const W: usize, const K: usize, S: Storage> Node for DopNode<W, K, S>
where
    Arity<W>: Alignment,
    Self: bytemuck::Pod,
{
    type Storage = S;
    const K: usize = K;
    const ARITY: usize = W;
    const EMPTY: Self = Self::new([[EMPTY; W]; K], [Child::EMPTY; W]);

    #[inline]
    fn children(&self) -> &[Child] {
        &self.child
    }

    fn set_child(&mut self, lane: usize, child: Child) {
        self.child[lane] = child;
    }
}

impl<const W: usize, const K: usize, S: Storage> Dop for DopNode<W, K, S>
where
    Arity<W>: Alignment,
    Self: bytemuck::Pod,
{
    const DIRECTIONS: &'static [Point] = &Directions::<K>::VECTORS;

    #[inline]
    fn plane(&self, j: usize, lane: usize) -> i16 {
        self.planes[j][lane]
    }

    #[inline]
    fn raise_plane(&mut self, j: usize, lane: usize, key: Key<S>) {
        let plane = &mut self.planes[j][lane];
        *plane = (*plane).max(key.code());
    }
}
