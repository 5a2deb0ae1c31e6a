//! Classes of pairs of bodies.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::scene::{BodyId, PairReport};

impl PlanningScene {
    /// Do two bodies meet never, always, or sometimes, within the limits of all joints of the robot
    /// ([`Scene::classify_pair`](crate::Scene::classify_pair))? Tests at most `boxes` boxes of values.
    ///
    /// # Errors
    /// [`PlanningError::Scene`]: there is no such body, both are the same, or both are clouds.
    pub fn classify_pair(
        &self,
        workspace: &mut Workspace,
        pair: (BodyId, BodyId),
        boxes: usize,
    ) -> Result<PairReport, PlanningError> {
        self.serve(workspace);
        Ok(workspace.scene.classify_pair(&self.query, &self.links, self.kinematics(), pair, boxes)?)
    }
}
