//! Which children of two nodes overlap, as bits.

use crate::node::Child;

/// Which pairs of children overlap.
#[derive(Copy, Clone, Default, Debug)]
pub struct Rows {
    /// Row i: the children of B that child i of A overlaps.
    pub(crate) rows: [u16; 16],
    /// Bit i of 16: row i is not empty. Stored in 32 bits, since a 16-bit load was compiled to a 32-bit one, which
    /// stalled on the adjacent stores: 5 % of a query.
    pub(crate) pending: u32,
}

impl Rows {
    /// Replaces a row by a subset of its bits.
    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, bits: u16) {
        self.rows[row & 15] = bits;
        self.pending &= !(u32::from(bits == 0) << (row & 15));
    }
}

/// The meaning of the bits of an entry.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::query) enum Descent {
    /// Row i: the children of B that child i of A overlaps.
    Both,
    /// Row 0: children of A that overlap all of B's volume.
    A,
    /// Row 0: children of B that overlap all of A's volume.
    B,
}

/// The indices of the set bits, ascending.
#[inline(always)]
pub(in crate::query) fn bits_of(mut bits: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        bit
    })
}

/// The used lanes of a node.
#[inline(always)]
pub(in crate::query) fn used_lanes(children: &[Child]) -> u16 {
    let mut used = 0;
    for (lane, child) in children.iter().enumerate() {
        used |= u16::from(*child != Child::EMPTY) << lane;
    }
    used
}
