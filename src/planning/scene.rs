//! A robot, the objects around it, and the group of joints that is planned for.

use super::PlanningNode;
use super::angles::wrapped;
use super::error::PlanningError;
use super::model::RobotModel;
use super::screen::Screen;
use crate::isa::Isa;
use crate::motion::{Base, Kinematics, MotionError};
use crate::pose::Pose;
use crate::query::Query;
use crate::scene::{BodyId, Scene, SceneError};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::sync::atomic::{AtomicU64, Ordering};

/// A robot among objects, queried by the values of its joints.
///
/// Copies share all trees. Queries take `&self` and the thread's [`Workspace`](super::Workspace).
#[derive(Clone, Debug)]
pub struct PlanningScene {
    pub(super) robot: Arc<RobotModel>,
    pub(super) scene: Scene<'static, PlanningNode>,
    /// The bodies of the robot, in its order.
    pub(super) links: Vec<BodyId>,
    pub(super) objects: Vec<(BodyId, String)>,
    /// The variables that are planned for.
    pub(super) variables: Vec<usize>,
    /// Their limits.
    limits: Vec<[f64; 2]>,
    /// Values of all variables; those of the variables that are planned for are ignored.
    pub(super) rest: Vec<f64>,
    pub(super) base: Base,
    pub(super) query: Query,
    pub(super) resolution: f64,
    /// Width of the cells of grids, if [`PlanningScene::free`] uses bounds.
    pub(super) cell: Option<f64>,
    pub(super) screen: Option<Arc<Screen>>,
    /// Two scenes with the same stamp are equal: a workspace of one serves the other.
    pub(super) stamp: u64,
}

/// A number that no other scene has.
pub(super) fn stamp() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl PlanningScene {
    /// The robot alone, with its base at the origin. All variables are planned for. Queries use the fastest instruction
    /// set of this machine.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if the fields of the description were changed to invalid values.
    pub fn new(robot: impl Into<Arc<RobotModel>>) -> Result<Self, PlanningError> {
        let robot = robot.into();
        robot.robot().kinematics()?;
        let mut scene = Scene::new();
        let bodies = robot.bodies().iter();
        let links =
            bodies.map(|body| scene.insert(body.body(), &Pose::IDENTITY)).collect::<Result<Vec<_>, _>>()?;
        for i in 0..links.len() {
            for j in i + 1..links.len() {
                if robot.pairs().contains(&(i, j)) {
                    scene.forbid_collision(links[i], links[j])?;
                } else {
                    scene.allow_collision(links[i], links[j])?;
                }
            }
        }
        let limits = robot.robot().limits.clone();
        Ok(Self {
            rest: limits.iter().map(|[low, high]| 0.0_f64.max(*low).min(*high)).collect(),
            variables: (0..limits.len()).collect(),
            limits,
            base: Base::ORIGIN,
            query: Query::new(Isa::detect()),
            resolution: 1e-6,
            cell: None,
            screen: None,
            objects: Vec::new(),
            scene,
            links,
            robot,
            stamp: stamp(),
        })
    }

    /// Sets the query: its instruction set and its budget.
    #[must_use]
    pub fn with_query(self, query: Query) -> Self {
        Self { query, stamp: stamp(), ..self }
    }

    /// Sets the resolution of motions, 1e-6 by default: the length of the shortest interval of time into which a motion
    /// is split ([`Scene::check_motion`]).
    #[must_use]
    pub fn with_resolution(self, resolution: f64) -> Self {
        Self { resolution, stamp: stamp(), ..self }
    }

    /// Plans for a group of joints of the robot's SRDF file only. All other variables keep their values in `rest`,
    /// which has one for each variable of the robot.
    ///
    /// # Errors
    /// [`PlanningError::NoGroup`]; [`PlanningError::Scene`] if a value of `rest` is outside its limits.
    pub fn select_group(&mut self, name: &str, rest: &[f64]) -> Result<(), PlanningError> {
        self.robot.robot().kinematics()?.check(rest)?;
        let group = self.robot.groups().iter().find(|group| group.name == name);
        let group = group.ok_or_else(|| PlanningError::NoGroup { name: name.into() })?;
        self.limits = group.variables.iter().map(|&variable| self.robot.robot().limits[variable]).collect();
        self.variables.clone_from(&group.variables);
        self.rest = rest.into();
        self.stamp = stamp();
        Ok(())
    }

    /// Places the robot's base in the world.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if a scene does not accept the pose.
    pub fn place_base(&mut self, world: &Pose) -> Result<(), PlanningError> {
        crate::scene::check_pose(world)?;
        self.base = (*world).into();
        self.stamp = stamp();
        self.set_screen();
        Ok(())
    }

    /// Allows two bodies to meet: no query tests the pair.
    ///
    /// # Errors
    /// [`PlanningError::Scene`]: there is no such body, or both are the same.
    pub fn allow_collision(&mut self, a: BodyId, b: BodyId) -> Result<(), PlanningError> {
        self.stamp = stamp();
        self.scene.allow_collision(a, b)?;
        self.set_screen();
        Ok(())
    }

    /// Forbids two bodies to meet: all queries test the pair.
    ///
    /// # Errors
    /// [`PlanningError::Scene`]: there is no such body, both are the same, or both are clouds.
    pub fn forbid_collision(&mut self, a: BodyId, b: BodyId) -> Result<(), PlanningError> {
        self.stamp = stamp();
        self.scene.forbid_collision(a, b)?;
        self.set_screen();
        Ok(())
    }

    /// The bodies of a link, or the one body of this name.
    pub(super) fn links_named(&self, name: &str) -> Result<Vec<BodyId>, PlanningError> {
        let names = self.robot.robot().names.iter().zip(self.robot.names());
        let is_named = |(link, body): (&String, &String)| link == name || body == name;
        let ids: Vec<_> =
            names.zip(&self.links).filter(|(names, _)| is_named(*names)).map(|(_, id)| *id).collect();
        if ids.is_empty() { Err(PlanningError::NoLink { name: name.into() }) } else { Ok(ids) }
    }

    /// The first body of a link of the robot, or the body of this name ([`RobotModel::names`]).
    ///
    /// # Errors
    /// [`PlanningError::NoLink`].
    pub fn link(&self, name: &str) -> Result<BodyId, PlanningError> {
        Ok(self.links_named(name)?[0])
    }

    /// The bodies of the robot, in its order.
    #[must_use]
    pub fn links(&self) -> &[BodyId] {
        &self.links
    }

    /// The objects, with their names, in the order of insertion.
    #[must_use]
    pub fn objects(&self) -> &[(BodyId, String)] {
        &self.objects
    }

    /// The name of a body of the robot or of an object. Empty if there is no such body.
    #[must_use]
    pub fn name(&self, id: BodyId) -> &str {
        let links = self.links.iter().zip(self.robot.names());
        let objects = self.objects.iter().map(|(object, name)| (object, name));
        links.chain(objects).find(|(body, _)| **body == id).map_or("", |(_, name)| name)
    }

    /// The robot model.
    #[must_use]
    pub fn robot(&self) -> &Arc<RobotModel> {
        &self.robot
    }

    /// The query that the scene uses.
    #[must_use]
    pub const fn query(&self) -> &Query {
        &self.query
    }

    /// The number of variables that are planned for: the length of a configuration.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.variables.len()
    }

    /// The names of the joints of the variables that are planned for.
    #[must_use]
    pub fn variable_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.variables.iter().map(|&variable| self.robot.robot().variables[variable].as_str())
    }

    /// Whether a variable, by its index among those that are planned for, belongs to a continuous joint, which rotates
    /// the shorter way around in motions. False if there is no such variable.
    #[must_use]
    pub fn is_continuous(&self, variable: usize) -> bool {
        self.variables.get(variable).is_some_and(|&variable| self.robot.robot().continuous[variable])
    }

    /// Lower and upper limits of the variables that are planned for.
    #[must_use]
    pub fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }

    pub(super) fn kinematics(&self) -> Kinematics<'_> {
        let robot = self.robot.robot();
        // `new` checked the robot, which nothing changes.
        Kinematics::checked_before(&robot.joints, &robot.bodies, &robot.limits).with_base(self.base)
    }

    /// Writes the values of all variables of the robot. Those of continuous joints may have any number of turns.
    pub(super) fn complete(&self, values: &[f64], all: &mut Vec<f64>) -> Result<(), PlanningError> {
        if values.len() != self.variables.len() {
            let error = MotionError::Length { given: values.len(), needed: self.variables.len() };
            return Err(SceneError::from(error).into());
        }
        all.clone_from(&self.rest);
        for (&variable, value) in self.variables.iter().zip(values) {
            all[variable] = match value {
                angle if self.robot.robot().continuous[variable] => wrapped(*angle),
                value => *value,
            };
        }
        Ok(())
    }
}
