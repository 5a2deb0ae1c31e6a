//! Clearance of a configuration, signed or not, and its gradient.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::motion::MotionError;
use crate::range::Point;
use crate::scene::{BodyId, SceneDistance, SceneError, SceneSignedDistance, SceneWitness};
use crate::vector::{difference, dot, unit};

impl PlanningScene {
    /// The least distance between two tested bodies, up to `cutoff` ([`Scene::clearance`](crate::Scene::clearance)). A
    /// `tolerance` of 0.01 gives bounds 1 % apart, and 0 gives the precision of `f64`.
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

    /// The derivative of a witness's distance with respect to each variable that is planned for, in the bodies' unit
    /// per unit of the variable: `n . (b' - a')`, where n is the unit vector from the point a of the witness to its
    /// point b, and the prime is the derivative of a point that moves with its body. `witness` comes from
    /// [`PlanningScene::clearance`] at the same values, which must have been the last query of the workspace. All zero
    /// if the points coincide. Does not allocate.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if a body of the witness does not exist, or `gradient` does not have one number for
    /// each variable.
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

    /// The least signed distance of two tested bodies, up to `cutoff`, and its derivative with respect to each variable
    /// that is planned for, for trajectory optimisers. Does not allocate.
    ///
    /// The distance is that of [`Scene::signed_clearance`](crate::Scene::signed_clearance): minus the penetration depth
    /// where bodies meet. The derivative is `n . (a' - b')`, in the bodies' unit per unit of the variable, where n is
    /// the normal of the witness, a and b are its points, and the prime is the derivative of a point that moves with
    /// its body. It is the derivative of the distance wherever this is smooth, and if bodies meet, that of the length
    /// `-lower` of the shortest translation found. All zero without a witness or a normal.
    ///
    /// # Errors
    /// As [`PlanningScene::clearance`]; [`PlanningError::Scene`] if `gradient` does not have one number for each
    /// variable.
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

    /// Adds to each number the derivative, with respect to its variable, of `n . (a - b)`: how far the first point is
    /// ahead of the second along the normal.
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

    /// The moving link that carries a body, either as its own or attached to it. `None` for objects that stand still.
    fn link_of(&self, workspace: &Workspace, mut id: BodyId) -> Result<Option<u32>, PlanningError> {
        while let Some(parent) = workspace.scene.attached_to(id)? {
            id = parent;
        }
        let body = self.links.iter().position(|link| *link == id);
        Ok(body.map(|body| self.robot.robot().bodies[body].link))
    }

    /// The position in the world of a point of a body, in the last configuration of the workspace.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is no such body.
    pub fn to_world(&self, workspace: &Workspace, id: BodyId, point: Point) -> Result<Point, PlanningError> {
        Ok(workspace.scene.world_pose(id)?.apply(point))
    }
}
