//! The smallest ball around some balls.
//!
//! The smallest ball is determined by at most four of the balls, which touch it from within: its basis. Starting with
//! one ball, the ball that reaches farthest beyond the current ball joins the basis, and those that the new ball does
//! not touch leave it, until no ball reaches beyond. The radius grows with each step. This is the scheme of Fischer and
//! Gärtner, *The smallest enclosing ball of balls*, 2004, with the farthest ball as pivot. A basis of four and one more
//! ball have few enough subsets to try all. (Welzl's move-to-front is wrong for balls.)

use crate::primitive::Sphere;
use crate::range::Point;
use crate::vector::sqrt;
use glam::DVec3;

/// Balls that reach beyond by less than this share of the radius count as inside.
const TOLERANCE: f64 = 1e-9;

/// Limit of the number of steps. Any set needs a few dozen.
const MAX_STEPS: usize = 1000;

/// The centre, up to rounding. The coordinates of the balls are those of a frame: neither very large nor very small.
///
/// # Panics
/// If there is no ball.
pub(in crate::construct) fn smallest_enclosing(balls: &[Sphere]) -> Point {
    let balls_at = |index: usize| Candidate {
        centre: DVec3::from_array(balls[index].centre),
        radius: balls[index].radius,
    };
    let mut found = balls_at(0);
    let mut basis = Basis { balls: [found; 5], len: 1 };
    for _ in 0..MAX_STEPS {
        let Some(farthest) = farthest_out(balls, &found) else { break };
        basis.push(balls_at(farthest));
        // Because of rounding, no subset may have a ball that contains all others. The last ball is then nearly the
        // smallest.
        let Some(better) = basis.reduce() else { break };
        if better.radius <= found.radius {
            break;
        }
        found = better;
    }
    found.centre.to_array()
}

/// The ball that reaches farthest beyond `found`, if any does.
fn farthest_out(balls: &[Sphere], found: &Candidate) -> Option<usize> {
    let mut limit = found.radius * (1.0 + TOLERANCE);
    let mut farthest = None;
    for (index, ball) in balls.iter().enumerate() {
        let square = DVec3::from_array(ball.centre).distance_squared(found.centre);
        let room = limit - ball.radius;
        // Nearly all are inside, and need no square root.
        if room < 0.0 || square > room * room {
            let reach = sqrt(square) + ball.radius;
            if reach > limit {
                (limit, farthest) = (reach, Some(index));
            }
        }
    }
    farthest
}

#[derive(Copy, Clone, Debug)]
struct Candidate {
    centre: DVec3,
    radius: f64,
}

impl Candidate {
    fn holds(&self, other: &Self) -> bool {
        self.centre.distance(other.centre) + other.radius <= self.radius * (1.0 + 0.5 * TOLERANCE)
    }
}

/// Balls that touch, or may touch, the smallest ball around them.
struct Basis {
    balls: [Candidate; 5],
    len: usize,
}

impl Basis {
    fn push(&mut self, ball: Candidate) {
        self.balls[self.len] = ball;
        self.len += 1;
    }

    /// The smallest ball around all of them, which touches the last one. Only the balls that determine it stay in the
    /// basis.
    fn reduce(&mut self) -> Option<Candidate> {
        let last = 1_u32 << (self.len - 1);
        let mut smallest: Option<(Candidate, u32)> = None;
        for subset in last..2 * last {
            if subset.count_ones() > 4 {
                continue;
            }
            let (members, len) = self.members(subset);
            let found = around_touching(&members[..len]);
            for ball in found.into_iter().flatten() {
                let is_smaller = smallest.is_none_or(|(best, _)| ball.radius < best.radius);
                if is_smaller && self.balls[..self.len].iter().all(|other| ball.holds(other)) {
                    smallest = Some((ball, subset));
                }
            }
        }
        let (ball, subset) = smallest?;
        let (members, len) = self.members(subset);
        (self.balls, self.len) = (members, len);
        Some(ball)
    }

    fn members(&self, subset: u32) -> ([Candidate; 5], usize) {
        let (mut members, mut len) = (self.balls, 0);
        for i in (0..self.len).filter(|i| subset >> i & 1 != 0) {
            members[len] = self.balls[i];
            len += 1;
        }
        (members, len)
    }
}

/// The balls, at most two, that one to four balls touch from within, with the centre in the affine hull of their
/// centres.
///
/// With the first centre as origin, another centre q, and the radius R sought, `|x| = R - r_0` and `|x - q| = R - r`
/// give `q . x = (q . q + r_0^2 - r^2) / 2 + (r - r_0) R`. This is linear, so x = u + R v, and `|x| = R - r_0` is a
/// quadratic equation for R.
fn around_touching(balls: &[Candidate]) -> [Option<Candidate>; 2] {
    let first = balls[0];
    let mut rows = [Row::default(); 3];
    let others = &balls[1..];
    for (row, ball) in rows.iter_mut().zip(others) {
        let q = ball.centre - first.centre;
        for (product, other) in row.products.iter_mut().zip(others) {
            *product = q.dot(other.centre - first.centre);
        }
        row.constant =
            0.5 * (q.length_squared() + (first.radius - ball.radius) * (first.radius + ball.radius));
        row.slope = ball.radius - first.radius;
    }
    let Some(weights) = solve(&mut rows[..others.len()]) else { return [None; 2] };
    let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
    for ((of_u, of_v), ball) in weights.into_iter().zip(others) {
        let q = ball.centre - first.centre;
        u += of_u * q;
        v += of_v * q;
    }
    let (a, b, c) =
        (v.length_squared() - 1.0, u.dot(v) + first.radius, u.length_squared() - first.radius * first.radius);
    let ball = |radius: f64| {
        let is_number = radius.is_finite() && radius >= 0.0;
        is_number.then(|| Candidate { centre: first.centre + u + radius * v, radius })
    };
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return [None; 2];
    }
    // Avoids cancellation: one root from the sum of terms of equal sign, the other from the product of the roots.
    let sum = -(b + libm::copysign(sqrt(discriminant), b));
    [ball(sum / a), ball(c / sum)]
}

/// A linear equation for up to three unknown weights: coefficients and two right-hand sides.
#[derive(Copy, Clone, Default)]
struct Row {
    products: [f64; 3],
    constant: f64,
    slope: f64,
}

/// The weights for both right-hand sides, by Gaussian elimination; `None` if the centres are affinely dependent.
fn solve(rows: &mut [Row]) -> Option<[(f64, f64); 3]> {
    let n = rows.len();
    let scale = rows.iter().flat_map(|row| row.products).fold(0.0, |m: f64, x| m.max(x.abs()));
    for i in 0..n {
        let pivot =
            (i..n).max_by(|&p, &q| rows[p].products[i].abs().total_cmp(&rows[q].products[i].abs()))?;
        rows.swap(i, pivot);
        if rows[i].products[i].abs() <= 1e-14 * scale {
            return None;
        }
        let above = rows[i];
        for row in &mut rows[i + 1..] {
            let factor = row.products[i] / above.products[i];
            for (x, y) in row.products.iter_mut().zip(above.products) {
                *x -= factor * y;
            }
            row.constant -= factor * above.constant;
            row.slope -= factor * above.slope;
        }
    }
    let mut weights = [(0.0, 0.0); 3];
    for i in (0..n).rev() {
        let row = &rows[i];
        let known = (i + 1..n).fold((0.0, 0.0), |(c, s), j| {
            (c + row.products[j] * weights[j].0, s + row.products[j] * weights[j].1)
        });
        let pivot = row.products[i];
        weights[i] = ((row.constant - known.0) / pivot, (row.slope - known.1) / pivot);
    }
    Some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{CASES_STEP, Rng};
    use alloc::vec::Vec;

    fn point(rng: &mut Rng) -> Point {
        [(); 3].map(|()| rng.range(-100.0, 100.0))
    }

    /// How far balls reach from a point.
    fn reach(balls: &[Sphere], p: Point) -> f64 {
        let reach =
            |ball: &Sphere| DVec3::from_array(ball.centre).distance(DVec3::from_array(p)) + ball.radius;
        balls.iter().map(reach).fold(0.0, f64::max)
    }

    /// The least reach from any point: a convex function, minimised by a nested ternary search.
    fn least_reach(balls: &[Sphere]) -> f64 {
        fn along(axis: usize, p: Point, balls: &[Sphere]) -> f64 {
            if axis == 3 {
                return reach(balls, p);
            }
            let at = |x: f64| {
                let mut p = p;
                p[axis] = x;
                along(axis + 1, p, balls)
            };
            let ends = |end: fn(f64, f64) -> f64| balls.iter().map(|ball| ball.centre[axis]).reduce(end);
            let (Some(mut low), Some(mut high)) = (ends(f64::min), ends(f64::max)) else { return 0.0 };
            while high - low > 1e-4 * (high.abs() + low.abs() + 1e-9) {
                let third = (high - low) / 3.0;
                if at(low + third) <= at(high - third) { high -= third } else { low += third }
            }
            at(0.5 * (low + high))
        }
        along(0, [0.0; 3], balls)
    }

    /// Up to nine balls, of one of several hard kinds.
    fn hard_set(rng: &mut Rng) -> Vec<Sphere> {
        let kind = rng.below(8);
        let first = Sphere { centre: point(rng), radius: 20.0 * rng.unit() };
        let [q, r] = [point(rng), point(rng)];
        let count = 1 + rng.below(9) as usize;
        let along = |t: f64, u: f64| core::array::from_fn(|i| first.centre[i] + t * q[i] + u * r[i]);
        let mut next = |i: usize| match kind {
            // Balls of very different sizes.
            0 => Sphere { centre: point(rng), radius: 100.0 * 1e-6_f64.powf(rng.unit()) },
            // Points.
            1 => Sphere { centre: point(rng), radius: 0.0 },
            // Nested, and touching from within.
            2 => {
                let share = rng.unit();
                let d = DVec3::from_array(point(rng)).normalize_or_zero();
                let centre = DVec3::from_array(first.centre) + share * first.radius * d;
                Sphere { centre: centre.to_array(), radius: first.radius * (1.0 - share) }
            }
            // Equal.
            3 => first,
            // Collinear, of equal or different sizes.
            4 => Sphere { centre: along(rng.unit(), 0.0), radius: first.radius },
            5 => Sphere { centre: along(rng.unit(), 0.0), radius: 20.0 * rng.unit() },
            // Coplanar.
            6 => Sphere { centre: along(rng.unit(), rng.unit()), radius: 5.0 * rng.unit() },
            // The corners of a cube, whose ball touches all.
            _ => Sphere {
                centre: core::array::from_fn(|axis| if i >> axis & 1 == 0 { -50.0 } else { 50.0 }),
                radius: first.radius,
            },
        };
        (0..count).map(&mut next).collect()
    }

    #[test]
    fn balls_are_the_smallest() {
        let rng = &mut Rng::new(1);
        for _ in 0..100 / CASES_STEP {
            let balls = hard_set(rng);
            let (got, want) = (reach(&balls, smallest_enclosing(&balls)), least_reach(&balls));
            assert!(got <= want * 1.0001, "{got} is not {want}: {balls:?}");
        }
    }

    /// No point near the centre has a smaller reach, for many sets and for large ones. The function is convex, so the
    /// minimum is global, up to the sampled directions.
    #[test]
    fn no_step_makes_it_smaller() {
        let rng = &mut Rng::new(2);
        let mut worst = 0.0;
        for round in 0..20_000 {
            let balls = if round % 100 == 0 {
                (0..2000).map(|_| Sphere { centre: point(rng), radius: 30.0 * rng.unit().powi(8) }).collect()
            } else {
                hard_set(rng)
            };
            let centre = smallest_enclosing(&balls);
            let radius = reach(&balls, centre);
            for _ in 0..10 {
                let d = DVec3::from_array(point(rng)).normalize_or_zero();
                let step = radius * 0.1_f64.powf(6.0 * rng.unit());
                let other = (DVec3::from_array(centre) + step * d).to_array();
                let other = reach(&balls, other);
                worst = f64::max(worst, 1.0 - other / radius);
            }
        }
        assert!(worst < 1e-6, "{worst:e}");
    }
}
