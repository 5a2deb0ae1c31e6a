//! Nodes of k-DOPs: the planes and links of 16 or 4 children, in the byte order that the kernels load.
//!
//! | | `Node16<K>` | `Node4<K>` |
//! |---|---|---|
//! | plane `j` of child `i` | bytes `32 j + 2 i` | bytes `8 j + 2 i` |
//! | link of child `i` | bytes `32 K + 4 i` | bytes `8 K + 4 i` |
//! | size, k = 6 / 14 / 18 / 26 / 32 | 256 / 512 / 640 / 896 / 1088 | 64 / 128 / 160 / 224 / 272 |
//!
//! Planes `2 s` and `2 s + 1` are slab `s`. In a `Node16` they share one 64-byte line: one zmm, two ymm or
//! four q registers.

use super::{Child, Dop, Node, sealed};
use crate::directions::Directions;
use crate::key::Key;
use crate::range::Point;

/// Sixteen children. Its slabs start on cache lines.
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(C, align(64))]
pub struct Node16<const K: usize> {
    /// `planes[j][i]`: key of plane `j` of child `i`, [`Key::EMPTY`] in unused lanes.
    pub planes: [[i16; 16]; K],
    /// Where the lanes lead.
    pub child: [Child; 16],
}

/// Four children.
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(C, align(16))]
pub struct Node4<const K: usize> {
    /// `planes[j][i]`: key of plane `j` of child `i`, [`Key::EMPTY`] in unused lanes.
    pub planes: [[i16; 4]; K],
    /// Where the lanes lead.
    pub child: [Child; 4],
}

macro_rules! impl_node {
    ($node:ident, $arity:literal) => {
        impl<const K: usize> sealed::Sealed for $node<K> {}

        impl<const K: usize> Node for $node<K>
        where
            Self: bytemuck::Pod,
        {
            const K: usize = K;
            const ARITY: usize = $arity;
            const EMPTY: Self =
                Self { planes: [[Key::EMPTY.code(); $arity]; K], child: [Child::EMPTY; $arity] };

            #[inline]
            fn children(&self) -> &[Child] {
                &self.child
            }

            fn set_child(&mut self, lane: usize, child: Child) {
                self.child[lane] = child;
            }
        }

        impl<const K: usize> Dop for $node<K>
        where
            Self: bytemuck::Pod,
        {
            const DIRECTIONS: &'static [Point] = &Directions::<K>::VECTORS;

            #[inline]
            fn plane(&self, j: usize, lane: usize) -> i16 {
                self.planes[j][lane]
            }

            #[inline]
            fn raise_plane(&mut self, j: usize, lane: usize, key: Key) {
                let plane = &mut self.planes[j][lane];
                *plane = (*plane).max(key.code());
            }
        }
    };
}

impl_node!(Node16, 16);
impl_node!(Node4, 4);
