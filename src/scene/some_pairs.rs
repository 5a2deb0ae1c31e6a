//! Queries of some pairs of a scene.

use super::body::{Body, BodyId, BodyTree};
use super::error::SceneError;
use super::placement::Scene;
use crate::node::{Box3, Dop};
use crate::pose::Pose;
use crate::query::{Lanes, Query, Verdict};

impl<'t, N: Dop> Scene<'t, N> {
    pub(crate) fn body(&self, id: BodyId) -> Result<&Body<'t, N>, SceneError> {
        self.memory.slots[self.index(id)?].body.as_ref().ok_or(SceneError::NoSuchBody { id })
    }

    /// The body's geometry.
    pub(crate) fn tree(&self, id: BodyId) -> Result<&BodyTree<'t, N>, SceneError> {
        Ok(&self.body(id)?.tree)
    }

    /// The body that a body is attached to, with its pose there.
    pub(crate) fn attachment(&self, id: BodyId) -> Result<Option<(BodyId, Pose)>, SceneError> {
        let parent = self.memory.slots[self.index(id)?].parent;
        Ok(self.attached_to(id)?.zip(parent.map(|parent| parent.at)))
    }

    /// The radius around a body.
    pub(crate) fn radius(&self, id: BodyId) -> Result<f64, SceneError> {
        Ok(self.body(id)?.radius)
    }

    /// Whether the body is a solid with capped holes.
    pub(crate) fn has_caps(&self, id: BodyId) -> Result<bool, SceneError> {
        Ok(self.tree(id)?.caps().is_some())
    }

    /// The box around a body in the world.
    pub(crate) fn bounds_of(&self, id: BodyId) -> Result<Box3, SceneError> {
        Ok(self.memory.bounds(self.index(id)?))
    }
}

impl<N: Lanes> Scene<'_, N> {
    /// Whether two bodies come within a margin of each other, whether or not the pair is tested.
    pub(crate) fn are_within(
        &self,
        query: &Query,
        a: BodyId,
        b: BodyId,
        margin: f64,
    ) -> Result<bool, SceneError> {
        let (i, j) = self.place_to_ask(a, b)?;
        let answer = self.ask_within(query, &self.pair_now(i as u32, j as u32), margin)?;
        Ok(matches!(answer.verdict, Verdict::Hit(_)))
    }

    /// Whether two bodies meet and are tested against each other: the verdict of [`Scene::collide`] for this pair.
    pub(crate) fn do_meet(&self, query: &Query, a: BodyId, b: BodyId) -> Result<bool, SceneError> {
        let (i, j) = self.place_to_ask(a, b)?;
        let pair = self.pair_now(i as u32, j as u32);
        let is_empty = [i, j].iter().any(|&i| self.memory.bounds(i).is_empty());
        if is_empty || pair.depth < 0.0 || !self.is_asked(a, b)? {
            return Ok(false);
        }
        Ok(matches!(self.ask_within(query, &pair, 0.0)?.verdict, Verdict::Hit(_)))
    }
}
