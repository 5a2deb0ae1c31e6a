//! Which pairs of bodies are tested.

use super::body::BodyId;
use super::error::SceneError;
use super::placement::Scene;

impl<N> Scene<'_, N> {
    /// Whether two bodies are tested against each other.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`], and [`SceneError::NoPair`] for a body and itself.
    pub fn is_asked(&self, a: BodyId, b: BodyId) -> Result<bool, SceneError> {
        let (i, j) = self.place_of_pair(a, b)?;
        Ok(self.memory.row(i, j / 16) >> (j % 16) & 1 != 0)
    }

    /// Allows two bodies to meet, whatever their groups: no query of the scene tests the pair.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`], and [`SceneError::NoPair`] for a body and itself.
    pub fn allow_collision(&mut self, a: BodyId, b: BodyId) -> Result<(), SceneError> {
        let (i, j) = self.place_of_pair(a, b)?;
        self.memory.set_pair(i, j, false);
        Ok(())
    }

    /// Forbids two bodies to meet, whatever their groups: all queries of the scene test the pair.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`], [`SceneError::NoPair`] for a body and itself, and [`SceneError::TwoClouds`].
    pub fn forbid_collision(&mut self, a: BodyId, b: BodyId) -> Result<(), SceneError> {
        let (i, j) = self.place_to_ask(a, b)?;
        self.memory.set_pair(i, j, true);
        Ok(())
    }

    /// [`Scene::place_of_pair`] for two bodies that are not both clouds. A cloud is the second of the pair.
    pub(super) fn place_to_ask(&self, a: BodyId, b: BodyId) -> Result<(usize, usize), SceneError> {
        let (i, j) = self.place_of_pair(a, b)?;
        if self.is_cloud(i) && self.is_cloud(j) {
            return Err(SceneError::TwoClouds { id: a });
        }
        Ok((i, j))
    }

    fn place_of_pair(&self, a: BodyId, b: BodyId) -> Result<(usize, usize), SceneError> {
        let (i, j) = (self.index(a)?, self.index(b)?);
        if i == j {
            return Err(SceneError::NoPair { id: a });
        }
        Ok(self.row_and_bit(i, j))
    }

    /// Row and column of a pair's bit in the matrix. A cloud is the second of each of its pairs, so its row is empty. A
    /// shape is the first, unless both are shapes. By default, the row of a fixed body contains only its pairs with
    /// clouds.
    pub(super) fn row_and_bit(&self, i: usize, j: usize) -> (usize, usize) {
        let is_fixed = |i: usize| self.memory.slots[i].body.as_ref().is_some_and(|body| body.is_fixed);
        let [a, b] = [i, j].map(|i| (self.rank(i), is_fixed(i), i));
        if a < b { (i, j) } else { (j, i) }
    }

    fn rank(&self, i: usize) -> u8 {
        self.memory.slots[i].body.as_ref().map_or(0, |body| body.tree.rank())
    }

    fn is_cloud(&self, i: usize) -> bool {
        self.memory.slots[i].body.as_ref().is_some_and(|body| body.tree.is_cloud())
    }
}
