//! The stack of a traversal: masks, not pairs, so that its size is bounded by the depth of the trees alone.

use crate::hierarchy::MAX_DEPTH;
use crate::node::Child;

/// Which pairs of children overlap.
#[derive(Copy, Clone, Default, Debug)]
pub struct Rows {
    /// Row i: the children of B that child i of A overlaps.
    pub(crate) rows: [u16; 16],
    /// Bit i, of 16: row i has a bit. In 32, since a load of 16 was compiled to one of 32 that had to wait for
    /// the stores of what lay beside it: 5 % of a query.
    pub(crate) pending: u32,
}

impl Rows {
    /// Puts fewer bits in a row.
    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, bits: u16) {
        self.rows[row & 15] = bits;
        self.pending &= !(u32::from(bits == 0) << (row & 15));
    }
}

/// Whose children the bits of an entry stand for.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Descent {
    /// Row i: the children of B that child i of A overlaps.
    Both,
    /// Row 0: children of A, against all of B's volume.
    A,
    /// Row 0: children of B, against all of A's volume.
    B,
}

/// Two volumes that overlap, of which at least one is a node's.
#[derive(Copy, Clone, Debug)]
pub(super) struct Volumes {
    pub(super) a: Child,
    pub(super) b: Child,
    /// The node that holds the planes of `b`, in lane `lane_b`; [`ABOVE_ROOT`] if that is the root, of the body or of a
    /// detail.
    pub(super) holder_b: u32,
    pub(super) lane_b: u8,
}

/// Instead of the node that holds the root as a child, which there is not.
pub(super) const ABOVE_ROOT: u32 = u32::MAX;

/// Volumes that were visited, and the pairs below them that are still to be visited.
#[derive(Copy, Clone, Debug)]
pub(super) struct Visited {
    pub(super) rows: Rows,
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    /// Whether the pairs were looked at once more, by thin slabs.
    pub(super) looked_at: bool,
}

/// Each entry is a level deeper in one tree or in both, so there are no more entries than both trees have
/// levels. Most queries need few: the others are not touched before they are needed.
#[derive(Debug)]
pub(crate) struct Stack {
    visited: [Visited; FIRST],
    more: Option<[Visited; 2 * MAX_DEPTH - FIRST]>,
    len: usize,
}

/// Levels of 16^8 primitives.
const FIRST: usize = 8;

const NONE: Visited = Visited {
    volumes: Volumes { a: Child::EMPTY, b: Child::EMPTY, holder_b: ABOVE_ROOT, lane_b: 0 },
    opened: Descent::Both,
    looked_at: false,
    rows: Rows { rows: [0; 16], pending: 0 },
};

/// Bytes of the stack of a query, whatever the trees: below 3 KB. (The traversal holds the planes of two
/// bodies, turned, besides: 2 x 576 bytes at arity 16 and k = 18.)
pub const STACK_BYTES: usize = size_of::<Stack>();
const _: () = assert!(STACK_BYTES <= 3072, "the stack of a query fits in 3 KB");

/// A pair that was visited, a row and a bit of it.
#[derive(Copy, Clone, Debug)]
pub(super) struct Next {
    pub(super) volumes: Volumes,
    pub(super) opened: Descent,
    pub(super) row: usize,
    pub(super) bit: usize,
}

impl Stack {
    /// The stack of a query that had none.
    #[cold]
    #[inline(never)]
    pub(super) fn begin(stack: &mut Option<Self>) {
        *stack = Some(Self { visited: [NONE; FIRST], more: None, len: 0 });
    }

    /// For rows with a bit.
    ///
    /// # Panics
    /// If full, which trees that were validated cannot bring about.
    #[inline(always)]
    pub(super) fn push(&mut self, volumes: Volumes, opened: Descent, rows: &Rows) {
        let entry = Visited { volumes, opened, rows: *rows, looked_at: false };
        match self.len.checked_sub(FIRST) {
            None => self.visited[self.len] = entry,
            Some(beyond) => self.more()[beyond] = entry,
        }
        self.len += 1;
    }

    // Not inlined, as is `begin`: what is made here was made once more in the frame of the traversal.
    #[cold]
    #[inline(never)]
    fn more(&mut self) -> &mut [Visited; 2 * MAX_DEPTH - FIRST] {
        self.more.get_or_insert([NONE; 2 * MAX_DEPTH - FIRST])
    }

    /// The entry that was pushed last.
    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut Visited> {
        let last = self.len.checked_sub(1)?;
        match last.checked_sub(FIRST) {
            None => self.visited.get_mut(last),
            Some(beyond) => self.more.as_mut()?.get_mut(beyond),
        }
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
