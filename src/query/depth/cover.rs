//! The lower bound of the depth: how far the union of the forbidden translations reaches in every direction.
//!
//! The sphere of directions is divided into triangles, at first the eight faces of an octahedron. Each has a *reach*:
//! all translations in its directions that are shorter are forbidden. The least reach of all is the lower bound. A step
//! takes the triangle with the least reach s, and asks for the forbidden neighbourhood of the translation `x = s u`
//! along its middle u. If its radius is f, and no direction v of the triangle is farther than d from u, then
//!
//! ```text
//! |s' v - s u| <= (s' - s) + s |v - u| <= (s' - s) + s d  for s' >= s
//! ```
//!
//! is below f for all s' below `s + f - s d`, the new reach. If much of f is lost to the width of the triangle, it is
//! divided into four, at the middles of its sides. The three corners of a spherical triangle are the points of it that
//! are farthest from its middle, as a cap that is smaller than half of the sphere is convex.

use super::interval::OutOfBudget;
use super::posed_pair::{Effort, PosedPair, Seed};
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{difference, dot, length, unit};

/// A triangle of directions.
#[derive(Copy, Clone)]
struct DirectionPart {
    reach: f64,
    /// A one, the number of the face, and two bits for each level of the division.
    path: u32,
}

/// Translations nearer than the radius to the centre are forbidden.
#[derive(Copy, Clone)]
struct Neighbourhood {
    centre: Point,
    radius: f64,
    /// A point that was in both bodies after the translation, in A's frame.
    point: Option<Point>,
}

const MOST_PARTS: usize = 256;
const MOST_LEVELS: u32 = 8;
const MOST_STEPS: u32 = 2048;
const MOST_BALLS: usize = 96;
/// Points that are tried for each translation.
const POINTS: usize = 4;
/// A gain of less than this fraction of the reach ends the search.
const GAIN: f64 = power_of_two(-8);
/// A part is not divided if at least this share of the way along its middle is forbidden in all of its directions.
const WORTH: f64 = 0.4;
/// How often the balls are gone through for the way through their union.
const PASSES: usize = 4;
/// Covers the roundings of directions, products and sums, relative to their terms.
const ROUNDING: f64 = power_of_two(-47);

pub(super) struct ForbiddenBall {
    parts: [DirectionPart; MOST_PARTS],
    len: usize,
    balls: [Neighbourhood; MOST_BALLS],
    ball_count: usize,
    steps: u32,
    /// Whether no step raises the bound any more.
    pub(super) is_final: bool,
}

impl ForbiddenBall {
    /// From the radius of the forbidden neighbourhood of no translation.
    pub(super) fn new(radius: f64, point: Option<Point>) -> Self {
        let reach = f64::max(radius, 0.0);
        let first = Neighbourhood { centre: [0.0; 3], radius, point };
        let mut parts = [DirectionPart { reach, path: 0 }; MOST_PARTS];
        for (part, path) in parts.iter_mut().zip(8..16) {
            part.path = path;
        }
        let balls = [first; MOST_BALLS];
        Self { parts, len: 8, balls, ball_count: 1, steps: 0, is_final: reach <= 0.0 }
    }

    fn least(&self) -> usize {
        let before = |i: usize, j: usize| {
            let key = |part: &DirectionPart| (part.reach, part.path);
            if key(&self.parts[j]) < key(&self.parts[i]) { j } else { i }
        };
        (1..self.len).fold(0, before)
    }

    /// All shorter translations are forbidden.
    pub(super) fn lower(&self) -> f64 {
        self.parts[self.least()].reach
    }

    /// The middle of the directions of least reach.
    pub(super) fn weakest(&self) -> Option<Point> {
        middle(&corners(self.parts[self.least()].path))
    }

    /// How far a direction is forbidden.
    pub(super) fn along(&self, direction: &Point) -> f64 {
        let lower = self.lower();
        unit(direction).map_or(lower, |along| self.exit(&[along], lower))
    }

    /// Raises the reach of the part where it is least, or divides that part. Without budget, nothing changes.
    pub(super) fn step(&mut self, bodies: &mut impl PosedPair) -> Result<(), OutOfBudget> {
        let at = self.least();
        let DirectionPart { reach, path } = self.parts[at];
        let corners = corners(path);
        let Some(along) = middle(&corners).filter(|_| self.steps < MOST_STEPS) else {
            self.is_final = true;
            return Ok(());
        };
        let (all, ray) = (self.exit(&corners, reach), self.exit(&[along], reach));
        if ray > reach * (1.0 + GAIN) {
            self.steps += 1;
            if all - reach >= WORTH * (ray - reach) || !self.divide(at) {
                self.is_final = all <= reach;
                self.parts[at].reach = all;
            }
            return Ok(());
        }
        let t = along.map(|x| x * reach);
        for effort in [Effort::Near, Effort::Wide] {
            let (radius, shared) = bodies.forbidden(&t, self.nearest(&t), POINTS, effort)?;
            self.add(Neighbourhood { centre: t, radius, point: shared.map(|shared| shared.point) });
            if radius > GAIN * reach {
                self.steps += 1;
                return Ok(());
            }
        }
        self.is_final = true;
        Ok(())
    }

    /// How far all translations in the directions between the corners are forbidden, given that those shorter than
    /// `reach` are.
    fn exit(&self, corners: &[Point], mut reach: f64) -> f64 {
        for _ in 0..PASSES {
            let before = reach;
            for ball in &self.balls[..self.ball_count] {
                reach = f64::max(reach, ball.exit(corners, reach));
            }
            if reach <= before {
                break;
            }
        }
        reach
    }

    /// The point of the ball that is the nearest to contain a translation.
    fn nearest(&self, t: &Point) -> Option<Seed> {
        let mut nearest = (f64::NEG_INFINITY, None);
        for Neighbourhood { centre, radius, point } in &self.balls[..self.ball_count] {
            let inside = radius - length(&difference(centre, t));
            if let Some(point) = *point
                && inside > nearest.0
            {
                nearest = (inside, Some(Seed { point, translation: *centre }));
            }
        }
        nearest.1
    }

    /// Of too many balls, the smallest is dropped.
    fn add(&mut self, ball: Neighbourhood) {
        if ball.radius <= 0.0 {
            return;
        }
        let at = if self.ball_count < MOST_BALLS {
            self.ball_count += 1;
            self.ball_count - 1
        } else {
            let smaller =
                |i: usize, j: usize| if self.balls[j].radius < self.balls[i].radius { j } else { i };
            (1..MOST_BALLS).fold(0, smaller)
        };
        self.balls[at] = ball;
    }

    /// Whether there is room for that.
    fn divide(&mut self, at: usize) -> bool {
        let part = self.parts[at];
        if self.len + 3 > MOST_PARTS || part.path.ilog2() >= 3 + 2 * MOST_LEVELS {
            return false;
        }
        self.parts[at].path = part.path << 2;
        for child in 1..4 {
            self.parts[self.len] = DirectionPart { path: part.path << 2 | child, ..part };
            self.len += 1;
        }
        true
    }
}

impl Neighbourhood {
    /// How far the ball forbids all translations in the directions between the corners, if it forbids those that are as
    /// long as `reach`; else 0.
    fn exit(&self, corners: &[Point], reach: f64) -> f64 {
        let square = dot(&self.centre, &self.centre);
        let far = libm::sqrt(square);
        let least = corners.iter().fold(far, |least, corner| f64::min(least, dot(corner, &self.centre)));
        let least = if least > 0.0 { least } else { -far } - ROUNDING * far;
        let radius_square = self.radius * self.radius;
        let under = (least * least - square) + radius_square - ROUNDING * (square + radius_square);
        if under <= 0.0 {
            return 0.0;
        }
        let (half, slack) = (libm::sqrt(under), ROUNDING * (far + self.radius));
        if (least - half) + slack < reach { (least + half) - slack } else { 0.0 }
    }
}

/// The corners of a part.
fn corners(path: u32) -> [Point; 3] {
    let levels = (path.ilog2() - 3) / 2;
    let face = path >> (2 * levels);
    let axis = |i: usize| {
        let mut axis = [0.0; 3];
        axis[i] = if face >> i & 1 == 0 { 1.0 } else { -1.0 };
        axis
    };
    let mut corners = [axis(0), axis(1), axis(2)];
    for level in (0..levels).rev() {
        let [p, q, r] = corners;
        let [a, b, c] = [halfway(&q, &r), halfway(&r, &p), halfway(&p, &q)];
        corners = match path >> (2 * level) & 3 {
            0 => [a, b, c],
            1 => [p, c, b],
            2 => [c, q, a],
            _ => [b, a, r],
        };
    }
    corners
}

/// The same for both orders of the ends, so that neighbours have common corners.
fn halfway(p: &Point, q: &Point) -> Point {
    let sum = core::array::from_fn(|i| p[i] + q[i]);
    unit(&sum).unwrap_or(sum)
}

fn middle([p, q, r]: &[Point; 3]) -> Option<Point> {
    unit(&core::array::from_fn(|i| (p[i] + q[i]) + r[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::vector::{cross, dot};
    use alloc::vec;
    use alloc::vec::Vec;

    /// Every direction is in some part of a divided sphere, and no farther from its middle than a corner.
    #[test]
    fn parts_cover_all_directions() {
        let mut rng = Rng::new(5);
        let mut paths: Vec<u32> = (8..16).collect();
        for _ in 0..60 {
            let at = rng.below(paths.len() as u64) as usize;
            let path = paths.swap_remove(at);
            paths.extend((0..4).map(|child| path << 2 | child));
        }
        let mut inside = vec![0; paths.len()];
        for _ in 0..20_000 {
            let Some(u) = unit(&[(); 3].map(|()| rng.range(-1.0, 1.0))) else { continue };
            let mut found = false;
            for (path, count) in paths.iter().zip(&mut inside) {
                let [p, q, r] = corners(*path);
                let sides = [(&p, &q), (&q, &r), (&r, &p)].map(|(p, q)| dot(&cross(p, q), &u));
                let near = dot(&u, &p) > 0.0 || dot(&u, &q) > 0.0;
                let is_in = near && (sides.iter().all(|x| *x >= 0.0) || sides.iter().all(|x| *x <= 0.0));
                if is_in {
                    let middle = middle(&[p, q, r]).unwrap_or_default();
                    let width =
                        [p, q, r].map(|p| length(&difference(&p, &middle))).into_iter().fold(0.0, f64::max);
                    assert!(length(&difference(&u, &middle)) <= width + ROUNDING, "{path:b}");
                    *count += 1;
                    found = true;
                }
            }
            assert!(found, "{u:?}");
        }
        assert!(inside.iter().filter(|count| **count > 0).count() > paths.len() / 2);
    }
}
