//! Where a scene keeps what it knows of its bodies: in memory lent by the caller, or in its own.

use super::broad::BodySize;
use super::{Body, SceneError};
use crate::node::{Aabb16, Box3};
use crate::pose::{Inverted, Pose, Relative};
#[cfg(feature = "alloc")]
use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};

/// What a scene knows of one body. To be lent: [`Slot::EMPTY`].
#[derive(Clone, Debug)]
pub struct Slot<'t, N> {
    pub(super) body: Option<Body<'t, N>>,
    pub(super) generation: u32,
    /// How many bodies are attached to it.
    pub(super) attached: u32,
    pub(super) parent: Option<Attached>,
    /// Which of the bodies it moves with that an edge, or many configurations, are asked about.
    pub(super) carrier: Option<u32>,
    pub(super) world: Pose,
    /// Of the pose in the world, if the body stands still: it is asked about more often than placed.
    pub(super) inverted: Inverted,
    pub(super) size: BodySize,
}

/// Where an attached body is.
#[derive(Copy, Clone, Debug)]
pub(super) struct Attached {
    pub(super) to: u32,
    /// In the frame of the other.
    pub(super) at: Pose,
}

impl<N> Slot<'_, N> {
    /// No body.
    pub const EMPTY: Self = Self {
        body: None,
        generation: 0,
        attached: 0,
        parent: None,
        carrier: None,
        world: Pose::IDENTITY,
        inverted: Inverted::IDENTITY,
        size: BodySize::NOTHING,
    };

    /// Where a body stands in the frame of this one, which itself stands at `world`.
    #[inline]
    pub(super) fn relative(&self, world_a: &Pose, world: &Pose) -> Relative {
        if self.body.as_ref().is_some_and(|body| body.is_fixed) && self.carrier.is_none() {
            return self.inverted.relative(world_a, world);
        }
        world.inverted().relative(world_a, world)
    }
}

/// Nodes of boxes for so many bodies.
#[must_use]
pub const fn boxes_for(bodies: usize) -> usize {
    bodies.div_ceil(16)
}

/// Rows of pairs for so many bodies.
#[must_use]
pub const fn rows_for(bodies: usize) -> usize {
    bodies * boxes_for(bodies)
}

/// Memory for a scene, lent by the caller. The slots say for how many bodies there is room.
#[derive(Debug)]
pub struct SceneMemory<'t, N> {
    /// One for each body.
    pub slots: &'t mut [Slot<'t, N>],
    /// At least [`boxes_for`] the slots.
    pub boxes: &'t mut [Aabb16],
    /// At least [`rows_for`] the slots.
    pub rows: &'t mut [u16],
}

/// A slice of the caller's, or one that grows.
#[derive(Debug)]
pub(super) enum LentOrOwned<'m, T> {
    Lent(&'m mut [T]),
    #[cfg(feature = "alloc")]
    Owned(Vec<T>),
}

impl<T> Deref for LentOrOwned<'_, T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Lent(slice) => slice,
            #[cfg(feature = "alloc")]
            Self::Owned(slice) => slice,
        }
    }
}

impl<T> DerefMut for LentOrOwned<'_, T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Lent(slice) => slice,
            #[cfg(feature = "alloc")]
            Self::Owned(slice) => slice,
        }
    }
}

/// The memory of a scene.
#[derive(Debug)]
pub(super) struct Memories<'t, N> {
    pub(super) slots: LentOrOwned<'t, Slot<'t, N>>,
    /// Around the bodies in the world, their radii included, sixteen at a time; NaN where there is none.
    pub(super) boxes: LentOrOwned<'t, Aabb16>,
    /// Which pairs are asked: bit j of row i is set in one of two symmetric places, that of the body which moves, or else of
    /// the lower index. [`Memories::stride`] numbers a row.
    rows: LentOrOwned<'t, u16>,
}

impl<'t, N> Memories<'t, N> {
    pub(super) fn lent(memory: SceneMemory<'t, N>) -> Result<Self, SceneError> {
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
            slots: LentOrOwned::Lent(slots),
            boxes: LentOrOwned::Lent(boxes),
            rows: LentOrOwned::Lent(rows),
        })
    }

    #[cfg(feature = "alloc")]
    pub(super) const fn owned() -> Self {
        Self {
            slots: LentOrOwned::Owned(Vec::new()),
            boxes: LentOrOwned::Owned(Vec::new()),
            rows: LentOrOwned::Owned(Vec::new()),
        }
    }

    /// Words of a row.
    #[inline(always)]
    pub(super) fn stride(&self) -> usize {
        boxes_for(self.slots.len())
    }

    /// The pairs of body i with sixteen others.
    #[inline(always)]
    pub(super) fn row(&self, i: usize, sixteen: usize) -> u16 {
        self.rows[i * self.stride() + sixteen]
    }

    pub(super) fn set_pair(&mut self, i: usize, j: usize, is_asked: bool) {
        let stride = self.stride();
        let word = &mut self.rows[i * stride + j / 16];
        *word = *word & !(1 << (j % 16)) | u16::from(is_asked) << (j % 16);
    }

    /// The box around body i.
    pub(super) fn bounds(&self, i: usize) -> Box3 {
        self.boxes[i / 16].lane(i % 16)
    }

    pub(super) fn set_bounds(&mut self, i: usize, bounds: Box3) {
        self.boxes[i / 16].set_lane(i % 16, &bounds);
    }

    /// A slot without a body: the first there is, or a new one.
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
        let (LentOrOwned::Owned(slots), LentOrOwned::Owned(boxes), LentOrOwned::Owned(rows)) =
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
