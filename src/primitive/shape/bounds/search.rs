//! Certain bounds of the distance between two shapes, in `f64`.
//!
//! Any point of A and any point of B bound the distance from above, and any direction bounds it from below: by the gap
//! between the projections on it. So an algorithm only proposes points and directions, and only their evaluation has
//! an error ([`super::support`] bounds it). Newton's method proposes them first, then the algorithm of Gilbert,
//! Johnson and Keerthi.

use super::certified::Certified;
use super::gjk::Simplex;
use super::newton::{self, Newton, Places};
use super::support::{Operands, each};
use crate::exact::power_of_two;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::exact::aligned;
use crate::range::Point;
use crate::vector::{cross, dot, sqrt};

#[cfg(test)]
pub(super) mod tests;

/// Maximum number of steps of the algorithm of Gilbert, Johnson and Keerthi. Polytopes with up to eight corners need
/// fewer than 30.
const STEPS: usize = 64;

/// How much a core is shrunk to find a common point.
const SHRINK: f64 = power_of_two(-7);

/// Maximum number of steps of the search for a common point.
const COMMON_STEPS: usize = 16;

/// Points with a smaller squared distance, in units of the squared size, may be a common interior point.
const NEAR: f64 = power_of_two(-60);

/// Points of shapes that meet, relative to the size. The promise of [`super::bounds`] is 2^-26.
const CLOSE: f64 = power_of_two(-28);

/// Initial directions: the vector between the centres plus one of these, in units of the size.
const STARTS: [Point; 5] =
    [[0.0; 3], [0.36, 0.48, 0.81], [-0.6, 0.64, 0.45], [0.47, -0.8, 0.36], [-0.81, -0.36, -0.47]];

/// The range of sizes in which no square or product of four lengths above 2^-80 of the size leaves the range of `f64`.
const COMFORTABLE: core::ops::RangeInclusive<f64> = power_of_two(-100)..=power_of_two(100);

/// Bounds of the distance between two shapes in one frame. Stops when the distance is certainly above `limit`, when
/// the bounds differ by at most `tolerance` times the lower one, or when `f64` cannot tell more: then they differ by
/// less than 2^-40, nearly always 2^-44, of the size of the cores and the distance of their centres.
pub(crate) fn bounds(a: &Shape, b: &Shape, limit: f64, tolerance: f64) -> Certified {
    let radii = [a.radius, b.radius];
    let Some(pair) = Operands::of(&a.core, &b.core, 1.0) else {
        return super::half_space::bounds(a, b);
    };
    if COMFORTABLE.contains(&pair.size) || pair.size == 0.0 {
        DistanceSearch::new(&pair, radii, limit, tolerance).run(a, b)
    } else {
        rescaled(a, b, limit, tolerance, pair.size)
    }
}

#[cold]
#[inline(never)]
fn rescaled(a: &Shape, b: &Shape, limit: f64, tolerance: f64, size: f64) -> Certified {
    let scale = unit_scale(size);
    let Some(pair) = Operands::of(&a.core, &b.core, scale) else {
        return Certified { lower: 0.0, upper: f64::INFINITY, a: [0.0; 3], b: [0.0; 3] };
    };
    let radii = [a.radius * scale, b.radius * scale];
    let found = DistanceSearch::new(&pair, radii, limit * scale, tolerance).run(a, b);
    let back = |x: f64| x / scale;
    Certified {
        lower: back(found.lower),
        upper: back(found.upper),
        a: found.a.map(back),
        b: found.b.map(back),
    }
}

/// A power of two that brings a size near 1.
pub(super) fn unit_scale(size: f64) -> f64 {
    power_of_two((1023 - (size.to_bits() >> 52) as i32).clamp(-1000, 1000))
}

/// The best bounds of the distance between two cores so far.
pub(super) struct DistanceSearch<'p> {
    pair: &'p Operands,
    radii: [f64; 2],
    /// The sum of the radii, rounded down and up.
    radius: [f64; 2],
    /// The search ends once the cores are certainly farther apart.
    limit: f64,
    tolerance: f64,
    /// The largest gap found; negative if the cores overlap along all directions tried.
    pub(super) lower: f64,
    /// The direction of that gap.
    pub(super) along: Point,
    pub(super) upper: f64,
    /// The vector from the point of B to that of A, and A's point relative to its centre.
    between: Point,
    of_a: Point,
}

impl<'p> DistanceSearch<'p> {
    #[inline(always)]
    pub(super) fn new(pair: &'p Operands, radii: [f64; 2], limit: f64, tolerance: f64) -> Self {
        let sum = radii[0] + radii[1];
        let radius = [sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON)];
        let limit = (limit + radius[1]) * (1.0 + 8.0 * f64::EPSILON);
        let (lower, upper) = (f64::NEG_INFINITY, f64::INFINITY);
        let zero = [0.0; 3];
        Self { pair, radii, radius, limit, tolerance, lower, upper, along: zero, between: zero, of_a: zero }
    }

    // Not inlined, since a rescaled search calls it, too.
    #[inline(never)]
    fn run(mut self, a: &Shape, b: &Shape) -> Certified {
        let guess = Places::guess(self.pair);
        if !self.newton(guess, Some([a, b])) && !self.touches(a, b) {
            self.gjk();
        }
        if self.may_meet() && !self.touches(a, b) {
            self.overlap();
        }
        self.finish()
    }

    /// Whether the closest points found are close enough to be those of shapes that certainly meet, which the search
    /// could not tell. Exact, for shapes along the axes.
    #[inline(never)]
    fn touches(&mut self, a: &Shape, b: &Shape) -> bool {
        let are_close = self.lower <= 0.0 && self.upper - self.radius[0] <= CLOSE * self.pair.size;
        let touches = are_close && aligned::decide(a, b, 0.0) == Some(true);
        if touches {
            self.upper = 0.0;
        }
        touches
    }

    /// Looks for the closest points.
    #[inline(always)]
    pub(super) fn approach(&mut self) {
        if !self.newton_from(Places::guess(self.pair)) {
            self.gjk();
        }
    }

    /// Whether the bounds do not tell if the cores meet, which matters for shapes without radii.
    #[inline(always)]
    fn may_meet(&self) -> bool {
        self.lower <= 0.0 && self.upper > self.radius[0]
    }

    /// Looks for a tetrahedron in A - B that certainly contains the origin. From a single initial direction, symmetric
    /// shapes may give only tetrahedra that have it on a face.
    #[cold]
    #[inline(never)]
    pub(super) fn overlap(&mut self) -> Option<[Point; 4]> {
        let [x, y, z] = self.pair.between;
        let size = self.pair.size;
        for [u, v, w] in STARTS {
            let found = self.overlap_from([x + u * size, y + v * size, z + w * size]);
            if found.is_some() || self.lower > 0.0 {
                return found;
            }
        }
        None
    }

    fn overlap_from(&mut self, mut direction: Point) -> Option<[Point; 4]> {
        let mut simplex = Simplex::new();
        for _ in 0..STEPS {
            let (point, of_a) = self.lower_along(&direction);
            if self.lower > 0.0 || simplex.has(&point) {
                return None;
            }
            simplex.add(point, of_a);
            let nearest = simplex.reduce();
            if nearest.inside {
                if simplex.surely_contains_origin(self.pair.slack, self.pair.size) {
                    self.upper_by(&nearest.point, &nearest.of_a);
                    self.upper = 0.0;
                    return Some(simplex.points);
                }
                return None;
            }
            direction = nearest.direction;
        }
        None
    }

    /// Proposes closest points by Newton's method from these places. Returns whether the bounds suffice. If the shapes
    /// are given, touching ones along the axes are decided before a common point is sought.
    #[inline(always)]
    fn newton(&mut self, places: Places, shapes: Option<[&Shape; 2]>) -> bool {
        let mut newton = Newton::new(self.pair, places);
        let mut goes_on = true;
        for step in 0..=newton::STEPS {
            if self.is_solved_by(&mut newton, step == 0) {
                return true;
            }
            if step == 0
                && self.lower <= 0.0
                && (shapes.is_some_and(|[a, b]| self.touches(a, b)) || self.common(&newton.between))
            {
                return true;
            }
            if !goes_on || step == newton::STEPS {
                break;
            }
            goes_on = newton.step(self.pair, self.lower);
        }
        self.lower_along(&newton.between);
        self.is_done()
    }

    /// [`DistanceSearch::newton`] without the shapes, compiled once for its rarer callers.
    #[inline(never)]
    fn newton_from(&mut self, places: Places) -> bool {
        self.newton(places, None)
    }

    /// Bounds the distance by the points and along the normal. If that does not raise the lower bound, but the
    /// direction between the points does, it becomes the normal. The first bound is along a vector perpendicular to the
    /// ways, as are those near the solution: it tells more often whether the cores meet.
    #[inline(always)]
    fn is_solved_by(&mut self, newton: &mut Newton, is_first: bool) -> bool {
        let square = self.upper_by(&newton.between, &newton.of_a);
        if square < NEAR * (self.pair.size * self.pair.size)
            && let Some(point) = newton.common(self.pair)
        {
            (self.upper, self.between, self.of_a) = (0.0, [0.0; 3], point);
            return true;
        }
        newton.find_ways(self.pair);
        let (before, is_near) = (self.lower, newton.is_near());
        let d = if is_near || is_first { newton.direction() } else { newton.normal };
        self.lower_along(&d);
        if self.lower <= before && !self.is_done() {
            self.lower_along(&newton.between);
            if self.lower > before {
                newton.normal = newton::unit(&newton.between);
                newton.find_ways(self.pair);
            }
        }
        if is_near && self.upper - self.lower < CLOSE * self.pair.size && !self.is_done() {
            self.lower_along(&newton.across_sides(self.pair, d));
        }
        self.is_done()
    }

    /// Looks for a common point of one core and the other shrunk about its centre: each point of the shrunk core is the
    /// centre of a ball inside the core, since `s K + (1 - s) K` is K for a convex K. Shrinks a core that is small, but
    /// not thin: its points move less, and the ball is not too small.
    #[inline(never)]
    fn common(&mut self, from: &Point) -> bool {
        let pair = self.pair;
        let inner = [pair.a.form.inner(), pair.b.form.inner()];
        let reach = [pair.a.reach, pair.b.reach];
        let is_in_b = inner[1] * (reach[0] * reach[0]) >= inner[0] * (reach[1] * reach[1]);
        let room = SHRINK * if is_in_b { inner[1] } else { inner[0] } - pair.slack;
        if room <= 0.0 {
            return false;
        }
        let mut simplex = Simplex::new();
        let mut direction = *from;
        for _ in 0..COMMON_STEPS {
            let shrunk = |p: Point| each(|k| (1.0 - SHRINK) * p[k]);
            let (of_a, of_b) = (pair.a.support(&each(|k| -direction[k])), pair.b.support(&direction));
            let (of_a, of_b) = if is_in_b { (of_a, shrunk(of_b)) } else { (shrunk(of_a), of_b) };
            let point: Point = each(|k| pair.between[k] + (of_a[k] - of_b[k]));
            if dot(&direction, &point) > 0.0 || simplex.has(&point) {
                return false;
            }
            simplex.add(point, of_a);
            let nearest = simplex.reduce();
            let v = &nearest.point;
            if sqrt(dot(v, v)) < room {
                let of_a = nearest.of_a;
                self.of_a = if is_in_b { of_a } else { each(|k| of_a[k] - v[k]) };
                (self.upper, self.between) = (0.0, [0.0; 3]);
                return true;
            }
            if nearest.inside {
                return false;
            }
            direction = nearest.direction;
        }
        false
    }

    /// The algorithm of Gilbert, Johnson and Keerthi, from the points found so far.
    #[cold]
    #[inline(never)]
    pub(super) fn gjk(&mut self) {
        let mut simplex = Simplex::new();
        let mut direction = self.between;
        let mut last = f64::INFINITY;
        for step in 0..STEPS {
            let (point, of_a) = self.lower_along(&direction);
            if self.is_done() || simplex.has(&point) {
                break;
            }
            simplex.add(point, of_a);
            let nearest = simplex.reduce();
            self.upper_by(&nearest.point, &nearest.of_a);
            if nearest.inside {
                if simplex.surely_contains_origin(self.pair.slack, self.pair.size) {
                    self.upper_by(&nearest.point, &nearest.of_a);
                    self.upper = 0.0;
                    return;
                }
                break;
            }
            if self.is_done() {
                return;
            }
            let square = dot(&nearest.point, &nearest.point);
            if square >= last {
                break;
            }
            last = square;
            direction = nearest.direction;
            if step % 4 == 3 {
                let places = Places::near(self.pair, &nearest.of_a, &nearest.point);
                if self.newton_from(places) {
                    return;
                }
            }
        }
        if !self.is_done() && !self.newton_from(Places::near(self.pair, &self.of_a, &self.between)) {
            self.edges();
        }
    }

    /// Bounds the distance from below along the perpendiculars of all edges and faces at the points found: the
    /// difference of points that nearly touch does not tell which ways are blocked.
    pub(super) fn edges(&mut self) {
        let places = Places::near(self.pair, &self.of_a, &self.between);
        let [p, q, r] = self.pair.a.form.edges(&places.a);
        let [s, t, u] = self.pair.b.form.edges(&places.b);
        let edges = [p, q, r, s, t, u];
        for i in 1..6 {
            for j in 0..i {
                let normal = cross(&edges[i], &edges[j]);
                let sign = 1.0_f64.copysign(dot(&normal, &self.between));
                self.lower_along(&each(|k| sign * normal[k]));
                self.lower_along(&each(|k| -sign * normal[k]));
            }
        }
    }

    /// Bounds the distance from below by the gap along d, which points from B to A. Returns the point of A - B at
    /// which the gap ends, and its point of A.
    #[inline(always)]
    fn lower_along(&mut self, d: &Point) -> (Point, Point) {
        let (point, of_a) = self.pair.support(d);
        let square = dot(d, d);
        if square > f64::MIN_POSITIVE {
            let gap = dot(d, &point) / sqrt(square) - self.pair.slack;
            if gap > self.lower {
                (self.lower, self.along) = (gap, *d);
            }
        }
        (point, of_a)
    }

    /// Bounds the distance from above by a point of A - B, and returns its square.
    #[inline(always)]
    fn upper_by(&mut self, between: &Point, of_a: &Point) -> f64 {
        let square = dot(between, between);
        let upper = sqrt(square) + self.pair.slack;
        if upper < self.upper {
            (self.upper, self.between, self.of_a) = (upper, *between, *of_a);
        }
        square
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        let width = self.upper - self.lower;
        self.lower > self.limit
            || width <= self.tolerance * (self.lower - self.radius[1])
            || width <= 2.5 * self.pair.slack
            || self.upper <= self.radius[0]
    }

    /// The bounds of the distance between the shapes.
    #[inline(always)]
    fn finish(&self) -> Certified {
        let (wide, narrow) = (1.0 + 2.0 * f64::EPSILON, 1.0 - 2.0 * f64::EPSILON);
        let meets = self.upper <= self.radius[0];
        let upper = if meets { 0.0 } else { (self.upper - self.radius[0]) * wide };
        let lower = self.lower - self.radius[1];
        let lower = if lower > 0.0 { lower * narrow } else { 0.0 };
        let a = self.pair.a.placed(&self.of_a);
        let of_b: Point = each(|k| self.pair.between[k] + self.of_a[k] - self.between[k]);
        let b = self.pair.b.placed(&of_b);
        let sum = self.radii[0] + self.radii[1];
        let length = sqrt(dot(&self.between, &self.between));
        if sum == 0.0 || length == 0.0 {
            return Certified { lower, upper, a, b };
        }
        let unit = if meets { 1.0 / sum } else { 1.0 / length };
        let toward = |p: &Point, by: f64| each(|k| p[k] + self.between[k] * (by * unit));
        Certified { lower, upper, a: toward(&a, -self.radii[0]), b: toward(&b, self.radii[1]) }
    }
}
