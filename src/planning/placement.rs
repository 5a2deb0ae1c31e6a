//! Workspaces of a scene, and the placement of the robot in them.

use super::PlanningNode;
use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::motion::LinkFrame;
use crate::pose::Pose;
use crate::scene::{BodyId, BodyTree};
use alloc::vec;
use alloc::vec::Vec;

impl PlanningScene {
    /// Memory for queries, one for each thread. It serves this scene and its copies, also after they change.
    #[must_use]
    pub fn workspace(&self) -> Workspace {
        let robot = self.robot.robot();
        Workspace {
            stamp: self.stamp,
            scene: self.scene.clone(),
            is_placed: false,
            links: vec![LinkFrame::EMPTY; robot.joints.len() + 1],
            poses: vec![Pose::IDENTITY; 2 * self.links.len()],
            values: [(); 3].map(|()| vec![0.0; robot.variables.len()]),
            waiting: Vec::new(),
            derivatives: vec![[0.0; 3]; robot.variables.len()],
            doubts: self.screen.as_ref().map(|screen| screen.doubts(robot.variables.len())),
        }
    }

    /// All bodies with their poses in the world at a configuration: those of the robot, in its order, then the objects.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`].
    pub fn placed(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
    ) -> Result<Vec<(BodyId, BodyTree<'static, PlanningNode>, Pose)>, PlanningError> {
        self.go_to(workspace, values)?;
        let objects = self.objects.iter().map(|(id, _)| *id);
        let mut placed = Vec::with_capacity(self.links.len() + self.objects.len());
        for id in self.links.iter().copied().chain(objects) {
            placed.push((id, workspace.scene.tree(id)?.clone(), *workspace.scene.world_pose(id)?));
        }
        Ok(placed)
    }

    /// Copies the scene if it is not the one that the workspace served last.
    pub(super) fn serve(&self, workspace: &mut Workspace) {
        if workspace.stamp != self.stamp {
            let waiting = core::mem::take(&mut workspace.waiting);
            *workspace = Workspace { waiting, ..self.workspace() };
        }
    }

    /// Places the robot.
    pub(super) fn go_to(&self, workspace: &mut Workspace, values: &[f64]) -> Result<(), PlanningError> {
        self.serve(workspace);
        let [all, ..] = &mut workspace.values;
        self.complete(values, all)?;
        self.kinematics().go_to(all, &mut workspace.links, &mut workspace.poses)?;
        workspace.scene.place_all(&self.links, &workspace.poses)?;
        workspace.is_placed = true;
        Ok(())
    }
}
