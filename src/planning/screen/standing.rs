//! Bodies that stand still, and the distance of points from them.

use super::rows::RowShape;
use crate::exact::power_of_two;
use crate::planning::PlanningNode;
use crate::pose::Pose;
use crate::primitive::shape::{Core, Shape, nearer};
use crate::query::Query;
use crate::range::Point;
use crate::scene::{Body, BodyId, BodyTree, Groups, Scene, SceneError};
use alloc::vec::Vec;

/// Radius of the probe in a grid, relative to a cell.
pub(super) const PROBE: f64 = power_of_two(-10);
/// Tolerance of distances.
const TOLERANCE: f64 = 0.005;

/// Bodies that stand still, and a small sphere that is moved about: the probe.
#[derive(Debug)]
pub(super) struct Standing {
    /// Bodies that are one bounded shape.
    shapes: Vec<WorldShape>,
    /// All other bodies.
    others: Option<OtherBodies>,
    /// Of the probe.
    radius: f64,
    /// A stack of candidates: a box of points is part of another box, whose candidates come before.
    near: Vec<u32>,
}

/// A shape at its pose in the world.
#[derive(Debug)]
struct WorldShape {
    shape: Shape,
    row: Option<RowShape>,
    /// Bound of the rounding of a point of the shape.
    error: f64,
}

#[derive(Debug)]
struct OtherBodies {
    scene: Scene<'static, PlanningNode>,
    probe: BodyId,
    query: Query,
}

/// The candidate that stands for all other bodies.
const OTHERS: u32 = u32::MAX;

/// The candidates of a box, as a range of [`Standing::near`].
#[derive(Copy, Clone, Debug)]
pub(super) struct CandidateRange {
    start: usize,
    end: usize,
}

impl Standing {
    /// `radius` is that of the probe: upper bounds are larger by it.
    pub(super) fn new(
        from: &Scene<'static, PlanningNode>,
        bodies: &[BodyId],
        radius: f64,
        query: &Query,
    ) -> Result<Self, SceneError> {
        let sphere = Shape::sphere(radius).map_err(|_| SceneError::Radius { given: radius })?;
        let (mut shapes, mut others) = (Vec::new(), None);
        for &id in bodies {
            let (body, world) = (from.body(id)?, from.world_pose(id)?);
            let shape = match from.tree(id)? {
                BodyTree::Shape(shape) if !shape.is_half_space() => shape.widened(from.radius(id)?).ok(),
                _ => None,
            };
            if let Some(shape) = shape {
                shapes.push(WorldShape::new(&shape, world));
                continue;
            }
            let others: &mut OtherBodies = match &mut others {
                Some(others) => others,
                none => {
                    let mut scene = Scene::new();
                    let probe = scene.insert(Body::new(sphere), &Pose::IDENTITY)?;
                    none.insert(OtherBodies { scene, probe, query: *query })
                }
            };
            let body = body.clone().with_groups(Groups::ALL).fixed();
            let _ = others.scene.insert(body, world)?;
        }
        Ok(Self { shapes, others, radius, near: Vec::new() })
    }

    /// All bodies.
    pub(super) fn all(&mut self) -> CandidateRange {
        self.near.clear();
        self.near.extend(0..self.shapes.len() as u32);
        self.near.extend(self.others.is_some().then_some(OTHERS));
        CandidateRange { start: 0, end: self.near.len() }
    }

    /// Bounds of the distance of a point from the candidates, and the candidates that may be nearest to some point at
    /// most `reach` from it. The lower bound is at most the cutoff. The upper bound may be infinite beyond the cutoff.
    ///
    /// At any of these points, the distance is at most `upper + reach`, and the distance of a body is at least the
    /// body's lower bound less `reach`.
    pub(super) fn distance(
        &mut self,
        p: &Point,
        cutoff: f64,
        among: CandidateRange,
        reach: f64,
    ) -> Result<([f64; 2], CandidateRange), SceneError> {
        self.near.truncate(among.end);
        let (mut lower, mut upper) = (cutoff, f64::INFINITY);
        // A little more, for roundings.
        let more = 2.001 * reach;
        for i in among.start..among.end {
            let candidate = self.near[i];
            let limit = cutoff.min(upper + more);
            let found = match (self.shapes.get(candidate as usize), &mut self.others) {
                (Some(shape), _) => shape.distance(p, self.radius, limit),
                (None, Some(others)) => others.distance(p, limit)?,
                (None, None) => None,
            };
            if let Some([least, most]) = found {
                lower = lower.min(least);
                upper = upper.min(most + self.radius);
                if least <= upper + more {
                    self.near.push(candidate);
                }
            }
        }
        Ok(([lower, upper], CandidateRange { start: among.end, end: self.near.len() }))
    }

    /// The candidates, if all are simple shapes, and a bound of the error of their distances at points so far from `p`.
    pub(super) fn simple(&self, among: CandidateRange, p: &Point, away: f64) -> Option<f64> {
        let mut error = 0.0_f64;
        for &candidate in &self.near[among.start..among.end] {
            let shape = self.shapes.get(candidate as usize)?;
            error = error.max(shape.error + shape.row.as_ref()?.error(p, away));
        }
        Some(error)
    }

    /// The distances of points `from + (0, 0, i step)` from the candidates, which are simple shapes.
    pub(super) fn row(&self, among: CandidateRange, from: &Point, step: f64, distances: &mut [f64]) {
        distances.fill(f64::INFINITY);
        let shapes = self.near[among.start..among.end].iter().map(|&i| &self.shapes[i as usize]);
        for row in shapes.filter_map(|shape| shape.row.as_ref()) {
            row.lessen(from, step, distances);
        }
    }
}

impl CandidateRange {
    pub(super) fn count(self) -> usize {
        self.end - self.start
    }
}

impl WorldShape {
    /// A coordinate of the shape in the world takes three products and three sums.
    fn new(shape: &Shape, world: &Pose) -> Self {
        let (centre, reach) = shape.ball();
        let sizes = [centre, world.translation()].into_iter().flatten().map(f64::abs);
        let (moved, error) = (shape.moved(world), (sizes.sum::<f64>() + reach) * power_of_two(-48));
        Self { shape: moved, row: RowShape::new(&moved), error }
    }

    /// Bounds of the distance of a small sphere; `None` if it is beyond the limit.
    fn distance(&self, p: &Point, radius: f64, limit: f64) -> Option<[f64; 2]> {
        let probe = Shape::unchecked(Core::Point(*p), radius);
        let found = nearer(&probe, &self.shape, limit + self.error, TOLERANCE, &mut 0)?;
        Some([(found.lower - self.error).max(0.0), found.upper + self.error])
    }
}

impl OtherBodies {
    /// As [`WorldShape::distance`].
    fn distance(&mut self, p: &Point, limit: f64) -> Result<Option<[f64; 2]>, SceneError> {
        self.scene.place(self.probe, &Pose::IDENTITY.shifted(p))?;
        let near = self.scene.clearance(&self.query, TOLERANCE, limit)?;
        Ok((near.lower < limit).then_some([near.lower, near.upper]))
    }
}
