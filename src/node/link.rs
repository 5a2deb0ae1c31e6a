//! Links: what a lane of a node leads to.

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
