//! Newton's method for the closest points of two cores, by their coordinates.
//!
//! The squared distance is minimised over the coordinates that the boundaries do not bar (projected Newton: Bertsekas
//! 1982). For polytopes it is quadratic, so one step solves it once the right coordinates are free. Near the solution the
//! distance itself is minimised, whose second derivative does not vanish where shapes touch: so convergence on rims is
//! quadratic too. Nothing here is certified.

use super::Point;
use super::place::{Place, Ways};
use super::support::Pair;
use crate::vector::{cross, dot};

/// The most steps.
const STEPS: usize = 12;

/// A step of less, in units of half edges and radii, is the last: the next one would be below rounding.
const LAST: f64 = 1.0 / (1_u64 << 40) as f64;

/// The squared cosine of the ways and the vector between the points near the solution.
const NEAR: f64 = 1e-2;

/// Two places.
#[derive(Copy, Clone, Debug)]
pub(super) struct Places {
    pub(super) a: Place,
    pub(super) b: Place,
}

/// Two points.
#[derive(Copy, Clone, Debug)]
pub(super) struct Found {
    /// From B to A.
    pub(super) between: Point,
    /// From A's centre.
    pub(super) of_a: Point,
    /// Perpendicular to all ways in which the points may move.
    pub(super) direction: Point,
}

impl Places {
    /// A's point nearest to B's centre, and the one of B nearest to it.
    #[inline(always)]
    pub(super) fn guess(pair: &Pair) -> Self {
        let a = pair.a.form.nearest(&pair.between.map(|x| -x));
        let of_a = pair.a.form.at(&a);
        let b = pair.b.form.nearest(&[0, 1, 2].map(|k| pair.between[k] + of_a[k]));
        Self { a, b }
    }

    /// The places nearest to a point of A and one at `between` from it.
    #[inline(always)]
    pub(super) fn near(pair: &Pair, of_a: &Point, between: &Point) -> Self {
        let of_b: Point = [0, 1, 2].map(|k| pair.between[k] + of_a[k] - between[k]);
        Self { a: pair.a.form.nearest(of_a), b: pair.b.form.nearest(&of_b) }
    }

    #[inline(always)]
    fn points(&self, pair: &Pair) -> (Point, Point) {
        let (a, b) = (pair.a.form.at(&self.a), pair.b.form.at(&self.b));
        (a, [0, 1, 2].map(|k| pair.between[k] + (a[k] - b[k])))
    }

    /// The places as they are.
    #[inline(always)]
    pub(super) fn found(&self, pair: &Pair) -> Found {
        let (of_a, between) = self.points(pair);
        let (ways, _) = self.ways(pair, &between);
        Found { between, of_a, direction: perpendicular(&ways, &between) }
    }

    /// A point of both cores, from A's centre, if they certainly meet because one of the two places is so far inside of
    /// its core that a ball about it has the other one.
    pub(super) fn common(&self, pair: &Pair, found: &Found) -> Option<Point> {
        let v = &found.between;
        let apart = libm::sqrt(dot(v, v)) + pair.slack;
        if pair.b.form.room(&self.b) > apart {
            Some(found.of_a)
        } else if pair.a.form.room(&self.a) > apart {
            Some([0, 1, 2].map(|k| found.of_a[k] - v[k]))
        } else {
            None
        }
    }

    /// The ways of both, those of B negated, and the number of those of A.
    #[inline(always)]
    fn ways(&self, pair: &Pair, between: &Point) -> (Ways, usize) {
        let mut ways = Ways::new();
        pair.a.form.ways(&self.a, between, &mut ways);
        let of_a = ways.len;
        pair.b.form.ways(&self.b, &between.map(|x| -x), &mut ways);
        for way in &mut ways.list[of_a..ways.len] {
            way.tangent = way.tangent.map(|x| -x);
            way.bend = way.bend.map(|x| -x);
            way.mixed = way.mixed.map(|x| -x);
        }
        (ways, of_a)
    }

    /// Moves to the closest points.
    pub(super) fn refine(&mut self, pair: &Pair) -> Found {
        let (mut of_a, mut between) = self.points(pair);
        let (mut ways, mut count) = self.ways(pair, &between);
        for _ in 0..STEPS {
            let step = solve(&ways, &between);
            let size = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let mut next = *self;
            let mut share = 1.0;
            let square = dot(&between, &between);
            let mut is_better = false;
            for _ in 0..4 {
                next = *self;
                for i in 0..ways.len {
                    let place = if i < count { &mut next.a } else { &mut next.b };
                    place.go(&ways.list[i], share * step[i]);
                }
                next.a.settle();
                next.b.settle();
                let (a, v) = next.points(pair);
                if dot(&v, &v) < square {
                    (of_a, between) = (a, v);
                    is_better = true;
                    break;
                }
                if size <= LAST {
                    break;
                }
                share *= 0.25;
            }
            if !is_better {
                break;
            }
            *self = next;
            (ways, count) = self.ways(pair, &between);
            if size <= LAST {
                break;
            }
        }
        Found { between, of_a, direction: perpendicular(&ways, &between) }
    }
}

/// Newton's step: the solution of H s = -g, without ways that depend on those before (`LDL^T`, skipping small pivots).
#[inline(always)]
fn solve(ways: &Ways, between: &Point) -> [f64; 6] {
    let n = ways.len;
    let mut h = [[0.0; 6]; 6];
    let mut s = [0.0; 6];
    let mut skipped = [false; 6];
    let square = dot(between, between);
    let mut is_near = square > 0.0;
    for i in 0..n {
        let tangent = &ways.list[i].tangent;
        s[i] = -dot(tangent, between);
        is_near &= s[i] * s[i] <= NEAR * (dot(tangent, tangent) * square);
    }
    let gradient = s;
    let inverse = if is_near { 1.0 / square } else { 0.0 };
    for i in 0..n {
        let way = &ways.list[i];
        for j in 0..=i {
            h[i][j] = dot(&way.tangent, &ways.list[j].tangent) - gradient[i] * (gradient[j] * inverse);
        }
        if i > 0 {
            h[i][i - 1] += dot(&way.mixed, between);
        }
        let diagonal = h[i][i];
        h[i][i] += dot(&way.bend, between);
        let least = 1e-14 * (diagonal + h[i][i]);
        // Row i of L times D, then of L.
        for j in 0..i {
            if skipped[j] {
                h[i][j] = 0.0;
                continue;
            }
            for k in 0..j {
                h[i][j] -= h[i][k] * h[j][k] * h[k][k];
            }
            h[i][j] /= h[j][j];
        }
        for k in 0..i {
            h[i][i] -= h[i][k] * h[i][k] * h[k][k];
            s[i] -= h[i][k] * s[k];
        }
        if h[i][i] <= least || h[i][i].is_nan() {
            skipped[i] = true;
            s[i] = 0.0;
            h[i][i] = 0.0;
        }
    }
    for i in (0..n).rev() {
        if skipped[i] {
            s[i] = 0.0;
            continue;
        }
        s[i] /= h[i][i];
        for k in i + 1..n {
            s[i] -= h[k][i] * s[k];
        }
    }
    s
}

/// A vector along `between` that is perpendicular to the ways: the cross product of two of them, or `between` without its part
/// along the one.
#[inline(always)]
fn perpendicular(ways: &Ways, between: &Point) -> Point {
    // The tangent of a rim is as inaccurate as the place on it; straight ways are exact.
    let mut best = [0.0; 3];
    let (mut most, mut straight) = (1e-10, false);
    for i in 0..ways.len {
        for j in 0..i {
            let is_straight = ways.list[i].bend == [0.0; 3] && ways.list[j].bend == [0.0; 3];
            let (u, v) = (&ways.list[i].tangent, &ways.list[j].tangent);
            let normal = cross(u, v);
            let sine = dot(&normal, &normal) / (dot(u, u) * dot(v, v));
            if sine > 1e-10 && (is_straight && !straight || sine > most && is_straight == straight) {
                (best, most, straight) = (normal, sine, is_straight);
            }
        }
    }
    if most > 1e-10 {
        let sign = 1.0_f64.copysign(dot(&best, between));
        return best.map(|x| sign * x);
    }
    if ways.len == 0 {
        return *between;
    }
    let way = &ways.list[0].tangent;
    let square = dot(way, way);
    let rest = if square > 0.0 { dot(way, between) / square } else { 0.0 };
    [0, 1, 2].map(|k| between[k] - rest * way[k])
}
