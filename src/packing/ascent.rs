//! Ascends from a free point to a nearby local maximum of the clearance.
//!
//! The clearance of a point is the minimum of its distances to triangles and its gaps to spheres. Each of these is a
//! convex function, and so lies above its tangent plane. For the few obstacles that matter at a point, a quadratic
//! program gives the best step: it maximizes the minimum of the tangent planes minus the squared step over twice a
//! reach (a proximal bundle method: Kiwiel, *Methods of Descent for Nondifferentiable Optimization*, 1985). If the
//! clearance after the step is less than predicted, another obstacle came near, and is added.

use super::grid::Placed;
use super::surface::Surface;
use alloc::vec::Vec;
use glam::DVec3;

/// What limits a sphere.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Obstacle {
    Triangle(u32),
    Ball(u32),
}

/// An obstacle's distance, the direction away from it, and its weight in the quadratic program.
#[derive(Copy, Clone, Debug)]
struct Tangent {
    obstacle: Obstacle,
    distance: f64,
    away: DVec3,
    weight: f64,
}

/// All obstacles for spheres.
#[derive(Copy, Clone, Debug)]
pub(super) struct Clearance<'a> {
    pub(super) surface: &'a Surface,
    pub(super) placed: &'a Placed,
}

/// A point inside, and its nearest obstacles.
#[derive(Copy, Clone, Debug)]
pub(super) struct Spot {
    pub(super) at: DVec3,
    /// The lesser of the distances to the surface and to the placed balls.
    pub(super) clearance: f64,
    /// The distance to the surface.
    pub(super) depth: f64,
    /// The nearest triangle.
    pub(super) triangle: u32,
    /// The nearest ball, if it is nearer than the surface.
    ball: Option<u32>,
}

/// Maximum number of obstacles considered at a time.
const KNOWN: usize = 12;
/// Maximum number of steps.
const STEPS: usize = 32;
/// A relative gain below this ends the ascent.
const GAIN: f64 = 1.0 / 8192.0;

impl Clearance<'_> {
    /// The nearest obstacles of a point inside. `likely` is the triangle to try first.
    pub(super) fn spot(&self, at: DVec3, likely: u32) -> Spot {
        let (depth, triangle) = self.surface.nearest(at, likely);
        let ball = self.placed.nearest(at, depth);
        Spot { at, clearance: ball.map_or(depth, |b| b.0), depth, triangle, ball: ball.map(|b| b.1) }
    }

    /// Ascends from a spot to a local maximum of the clearance. `reach` is the initial step size.
    pub(super) fn climb(&self, start: Spot, mut reach: f64) -> Spot {
        let mut best = start;
        let mut known: Vec<Tangent> = Vec::with_capacity(KNOWN + 2);
        self.learn(&mut known, &best, best.at);
        for _ in 0..STEPS {
            let step = best_step(&mut known, reach);
            let foretold = known.iter().map(|t| t.distance + t.away.dot(step)).fold(f64::INFINITY, f64::min);
            if foretold <= best.clearance * (1.0 + GAIN) {
                break;
            }
            let next = self.spot(best.at + step, best.triangle);
            // A step shorter than one of the two distances to the surface cannot cross it.
            let length = step.length();
            let is_inside = length < best.depth.max(next.depth) || self.surface.is_inside(next.at);
            let gain = next.clearance - best.clearance;
            if is_inside && gain > 0.25 * (foretold - best.clearance) {
                best = next;
                self.learn(&mut known, &next, best.at);
                if length > 0.5 * reach {
                    reach *= 2.0;
                }
            } else if !is_inside || !self.learn(&mut known, &next, best.at) {
                reach *= 0.25;
            }
        }
        best
    }

    /// Adds the obstacles of a spot, and evaluates all known ones at `at`. Returns whether one was new.
    fn learn(&self, known: &mut Vec<Tangent>, near: &Spot, at: DVec3) -> bool {
        let count = known.len();
        let found = [Some(Obstacle::Triangle(near.triangle)), near.ball.map(Obstacle::Ball)];
        for obstacle in found.into_iter().flatten() {
            if known.iter().all(|tangent| tangent.obstacle != obstacle) {
                known.push(Tangent { obstacle, distance: 0.0, away: DVec3::ZERO, weight: 0.0 });
            }
        }
        let is_new = known.len() > count;
        for tangent in known.iter_mut() {
            let (from, radius) = match tangent.obstacle {
                Obstacle::Triangle(index) => (self.surface.closest(index, at), 0.0),
                Obstacle::Ball(index) => {
                    let ball = &self.placed.balls()[index as usize];
                    (ball.centre, ball.radius)
                }
            };
            let length = at.distance(from);
            tangent.distance = length - radius;
            tangent.away = if length > 0.0 { (at - from) / length } else { DVec3::ZERO };
        }
        while known.len() > KNOWN {
            // Drop the farthest; the first of equals, so that a new obstacle stays.
            let farthest = (0..known.len())
                .fold(0, |far, i| if known[i].distance > known[far].distance { i } else { far });
            known.remove(farthest);
        }
        is_new
    }
}

/// The step d that maximizes `min(distance + away . d) - d^2 / (2 reach)`, up to a few per cent. Solves the dual:
/// weights on a simplex, improved pairwise.
fn best_step(known: &mut [Tangent], reach: f64) -> DVec3 {
    // Start from the last weights, unless most belonged to obstacles since dropped.
    let sum: f64 = known.iter().map(|t| t.weight).sum();
    if sum > 0.5 {
        known.iter_mut().for_each(|t| t.weight /= sum);
    } else {
        known.iter_mut().for_each(|t| t.weight = 0.0);
        known[0].weight = 1.0;
    }
    let mut pull = known.iter().fold(DVec3::ZERO, |pull, t| pull + t.away * t.weight);
    for _ in 0..8 * KNOWN {
        // Shift weight from the farthest obstacle after the step to the nearest.
        let (mut near, mut far) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
        for (i, t) in known.iter().enumerate() {
            let after = t.distance + reach * t.away.dot(pull);
            if after < near.1 {
                near = (i, after);
            }
            if t.weight > 0.0 && after > far.1 {
                far = (i, after);
            }
        }
        let difference = known[near.0].away - known[far.0].away;
        let curvature = reach * difference.length_squared();
        if far.1 - near.1 <= 1e-5 * reach || curvature <= 0.0 {
            break;
        }
        let shift = ((far.1 - near.1) / curvature).min(known[far.0].weight);
        known[near.0].weight += shift;
        known[far.0].weight -= shift;
        pull += difference * shift;
    }
    pull * reach
}
