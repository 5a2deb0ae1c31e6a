//! Bodies that stand still, and the distance of a point from them.

use crate::exact::power_of_two;
use crate::planning::PlanningNode;
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::query::Query;
use crate::range::Point;
use crate::scene::{Body, BodyId, Groups, Scene, SceneError};

/// Radius of the probe in a grid, relative to a cell.
pub(super) const PROBE: f64 = power_of_two(-10);
/// Tolerance of distances.
const TOLERANCE: f64 = 0.005;

/// Bodies that stand still, and a small sphere that is moved about.
#[derive(Debug)]
pub(super) struct Standing {
    scene: Scene<'static, PlanningNode>,
    probe: BodyId,
    radius: f64,
    query: Query,
}

impl Standing {
    /// `radius` is that of the probe: upper bounds are larger by it.
    pub(super) fn new(
        from: &Scene<'static, PlanningNode>,
        bodies: &[BodyId],
        radius: f64,
        query: &Query,
    ) -> Result<Self, SceneError> {
        let mut scene = Scene::new();
        let sphere = Shape::sphere(radius).map_err(|_| SceneError::Radius { given: radius })?;
        let probe = scene.insert(Body::new(sphere), &Pose::IDENTITY)?;
        for &id in bodies {
            let body = from.body(id)?.clone().with_groups(Groups::ALL).fixed();
            let _ = scene.insert(body, from.world_pose(id)?)?;
        }
        Ok(Self { scene, probe, radius, query: *query })
    }

    /// Bounds of the distance of a point. The lower one is at most the cutoff, and the upper one may be infinite beyond
    /// it.
    pub(super) fn distance(&mut self, p: &Point, cutoff: f64) -> Result<[f64; 2], SceneError> {
        self.scene.place(self.probe, &Pose::IDENTITY.shifted(p))?;
        let near = self.scene.clearance(&self.query, TOLERANCE, cutoff)?;
        Ok([near.lower, near.upper + self.radius])
    }
}
