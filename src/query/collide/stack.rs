//! The stack of a traversal: masks, not pairs, so that its size is bounded by the depth of the trees alone.

use crate::hierarchy::MAX_DEPTH;
use crate::node::Child;
use crate::query::lanes::{Descent, Rows};

/// Two volumes that overlap, of which at least one is a node's.
#[derive(Copy, Clone, Debug)]
pub(super) struct Volumes {
    pub(super) a: Child,
    pub(super) b: Child,
    /// The node that holds the planes of `b`, in lane `lane_b`; [`ABOVE_ROOT`] if that is the root.
    pub(super) holder_b: u32,
    pub(super) lane_b: u8,
}

/// Volumes that were visited, and the pairs below them that are still to be visited.
#[derive(Copy, Clone, Debug)]
pub(super) struct Visited {
    pub(super) rows: Rows,
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    /// Whether the pairs were looked at once more, by normal slabs.
    pub(super) looked_at: bool,
}

/// The volumes that wait, in memory of a caller's. Each entry is a level deeper in one tree or in both, so there are no more
/// than both trees have levels.
pub(super) struct Stack<'s> {
    visited: &'s mut [Visited],
    len: usize,
}

/// What most queries need that are not decided at the roots: levels of 16^6 primitives.
pub(super) const FEW: usize = 6;
/// What is needed below the last of these.
pub(super) const MANY: usize = 2 * MAX_DEPTH - FEW + 1;

/// To be overwritten: zeros, which take no copy.
pub(super) const NOT_VISITED: Visited = Visited {
    volumes: Volumes { a: Child::ROOT, b: Child::ROOT, holder_b: 0, lane_b: 0 },
    opened: Descent::Both,
    looked_at: false,
    rows: Rows { rows: [0; 16], pending: 0 },
};

/// Bytes of the pairs that wait in a query, whatever the trees: below 3 KB, of which one that is not six levels below the roots
/// takes a seventh. (A traversal holds the planes of a node's children, turned, besides: 576 bytes at arity 16 and k = 18.)
pub const STACK_BYTES: usize = (FEW + MANY) * size_of::<Visited>();
const _: () = assert!(STACK_BYTES <= 3072, "the stack of a query fits in 3 KB");

/// A pair that was visited, a row and a bit of it.
#[derive(Copy, Clone, Debug)]
pub(super) struct Next {
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    pub(super) row: usize,
    pub(super) bit: usize,
}

impl<'s> Stack<'s> {
    /// With the first of the entries in the memory.
    #[inline(always)]
    pub(super) const fn new(memory: &'s mut [Visited], len: usize) -> Self {
        Self { visited: memory, len }
    }

    /// For rows with a bit. True if that was the last entry that there is room for: to go on, it has to be visited elsewhere, and
    /// popped.
    ///
    /// # Panics
    /// If the last one was pushed before.
    #[inline(always)]
    pub(super) fn push(&mut self, entry: Visited) -> bool {
        self.visited[self.len] = entry;
        self.len += 1;
        self.len == self.visited.len()
    }

    /// The entry that was pushed last.
    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut Visited> {
        self.visited.get_mut(self.len.checked_sub(1)?)
    }

    /// Takes the next bit of the entry that was pushed last: lower rows first, lower bits first.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<Next> {
        let top = self.top()?;
        let rows = &mut top.rows;
        let row = (rows.pending.trailing_zeros() & 15) as usize;
        let bits = &mut rows.rows[row];
        let bit = (bits.trailing_zeros() & 15) as usize;
        *bits &= bits.wrapping_sub(1);
        if *bits == 0 {
            rows.pending &= rows.pending.wrapping_sub(1);
        }
        let done = rows.pending == 0;
        let next = Next { volumes: top.volumes, opened: top.opened, row, bit };
        if done {
            self.len -= 1;
        }
        Some(next)
    }

    /// Drops the entry that was pushed last.
    #[inline(always)]
    pub(super) fn pop(&mut self) {
        self.len -= 1;
    }
}
