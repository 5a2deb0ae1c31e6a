//! The stack of a distance query: pending volumes with their bounds.

use crate::hierarchy::MAX_DEPTH;
use crate::node::Child;
use crate::query::lanes::{Entries, Entry, least};
use crate::query::setup::Side;

/// A child of a node of A, whose planes are rotated into B's frame.
#[derive(Copy, Clone, Debug)]
pub(super) struct VolumeA {
    pub(super) child: Child,
    /// Link to its parent node; empty for the root.
    pub(super) parent: Child,
    pub(super) lane: u8,
    pub(super) level: u8,
    /// Set for nodes only; leaves are not opened.
    pub(super) width: f32,
}

/// A child of a node of B.
#[derive(Copy, Clone, Debug)]
pub(super) struct VolumeB {
    pub(super) child: Child,
    pub(super) parent: u32,
    pub(super) lane: u8,
    pub(super) level: u8,
    pub(super) width: f32,
}

/// A volume wider than the other by this factor is opened next, whatever their levels.
const WIDER: f32 = 4.0;

impl VolumeA {
    /// Whether node `self` is opened next rather than `b`: the one on the higher level, unless the other is much wider.
    #[inline(always)]
    pub(super) fn is_next(&self, b: &VolumeB) -> bool {
        if self.level <= b.level { self.width * WIDER >= b.width } else { self.width > WIDER * b.width }
    }
}

/// A finished step, and the lanes that are still pending.
#[derive(Copy, Clone, Debug)]
pub(super) struct Opened {
    pub(super) entries: Entries,
    pub(super) a: VolumeA,
    pub(super) b: VolumeB,
    /// The body whose children the lanes are.
    pub(super) body: Side,
}

/// Every step is a level deeper in one of the trees.
const MAX_OPENED: usize = 2 * MAX_DEPTH;

/// Bytes of the stack of a distance query, for all trees: below 5 KB.
pub const DISTANCE_STACK_BYTES: usize = size_of::<Frontier>();
const _: () = assert!(DISTANCE_STACK_BYTES <= 5120, "the stack of a distance query fits in 5 KB");

impl Opened {
    /// Initial value, to be overwritten: writing zeros is faster than copying four kilobytes.
    const BLANK: Self = Self {
        entries: [Entry::ZEROS; 16],
        a: VolumeA { child: Child::ROOT, parent: Child::ROOT, lane: 0, level: 0, width: 0.0 },
        b: VolumeB { child: Child::ROOT, parent: 0, lane: 0, level: 0, width: 0.0 },
        body: Side::A,
    };
}

#[derive(Debug)]
pub(super) struct Frontier {
    opened: [Opened; MAX_OPENED],
    len: usize,
}

impl Frontier {
    pub(super) const fn new() -> Self {
        Self { opened: [Opened::BLANK; MAX_OPENED], len: 0 }
    }

    /// # Panics
    /// If full, which validated trees cannot cause.
    #[inline(always)]
    pub(super) fn push(&mut self, step: Opened) {
        self.opened[self.len] = step;
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut Opened> {
        self.opened.get_mut(self.len.checked_sub(1)?)
    }

    pub(super) fn pop(&mut self) {
        self.len -= 1;
    }

    /// The least bound of all pending volumes, if there are any.
    pub(super) fn least(&self) -> Option<f32> {
        let least = self.opened[..self.len].iter().map(|step| least(&step.entries)).min()?;
        (least != Entry::NONE).then(|| least.bound())
    }
}
