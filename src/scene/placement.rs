//! A scene: bodies, their poses in the world, and their attachments.

use super::body::{Body, BodyId};
use super::body_size::BodySize;
use super::error::SceneError;
use super::memory::{Attached, Memories, SceneMemory};
use crate::node::{Box3, Dop};
use crate::pose::{Pose, PoseError};
use crate::range::MAX_COORDINATE;

/// Bodies of one node type, placed in the world.
#[derive(Debug)]
pub struct Scene<'t, N> {
    pub(super) memory: Memories<'t, N>,
}

/// An independent scene that shares the trees. The copy of a scene in borrowed memory allocates its own.
#[cfg(feature = "alloc")]
impl<N> Clone for Scene<'_, N> {
    fn clone(&self) -> Self {
        Self { memory: self.memory.clone() }
    }
}

#[cfg(feature = "alloc")]
impl<N> Default for Scene<'_, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<N> Scene<'_, N> {
    /// Largest accepted deviation of a world pose's matrix from a rotation: the largest entry of `R R^T - 1`. Less than
    /// [`Pose::TOLERANCE`], so that any two bodies have a relative pose. Matrices with six digits or in `f32` pass, and
    /// so does every quaternion that gives a pose.
    pub const TOLERANCE: f64 = 1.5e-5;

    /// Largest coordinate of a body's position in the world: 2^298.
    pub const MAX_TRANSLATION: f64 = MAX_COORDINATE / 4.0;

    /// An empty scene, which allocates as bodies are inserted.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub const fn new() -> Self {
        Self { memory: Memories::owned() }
    }
}

impl<'t, N> Scene<'t, N> {
    /// An empty scene in the caller's memory, which does not allocate.
    ///
    /// ```
    /// use simdop::node::{Aabb16, Node16};
    /// use simdop::scene::{SceneMemory, Scene, Slot, boxes_for, rows_for};
    /// const ROOM: usize = 40;
    /// let mut slots = [const { Slot::<Node16<18>>::EMPTY }; ROOM];
    /// let mut boxes = [Aabb16::EMPTY; boxes_for(ROOM)];
    /// let mut rows = [0; rows_for(ROOM)];
    /// let scene = Scene::in_memory(SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows })?;
    /// assert_eq!(scene.ids().count(), 0);
    /// # Ok::<(), simdop::scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError::Memory`] if there are too few boxes or rows for the slots.
    pub fn in_memory(memory: SceneMemory<'t, N>) -> Result<Self, SceneError> {
        Ok(Self { memory: Memories::borrowed(memory)? })
    }

    /// The number of bodies that fit without growing.
    #[must_use]
    pub fn room(&self) -> usize {
        self.memory.slots.len()
    }

    /// The bodies in the scene, by ascending index.
    pub fn ids(&self) -> impl Iterator<Item = BodyId> + '_ {
        (0..self.memory.slots.len())
            .filter(|&index| self.memory.slots[index].body.is_some())
            .map(|index| self.id(index))
    }

    pub(super) fn id(&self, index: usize) -> BodyId {
        BodyId { index: index as u32, generation: self.memory.slots[index].generation }
    }

    pub(super) fn index(&self, id: BodyId) -> Result<usize, SceneError> {
        let index = id.index as usize;
        match self.memory.slots.get(index) {
            Some(slot) if slot.body.is_some() && slot.generation == id.generation => Ok(index),
            _ => Err(SceneError::NoSuchBody { id }),
        }
    }

    /// The body's pose in the world.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`].
    pub fn world_pose(&self, id: BodyId) -> Result<&Pose, SceneError> {
        Ok(&self.memory.slots[self.index(id)?].world)
    }

    /// The body at the end of the chain of attachments; the body itself if it is not attached.
    pub(super) fn root(&self, i: usize) -> usize {
        let mut root = i;
        while let Some(parent) = self.memory.slots[root].parent {
            root = parent.to as usize;
        }
        root
    }

    /// Stores in each slot which of the `moving` bodies its body moves with: itself, or the one it is attached to.
    pub(super) fn set_carriers(&mut self, moving: &[BodyId]) -> Result<(), SceneError> {
        for slot in self.memory.slots.iter_mut() {
            slot.carrier = None;
        }
        for (i, &id) in moving.iter().enumerate() {
            let index = self.index(id)?;
            let slot = &mut self.memory.slots[index];
            if slot.parent.is_some() {
                return Err(SceneError::IsAttached { id });
            }
            slot.carrier = Some(i as u32);
        }
        for i in 0..self.memory.slots.len() {
            self.memory.slots[i].carrier = self.memory.slots[self.root(i)].carrier;
        }
        Ok(())
    }
}

impl<'t, N: Dop> Scene<'t, N> {
    /// Inserts a body.
    ///
    /// # Errors
    /// [`SceneError`]: an invalid radius or pose, or no room.
    pub fn insert(&mut self, body: Body<'t, N>, world: &Pose) -> Result<BodyId, SceneError> {
        if !body.has_valid_radius() {
            return Err(SceneError::Radius { given: body.radius });
        }
        check(world)?;
        let i = self.memory.vacant().ok_or(SceneError::Full)?;
        let slot = &mut self.memory.slots[i];
        slot.size = BodySize::of(&body);
        slot.body = Some(body);
        self.put(i, world);
        for j in 0..self.memory.slots.len() {
            if let (Some(body), Some(other)) = (&self.memory.slots[i].body, &self.memory.slots[j].body)
                && j != i
            {
                let is_asked = body.is_asked_against(other);
                let (row, bit) = self.row_and_bit(i, j);
                self.memory.set_pair(row, bit, is_asked);
            }
        }
        Ok(self.id(i))
    }

    /// Removes a body. Bodies attached to it are detached and stay where they are.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`].
    pub fn remove(&mut self, id: BodyId) -> Result<Body<'t, N>, SceneError> {
        let i = self.index(id)?;
        self.detach(id)?;
        for j in 0..self.memory.slots.len() {
            if self.memory.slots[j].parent.is_some_and(|parent| parent.to as usize == i) {
                self.memory.slots[j].parent = None;
            }
            self.memory.set_pair(i, j, false);
            self.memory.set_pair(j, i, false);
        }
        self.memory.set_bounds(i, Box3::EMPTY);
        let slot = &mut self.memory.slots[i];
        slot.attached = 0;
        slot.generation = slot.generation.wrapping_add(1);
        slot.body.take().ok_or(SceneError::NoSuchBody { id })
    }

    /// Places a body, and moves the bodies attached to it along.
    ///
    /// # Errors
    /// [`SceneError`]: the pose, or that of an attached body, is invalid, in which case no body moves; or the body is
    /// itself attached to another.
    // Inlined with its check, so that a caller who has just made the pose from rows computes their products only once.
    #[inline]
    pub fn place(&mut self, id: BodyId, world: &Pose) -> Result<(), SceneError> {
        let i = self.index(id)?;
        if self.memory.slots[i].parent.is_some() {
            return Err(SceneError::IsAttached { id });
        }
        check(world)?;
        if self.memory.slots[i].attached > 0 {
            self.place_carried(i, world)?;
        }
        self.put(i, world);
        Ok(())
    }

    /// Places the bodies attached to a body, directly or not, for this pose of the body.
    #[inline(never)]
    fn place_carried(&mut self, i: usize, world: &Pose) -> Result<(), SceneError> {
        let is_carried = |scene: &Self, j: usize| j != i && scene.root(j) == i;
        // Check all poses first, so that an error moves no body.
        for j in 0..self.memory.slots.len() {
            if is_carried(self, j) {
                check(&self.carried(j, world)?)?;
            }
        }
        for j in 0..self.memory.slots.len() {
            if is_carried(self, j) {
                let moved = self.carried(j, world)?;
                self.put(j, &moved);
            }
        }
        Ok(())
    }

    /// Attaches a body to another. It keeps its current pose relative to that body, and [`Scene::place`] moves both.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`]; [`SceneError::IsAttached`] if the body is attached already;
    /// [`SceneError::Cycle`] if the other is attached to it, directly or not.
    pub fn attach(&mut self, id: BodyId, to: BodyId) -> Result<(), SceneError> {
        let (i, other) = (self.index(id)?, self.index(to)?);
        if self.memory.slots[i].parent.is_some() {
            return Err(SceneError::IsAttached { id });
        }
        if self.root(other) == i {
            return Err(SceneError::Cycle { id });
        }
        let slots = &mut self.memory.slots;
        let at = *Pose::relative(&slots[i].world, &slots[other].world)?.pose();
        slots[other].attached += 1;
        slots[i].parent = Some(Attached { to: other as u32, at });
        Ok(())
    }

    /// The body that a body is attached to.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`].
    pub fn attached_to(&self, id: BodyId) -> Result<Option<BodyId>, SceneError> {
        let parent = self.memory.slots[self.index(id)?].parent;
        Ok(parent.map(|parent| self.id(parent.to as usize)))
    }

    /// Detaches a body. It stays where it is. Does nothing if the body is not attached.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`].
    pub fn detach(&mut self, id: BodyId) -> Result<(), SceneError> {
        let i = self.index(id)?;
        if let Some(parent) = self.memory.slots[i].parent.take() {
            self.memory.slots[parent.to as usize].attached -= 1;
        }
        Ok(())
    }

    /// The world pose of body i if its [root](Self::root) is at `world`.
    pub(super) fn carried(&self, i: usize, world: &Pose) -> Result<Pose, SceneError> {
        let Some(Attached { to, at }) = self.memory.slots[i].parent else { return Ok(*world) };
        let (mut at, mut above) = (at, to);
        while let Some(parent) = self.memory.slots[above as usize].parent {
            (at, above) = (parent.at.compose(&at)?, parent.to);
        }
        Ok(world.compose(&at)?)
    }

    /// Places several bodies, and stops at the first error.
    pub(crate) fn place_all(&mut self, ids: &[BodyId], poses: &[Pose]) -> Result<(), SceneError> {
        ids.iter().zip(poses).try_for_each(|(&id, pose)| self.place(id, pose))
    }

    fn put(&mut self, i: usize, world: &Pose) {
        let slot = &mut self.memory.slots[i];
        slot.world = *world;
        if slot.body.as_ref().is_some_and(|body| body.is_fixed) {
            slot.inverted = world.inverted();
        }
        let bounds = slot.size.bounds(world);
        self.memory.set_bounds(i, bounds);
    }
}

/// Whether a scene accepts a world pose.
#[cfg_attr(simdop_small, inline(never))]
#[cfg_attr(not(simdop_small), inline(always))]
pub(crate) fn check(world: &Pose) -> Result<(), SceneError> {
    let near = |x: f64| x.abs() <= Scene::<()>::MAX_TRANSLATION;
    let [x, y, z] = world.translation();
    let is_accepted = world.is_rotation(Scene::<()>::TOLERANCE) & (near(x) & near(y) & near(z));
    if is_accepted { Ok(()) } else { Err(fault(world)) }
}

/// The error of a pose that failed [`check`].
#[cold]
fn fault(world: &Pose) -> SceneError {
    SceneError::Pose(if world.is_rotation(Scene::<()>::TOLERANCE) {
        PoseError::TooFar
    } else {
        PoseError::NotOrthonormal { deviation: world.deviation() }
    })
}
