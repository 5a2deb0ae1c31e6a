//! The lower bound of the depth: how far the union of the forbidden translations reaches in every direction.
//!
//! The sphere of directions is divided into triangles, at first the eight faces of an octahedron. Each has a *reach*:
//! all translations in its directions that are shorter are forbidden. The least reach of all is the lower bound.
//!
//! All forbidden balls are kept, as far as there is room. For a ball of radius r about c and a unit vector v with
//! `v . c >= m`,
//!
//! ```text
//! |s v - c|^2 = s^2 - 2 s v . c + c^2 <= s^2 - 2 s m + c^2,
//! ```
//!
//! which is below r^2 between the roots `m +- sqrt(m^2 - c^2 + r^2)`. If the reach is between the roots for the least m
//! of a triangle, it rises to the second one. The least product of c with the directions of a spherical triangle is at
//! a corner, if it is not negative there: the cap of directions with at least this product is then at most a
//! hemisphere, and so convex.
//!
//! A step takes the triangle with the least reach. If no ball raises it, and nothing farther is forbidden along some
//! corner or the middle, the step seeks the next ball there. If farther translations are forbidden along all four, the
//! balls overlap differently in different directions: the step divides a large triangle into four, at the middles of
//! its sides, and a small one after a ball about its middle has not helped.
//!
//! At first, balls are sought about translations [`FAR`] times as long as the reach, where one ball raises it the most.
//! The points of these balls are not widened. When such a ball does not help, the bound is final until
//! [`ForbiddenBall::seek_near`]: from then on, balls are sought at the reach itself.

use super::interval::OutOfBudget;
use super::posed_pair::{PosedPair, Seed, Shared};
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{difference, dot, length, sqrt, unit};

/// A triangle of directions.
#[derive(Copy, Clone)]
struct DirectionPart {
    reach: f64,
    /// A bit 1, the number of the face, and two bits for each level of the division.
    path: u32,
    /// Whether a ball about its middle was sought at this reach.
    is_asked: bool,
}

/// Translations nearer than the radius to the centre are forbidden.
#[derive(Copy, Clone)]
struct Neighbourhood {
    centre: Point,
    radius: f64,
    /// The distance of the centre from the origin.
    far: f64,
    /// The squared radius minus the squared distance of the centre, rounded down.
    under: f64,
    /// A point in both bodies after the translation.
    seed: Option<Seed>,
}

const MOST_PARTS: usize = 256;
const MOST_LEVELS: u32 = 8;
/// From this level on, a ball about the middle of a part is sought before the part is divided.
const ASKED_LEVEL: u32 = 2;
const MOST_STEPS: u32 = 1024;
const MOST_BALLS: usize = 64;
/// Number of points tried for each translation at the reach itself.
const POINTS: usize = 4;
/// The length of the translations of the first balls, relative to the reach.
const FAR: f64 = 2.0;
/// A gain of less than this fraction of the reach ends the search.
const GAIN: f64 = power_of_two(-7);
/// A part is not divided if its reach rises by at least this fraction of what is forbidden beyond it along the weakest
/// of its corners and its middle.
const WORTH: f64 = 0.4;
/// Number of passes over the balls to find how far their union reaches.
const PASSES: usize = 4;
/// Covers the roundings of directions, products and sums, relative to their terms.
const ROUNDING: f64 = power_of_two(-47);

pub(super) struct ForbiddenBall {
    parts: [DirectionPart; MOST_PARTS],
    len: usize,
    balls: [Neighbourhood; MOST_BALLS],
    ball_count: usize,
    steps: u32,
    /// Whether balls are sought about translations longer than the reach.
    is_far: bool,
    /// Whether no step raises the bound any more.
    pub(super) is_final: bool,
}

impl ForbiddenBall {
    /// Starts with the radius of the forbidden neighbourhood of the zero translation.
    pub(super) fn new(radius: f64, shared: Option<&Shared>) -> Self {
        let reach = f64::max(radius, 0.0);
        let first = Neighbourhood::new([0.0; 3], radius, shared);
        let mut parts = [DirectionPart { reach, path: 0, is_asked: false }; MOST_PARTS];
        for (part, path) in parts.iter_mut().zip(8..16) {
            part.path = path;
        }
        let balls = [first; MOST_BALLS];
        Self { parts, len: 8, balls, ball_count: 1, steps: 0, is_far: true, is_final: reach <= 0.0 }
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

    /// Among the directions of the part with the least reach, the one along which the least is forbidden.
    pub(super) fn weakest(&self) -> Option<Point> {
        let DirectionPart { reach, path, .. } = self.parts[self.least()];
        let directions = directions(path)?;
        Some(directions[least_of(&self.reaches(&directions, reach).1)])
    }

    /// The length up to which translations along a direction are forbidden.
    pub(super) fn along(&self, direction: &Point) -> f64 {
        let lower = self.lower();
        unit(direction).map_or(lower, |along| self.reaches(&[along; 4], lower).0)
    }

    /// Seeks balls at the reach itself from now on.
    pub(super) fn seek_near(&mut self) {
        self.is_far = false;
        self.is_final = self.lower() <= 0.0;
    }

    /// Raises the reach of the part where it is least, adds a ball there, or divides the part.
    pub(super) fn step(&mut self, bodies: &mut impl PosedPair) -> Result<(), OutOfBudget> {
        let at = self.least();
        let DirectionPart { reach, path, is_asked } = self.parts[at];
        let Some(directions) = directions(path).filter(|_| self.steps < MOST_STEPS) else {
            self.is_final = true;
            return Ok(());
        };
        bodies.spend(self.ball_count.div_ceil(16) as u64)?;
        self.steps += 1;
        let (all, rays) = self.reaches(&directions, reach);
        let (weakest, more) = (least_of(&rays), reach * (1.0 + GAIN));
        if all > more && all - reach >= WORTH * (rays[weakest] - reach) {
            (self.parts[at].reach, self.parts[at].is_asked) = (all, false);
            return Ok(());
        }
        let is_stuck = rays[weakest] <= more;
        if !is_stuck && (is_asked || path.ilog2() < 3 + 2 * ASKED_LEVEL) {
            if !self.divide(at) {
                self.is_final = all <= reach;
                self.parts[at].reach = all;
            }
            return Ok(());
        }
        // If all four reach farther, a direction between them may not.
        let along = if is_stuck { weakest } else { MIDDLE };
        let (far, points) = if self.is_far { (FAR * reach, 0) } else { (reach, POINTS) };
        let t = directions[along].map(|x| x * far);
        let (radius, shared) = bodies.forbidden(&t, self.nearest(&t), points, GAIN * reach)?;
        let ball = Neighbourhood::new(t, radius, shared.as_ref());
        self.add(ball);
        self.is_final = is_stuck && ball.reach(dot(&directions[along], &t), reach) <= more;
        self.parts[at].is_asked = !is_stuck;
        Ok(())
    }

    /// The lengths up to which translations are forbidden: in all directions between the first three, and along each of
    /// the four. Those shorter than `reach` are known to be forbidden.
    fn reaches(&self, directions: &[Point; 4], reach: f64) -> (f64, [f64; 4]) {
        let (mut all, mut rays) = (reach, [reach; 4]);
        for _ in 0..PASSES {
            let before = (all, rays);
            for ball in &self.balls[..self.ball_count] {
                let along = directions.each_ref().map(|direction| dot(direction, &ball.centre));
                let least = f64::min(f64::min(along[0], along[1]), along[2]);
                all = ball.reach(least, all);
                for (ray, along) in rays.iter_mut().zip(along) {
                    *ray = ball.reach(along, *ray);
                }
            }
            if before == (all, rays) {
                break;
            }
        }
        (all, rays)
    }

    /// The seed of the ball that contains a translation the deepest, or is nearest to containing it.
    fn nearest(&self, t: &Point) -> Option<Seed> {
        let mut nearest = (f64::NEG_INFINITY, None);
        for Neighbourhood { centre, radius, seed, .. } in &self.balls[..self.ball_count] {
            let inside = radius - length(&difference(centre, t));
            if seed.is_some() && inside > nearest.0 {
                nearest = (inside, *seed);
            }
        }
        nearest.1
    }

    /// Adds a ball. If there is no room, it replaces the smallest.
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

    /// Divides a part into four. False if there is no room.
    fn divide(&mut self, at: usize) -> bool {
        let part = self.parts[at];
        if self.len + 3 > MOST_PARTS || part.path.ilog2() >= 3 + 2 * MOST_LEVELS {
            return false;
        }
        (self.parts[at].path, self.parts[at].is_asked) = (part.path << 2, false);
        for child in 1..4 {
            self.parts[self.len] = DirectionPart { path: part.path << 2 | child, is_asked: false, ..part };
            self.len += 1;
        }
        true
    }
}

impl Neighbourhood {
    fn new(centre: Point, radius: f64, shared: Option<&Shared>) -> Self {
        let seed = shared.map(|&Shared { point, radii, .. }| Seed { point, translation: centre, radii });
        let (square, radius_square) = (dot(&centre, &centre), radius * radius);
        let under = (radius_square - square) - ROUNDING * (square + radius_square);
        Self { centre, radius, far: sqrt(square), under, seed }
    }

    /// The length up to which translations are forbidden along all directions whose product with the centre is at least
    /// `least`. Those shorter than `reach` are known to be forbidden.
    fn reach(&self, least: f64, reach: f64) -> f64 {
        let least = if least > 0.0 { least } else { -self.far } - ROUNDING * self.far;
        let (under, ahead) = (least * least + self.under, reach - least);
        if ahead * ahead >= under {
            return reach;
        }
        f64::max(reach, (least + sqrt(under)) - ROUNDING * (self.far + self.radius))
    }
}

/// The index of the middle among the [`directions`].
const MIDDLE: usize = 3;

/// The index of the least number.
fn least_of(numbers: &[f64; 4]) -> usize {
    (1..4).fold(0, |least, i| if numbers[i] < numbers[least] { i } else { least })
}

/// The corners of a part, and its middle.
fn directions(path: u32) -> Option<[Point; 4]> {
    let corners = corners(path);
    let [p, q, r] = corners;
    middle(&corners).map(|middle| [p, q, r, middle])
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

/// The middle is the same for both orders of the ends, so that neighbours have common corners.
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
    use crate::query::entry::QueryStats;
    use crate::rng::{CASES_STEP, Rng};
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
        for _ in 0..20_000 / CASES_STEP {
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

    /// No sampled translation below the reach of a part is outside all balls.
    #[test]
    fn reaches_are_inside_of_the_balls() {
        let mut rng = Rng::new(6);
        let vector = |rng: &mut Rng, size: f64| [(); 3].map(|()| rng.range(-size, size));
        let (mut raised, mut joined) = (0, 0);
        for _ in 0..4000 {
            let mut cover = ForbiddenBall::new(rng.range(0.2, 1.0), None);
            for _ in 0..rng.below(12) {
                let ball = Neighbourhood::new(vector(&mut rng, 1.5), rng.range(0.0, 1.2), None);
                cover.add(ball);
            }
            let levels = rng.below(5);
            let path = (0..levels).fold(8 + rng.below(8) as u32, |path, _| path << 2 | rng.below(4) as u32);
            let Some(directions) = directions(path) else { continue };
            let first = cover.balls[0].radius;
            let (all, rays) = cover.reaches(&directions, first);
            raised += u32::from(all > first);
            joined += u32::from(rays[MIDDLE] > first);
            let check = |u: &Point, far: f64, rng: &mut Rng| {
                let far = far * (1.0 - 1e-12) * (1.0 - rng.unit().powi(4));
                let t = u.map(|x| x * far);
                let is_in = |ball: &Neighbourhood| length(&difference(&t, &ball.centre)) < ball.radius;
                assert!(cover.balls[..cover.ball_count].iter().any(is_in), "{path:b} {t:?}");
            };
            for _ in 0..20 {
                let weights: Point = [(); 3].map(|()| rng.unit());
                let sum: Point =
                    core::array::from_fn(|i| (0..3).map(|k| weights[k] * directions[k][i]).sum());
                let Some(u) = unit(&sum) else { continue };
                check(&u, all, &mut rng);
            }
            for (u, ray) in directions.iter().zip(rays) {
                check(u, ray, &mut rng);
            }
        }
        assert!(raised > 200 && joined > 400, "{raised} {joined}");
    }

    /// All translations shorter than 1 are forbidden, but at most a ball of this radius about each is known.
    struct Forbidden(f64);

    impl PosedPair for Forbidden {
        fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget> {
            Ok(length(t) >= 1.0)
        }

        fn gap(&mut self, _: &Point, _: f64) -> Result<Option<(f64, Point)>, OutOfBudget> {
            Ok(None)
        }

        fn far(&self) -> f64 {
            2.0
        }

        fn forbidden(
            &mut self,
            t: &Point,
            _: Option<Seed>,
            _: usize,
            _: f64,
        ) -> Result<(f64, Option<Shared>), OutOfBudget> {
            Ok((f64::min(1.0 - length(t), self.0), None))
        }

        fn stats(&self) -> QueryStats {
            QueryStats::default()
        }

        fn spend(&mut self, _: u64) -> Result<(), OutOfBudget> {
            Ok(())
        }
    }

    /// The bounds before and after balls are sought near the reach. No ball contains a translation that is free.
    fn bounds(mut bodies: Forbidden) -> [f64; 2] {
        let mut cover = ForbiddenBall::new(0.3, None);
        let mut ends = [0.0; 2];
        for end in &mut ends {
            while !cover.is_final {
                assert!(cover.step(&mut bodies).is_ok());
            }
            *end = cover.lower();
            for direction in (8..16).filter_map(directions).flatten() {
                assert!(cover.along(&direction) <= 1.0, "{direction:?}");
            }
            cover.seek_near();
        }
        ends
    }

    /// The ball at twice the reach only touches the first one, and does not help. Balls at the reach do.
    #[test]
    fn balls_near_the_reach_go_on_where_far_ones_end() {
        let [far, near] = bounds(Forbidden(0.3));
        assert!((0.3..0.4).contains(&far) && 0.7 < near && near <= 1.0, "{far} {near}");
    }

    /// The ball at twice the reach overlaps the first one.
    #[test]
    fn far_balls_help() {
        let [far, near] = bounds(Forbidden(0.5));
        assert!(0.6 < far && far <= near && near <= 1.0, "{far} {near}");
    }
}
