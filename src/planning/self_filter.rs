//! Filters the points of a scan that belong to the robot.

use super::PlanningNode;
use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::node::Box3;
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::primitive::shape::Core;
use crate::query::{Query, ToleranceError};
use crate::range::MAX_COORDINATE;
use crate::scene::{Body, BodyId, Groups, Scene, SceneError};
use alloc::vec::Vec;

impl PlanningScene {
    /// Which points of the world are within `margin` of the robot in a configuration, or inside it? Remove these points
    /// from a scan before it becomes an obstacle. Attached objects count as parts of the robot. A link that is a
    /// surface has no interior ([`LinkGeometry::is_solid`](super::LinkGeometry::is_solid)).
    ///
    /// Exact up to the rounding of poses, like all verdicts of a scene. A point that is not finite, such as a pixel
    /// without a depth, is not near.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`]; the margin is negative, NaN or too large.
    pub fn near_robot(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        points: &[[f32; 3]],
        margin: f64,
    ) -> Result<Vec<bool>, PlanningError> {
        if !(0.0..=MAX_COORDINATE).contains(&margin) {
            return Err(SceneError::Tolerance(ToleranceError { given: margin }).into());
        }
        self.go_to(workspace, values)?;
        let mut filter = SelfFilter::new(&workspace.scene, &self.robot_parts(workspace)?, margin)?;
        let query = Query::new(self.query.isa());
        points.iter().map(|point| Ok(filter.is_near(&query, &point.map(f64::from))?)).collect()
    }

    /// The bodies of the robot, and the objects that are attached to it.
    fn robot_parts(&self, workspace: &Workspace) -> Result<Vec<BodyId>, SceneError> {
        let mut parts = self.links.clone();
        for &(id, _) in &self.objects {
            if workspace.scene.attached_to(id)?.is_some() {
                parts.push(id);
            }
        }
        Ok(parts)
    }
}

/// The parts of a robot at their poses, and a movable point.
struct SelfFilter {
    scene: Scene<'static, PlanningNode>,
    point: BodyId,
    parts: Vec<(BodyId, Box3)>,
    margin: f64,
    /// A point within the margin of a part is at most this far outside the part's box along each axis.
    reach: f64,
    /// The box around all parts.
    all: Box3,
}

impl SelfFilter {
    fn new(of: &Scene<'static, PlanningNode>, parts: &[BodyId], margin: f64) -> Result<Self, SceneError> {
        let mut scene = Scene::new();
        let point = Shape::new(Core::Point([0.0; 3]), 0.0).map_err(|_| SceneError::Radius { given: 0.0 })?;
        let point = scene.insert(Body::new(point), &Pose::IDENTITY)?;
        let (mut placed, mut all) = (Vec::with_capacity(parts.len()), Box3::EMPTY);
        for &id in parts {
            let body = of.body(id)?.clone().with_groups(Groups::ALL);
            let bounds = of.bounds_of(id)?;
            placed.push((scene.insert(body, of.world_pose(id)?)?, bounds));
            all.add(&bounds);
        }
        Ok(Self { scene, point, parts: placed, margin, reach: margin * (1.0 + 1e-12), all })
    }

    fn is_near(&mut self, query: &Query, p: &[f64; 3]) -> Result<bool, SceneError> {
        if !is_in(p, &self.all, self.reach) {
            return Ok(false);
        }
        let mut is_placed = false;
        for (part, bounds) in &self.parts {
            if !is_in(p, bounds, self.reach) {
                continue;
            }
            if !is_placed {
                self.scene.place(self.point, &Pose::IDENTITY.shifted(p))?;
                is_placed = true;
            }
            if self.scene.are_within(query, self.point, *part, self.margin)? {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Whether a point is in a box widened by a length. False for NaN.
fn is_in(p: &[f64; 3], of: &Box3, by: f64) -> bool {
    (0..3).all(|i| p[i] >= f64::from(of.lower[i]) - by && p[i] <= f64::from(of.upper[i]) + by)
}
