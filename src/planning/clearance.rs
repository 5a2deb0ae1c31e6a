//! Clearance of a configuration, signed or not, and its gradient.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::motion::MotionError;
use crate::range::Point;
use crate::scene::{BodyId, SceneDistance, SceneError, SceneSignedDistance, SceneWitness};
use crate::vector::{difference, dot, unit};

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
    /// Without heap.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if a body of the witness does not exist, or `gradient` has not one number for each
    /// variable.
    pub fn clearance_gradient(
        &self,
        workspace: &mut Workspace,
        witness: &SceneWitness,
        gradient: &mut [f64],
    ) -> Result<(), PlanningError> {
        self.check_length(gradient)?;
        let points = [(witness.hit.a, witness.a), (witness.hit.b, witness.b)];
        let normal = unit(&difference(&witness.a, &witness.b)).unwrap_or_default();
        gradient.fill(0.0);
        self.slopes(workspace, points, &normal, gradient)
    }

    /// The least signed distance of two tested bodies, up to `cutoff`, and its derivative by each variable that is
    /// planned for: what a trajectory optimiser needs. Without heap.
    ///
    /// The distance is that of [`Scene::signed_clearance`](crate::Scene::signed_clearance): negative where bodies meet,
    /// by their depth. The derivative is `n . (a' - b')`, where n is the normal of the witness, a and b are its points,
    /// and the dash is the derivative of a point that moves with its body; in the bodies' unit per unit of the
    /// variable. It is that of the distance wherever this is smooth, and of bodies that meet, that of the least
    /// translation that was found, whose length is `-lower`. All zero without a witness or a normal.
    ///
    /// # Errors
    /// As [`PlanningScene::clearance`]; [`PlanningError::Scene`] if `gradient` has not one number for each variable.
    pub fn signed_clearance(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        tolerance: f64,
        cutoff: f64,
        gradient: &mut [f64],
    ) -> Result<SceneSignedDistance, PlanningError> {
        self.check_length(gradient)?;
        self.go_to(workspace, values)?;
        let found = workspace.scene.signed_clearance(&self.query, tolerance, cutoff)?;
        gradient.fill(0.0);
        if let Some(witness) = &found.witness {
            let points = [(witness.hit.a, witness.a), (witness.hit.b, witness.b)];
            self.slopes(workspace, points, &witness.normal, gradient)?;
        }
        Ok(found)
    }

    fn check_length(&self, gradient: &[f64]) -> Result<(), PlanningError> {
        if gradient.len() == self.variables() {
            return Ok(());
        }
        let error = MotionError::Length { given: gradient.len(), needed: self.variables() };
        Err(SceneError::from(error).into())
    }

    /// Adds to each number the derivative, by its variable, of how far the first point is ahead of the second along the
    /// normal.
    fn slopes(
        &self,
        workspace: &mut Workspace,
        points: [(BodyId, Point); 2],
        normal: &Point,
        gradient: &mut [f64],
    ) -> Result<(), PlanningError> {
        for ((id, point), sign) in points.into_iter().zip([1.0, -1.0]) {
            let Some(link) = self.link_of(workspace, id)? else { continue };
            self.kinematics().point_jacobian(&workspace.links, link, point, &mut workspace.derivatives);
            for (slope, &variable) in gradient.iter_mut().zip(&self.variables) {
                *slope += sign * dot(normal, &workspace.derivatives[variable]);
            }
        }
        Ok(())
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
