//! Newton's method for the closest points of two cores, by their coordinates.
//!
//! The squared distance is minimised over the coordinates that the boundaries leave free (projected Newton: Bertsekas
//! 1982). For polytopes it is quadratic, so one step solves it once the right coordinates are free. Near the solution
//! the distance itself is minimised, whose second derivative does not vanish where shapes touch: so convergence on
//! rims is quadratic too.
//!
//! **The normal.** The direction of the distance is an unknown of its own. With the tangents T of the free coordinates
//! u, the vector w between the points and the unit normal n, a solution has `T^T n = 0` and `w = (n . w) n`. Newton's
//! step for this system is `(T^T T - g g^T + (n . w) K) du = -T^T w`, with `g = T^T n` and the curvatures K along n;
//! the next normal is the direction of `(n . w) n` plus the part of `w + T du` that is perpendicular to n. Where w is
//! parallel to n, this is the step for the distance. But where shapes nearly touch, terms of second order in du exceed
//! the distance and turn w, while n stays accurate. Its lower bound also tells whether a step leads on.
//!
//! Nothing here is certified.

use super::place::{CorePoint, Displacement, Way, Ways};
use super::support::{Form, Operands, each};
use crate::range::Point;
use crate::vector::{cross, dot, sqrt};

/// Maximum number of steps.
pub(super) const STEPS: usize = 16;

/// Alternating projections before the first step.
const ROUNDS: usize = 2;

/// Alternating projections instead of a step that does not reduce the distance.
const PROJECTIONS: usize = 4;

/// A step shorter than this, in units of half edges and radii, is the last: the next one would be below rounding.
const LAST: f64 = 1.0 / (1_u64 << 40) as f64;

/// Near the solution, the squared cosine of the angle between each way and the normal is at most this.
const NEAR: f64 = 0.03;

/// Number of shares of a step that are tried, each a fourth of the one before.
const SHARES: usize = 4;

/// A step that reaches a bound after a smaller share is not cut off there.
const LEAST_SHARE: f64 = 0.01;

/// Relative slopes of the distance below this are rounding.
const FLATTEST: f64 = 1e-14;

/// A step that reaches the boundary of any core, in units of half edges and radii.
const ACROSS: f64 = 2.0;

/// Unit vectors with a smaller product have different directions.
const SAME: f64 = 0.999;

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
    /// Estimate of the direction from B to A at the solution, of unit length. Zero where the points are equal.
    pub(super) normal: Point,
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
    /// [`Newton::find_ways`] completes it.
    #[inline(always)]
    pub(super) fn new(pair: &Operands, places: Places) -> Self {
        let (of_a, between) = places.points(pair);
        Self { places, between, of_a, normal: unit(&between), ways: Ways::new(), count: 0 }
    }

    /// The ways of the places that the normal leaves free.
    #[inline(always)]
    pub(super) fn find_ways(&mut self, pair: &Operands) {
        self.ways.len = 0;
        pair.a.form.ways(&self.places.a, &self.normal, &mut self.ways);
        self.count = self.ways.len;
        pair.b.form.ways(&self.places.b, &each(|k| -self.normal[k]), &mut self.ways);
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

    /// Moves the places and the normal; the caller then calls [`Newton::find_ways`]. `lower` is the greatest lower
    /// bound of the distance. Returns false if that was the last step.
    #[inline(always)]
    pub(super) fn step(&mut self, pair: &Operands, lower: f64) -> bool {
        if dot(&self.between, &self.between) == 0.0 {
            return false;
        }
        let (step, is_near) = self.solve(true);
        // The distance of shapes that overlap has no second derivative where it vanishes; its square has one.
        self.go(pair, &step, lower)
            || is_near && (self.go_far(pair, lower) || self.go_to_bound(pair, &step))
            || self.project(pair)
    }

    /// Alternating projections never increase the distance; a step that is clamped at the boundaries may. The normal
    /// becomes the direction between the points.
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
            if !self.approaches(pair, Places { a, b }) {
                break;
            }
        }
        let normal = unit(&self.between);
        let is_other = dot(&normal, &self.normal) < SAME;
        self.normal = normal;
        is_other || dot(&self.between, &self.between) < 0.75 * before
    }

    #[cold]
    #[inline(never)]
    fn go_far(&mut self, pair: &Operands, lower: f64) -> bool {
        let (step, _) = self.solve(false);
        self.go(pair, &step, lower)
    }

    /// Returns false if the step is below rounding, or no fraction of it reduces the distance.
    #[inline(always)]
    fn go(&mut self, pair: &Operands, step: &[f64; 6], lower: f64) -> bool {
        let size = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let by = self.displacements(step);
        let normal = self.predicted(step, 1.0);
        if self.approaches(pair, self.moved(&by, 1.0)) {
            self.normal = normal;
            return size > LAST;
        }
        if size <= LAST {
            return false;
        }
        self.go_less(pair, &by, step, lower)
    }

    /// [`Newton::go`] where the full step does not reduce the distance: goes on if it certainly raises the lower bound,
    /// and else takes a part of it.
    #[cold]
    #[inline(never)]
    fn go_less(&mut self, pair: &Operands, by: &[Displacement; 2], step: &[f64; 6], lower: f64) -> bool {
        let normal = self.predicted(step, 1.0);
        if dot(&normal, &pair.support(&normal).0) - pair.slack > lower {
            self.go_to(pair, self.moved(by, 1.0));
            self.normal = normal;
            return true;
        }
        // Up to the first bound that a coordinate reaches: then that coordinate is fixed.
        let most = self.share_to_bound(by);
        let mut share = if most < 1.0 && most > LEAST_SHARE { most } else { 0.25 };
        for _ in 0..SHARES {
            let normal = self.predicted(step, share);
            if self.approaches(pair, self.moved(by, share)) {
                self.normal = normal;
                return true;
            }
            share *= 0.25;
        }
        false
    }

    /// Goes up to the first bound that a coordinate reaches after a small share of a step, unless that increases the
    /// distance: a short way at its bound no longer shortens the next step.
    #[cold]
    #[inline(never)]
    fn go_to_bound(&mut self, pair: &Operands, step: &[f64; 6]) -> bool {
        let by = self.displacements(step);
        let share = self.share_to_bound(&by);
        let (normal, places) = (self.predicted(step, share), self.moved(&by, share));
        let (of_a, between) = places.points(pair);
        let square = dot(&self.between, &self.between) * (1.0 + 4.0 * f64::EPSILON);
        let leads_on = share < LEAST_SHARE && dot(&between, &between) <= square;
        if leads_on {
            (self.places, self.of_a, self.between, self.normal) = (places, of_a, between, normal);
        }
        leads_on
    }

    #[inline(always)]
    fn displacements(&self, step: &[f64; 6]) -> [Displacement; 2] {
        let mut by = [Displacement::NONE; 2];
        for (i, way) in self.ways.list[..self.ways.len].iter().enumerate() {
            by[usize::from(i >= self.count)].add(way, step[i]);
        }
        by
    }

    #[inline(always)]
    fn share_to_bound(&self, by: &[Displacement; 2]) -> f64 {
        self.places.a.share_to_bound(&by[0]).min(self.places.b.share_to_bound(&by[1]))
    }

    /// The places after a share of a step.
    #[inline(always)]
    fn moved(&self, by: &[Displacement; 2], share: f64) -> Places {
        Places { a: self.places.a.moved(&by[0], share), b: self.places.b.moved(&by[1], share) }
    }

    #[inline(always)]
    fn go_to(&mut self, pair: &Operands, places: Places) {
        (self.of_a, self.between) = places.points(pair);
        self.places = places;
    }

    /// Goes to these places if they are closer to each other.
    #[inline(always)]
    fn approaches(&mut self, pair: &Operands, places: Places) -> bool {
        let (of_a, between) = places.points(pair);
        let is_closer = dot(&between, &between) < dot(&self.between, &self.between);
        if is_closer {
            (self.places, self.of_a, self.between) = (places, of_a, between);
        }
        is_closer
    }

    /// The normal after a share of a step.
    #[inline(always)]
    fn predicted(&self, step: &[f64; 6], share: f64) -> Point {
        let mut moved = self.between;
        for (i, way) in self.ways.list[..self.ways.len].iter().enumerate() {
            moved = each(|k| moved[k] + share * step[i] * way.tangent[k]);
        }
        let lost = dot(&self.normal, &self.between) - dot(&self.normal, &moved);
        unit(&each(|k| moved[k] + lost * self.normal[k]))
    }

    /// A direction near d that is perpendicular to the side lines of cones on which the places are.
    #[cold]
    #[inline(never)]
    pub(super) fn across_sides(&self, pair: &Operands, mut d: Point) -> Point {
        // Where both are cones, each correction undoes a part of the other.
        for _ in 0..3 {
            d = pair.b.form.across_side(&self.places.b, &d);
            let of_a = pair.a.form.across_side(&self.places.a, &each(|k| -d[k]));
            d = each(|k| -of_a[k]);
        }
        d
    }

    /// Whether the normal is nearly perpendicular to all ways.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        let ways = &self.ways.list[..self.ways.len];
        ways.iter().all(|way| way.slope * way.slope <= NEAR * dot(&way.tangent, &way.tangent))
    }

    /// A vector near the normal that is perpendicular to the ways: the cross product of two of them, or the normal
    /// without its component along the only one.
    #[inline(always)]
    pub(super) fn direction(&self) -> Point {
        let ways = &self.ways.list[..self.ways.len];
        match ways {
            [] => return self.normal,
            [way] => return without(&self.normal, &way.tangent),
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
                let sign = 1.0_f64.copysign(dot(&best, &self.normal));
                return each(|k| sign * best[k]);
            }
        }
        without(&self.normal, &ways[0].tangent)
    }

    /// The step along a way that depends on earlier ones, which follow it. Two faces that are nearly parallel are
    /// closest at a boundary, but the square of their angle is below rounding. So the step is longer than any core, and
    /// [`Newton::go_less`] ends it at the boundary. Zero if the distance decreases by no more than rounding.
    #[cold]
    fn across(&self, way: &Way, slope: f64, square: f64) -> f64 {
        let least = FLATTEST * sqrt(square * dot(&self.between, &self.between));
        if slope.abs() > least && !way.bends() { ACROSS.copysign(slope) } else { 0.0 }
    }

    /// Newton's step, and whether it is for the distance instead of its square, without `g g^T`. [`Newton::across`]
    /// gives the steps of ways that depend on earlier ones (small pivots of `LDL^T`).
    #[inline(always)]
    fn solve(&self, may_be_near: bool) -> ([f64; 6], bool) {
        let (list, n) = (&self.ways.list, self.ways.len);
        // L below the diagonal, and the transpose of L D above it.
        let mut h = [[0.0; 6]; 6];
        let (mut s, mut inverse, mut squares) = ([0.0; 6], [0.0; 6], [0.0; 6]);
        let height = dot(&self.normal, &self.between);
        let mut is_near = may_be_near && height > 0.0;
        let height = if height > 0.0 { height } else { 0.0 };
        for i in 0..n {
            let way = &list[i];
            s[i] = -dot(&way.tangent, &self.between);
            squares[i] = dot(&way.tangent, &way.tangent);
            is_near &= way.slope * way.slope <= NEAR * squares[i];
        }
        let less = if is_near { 1.0 } else { 0.0 };
        for i in 0..n {
            let way = &list[i];
            let slope = less * way.slope;
            let square = squares[i] - slope * way.slope;
            let mut diagonal = square + height * way.bend;
            let least = 1e-14 * (square + diagonal);
            let (above, below) = h.split_at_mut(i);
            let row = &mut below[0];
            for j in 0..i {
                let mut product = dot(&way.tangent, &list[j].tangent) - slope * list[j].slope;
                if j + 1 == i {
                    product += height * way.mixed;
                }
                for (x, before) in row.iter().zip(&*above).take(j) {
                    product -= x * before[j];
                }
                above[j][i] = product;
                row[j] = product * inverse[j];
                diagonal -= row[j] * product;
                s[i] -= row[j] * s[j];
            }
            if diagonal > least {
                inverse[i] = 1.0 / diagonal;
            } else {
                s[i] = self.across(way, s[i], squares[i]);
            }
        }
        for i in (0..n).rev() {
            if inverse[i] > 0.0 {
                s[i] *= inverse[i];
                for k in i + 1..n {
                    s[i] -= h[k][i] * s[k];
                }
            }
        }
        (s, is_near)
    }
}

/// A vector without its component along another.
#[inline(always)]
pub(super) fn without(v: &Point, way: &Point) -> Point {
    let square = dot(way, way);
    let rest = if square > 0.0 { dot(way, v) / square } else { 0.0 };
    each(|k| v[k] - rest * way[k])
}

/// The vector of unit length in the direction of another whose squares are in range, or zero. Takes less time than
/// [`crate::vector::unit`], in every step.
#[inline(always)]
pub(super) fn unit(v: &Point) -> Point {
    let length = sqrt(dot(v, v));
    let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
    each(|k| v[k] * inverse)
}
