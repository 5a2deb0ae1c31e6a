//! Which pairs of bodies are asked.

use super::{BodyId, Scene, SceneError};

impl<N> Scene<'_, N> {
    /// Whether the bodies are asked against each other.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`], and [`SceneError::NoPair`] of a body and itself.
    pub fn is_asked(&self, a: BodyId, b: BodyId) -> Result<bool, SceneError> {
        let (i, j) = self.place_of_pair(a, b)?;
        Ok(self.memory.row(i, j / 16) >> (j % 16) & 1 != 0)
    }

    /// Says whether two bodies are asked against each other, whatever their groups.
    ///
    /// # Errors
    /// [`SceneError::NoSuchBody`], and [`SceneError::NoPair`] of a body and itself.
    pub fn set_pair(&mut self, a: BodyId, b: BodyId, is_asked: bool) -> Result<(), SceneError> {
        let (i, j) = self.place_of_pair(a, b)?;
        self.memory.set_pair(i, j, is_asked);
        Ok(())
    }

    fn place_of_pair(&self, a: BodyId, b: BodyId) -> Result<(usize, usize), SceneError> {
        let (i, j) = (self.index(a)?, self.index(b)?);
        if i == j {
            return Err(SceneError::NoPair { id: a });
        }
        Ok(self.row_and_bit(i, j))
    }

    /// Where the matrix has the bit of a pair. Rows of bodies that stand still are so without bits, and are not looked at.
    pub(super) fn row_and_bit(&self, i: usize, j: usize) -> (usize, usize) {
        let is_fixed = |i: usize| self.memory.slots[i].body.as_ref().is_some_and(|body| body.is_fixed);
        match (is_fixed(i), is_fixed(j)) {
            (true, false) => (j, i),
            (false, true) => (i, j),
            _ => (i.min(j), i.max(j)),
        }
    }
}
