//! Memory of a scene: borrowed from the caller, or owned.

use super::body::Body;
use super::body_size::BodySize;
use super::error::SceneError;
use crate::node::{Aabb16, Box3};
use crate::pose::{Inverted, Pose, Relative};
#[cfg(feature = "alloc")]
use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};

/// The state of one body. [`Slot::EMPTY`] initializes the caller's memory.
#[derive(Debug)]
pub struct Slot<'t, N> {
    pub(super) body: Option<Body<'t, N>>,
    pub(super) generation: u32,
    /// Number of bodies attached to this one.
    pub(super) attached: u32,
    pub(super) parent: Option<Attached>,
    /// Index of the moving body, in a motion or a batch of configurations, that this one moves with.
    pub(super) carrier: Option<u32>,
    /// The last interval of a motion for which this body's motion bound was computed, and the bound.
    pub(super) bound: (u32, f64),
    pub(super) world: Pose,
    /// Inverse of the world pose, stored for fixed bodies: they are tested more often than placed.
    pub(super) inverted: Inverted,
    pub(super) size: BodySize,
}

impl<N> Clone for Slot<'_, N> {
    fn clone(&self) -> Self {
        Self { body: self.body.clone(), ..*self }
    }
}

/// The attachment of a body.
#[derive(Copy, Clone, Debug)]
pub(super) struct Attached {
    pub(super) to: u32,
    /// The pose in the frame of the body that it is attached to.
    pub(super) at: Pose,
}

impl<N> Slot<'_, N> {
    /// An empty slot.
    pub const EMPTY: Self = Self {
        body: None,
        generation: 0,
        attached: 0,
        parent: None,
        carrier: None,
        bound: (0, 0.0),
        world: Pose::IDENTITY,
        inverted: Inverted::IDENTITY,
        size: BodySize::NOTHING,
    };

    /// The pose of a body at `world_a` relative to this one at `world`.
    #[inline]
    pub(super) fn relative(&self, world_a: &Pose, world: &Pose) -> Relative {
        if self.body.as_ref().is_some_and(|body| body.is_fixed) && self.carrier.is_none() {
            return self.inverted.relative(world_a, world);
        }
        world.inverted().relative(world_a, world)
    }
}

/// Number of boxes needed for this many bodies: one [`Aabb16`] for each sixteen.
#[must_use]
pub const fn boxes_for(bodies: usize) -> usize {
    bodies.div_ceil(16)
}

/// Number of words needed in the pair matrix for this many bodies.
#[must_use]
pub const fn rows_for(bodies: usize) -> usize {
    bodies * boxes_for(bodies)
}

/// Memory for a scene, borrowed from the caller. The number of slots limits the number of bodies.
#[derive(Debug)]
pub struct SceneMemory<'t, N> {
    /// One for each body.
    pub slots: &'t mut [Slot<'t, N>],
    /// At least [`boxes_for`] the number of slots.
    pub boxes: &'t mut [Aabb16],
    /// At least [`rows_for`] the number of slots.
    pub rows: &'t mut [u16],
}

/// A borrowed slice, or a vector that grows.
#[derive(Debug)]
pub(super) enum BorrowedOrOwned<'m, T> {
    Borrowed(&'m mut [T]),
    #[cfg(feature = "alloc")]
    Owned(Vec<T>),
}

impl<T> Deref for BorrowedOrOwned<'_, T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Borrowed(slice) => slice,
            #[cfg(feature = "alloc")]
            Self::Owned(slice) => slice,
        }
    }
}

impl<T> DerefMut for BorrowedOrOwned<'_, T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Borrowed(slice) => slice,
            #[cfg(feature = "alloc")]
            Self::Owned(slice) => slice,
        }
    }
}

#[cfg(feature = "alloc")]
impl<T: Clone> Clone for BorrowedOrOwned<'_, T> {
    fn clone(&self) -> Self {
        Self::Owned(self.to_vec())
    }
}

#[derive(Debug)]
pub(super) struct Memories<'t, N> {
    pub(super) slots: BorrowedOrOwned<'t, Slot<'t, N>>,
    /// Boxes around the bodies in the world, radii included, in groups of sixteen; NaN for an empty slot.
    pub(super) boxes: BorrowedOrOwned<'t, Aabb16>,
    /// The pairs to test: bit j of row i. Each pair has its bit in one of two symmetric places: in the row of the
    /// moving body, or else of the lower index. A row has [`Memories::stride`] words.
    rows: BorrowedOrOwned<'t, u16>,
}

#[cfg(feature = "alloc")]
impl<N> Clone for Memories<'_, N> {
    fn clone(&self) -> Self {
        Self { slots: self.slots.clone(), boxes: self.boxes.clone(), rows: self.rows.clone() }
    }
}

impl<'t, N> Memories<'t, N> {
    pub(super) fn borrowed(memory: SceneMemory<'t, N>) -> Result<Self, SceneError> {
        let SceneMemory { slots, boxes, rows } = memory;
        let bodies = slots.len();
        if boxes.len() < boxes_for(bodies) || rows.len() < rows_for(bodies) {
            return Err(SceneError::Memory { bodies, boxes: boxes_for(bodies), rows: rows_for(bodies) });
        }
        for slot in slots.iter_mut() {
            *slot = Slot::EMPTY;
        }
        boxes.fill(Aabb16::EMPTY);
        rows.fill(0);
        Ok(Self {
            slots: BorrowedOrOwned::Borrowed(slots),
            boxes: BorrowedOrOwned::Borrowed(boxes),
            rows: BorrowedOrOwned::Borrowed(rows),
        })
    }

    #[cfg(feature = "alloc")]
    pub(super) const fn owned() -> Self {
        Self {
            slots: BorrowedOrOwned::Owned(Vec::new()),
            boxes: BorrowedOrOwned::Owned(Vec::new()),
            rows: BorrowedOrOwned::Owned(Vec::new()),
        }
    }

    /// Words per row.
    #[inline(always)]
    pub(super) fn stride(&self) -> usize {
        boxes_for(self.slots.len())
    }

    /// The pairs of body i with one group of sixteen others.
    #[inline(always)]
    pub(super) fn row(&self, i: usize, sixteen: usize) -> u16 {
        self.rows[i * self.stride() + sixteen]
    }

    pub(super) fn set_pair(&mut self, i: usize, j: usize, is_asked: bool) {
        let stride = self.stride();
        let word = &mut self.rows[i * stride + j / 16];
        *word = *word & !(1 << (j % 16)) | u16::from(is_asked) << (j % 16);
    }

    pub(super) fn bounds(&self, i: usize) -> Box3 {
        self.boxes[i / 16].lane(i % 16)
    }

    pub(super) fn set_bounds(&mut self, i: usize, bounds: Box3) {
        self.boxes[i / 16].set_lane(i % 16, &bounds);
    }

    /// The first empty slot, or a new one.
    pub(super) fn vacant(&mut self) -> Option<usize> {
        let vacant = self.slots.iter().position(|slot| slot.body.is_none());
        if vacant.is_some() {
            return vacant;
        }
        self.grow()
    }

    #[cfg(not(feature = "alloc"))]
    fn grow(&mut self) -> Option<usize> {
        None
    }

    #[cfg(feature = "alloc")]
    fn grow(&mut self) -> Option<usize> {
        let (BorrowedOrOwned::Owned(slots), BorrowedOrOwned::Owned(boxes), BorrowedOrOwned::Owned(rows)) =
            (&mut self.slots, &mut self.boxes, &mut self.rows)
        else {
            return None;
        };
        let (old, bodies) = (slots.len(), (2 * slots.len()).max(16));
        let (from, stride) = (boxes_for(old), boxes_for(bodies));
        let mut longer = alloc::vec![0; rows_for(bodies)];
        for i in 0..old {
            longer[i * stride..i * stride + from].copy_from_slice(&rows[i * from..(i + 1) * from]);
        }
        *rows = longer;
        boxes.resize(stride, Aabb16::EMPTY);
        slots.resize_with(bodies, || Slot::EMPTY);
        Some(old)
    }
}
