//! The stack of a traversal: masks, not pairs, so that its size is bounded by the depth of the trees alone.

use super::lanes::Rows;
use crate::hierarchy::MAX_DEPTH;
use crate::node::Child;

/// A pair that was visited: two nodes, or a node and a leaf; and the pairs below it that are still to be
/// visited.
#[derive(Copy, Clone, Debug)]
struct Visited {
    a: Child,
    b: Child,
    rows: Rows,
}

/// Both bodies descend together, and one goes on alone when the other is at a leaf: each entry is a level
/// deeper in whichever tree is still descending, so there are no more entries than the deeper tree has
/// levels.
#[derive(Debug)]
pub(crate) struct Stack {
    visited: [Visited; MAX_DEPTH],
    len: usize,
}

/// Bytes of the stack of a query, whatever the trees: below 1 KB. (The traversal holds the planes of two
/// bodies, turned, besides: 2 x 576 bytes at arity 16 and k = 18.)
pub const STACK_BYTES: usize = size_of::<Stack>();
const _: () = assert!(STACK_BYTES <= 1024, "the stack of a query fits in 1 KB");

/// A pair that was visited, a row and a bit of it.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Next {
    pub(crate) a: Child,
    pub(crate) b: Child,
    pub(crate) row: usize,
    pub(crate) bit: usize,
}

impl Stack {
    pub(crate) const fn new() -> Self {
        let none = Visited { a: Child::EMPTY, b: Child::EMPTY, rows: Rows { rows: [0; 16], pending: 0 } };
        Self { visited: [none; MAX_DEPTH], len: 0 }
    }

    /// For rows with a bit.
    ///
    /// # Panics
    /// If full, which trees that were validated cannot bring about.
    #[inline(always)]
    pub(crate) fn push(&mut self, a: Child, b: Child, rows: &Rows) {
        self.visited[self.len] = Visited { a, b, rows: *rows };
        self.len += 1;
    }

    /// Takes the next bit of the entry that was pushed last: lower rows first, lower bits first.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<Next> {
        let top = self.visited.get_mut(self.len.checked_sub(1)?)?;
        let rows = &mut top.rows;
        let row = (rows.pending.trailing_zeros() & 15) as usize;
        let bits = &mut rows.rows[row];
        let bit = (bits.trailing_zeros() & 15) as usize;
        *bits &= bits.wrapping_sub(1);
        if *bits == 0 {
            rows.pending &= rows.pending.wrapping_sub(1);
        }
        let done = rows.pending == 0;
        let next = Next { a: top.a, b: top.b, row, bit };
        if done {
            self.len -= 1;
        }
        Some(next)
    }
}
