//! The stack of a traversal: it holds masks, not pairs, so that its size depends only on the depth of the trees.

use crate::hierarchy::MAX_DEPTH;
use crate::node::Child;
use crate::query::lanes::{Descent, Rows};

/// Two volumes that overlap, at least one of which is a node's.
#[derive(Copy, Clone, Debug)]
pub(super) struct Volumes {
    pub(super) a: Child,
    pub(super) b: Child,
    /// The node that holds the planes of `b`, in lane `lane_b`; [`ABOVE_ROOT`](crate::query::setup::ABOVE_ROOT) if `b`
    /// is the root.
    pub(super) holder_b: u32,
    pub(super) lane_b: u8,
}

/// Volumes that were visited, and the pending pairs below them.
#[derive(Copy, Clone, Debug)]
pub(super) struct Visited {
    pub(super) rows: Rows,
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    /// Whether the normal slabs of the pairs were tested.
    pub(super) looked_at: bool,
}

/// The pending volumes, in the caller's memory. Each entry is at least one level deeper than the one before it, in one
/// tree or in both, so both trees together have at least as many levels as there are entries.
pub(super) struct Stack<'s> {
    visited: &'s mut [Visited],
    len: usize,
}

/// Enough entries for most queries that are not decided at the roots: the levels of a tree of 16^6 primitives.
pub(super) const FEW: usize = 6;
/// The number of entries below the last of these.
pub(super) const MANY: usize = 2 * MAX_DEPTH - FEW + 1;

/// Initial value, to be overwritten: all zeros, which need no copy.
pub(super) const NOT_VISITED: Visited = Visited {
    volumes: Volumes { a: Child::ROOT, b: Child::ROOT, holder_b: 0, lane_b: 0 },
    opened: Descent::Both,
    looked_at: false,
    rows: Rows { rows: [0; 16], pending: 0 },
};

/// Bytes of the pending pairs in a query, for all trees: below 3 KB. A query that goes at most six levels below the
/// roots uses a seventh of that. (A traversal also holds the rotated planes of a node's children: 576 bytes at arity 16
/// and k = 18.)
pub const STACK_BYTES: usize = (FEW + MANY) * size_of::<Visited>();
const _: () = assert!(STACK_BYTES <= 3072, "the stack of a query fits in 3 KB");

/// A pending pair: a row and a bit of an entry.
#[derive(Copy, Clone, Debug)]
pub(super) struct Next {
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    pub(super) row: usize,
    pub(super) bit: usize,
}

impl<'s> Stack<'s> {
    /// A stack whose first `len` entries are already in memory.
    #[inline(always)]
    pub(super) const fn new(memory: &'s mut [Visited], len: usize) -> Self {
        Self { visited: memory, len }
    }

    /// Pushes an entry that has at least one bit. Returns true if the memory is now full: the caller must then visit
    /// and pop this entry with more memory.
    ///
    /// # Panics
    /// If the stack was already full.
    #[inline(always)]
    pub(super) fn push(&mut self, entry: Visited) -> bool {
        self.visited[self.len] = entry;
        self.len += 1;
        self.len == self.visited.len()
    }

    /// The last entry.
    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut Visited> {
        self.visited.get_mut(self.len.checked_sub(1)?)
    }

    /// Takes the next bit of the last entry: lower rows first, lower bits first.
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

    /// Drops the last entry.
    #[inline(always)]
    pub(super) fn pop(&mut self) {
        self.len -= 1;
    }
}
