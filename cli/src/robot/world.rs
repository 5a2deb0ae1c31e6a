//! A robot among the obstacles of a problem.

use super::configurations::distance;
use super::problems::Problem;
use core::num::NonZeroU32;
use simdop::planning::{PlanSettings, PlannedPath, PlanningError, PlanningScene, RobotModel, Workspace};
use simdop::query::Query;
use simdop::scene::{Body, MotionAnswer, SceneHit};
use std::sync::Arc;

/// Samples per unit of length in joint space: as many as the planner VAMP takes.
const SAMPLES: f64 = 32.0;

pub(super) struct World {
    scene: PlanningScene,
    workspace: Workspace,
}

impl World {
    pub(super) fn new(
        model: &Arc<RobotModel>,
        problem: &Problem,
        query: Query,
    ) -> Result<Self, PlanningError> {
        let mut scene = PlanningScene::new(Arc::clone(model))?.with_query(query);
        for obstacle in &problem.obstacles {
            let _ = scene.insert(obstacle.name.as_str(), Body::new(obstacle.shape).fixed(), &obstacle.at)?;
        }
        Ok(Self { workspace: scene.workspace(), scene })
    }

    /// Two bodies that meet at these values, if any do. Places the bodies first.
    pub(super) fn hit_at(&mut self, values: &[f64]) -> Result<Option<SceneHit>, PlanningError> {
        Ok(self.scene.collide(&mut self.workspace, values)?.hit())
    }

    /// A straight motion in the joints, certified.
    pub(super) fn edge(&mut self, ends: [&[f64]; 2]) -> Result<MotionAnswer, PlanningError> {
        self.scene.check_motion(&mut self.workspace, ends)
    }

    /// The same motion at samples.
    pub(super) fn check_motion_discrete(&mut self, ends: [&[f64]; 2]) -> Result<MotionAnswer, PlanningError> {
        let parts = (SAMPLES * distance(ends[0], ends[1])).ceil() as u32;
        let parts = NonZeroU32::new(parts).unwrap_or(NonZeroU32::MIN);
        self.scene.check_motion_discrete(&mut self.workspace, ends, parts)
    }

    /// A path to one of the problem's goals.
    pub(super) fn plan(
        &mut self,
        problem: &Problem,
        settings: &PlanSettings,
    ) -> Result<PlannedPath, PlanningError> {
        let goals: Vec<&[f64]> = problem.goals.iter().map(Vec::as_slice).collect();
        self.scene.plan(&mut self.workspace, &problem.start, &goals, settings)
    }

    /// The robot's bodies first, in their order.
    pub(super) fn names(&self, hit: &SceneHit) -> [&str; 2] {
        let place = |id| self.scene.links().iter().position(|link| *link == id).unwrap_or(usize::MAX);
        let [a, b] = if place(hit.b) < place(hit.a) { [hit.b, hit.a] } else { [hit.a, hit.b] };
        [a, b].map(|id| self.scene.name(id))
    }
}
