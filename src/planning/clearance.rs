//! Clearance of a configuration, and its gradient.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::range::Point;
use crate::scene::{BodyId, SceneDistance, SceneWitness};
use crate::vector::{difference, dot, length};
use alloc::vec;
use alloc::vec::Vec;

impl PlanningScene {
    /// The least distance between two tested bodies, up to `cutoff` ([`Scene::clearance`](crate::Scene::clearance)).
    /// `tolerance` 0.01 gives bounds 1 % apart, and 0 the precision of `f64`.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`]; the tolerance or the cutoff is invalid.
    pub fn clearance(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        tolerance: f64,
        cutoff: f64,
    ) -> Result<SceneDistance, PlanningError> {
        self.go_to(workspace, values)?;
        Ok(workspace.scene.clearance(&self.query, tolerance, cutoff)?)
    }

    /// The derivative of the distance of a witness by each variable that is planned for, in the bodies' unit per unit
    /// of the variable: `n . (b' - a')`, where n is the unit vector from the point a of the witness to its point b, and
    /// the dash is the derivative of a point that moves with its body. `witness` is that of [`PlanningScene::clearance`]
    /// for the same values, and must have been the last query of the workspace. All zero where the points coincide.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if a body of the witness does not exist.
    pub fn clearance_gradient(
        &self,
        workspace: &mut Workspace,
        witness: &SceneWitness,
    ) -> Result<Vec<f64>, PlanningError> {
        let across = difference(&witness.b, &witness.a);
        let distance = length(&across);
        let mut gradient = vec![0.0; self.variables()];
        if distance <= 0.0 {
            return Ok(gradient);
        }
        let mut derivatives = vec![[0.0; 3]; self.rest.len()];
        for (id, point, sign) in [(witness.hit.a, witness.a, -1.0), (witness.hit.b, witness.b, 1.0)] {
            let Some(link) = self.link_of(workspace, id)? else { continue };
            self.kinematics().point_jacobian(&workspace.links, link, point, &mut derivatives);
            for (slope, &variable) in gradient.iter_mut().zip(&self.variables) {
                *slope += sign * dot(&across, &derivatives[variable]) / distance;
            }
        }
        Ok(gradient)
    }

    /// The moving link that carries a body, attached or its own. `None` for objects that stand still.
    fn link_of(&self, workspace: &Workspace, mut id: BodyId) -> Result<Option<u32>, PlanningError> {
        while let Some(parent) = workspace.scene.attached_to(id)? {
            id = parent;
        }
        let body = self.links.iter().position(|link| *link == id);
        Ok(body.map(|body| self.robot.robot().bodies[body].link))
    }

    /// Where a point of a body is in the world, in the last configuration of the workspace.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is no such body.
    pub fn to_world(&self, workspace: &Workspace, id: BodyId, point: Point) -> Result<Point, PlanningError> {
        Ok(workspace.scene.world_pose(id)?.apply(point))
    }
}
