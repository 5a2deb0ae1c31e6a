//! Newton's method for the closest points of two cores, by their coordinates.
//!
//! The squared distance is minimised over the coordinates that the boundaries leave free (projected Newton: Bertsekas
//! 1982). For polytopes it is quadratic, so one step solves it once the right coordinates are free. Near the solution
//! the distance itself is minimised, whose second derivative does not vanish where shapes touch: so convergence on
//! rims is quadratic too. Nothing here is certified.

use super::place::{CorePoint, Ways};
use super::support::{Form, Operands, each};
use crate::range::Point;
use crate::vector::{cross, dot, sqrt};

/// Maximum number of steps.
pub(super) const STEPS: usize = 16;

/// Alternating projections before the first step.
const ROUNDS: usize = 1;

/// Alternating projections instead of a step that does not reduce the distance.
const PROJECTIONS: usize = 4;

/// A step shorter than this, in units of half edges and radii, is the last: the next one would be below rounding.
const LAST: f64 = 1.0 / (1_u64 << 40) as f64;

/// Near the solution, the squared cosine of the angle between each way and the vector between the points is at most
/// this.
const NEAR: f64 = 1e-2;

/// A place in each core.
#[derive(Copy, Clone, Debug)]
pub(super) struct Places {
    pub(super) a: CorePoint,
    pub(super) b: CorePoint,
}

/// The state of the method.
#[derive(Copy, Clone, Debug)]
pub(super) struct Newton {
    places: Places,
    /// From the point of B to that of A.
    pub(super) between: Point,
    /// A's point, relative to its centre.
    pub(super) of_a: Point,
    /// The ways of A's place, then those of B's place, negated.
    ways: Ways,
    count: usize,
}

impl Places {
    /// A's point nearest to B's centre, B's point nearest to that, and [`ROUNDS`] more such projections: a round costs
    /// a fourth of a step.
    #[inline(always)]
    pub(super) fn guess(pair: &Operands) -> Self {
        let (form, other) = (&pair.a.form, &pair.b.form);
        let t = &pair.between;
        let mut a = form.nearest(&[-t[0], -t[1], -t[2]]);
        let mut p = form.at(&a);
        let mut b = other.nearest(&[t[0] + p[0], t[1] + p[1], t[2] + p[2]]);
        if matches!(form, Form::Point) || matches!(other, Form::Point) {
            return Self { a, b };
        }
        for _ in 0..ROUNDS {
            let q = other.at(&b);
            a = form.nearest(&[q[0] - t[0], q[1] - t[1], q[2] - t[2]]);
            p = form.at(&a);
            b = other.nearest(&[t[0] + p[0], t[1] + p[1], t[2] + p[2]]);
        }
        Self { a, b }
    }

    /// The places nearest to a point of A, and to the point of B from which `between` leads to it.
    #[inline(always)]
    pub(super) fn near(pair: &Operands, of_a: &Point, between: &Point) -> Self {
        let of_b: Point = each(|k| pair.between[k] + of_a[k] - between[k]);
        Self { a: pair.a.form.nearest(of_a), b: pair.b.form.nearest(&of_b) }
    }

    #[inline(always)]
    fn points(&self, pair: &Operands) -> (Point, Point) {
        let (a, b) = (pair.a.form.at(&self.a), pair.b.form.at(&self.b));
        (a, each(|k| pair.between[k] + (a[k] - b[k])))
    }
}

impl Newton {
    #[inline(always)]
    pub(super) fn new(pair: &Operands, places: Places) -> Self {
        let (of_a, between) = places.points(pair);
        let mut newton = Self { places, between, of_a, ways: Ways::new(), count: 0 };
        newton.find_ways(pair);
        newton
    }

    #[inline(always)]
    fn find_ways(&mut self, pair: &Operands) {
        self.ways.len = 0;
        pair.a.form.ways(&self.places.a, &self.between, &mut self.ways);
        self.count = self.ways.len;
        pair.b.form.ways(&self.places.b, &each(|k| -self.between[k]), &mut self.ways);
        for way in &mut self.ways.list[self.count..self.ways.len] {
            way.tangent = each(|k| -way.tangent[k]);
        }
    }

    /// A common point of the cores, relative to A's centre, if one of the two places is so far inside its core that a
    /// ball about it contains the other place: then the cores certainly meet.
    pub(super) fn common(&self, pair: &Operands) -> Option<Point> {
        let v = &self.between;
        let apart = sqrt(dot(v, v)) + pair.slack;
        if pair.b.form.room(&self.places.b) > apart {
            Some(self.of_a)
        } else if pair.a.form.room(&self.places.a) > apart {
            Some(each(|k| self.of_a[k] - v[k]))
        } else {
            None
        }
    }

    /// Moves the places. Returns false if that was the last step.
    #[inline(always)]
    pub(super) fn step(&mut self, pair: &Operands) -> bool {
        let (step, is_near) = solve(&self.ways, &self.between, true);
        // The distance of shapes that overlap has no second derivative where it vanishes; its square has one.
        self.go(pair, &step) || is_near && self.go_far(pair) || self.project(pair)
    }

    /// Alternating projections never increase the distance; a step that is clamped at the boundaries may.
    #[cold]
    #[inline(never)]
    fn project(&mut self, pair: &Operands) -> bool {
        let before = dot(&self.between, &self.between);
        let t = &pair.between;
        for _ in 0..PROJECTIONS {
            let q = pair.b.form.at(&self.places.b);
            let a = pair.a.form.nearest(&each(|k| q[k] - t[k]));
            let p = pair.a.form.at(&a);
            let b = pair.b.form.nearest(&each(|k| t[k] + p[k]));
            let next = Places { a, b };
            let (of_a, between) = next.points(pair);
            if dot(&between, &between) >= dot(&self.between, &self.between) {
                break;
            }
            (self.places, self.of_a, self.between) = (next, of_a, between);
        }
        let is_better = dot(&self.between, &self.between) < 0.75 * before;
        self.find_ways(pair);
        is_better
    }

    #[cold]
    #[inline(never)]
    fn go_far(&mut self, pair: &Operands) -> bool {
        let (step, _) = solve(&self.ways, &self.between, false);
        self.go(pair, &step)
    }

    /// Returns false if the step is below rounding, or no fraction of it reduces the distance.
    #[inline(always)]
    fn go(&mut self, pair: &Operands, step: &[f64; 6]) -> bool {
        let size = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let square = dot(&self.between, &self.between);
        let mut share = 1.0;
        for _ in 0..4 {
            let mut next = self.places;
            for (i, way) in self.ways.list[..self.ways.len].iter().enumerate() {
                let place = if i < self.count { &mut next.a } else { &mut next.b };
                place.go(way, share * step[i]);
            }
            next.a.settle();
            next.b.settle();
            let (of_a, between) = next.points(pair);
            if dot(&between, &between) < square {
                (self.places, self.of_a, self.between) = (next, of_a, between);
                self.find_ways(pair);
                return size > LAST;
            }
            if size <= LAST {
                break;
            }
            share *= 0.25;
        }
        false
    }

    /// Whether the vector between the points is nearly perpendicular to all ways.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        let square = dot(&self.between, &self.between);
        let ways = &self.ways.list[..self.ways.len];
        ways.iter().all(|way| way.slope * way.slope <= NEAR * (dot(&way.tangent, &way.tangent) * square))
    }

    /// A vector near `between` that is perpendicular to the ways: the cross product of two of them, or `between`
    /// without its component along the only one.
    #[inline(always)]
    pub(super) fn direction(&self) -> Point {
        let ways = &self.ways.list[..self.ways.len];
        match ways {
            [] => return self.between,
            [way] => return without(&self.between, &way.tangent),
            _ => {}
        }
        // The tangent of a rim is as inaccurate as the place on it; straight ways are exact.
        for accepts_bent in [false, true] {
            let (mut best, mut most) = ([0.0; 3], 1e-10);
            for i in 1..ways.len() {
                for j in 0..i {
                    let (u, v) = (&ways[i], &ways[j]);
                    if !accepts_bent && (u.bends() || v.bends()) {
                        continue;
                    }
                    let normal = cross(&u.tangent, &v.tangent);
                    let sine = dot(&normal, &normal);
                    let product = dot(&u.tangent, &u.tangent) * dot(&v.tangent, &v.tangent);
                    if sine > most * product {
                        (best, most) = (normal, sine / product);
                    }
                    if most > 0.1 {
                        break;
                    }
                }
            }
            if most > 1e-10 {
                let sign = 1.0_f64.copysign(dot(&best, &self.between));
                return each(|k| sign * best[k]);
            }
        }
        without(&self.between, &ways[0].tangent)
    }
}

/// A vector without its component along another.
#[inline(always)]
pub(super) fn without(v: &Point, way: &Point) -> Point {
    let square = dot(way, way);
    let rest = if square > 0.0 { dot(way, v) / square } else { 0.0 };
    each(|k| v[k] - rest * way[k])
}

/// Newton's step, the solution of H s = -g, and whether it is for the distance instead of its square. Omits ways that
/// depend on earlier ones (`LDL^T`, skipping small pivots).
#[inline(always)]
fn solve(ways: &Ways, between: &Point, may_be_near: bool) -> ([f64; 6], bool) {
    let n = ways.len;
    let mut h = [[0.0; 6]; 6];
    let mut s = [0.0; 6];
    let mut skipped = [false; 6];
    let square = dot(between, between);
    let mut is_near = may_be_near && square > 0.0;
    for i in 0..n {
        let way = &ways.list[i];
        s[i] = -way.slope;
        h[i][i] = dot(&way.tangent, &way.tangent);
        is_near &= s[i] * s[i] <= NEAR * (h[i][i] * square);
    }
    let gradient = s;
    let inverse = if is_near { 1.0 / square } else { 0.0 };
    for i in 0..n {
        let way = &ways.list[i];
        for j in 0..i {
            h[i][j] = dot(&way.tangent, &ways.list[j].tangent) - gradient[i] * (gradient[j] * inverse);
        }
        h[i][i] -= gradient[i] * (gradient[i] * inverse);
        if i > 0 {
            h[i][i - 1] += way.mixed;
        }
        let diagonal = h[i][i];
        h[i][i] += way.bend;
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
    (s, is_near)
}
