//! Objects around the robot.

use super::PlanningNode;
use super::error::PlanningError;
use super::scene::{PlanningScene, stamp};
use crate::pose::Pose;
use crate::scene::{Body, BodyId};
use alloc::string::String;
use alloc::vec::Vec;

impl PlanningScene {
    /// Adds an object, such as a shape, a shared tree, or a shared cloud. Make it [fixed](Body::fixed) unless it will
    /// be attached to the robot: two fixed bodies are not tested against each other. The bodies of the robot come
    /// before all objects ([`PlanningScene::link`]).
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if the pose or the body's radius is invalid.
    pub fn insert(
        &mut self,
        name: impl Into<String>,
        body: Body<'static, PlanningNode>,
        world: &Pose,
    ) -> Result<BodyId, PlanningError> {
        let id = self.scene.insert(body, world)?;
        self.objects.push((id, name.into()));
        self.stamp = stamp();
        self.update_screen(id, None);
        Ok(id)
    }

    /// Moves an object, and everything attached to it.
    ///
    /// # Errors
    /// [`PlanningError::IsRobot`]; [`PlanningError::Scene`] if there is no such object, it is attached, or the pose is
    /// invalid.
    pub fn place(&mut self, object: BodyId, world: &Pose) -> Result<(), PlanningError> {
        self.check_object(object)?;
        self.stamp = stamp();
        let before = self.scene.bounds_of(object)?;
        self.scene.place(object, world)?;
        self.update_screen(object, Some(before));
        Ok(())
    }

    /// Removes an object. Bodies attached to it stay where they are.
    ///
    /// # Errors
    /// [`PlanningError::IsRobot`]; [`PlanningError::Scene`] if there is no such object.
    pub fn remove(&mut self, object: BodyId) -> Result<Body<'static, PlanningNode>, PlanningError> {
        self.check_object(object)?;
        let before = self.scene.bounds_of(object)?;
        let body = self.scene.remove(object)?;
        self.objects.retain(|(id, _)| *id != object);
        self.stamp = stamp();
        self.update_screen(object, Some(before));
        Ok(body)
    }

    /// Attaches an object to a link of the robot, at their relative pose when the variables that are planned for have
    /// these values. From then on the object moves with the link, and may touch the links and bodies named in `touched`
    /// ([`RobotModel::names`](super::RobotModel::names)).
    ///
    /// # Errors
    /// [`PlanningError`]: there is no such link or object, the object is attached already or part of the robot, or a
    /// value is outside its limits.
    pub fn attach(
        &mut self,
        object: BodyId,
        link: &str,
        values: &[f64],
        touched: &[&str],
    ) -> Result<(), PlanningError> {
        self.check_object(object)?;
        let to = self.link(link)?;
        let touched =
            touched.iter().map(|name| self.links_named(name)).collect::<Result<Vec<_>, _>>()?.concat();
        let mut workspace = self.workspace();
        self.go_to(&mut workspace, values)?;
        for &id in &self.links {
            self.scene.place(id, workspace.scene.world_pose(id)?)?;
        }
        self.scene.attach(object, to)?;
        for id in touched {
            self.scene.allow_collision(object, id)?;
        }
        self.stamp = stamp();
        self.set_screen();
        Ok(())
    }

    /// Detaches an object from the robot and places it at `world`. From then on it is tested against all links again.
    ///
    /// # Errors
    /// As [`PlanningScene::place`].
    pub fn detach(&mut self, object: BodyId, world: &Pose) -> Result<(), PlanningError> {
        self.check_object(object)?;
        // Checked first, so that an error detaches nothing.
        crate::scene::check_pose(world)?;
        self.scene.detach(object)?;
        self.stamp = stamp();
        self.scene.place(object, world)?;
        for &link in &self.links {
            self.scene.forbid_collision(object, link)?;
        }
        self.set_screen();
        Ok(())
    }

    fn check_object(&self, object: BodyId) -> Result<(), PlanningError> {
        match self.links.iter().position(|link| *link == object) {
            Some(body) => Err(PlanningError::IsRobot { name: self.robot.names()[body].clone() }),
            None => Ok(()),
        }
    }
}
