//! The stack of a traversal: masks, not pairs, so that its size is bounded by the depth of the trees alone.

use super::lanes::Rows;
use crate::hierarchy::MAX_DEPTH;

/// A visited pair of nodes and the pairs of children that are still to be looked at. 44 bytes.
#[derive(Copy, Clone, Debug)]
struct Frame {
    a: u32,
    b: u32,
    /// Bit i: row i has a bit left.
    pending: u16,
    rows: Rows,
}

/// Both trees descend one level a frame, so the shallower one bounds the number of frames.
#[derive(Debug)]
pub(crate) struct Stack {
    frames: [Frame; MAX_DEPTH],
    len: usize,
}

/// A visited node of one tree, against one leaf of the other, and the children still to be looked at.
#[derive(Debug)]
pub(crate) struct SingleStack {
    frames: [(u32, u16); MAX_DEPTH],
    len: usize,
}

/// Bytes of the stacks of a query, whatever the trees: below 2 KB.
pub const STACK_BYTES: usize = size_of::<Stack>() + size_of::<SingleStack>();
const _: () = assert!(STACK_BYTES <= 2048, "the stacks of a query fit in 2 KB");

impl Stack {
    pub(crate) const fn new() -> Self {
        Self { frames: [Frame { a: 0, b: 0, pending: 0, rows: [0; 16] }; MAX_DEPTH], len: 0 }
    }

    /// # Panics
    /// Beyond [`MAX_DEPTH`] frames, which a validated tree cannot reach.
    #[inline]
    pub(crate) fn push(&mut self, a: u32, b: u32, rows: Rows) {
        let pending = (0..16).fold(0, |mask, i| mask | u16::from(rows[i] != 0) << i);
        self.frames[self.len] = Frame { a, b, pending, rows };
        self.len += 1;
    }

    /// The next pair: node and lane of A, node and lane of B. Lower lanes first, A's before B's.
    #[inline]
    pub(crate) fn next(&mut self) -> Option<[(u32, usize); 2]> {
        while self.len > 0 {
            let top = &mut self.frames[self.len - 1];
            if top.pending == 0 {
                self.len -= 1;
                continue;
            }
            let lane_a = (top.pending.trailing_zeros() & 15) as usize;
            let row = &mut top.rows[lane_a];
            let lane_b = (row.trailing_zeros() & 15) as usize;
            *row &= *row - 1;
            if *row == 0 {
                top.pending &= top.pending - 1;
            }
            return Some([(top.a, lane_a), (top.b, lane_b)]);
        }
        None
    }
}

impl SingleStack {
    pub(crate) const fn new() -> Self {
        Self { frames: [(0, 0); MAX_DEPTH], len: 0 }
    }

    /// # Panics
    /// Beyond [`MAX_DEPTH`] frames, which a validated tree cannot reach.
    #[inline]
    pub(crate) fn push(&mut self, node: u32, mask: u16) {
        self.frames[self.len] = (node, mask);
        self.len += 1;
    }

    /// The next node and lane. Lower lanes first.
    #[inline]
    pub(crate) fn next(&mut self) -> Option<(u32, usize)> {
        while self.len > 0 {
            let (node, mask) = &mut self.frames[self.len - 1];
            if *mask == 0 {
                self.len -= 1;
                continue;
            }
            let lane = (mask.trailing_zeros() & 15) as usize;
            *mask &= *mask - 1;
            return Some((*node, lane));
        }
        None
    }
}
