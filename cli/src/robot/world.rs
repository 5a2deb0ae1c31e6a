//! A robot among the obstacles of a problem.

use super::model::Model;
use super::problems::Problem;
use crate::random::distance;
use core::num::NonZeroU32;
use simdop::motion::{JointMotion, Kinematics, LinkFrame};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{Body, BodyId, MotionAnswer, MotionHit, MotionMemory, Scene, SceneError, SceneHit};

/// Samples per unit of length in the joints: as many as the planner VAMP takes.
const SAMPLES: f64 = 32.0;
/// Intervals of a motion's time shorter than this are not split.
const SHORTEST: f64 = 1e-6;
/// Pending pairs of bodies in intervals: more than motions of seven joints among a dozen boxes need.
const WAITING: usize = 8192;

pub(super) struct World<'t> {
    scene: Scene<'t, Node16<18>>,
    ids: Vec<BodyId>,
    obstacles: Vec<(BodyId, &'t str)>,
    model: &'t Model,
    robot: Kinematics<'t>,
    query: Query,
    values: Vec<f64>,
    links: Vec<LinkFrame>,
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
}

impl<'t> World<'t> {
    pub(super) fn new(model: &'t Model, problem: &'t Problem, query: Query) -> Result<Self, SceneError> {
        let (mut scene, ids) = model.scene()?;
        let robot = model.robot.kinematics()?;
        let mut obstacles = Vec::new();
        for obstacle in &problem.obstacles {
            let id = scene.insert(Body::new(obstacle.shape).fixed(), &obstacle.at)?;
            obstacles.push((id, obstacle.name.as_str()));
        }
        Ok(Self {
            scene,
            obstacles,
            model,
            robot,
            query,
            values: vec![0.0; robot.limits().len()],
            links: vec![LinkFrame::EMPTY; robot.links()],
            poses: vec![Pose::IDENTITY; 2 * ids.len()],
            waiting: vec![MotionHit::EMPTY; WAITING],
            ids,
        })
    }

    /// Two bodies that meet at these values, if any do. Includes placing them.
    pub(super) fn hit_at(&mut self, values: &[f64]) -> Result<Option<SceneHit>, SceneError> {
        self.robot.go_to(values, &mut self.links, &mut self.poses)?;
        for (&id, pose) in self.ids.iter().zip(&self.poses) {
            self.scene.place(id, pose)?;
        }
        Ok(self.scene.collide(&self.query)?.hit())
    }

    /// A straight motion in the joints, certified.
    pub(super) fn edge(&mut self, ends: [&[f64]; 2]) -> Result<MotionAnswer, SceneError> {
        let mut motion = JointMotion::new(self.robot, ends, &mut self.values, &mut self.links)?;
        let mut memory = MotionMemory { poses: &mut self.poses, waiting: &mut self.waiting };
        self.scene.check_motion(&self.query, &self.ids, &mut motion, SHORTEST, &mut memory)
    }

    /// The same motion at samples.
    pub(super) fn check_motion_discrete(&mut self, ends: [&[f64]; 2]) -> Result<MotionAnswer, SceneError> {
        let parts = (SAMPLES * distance(ends[0], ends[1])).ceil() as u32;
        let parts = NonZeroU32::new(parts).unwrap_or(NonZeroU32::MIN);
        let mut motion = JointMotion::new(self.robot, ends, &mut self.values, &mut self.links)?;
        let mut memory = MotionMemory { poses: &mut self.poses, waiting: &mut self.waiting };
        self.scene.check_motion_discrete(&self.query, &self.ids, &mut motion, parts, &mut memory)
    }

    /// The robot's bodies first, in their order.
    pub(super) fn names(&self, hit: &SceneHit) -> [&str; 2] {
        let place = |id: BodyId| self.ids.iter().position(|body| *body == id).unwrap_or(usize::MAX);
        let [a, b] = if place(hit.b) < place(hit.a) { [hit.b, hit.a] } else { [hit.a, hit.b] };
        [a, b].map(|id| match self.model.names.get(place(id)) {
            Some(name) => name.as_str(),
            None => self.obstacles.iter().find(|(body, _)| *body == id).map_or("", |(_, name)| name),
        })
    }
}
