//! Links: the target of a node's lane.

/// The target of a node's lane, in 32 bits.
///
/// | bits | meaning |
/// |---|---|
/// | all ones | empty: the lane is unused |
/// | 31 = 0, 30..26, 25..0 | [`Width`] of the volume, index of an inner node |
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

pub(crate) const LEAF_BIT: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;
const WIDTH_SHIFT: u32 = 26;
/// The index bits of a link to a node.
pub(crate) const INDEX: u32 = (1 << WIDTH_SHIFT) - 1;
/// The index bits of a link to primitives.
pub(crate) const FIRST: u32 = (1 << COUNT_SHIFT) - 1;

impl Child {
    /// The link to the root, with the least width.
    pub const ROOT: Self = Self(0);
    /// The link of an unused lane.
    pub const EMPTY: Self = Self(u32::MAX);
    /// Maximum number of primitives of a hierarchy; it has fewer nodes.
    pub const MAX_PRIMITIVES: u32 = (1 << WIDTH_SHIFT) - MAX_LEAF_SIZE;

    /// Link to a node, `index` below 2^26, with the width of its volume.
    pub(crate) const fn inner(index: u32, width: Width) -> Self {
        debug_assert!(index <= INDEX, "the index of a node has 26 bits");
        Self((width.0 as u32) << WIDTH_SHIFT | index)
    }

    /// Link to the first node of a tree; the coordinates of its points are at most `[x, y, z]` from the frame's centre.
    pub(crate) const fn root(index: u32, [x, y, z]: [f32; 3]) -> Self {
        Self::inner(index, Width::of(2.0 * ((x + y) + z)))
    }

    /// The width of the node's volume. Meaningless in other links.
    #[inline]
    #[must_use]
    pub const fn width(self) -> Width {
        Width((self.0 >> WIDTH_SHIFT & 31) as u8)
    }

    /// Link to `count` (1 ..= 16) primitives from `first`, below [`Child::MAX_PRIMITIVES`].
    pub(crate) const fn leaf(first: u32, count: u32) -> Self {
        debug_assert!(
            first < Self::MAX_PRIMITIVES && count >= 1 && count <= MAX_LEAF_SIZE,
            "leaf out of range"
        );
        Self(LEAF_BIT | (count - 1) << COUNT_SHIFT | first)
    }

    /// Decodes the link.
    #[inline]
    #[must_use]
    pub const fn link(self) -> Link {
        if self.0 == Self::EMPTY.0 {
            Link::Empty
        } else if self.0 & LEAF_BIT == 0 {
            Link::Inner(self.0 & INDEX)
        } else {
            let count = (self.0 >> COUNT_SHIFT & 0xf) + 1;
            Link::Leaf { first: self.0 & FIRST, count }
        }
    }
}

impl Link {
    /// The primitives of a leaf.
    #[inline(always)]
    pub(crate) const fn primitives(self) -> core::ops::Range<u32> {
        match self {
            Self::Leaf { first, count } => first..first + count,
            _ => 0..0,
        }
    }
}

/// Largest number of primitives in a leaf.
pub const MAX_LEAF_SIZE: u32 = 16;

/// The width of a volume: the binary logarithm of the sum of its slabs along the three axes, in the frame's unit, in 5
/// bits. The code is the logarithm, rounded down, plus 14, clamped to 0 ..= 31: 2^17 is at least the width of any body
/// in its frame, and 2^-14 is a 10^-9th of that.
///
/// It only decides which of two nodes a query opens first: no verdict depends on it.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Width(u8);

/// The code of width 1 in the frame's unit.
const CODE_OF_ONE: i32 = 14;

impl Width {
    /// The code for this sum of slabs, in the frame's unit. The greatest code for infinity and NaN.
    #[must_use]
    pub const fn of(sum: f32) -> Self {
        let exponent = (sum.to_bits() >> 23 & 0xff) as i32 - 127;
        let code = exponent + CODE_OF_ONE;
        Self(if code < 0 {
            0
        } else if code > 31 {
            31
        } else {
            code as u8
        })
    }

    /// The number of powers of two by which this is wider than `other`, in a frame whose unit is `2^exponent` times
    /// this one's.
    #[inline(always)]
    pub(crate) const fn excess(self, other: Self, exponent: i32) -> i32 {
        self.0 as i32 - other.0 as i32 - exponent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_logarithms_within_their_range() {
        let code = |sum: f32| Width::of(sum).0;
        assert_eq!([code(1.0), code(1.99), code(2.0), code(0.99)], [14, 14, 15, 13]);
        assert_eq!([code(0.0), code(1e-30), code(2.0_f32.powi(-14)), code(2.0_f32.powi(-13))], [0, 0, 0, 1]);
        assert_eq!(
            [code(131_071.0), code(131_072.0), code(1e30), code(f32::INFINITY), code(f32::NAN)],
            [30, 31, 31, 31, 31]
        );
    }

    #[test]
    fn a_link_keeps_index_and_width_apart() {
        for index in [0, 1, INDEX - 1, INDEX] {
            for code in 0..32 {
                let child = Child::inner(index, Width(code));
                assert_eq!((child.link(), child.width()), (Link::Inner(index), Width(code)));
            }
        }
    }
}
