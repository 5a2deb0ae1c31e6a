//! Nodes: the planes and links of 16 or 4 children, in the byte order that the kernels load.
//!
//! | | `Node16<K>` | `Node4<K>` |
//! |---|---|---|
//! | plane `j` of child `i` | bytes `32 j + 2 i` | bytes `8 j + 2 i` |
//! | link of child `i` | bytes `32 K + 4 i` | bytes `8 K + 4 i` |
//! | size, k = 6 / 14 / 18 / 26 / 32 | 256 / 512 / 640 / 896 / 1088 | 64 / 128 / 160 / 224 / 272 |
//!
//! Planes `2 s` and `2 s + 1` are slab `s`. In a `Node16` they share one 64-byte line: one zmm, two ymm or four q registers.

use crate::key::Key;

/// What a lane of a node leads to, in 32 bits.
///
/// | bits | meaning |
/// |---|---|
/// | all ones | nothing: the lane is unused |
/// | 31 = 0, 30..0 | index of an inner node |
/// | 31 = 1, 30..27, 26..0 | leaf: number of primitives less one, index of the first |
#[derive(Copy, Clone, PartialEq, Eq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Child(u32);

/// A [`Child`], decoded.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Link {
    /// The lane is unused.
    Empty,
    /// Index of a node.
    Inner(u32),
    /// Primitives `first .. first + count`, `count` in 1 ..= 16.
    Leaf {
        /// Index of the first primitive, below [`Child::MAX_PRIMITIVES`].
        first: u32,
        /// Number of primitives.
        count: u32,
    },
}

const LEAF_BIT: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;

impl Child {
    /// The link to the root.
    pub const ROOT: Self = Self(0);
    /// The unused lane.
    pub const EMPTY: Self = Self(u32::MAX);
    /// A hierarchy has at most this many primitives.
    pub const MAX_PRIMITIVES: u32 = (1 << COUNT_SHIFT) - MAX_LEAF_SIZE;

    /// Link to a node, `index` below 2^31.
    #[cfg(feature = "alloc")]
    pub(crate) const fn inner(index: u32) -> Self {
        debug_assert!(index < LEAF_BIT, "node index needs its 32nd bit");
        Self(index)
    }

    /// Link to `count` (1 ..= 16) primitives from `first`, below [`Child::MAX_PRIMITIVES`].
    #[cfg(feature = "alloc")]
    pub(crate) const fn leaf(first: u32, count: u32) -> Self {
        debug_assert!(
            first < Self::MAX_PRIMITIVES && count >= 1 && count <= MAX_LEAF_SIZE,
            "leaf out of range"
        );
        Self(LEAF_BIT | (count - 1) << COUNT_SHIFT | first)
    }

    /// What the lane leads to.
    #[inline]
    #[must_use]
    pub const fn link(self) -> Link {
        if self.0 == Self::EMPTY.0 {
            Link::Empty
        } else if self.0 & LEAF_BIT == 0 {
            Link::Inner(self.0)
        } else {
            let count = (self.0 >> COUNT_SHIFT & 0xf) + 1;
            Link::Leaf { first: self.0 & ((1 << COUNT_SHIFT) - 1), count }
        }
    }
}

/// Largest number of primitives in a leaf.
pub const MAX_LEAF_SIZE: u32 = 16;

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

mod sealed {
    pub trait Sealed {}
}

/// A node of some arity and k. Implemented by [`Node16`] and [`Node4`] only.
pub trait Node: bytemuck::Pod + Send + Sync + sealed::Sealed + core::fmt::Debug {
    /// Number of planes of a child.
    const K: usize;
    /// Number of children.
    const ARITY: usize;
    /// A node of unused lanes.
    const EMPTY: Self;

    /// The links of all lanes.
    fn children(&self) -> &[Child];
    /// The code of plane `j` of child `lane`.
    fn plane(&self, j: usize, lane: usize) -> i16;
    /// Makes `lane` a child.
    fn set_child(&mut self, lane: usize, child: Child);
    /// Raises plane `j` of child `lane` to bound `key` too.
    fn raise_plane(&mut self, j: usize, lane: usize, key: Key);
    /// The key of each direction's support of `p`, in `frame`, to `keys`: one for each plane.
    fn supports(frame: &crate::frame::Frame, p: crate::range::Point, keys: &mut [Key]);
    /// Whether `key` bounds direction `j`'s support of `p`, in exact arithmetic.
    fn bounds(frame: &crate::frame::Frame, j: usize, p: crate::range::Point, key: Key) -> bool;
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

            #[inline]
            fn plane(&self, j: usize, lane: usize) -> i16 {
                self.planes[j][lane]
            }

            fn set_child(&mut self, lane: usize, child: Child) {
                self.child[lane] = child;
            }

            #[inline]
            fn raise_plane(&mut self, j: usize, lane: usize, key: Key) {
                let plane = &mut self.planes[j][lane];
                *plane = (*plane).max(key.code());
            }

            fn supports(frame: &crate::frame::Frame, p: crate::range::Point, keys: &mut [Key]) {
                frame.supports::<K>(p, keys);
            }

            fn bounds(frame: &crate::frame::Frame, j: usize, p: crate::range::Point, key: Key) -> bool {
                frame.bounds::<K>(j, p, key)
            }
        }
    };
}

impl_node!(Node16, 16);
impl_node!(Node4, 4);
