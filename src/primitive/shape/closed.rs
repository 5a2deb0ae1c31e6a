//! Bounds of the distance where a formula or a few cheap steps give the closest points: a point against any bounded
//! core but a triangle, and segments and cuboids against each other.
//!
//! As in [`super::bounds`], only evaluations have to be certain. In what follows u = 2^-53, and S is at least the
//! distance of the two centres and the greatest distances of points of the cores from them together. Factors 1 + 2^-40
//! for terms of second order are implied. A `slack` bounds all errors of a length.

use super::bounds::Bounds;
use super::newton::without;
use super::support::each;
use super::{Core, Point, Shape};
use crate::exact::power_of_two;
use crate::vector::{cross, difference, dot};

#[cfg(test)]
mod tests;

/// Squared sizes between which no product of four lengths overflows, nor underflows by more than a slack.
const COMFORTABLE: core::ops::RangeInclusive<f64> = power_of_two(-200)..=power_of_two(200);

/// The most rounds of [`blocks`].
const ROUNDS: usize = 10;

/// How much blocks are shrunk to find a common point.
const SHRINK: f64 = power_of_two(-7);

/// Bounds of the distance of two shapes as [`super::bounds::bounds`] gives them, or `None` if they would not be as
/// tight.
#[inline(always)]
pub(super) fn bounds(a: &Shape, b: &Shape, limit: f64, tolerance: f64) -> Option<Bounds> {
    let goal = || Goal::new(a.radius, b.radius, limit, tolerance);
    let turned = || Goal::new(b.radius, a.radius, limit, tolerance);
    match (&a.core, &b.core) {
        (Core::Point(p), Core::Point(q)) => Some(points(p, q, &goal())),
        (Core::Point(p), Core::Segment(s)) => point_and_segment(p, s, &goal()),
        (Core::Segment(s), Core::Point(p)) => point_and_segment(p, s, &turned()).map(swapped),
        (Core::Segment(s), Core::Segment(t)) => {
            let (g, h) = (half_of(s), half_of(t));
            let (a, b) = (Block { origin: &s[0], half: &g }, Block { origin: &t[0], half: &h });
            blocks(&a, &b, &goal())
        }
        (Core::Point(p), Core::Cuboid { centre, half }) => {
            let (a, b) = (Block { origin: p, half: &[] }, Block { origin: centre, half });
            blocks(&a, &b, &goal())
        }
        (Core::Cuboid { centre, half }, Core::Point(p)) => {
            let (a, b) = (Block { origin: p, half: &[] }, Block { origin: centre, half });
            blocks(&a, &b, &turned()).map(swapped)
        }
        (Core::Segment(s), Core::Cuboid { centre, half }) => segment_and_cuboid(s, centre, half, &goal()),
        (Core::Cuboid { centre, half }, Core::Segment(s)) => {
            segment_and_cuboid(s, centre, half, &turned()).map(swapped)
        }
        (Core::Cuboid { centre: c, half: g }, Core::Cuboid { centre, half }) => {
            blocks(&Block { origin: c, half: g }, &Block { origin: centre, half }, &goal())
        }
        (Core::Point(p), Core::Cylinder { centre, half_axis, radius }) => {
            point_and_cylinder(p, centre, half_axis, *radius, &goal())
        }
        (Core::Cylinder { centre, half_axis, radius }, Core::Point(p)) => {
            point_and_cylinder(p, centre, half_axis, *radius, &turned()).map(swapped)
        }
        (Core::Point(p), Core::Cone { base, axis, radius }) => {
            point_and_cone(p, base, axis, *radius, &goal())
        }
        (Core::Cone { base, axis, radius }, Core::Point(p)) => {
            point_and_cone(p, base, axis, *radius, &turned()).map(swapped)
        }
        _ => None,
    }
}

#[inline(always)]
fn swapped(found: Bounds) -> Bounds {
    Bounds { a: found.b, b: found.a, ..found }
}

/// What bounds have to attain.
struct Goal {
    radii: [f64; 2],
    /// The sum of the radii, rounded down and up.
    less: f64,
    more: f64,
    /// Cores farther apart are of no interest.
    limit: f64,
    tolerance: f64,
}

impl Goal {
    #[inline(always)]
    fn new(a: f64, b: f64, limit: f64, tolerance: f64) -> Self {
        let sum = a + b;
        let (less, more) = (sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON));
        let limit = (limit + more) * (1.0 + 8.0 * f64::EPSILON);
        Self { radii: [a, b], less, more, limit, tolerance }
    }

    /// Whether bounds of the distance of the cores suffice.
    #[inline(always)]
    fn is_met(&self, lower: f64, upper: f64, slack: f64) -> bool {
        let width = upper - lower;
        width <= self.tolerance * (lower - self.more)
            || width <= 2.5 * slack
            || lower > self.limit
            || upper <= self.less
    }

    /// The bounds of the shapes from those of the cores, A's closest point, and the vector from B's to it, which has
    /// this length.
    #[inline(always)]
    fn bounds(&self, lower: f64, upper: f64, a: &Point, between: &Point, length: f64) -> Bounds {
        let (wide, narrow) = (1.0 + 2.0 * f64::EPSILON, 1.0 - 2.0 * f64::EPSILON);
        let meets = upper <= self.less;
        let upper = if meets { 0.0 } else { (upper - self.less) * wide };
        let lower = lower - self.more;
        let lower = if lower > 0.0 { lower * narrow } else { 0.0 };
        // Shapes that meet have the point in common that divides the vector by their radii.
        let whole = if meets { self.radii[0] + self.radii[1] } else { length };
        let unit = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        let (s, t) = (self.radii[0] * unit, self.radii[1] * unit);
        let b = difference(a, between);
        Bounds { lower, upper, a: each(|k| a[k] - s * between[k]), b: each(|k| b[k] + t * between[k]) }
    }

    /// The bounds of a length with this error, or `None` if it is too large.
    #[inline(always)]
    fn bounds_of_length(&self, a: &Point, between: &Point, length: f64, slack: f64) -> Option<Bounds> {
        let (lower, upper) = (length - slack, length + slack);
        // Of cores that touch, up to the slack, only a search tells whether they do.
        (lower > 0.0 || upper <= self.less).then(|| self.bounds(lower, upper, a, between, length))
    }
}

/// Two points. Three differences, three squares, two sums and a root are wrong by at most 4u of the result: differences
/// are multiples of 2^-302 below 2^304, whose squares neither underflow nor overflow.
#[inline(always)]
fn points(p: &Point, q: &Point, goal: &Goal) -> Bounds {
    let between = difference(p, q);
    let length = libm::sqrt(dot(&between, &between));
    let slack = length * (4.0 * f64::EPSILON);
    goal.bounds(length - slack, length + slack, p, &between, length)
}

/// A point and a segment.
///
/// The differences are exact up to u of each coordinate: 2u S. The parameter is wrong by 8u of `|w| / |edge|`, which
/// moves the point of the segment by 8u S; its other errors, those of the difference and of the norm, are at most
/// 3 + 1 + 3 roundings of S. So 21u S bound all. A parameter that is off makes the computed length greater, not less,
/// but for those errors.
#[inline(always)]
fn point_and_segment(p: &Point, [q, r]: &[Point; 2], goal: &Goal) -> Option<Bounds> {
    let (w, edge) = (difference(p, q), difference(r, q));
    let (along, square, far) = (dot(&w, &edge), dot(&edge, &edge), dot(&w, &w));
    // Not a number for a segment that is a point.
    let t = along / square;
    let t = if t > 0.0 { if t < 1.0 { t } else { 1.0 } } else { 0.0 };
    let between: Point = each(|k| w[k] - t * edge[k]);
    let length = libm::sqrt(dot(&between, &between));
    // The root of twice the sum of two squares is at least the sum.
    let slack = 12.0 * f64::EPSILON * libm::sqrt(2.0 * (far + square));
    goal.bounds_of_length(p, &between, length, slack)
}

/// A point and a cylinder: both distances, along the axis and from it, are known.
///
/// The vector to the point and `along` times the axis are wrong by 8u S, the vector across by 11u S and its norm by
/// 14u S. The distance depends on the two excesses by at most their errors, 18u S together; its vector and norm add 9u S.
#[inline(always)]
fn point_and_cylinder(p: &Point, centre: &Point, half: &Point, radius: f64, goal: &Goal) -> Option<Bounds> {
    let w = difference(p, centre);
    let (far, square) = (dot(&w, &w), dot(half, half));
    let size = (far + square) + radius * radius;
    if !(COMFORTABLE.contains(&size) && square > size * power_of_two(-200)) {
        return None;
    }
    let along = dot(&w, half) / square;
    let across: Point = each(|k| w[k] - along * half[k]);
    let out = libm::sqrt(dot(&across, &across));
    let excess = if along > 1.0 {
        along - 1.0
    } else if along < -1.0 {
        along + 1.0
    } else {
        0.0
    };
    let share = if out > radius { (out - radius) / out } else { 0.0 };
    let between: Point = each(|k| excess * half[k] + share * across[k]);
    let length = libm::sqrt(dot(&between, &between));
    let slack = ROUND_SLACK * libm::sqrt(3.0 * size);
    goal.bounds_of_length(p, &between, length, slack)
}

/// The slack of a point and a cylinder, relative to S; of a point and a cone it is twice that.
const ROUND_SLACK: f64 = 16.0 * f64::EPSILON;

/// A point and a cone, in the half plane through its axis and the point. The distance depends on the two coordinates
/// there by at most their errors, 18u S as for a cylinder, and on the height by its error, 3u S. The parameter of the
/// closest point of the side is wrong by 10u of S and the length of the side; differences and norms add 9u S.
#[inline(always)]
fn point_and_cone(p: &Point, base: &Point, axis: &Point, radius: f64, goal: &Goal) -> Option<Bounds> {
    let w = difference(p, base);
    let (far, square) = (dot(&w, &w), dot(axis, axis));
    let size = (far + square) + radius * radius;
    if !(COMFORTABLE.contains(&size) && square > size * power_of_two(-200)) {
        return None;
    }
    let along = dot(&w, axis) / square;
    let across: Point = each(|k| w[k] - along * axis[k]);
    let out_square = dot(&across, &across);
    let (out, height) = (libm::sqrt(out_square), libm::sqrt(square));
    let up = along * height;
    let beyond = out - radius;
    // The closest point of the side, from the rim to the tip. Multiples of the two vectors to the point.
    let side = square + radius * radius;
    let t = (height * up - radius * beyond) / side;
    let t = if t > 0.0 { if t < 1.0 { t } else { 1.0 } } else { 0.0 };
    let (dx, dy) = if up < 0.0 {
        (if beyond > 0.0 { beyond } else { 0.0 }, up)
    } else if height * beyond + radius * up <= 0.0 {
        (0.0, 0.0)
    } else {
        (beyond + t * radius, up - t * height)
    };
    let length = libm::sqrt(dx * dx + dy * dy);
    let (x, y) = (if out > 0.0 { dx / out } else { 0.0 }, dy / height);
    let between: Point = each(|k| x * across[k] + y * axis[k]);
    let slack = 2.0 * ROUND_SLACK * libm::sqrt(3.0 * size);
    goal.bounds_of_length(p, &between, length, slack)
}

#[inline(never)]
fn segment_and_cuboid(s: &[Point; 2], centre: &Point, half: &[Point; 3], goal: &Goal) -> Option<Bounds> {
    let g = half_of(s);
    blocks(&Block { origin: &s[0], half: &g }, &Block { origin: centre, half }, goal)
}

#[inline(always)]
fn half_of([p, q]: &[Point; 2]) -> [Point; 1] {
    [each(|k| 0.5 * (q[k] - p[k]))]
}

/// All sums of a centre and multiples of `half` by -1 to 1: a point, a segment, or a cuboid.
struct Block<'s, const N: usize> {
    /// The centre, or the end of a segment from which its half edge leads there.
    origin: &'s Point,
    half: &'s [Point; N],
}

impl<const N: usize> Block<'_, N> {
    /// From the origin to the point with these coordinates.
    #[inline(always)]
    fn point(&self, x: &[f64; N]) -> Point {
        let mut p = if N == 1 { self.half[0] } else { [0.0; 3] };
        for i in 0..N {
            p = each(|k| p[k] + x[i] * self.half[i][k]);
        }
        p
    }

    /// The greatest product of a point, from the centre, with d.
    #[inline(always)]
    fn reach(&self, d: &Point) -> f64 {
        let mut sum = 0.0;
        for i in 0..N {
            sum += dot(&self.half[i], d).abs();
        }
        sum
    }

    /// Whether a ball of this radius about the point with these coordinates is certainly inside. The angles between the
    /// half edges of a cuboid are right ones within 1e-4, so its faces are nearer than its half edges are long by a
    /// factor of 1 - 4e-4 at most.
    #[inline(always)]
    fn has_ball(&self, x: &[f64; N], squares: &[f64; N], radius: f64) -> bool {
        let mut is_inside = N == 3;
        for i in 0..N {
            let room = 0.999 * (1.0 - x[i].abs());
            is_inside &= room * room * squares[i] > radius * radius;
        }
        is_inside
    }
}

/// Between `-most` and `most`.
#[inline(always)]
fn clamped(x: f64, most: f64) -> f64 {
    let x = if x > -most { x } else { -most };
    if x < most { x } else { most }
}

#[inline(always)]
fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// Two blocks, by their coordinates x and y.
///
/// Each round projects A's point to B and B's to A, up to rounding and the angles of the edges. Where both have a free
/// coordinate, a Newton step then minimises over the free coordinates of B, while A's point follows. Two cuboids start
/// from the features along the axis with the widest gap: where this gap is their distance, which it is unless a corner
/// or edge is nearest to an edge or a corner, they are the closest.
///
/// **Error.** The half edge of a segment is wrong by u of itself, its centre by as much, and `between` by three more
/// roundings of parts of S: 5u S. A point adds at most 5 roundings of each product, 9u S since the half edges together
/// are at most sqrt(3) times as long as a diagonal. With 3u for the norm that makes 17u S for an upper bound. For a
/// lower one, seven products with a vector d are wrong by 3u and summed by six additions: 9u sqrt(3) S, and the quotient
/// by |d| is wrong by 3u: 6u S. These and the 5u S of `between` are less than 27u S.
///
/// S is at most the root of three times the sum of the squares of its parts.
#[inline(always)]
fn blocks<const N: usize, const M: usize>(a: &Block<'_, N>, b: &Block<'_, M>, goal: &Goal) -> Option<Bounds> {
    const SLACK: f64 = 32.0 * 0.5 * f64::EPSILON;
    let mut t = difference(a.origin, b.origin);
    if N == 1 {
        t = each(|k| t[k] + a.half[0][k]);
    }
    if M == 1 {
        t = each(|k| t[k] - b.half[0][k]);
    }
    let squares_a: [f64; N] = core::array::from_fn(|i| dot(&a.half[i], &a.half[i]));
    let squares_b: [f64; M] = core::array::from_fn(|j| dot(&b.half[j], &b.half[j]));
    let mut total = dot(&t, &t);
    for i in 0..N {
        total += squares_a[i];
    }
    for j in 0..M {
        total += squares_b[j];
    }
    if !COMFORTABLE.contains(&total) {
        return None;
    }
    let slack = SLACK * libm::sqrt(3.0 * total);
    let inverse_a = squares_a.map(inverse);
    let inverse_b = squares_b.map(inverse);
    let of_t_a: [f64; N] = core::array::from_fn(|i| dot(&a.half[i], &t));
    let of_t_b: [f64; M] = core::array::from_fn(|j| dot(&b.half[j], &t));
    let mixed: [[f64; M]; N] =
        core::array::from_fn(|i| core::array::from_fn(|j| dot(&a.half[i], &b.half[j])));

    // A's nearest point to the centre of B, and unclamped coordinates of the nearest points.
    let mut y = [0.0; M];
    let mut p: [f64; N] = core::array::from_fn(|i| -of_t_a[i] * inverse_a[i]);
    let mut x = p.map(|p| clamped(p, 1.0));
    // Points that are not near the boundary show that cores meet.
    let (mut most, mut is_apart) = (1.0, false);
    let origins = difference(a.origin, b.origin);
    if N == 3 && M == 3 {
        match widest(&squares_a, &squares_b, &of_t_a, &of_t_b, &mixed) {
            Axis::None => most = 1.0 - SHRINK,
            Axis::A(i) => {
                let sign = 1.0_f64.copysign(of_t_a[i]);
                y = core::array::from_fn(|j| sign.copysign(sign * mixed[i][j]));
                x = core::array::from_fn(|i| {
                    let mut q = -of_t_a[i];
                    for j in 0..M {
                        q += mixed[i][j] * y[j];
                    }
                    clamped(q * inverse_a[i], most)
                });
            }
            Axis::B(j) => {
                let sign = 1.0_f64.copysign(of_t_b[j]);
                x = core::array::from_fn(|i| 1.0_f64.copysign(-sign * mixed[i][j]));
                y = core::array::from_fn(|j| {
                    let mut q = of_t_b[j];
                    for i in 0..N {
                        q += mixed[i][j] * x[i];
                    }
                    clamped(q * inverse_b[j], most)
                });
            }
            Axis::Edges(i, j) => {
                let normal = cross(&a.half[i], &b.half[j]);
                let sign = 1.0_f64.copysign(dot(&normal, &t));
                x = core::array::from_fn(|i| 1.0_f64.copysign(-sign * dot(&normal, &a.half[i])));
                y = core::array::from_fn(|j| 1.0_f64.copysign(sign * dot(&normal, &b.half[j])));
                (x[i], y[j]) = (0.0, 0.0);
                let (mut of_a, mut of_b) = (-of_t_a[i], of_t_b[j]);
                for k in 0..3 {
                    of_a += mixed[i][k] * y[k];
                    of_b += mixed[k][j] * x[k];
                }
                let share = mixed[i][j] * inverse_a[i];
                y[j] = clamped((of_b + share * of_a) / (squares_b[j] - share * mixed[i][j]), most);
                x[i] = clamped((of_a + mixed[i][j] * y[j]) * inverse_a[i], most);
                y[j] = clamped((of_b + mixed[i][j] * x[i]) * inverse_b[j], most);
            }
        }
    }
    for round in 0..ROUNDS {
        let is_start = N == 3 && M == 3 && round == 0;
        for _ in 0..if is_start {
            0
        } else if round == 0 {
            2
        } else {
            1
        } {
            for j in 0..M {
                let mut q = of_t_b[j];
                for i in 0..N {
                    q += mixed[i][j] * x[i];
                }
                y[j] = clamped(q * inverse_b[j], most);
            }
            for i in 0..N {
                let mut q = -of_t_a[i];
                for j in 0..M {
                    q += mixed[i][j] * y[j];
                }
                p[i] = q * inverse_a[i];
                x[i] = clamped(p[i], most);
            }
            if N == 0 {
                break;
            }
        }
        if !is_start && x.iter().any(|x| x.abs() < most) && y.iter().any(|y| y.abs() < most) {
            let (mut h, mut s) = ([[0.0; M]; M], [0.0; M]);
            for j in 0..M {
                let mut slope = of_t_b[j] - squares_b[j] * y[j];
                for i in 0..N {
                    slope += mixed[i][j] * x[i];
                }
                let is_free = y[j].abs() < most || slope * y[j] < 0.0;
                if !is_free {
                    continue;
                }
                s[j] = slope;
                h[j][j] = squares_b[j];
                for i in 0..N {
                    let share = if p[i].abs() < most { mixed[i][j] * inverse_a[i] } else { 0.0 };
                    for k in 0..=j {
                        h[j][k] -= share * mixed[i][k];
                    }
                }
            }
            solve(&mut h, &mut s, &squares_b);
            for j in 0..M {
                y[j] = clamped(y[j] + s[j], most);
            }
            for i in 0..N {
                let mut q = -of_t_a[i];
                for j in 0..M {
                    q += mixed[i][j] * y[j];
                }
                p[i] = q * inverse_a[i];
                x[i] = clamped(p[i], most);
            }
        }
        let (of_a, of_b) = (a.point(&x), b.point(&y));
        let between: Point = each(|k| origins[k] + (of_a[k] - of_b[k]));
        let at: Point = each(|k| a.origin[k] + of_a[k]);
        let square = dot(&between, &between);
        let length = libm::sqrt(square);
        let upper = length + slack;
        if upper <= goal.less {
            return Some(goal.bounds(0.0, upper, &at, &between, length));
        }
        let gap = |d: &Point, length: f64| (dot(d, &t) - (a.reach(d) + b.reach(d))) / length - slack;
        let lower = if square > f64::MIN_POSITIVE { gap(&between, length) } else { 0.0 };
        if lower <= 0.0 {
            if b.has_ball(&y, &squares_b, upper) {
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if a.has_ball(&x, &squares_a, upper) {
                let at = difference(&at, &between);
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if round > 0 && !is_apart {
                most = 1.0 - SHRINK;
            }
            continue;
        }
        (is_apart, most) = (true, 1.0);
        if goal.is_met(lower, upper, slack) {
            return Some(goal.bounds(lower, upper, &at, &between, length));
        }
        // Of points that are near, their difference does not tell which ways are barred.
        if upper - lower < 1e-3 * upper {
            let d = perpendicular(a, &x, b, &y, &between);
            let square = dot(&d, &d);
            if square > f64::MIN_POSITIVE {
                let lower = gap(&d, libm::sqrt(square));
                if goal.is_met(lower, upper, slack) {
                    return Some(goal.bounds(lower, upper, &at, &between, length));
                }
            }
        }
        if N == 0 {
            return None;
        }
    }
    None
}

/// A vector along d that is perpendicular to edges of which the points are not ends: the cross product of two of them,
/// or d without its part along the only one.
#[inline(always)]
fn perpendicular<const N: usize, const M: usize>(
    a: &Block<'_, N>,
    x: &[f64; N],
    b: &Block<'_, M>,
    y: &[f64; M],
    d: &Point,
) -> Point {
    let (mut edges, mut len) = ([[0.0; 3]; 6], 0);
    let free = x.iter().zip(a.half).chain(y.iter().zip(b.half)).filter(|(x, _)| x.abs() < 1.0);
    for (_, edge) in free {
        edges[len] = *edge;
        len += 1;
    }
    for i in 1..len {
        for j in 0..i {
            let (u, v) = (&edges[i], &edges[j]);
            let normal = cross(u, v);
            if dot(&normal, &normal) > 1e-10 * (dot(u, u) * dot(v, v)) {
                let sign = 1.0_f64.copysign(dot(&normal, d));
                return each(|k| sign * normal[k]);
            }
        }
    }
    if len > 0 { without(d, &edges[0]) } else { *d }
}

/// Solves h s = s for a symmetric h, of which only the lower triangle is used, without unknowns that depend on those
/// before: their pivots are below a small share of `squares`.
#[inline(always)]
fn solve<const M: usize>(h: &mut [[f64; M]; M], s: &mut [f64; M], squares: &[f64; M]) {
    // L of `L D L^T`, and the reciprocals of D.
    let mut pivots = [0.0; M];
    for j in 0..M {
        let mut d = h[j][j];
        for k in 0..j {
            for m in 0..k {
                h[j][k] -= h[j][m] * h[k][m];
            }
            // L D, until the row is complete.
            let l = h[j][k] * pivots[k];
            d -= h[j][k] * l;
            s[j] -= l * s[k];
        }
        for k in 0..j {
            h[j][k] *= pivots[k];
        }
        pivots[j] = if d > 1e-8 * squares[j] { 1.0 / d } else { 0.0 };
    }
    for j in (0..M).rev() {
        s[j] *= pivots[j];
        for k in j + 1..M {
            s[j] -= h[k][j] * s[k];
        }
    }
}

/// The axis of two cuboids along which they are farthest apart.
enum Axis {
    /// They overlap along all.
    None,
    A(usize),
    B(usize),
    Edges(usize, usize),
}

/// The axis with the widest gap, up to rounding and the angles of the edges, of the half edges of two cuboids and the
/// cross products of two of them (Gottschalk, Lin and Manocha 1996).
#[inline(always)]
fn widest<const N: usize, const M: usize>(
    squares_a: &[f64; N],
    squares_b: &[f64; M],
    of_t_a: &[f64; N],
    of_t_b: &[f64; M],
    mixed: &[[f64; M]; N],
) -> Axis {
    let (a, b) = (squares_a.map(libm::sqrt), squares_b.map(libm::sqrt));
    let (inverse_a, inverse_b) = (a.map(inverse), b.map(inverse));
    let cosines: [[f64; M]; N] =
        core::array::from_fn(|i| core::array::from_fn(|j| mixed[i][j] * (inverse_a[i] * inverse_b[j])));
    let (mut best, mut axis) = (0.0, Axis::None);
    for i in 0..N {
        let mut gap = of_t_a[i].abs() * inverse_a[i] - a[i];
        for j in 0..M {
            gap -= b[j] * cosines[i][j].abs();
        }
        if gap > best {
            (best, axis) = (gap, Axis::A(i));
        }
    }
    for j in 0..M {
        let mut gap = of_t_b[j].abs() * inverse_b[j] - b[j];
        for i in 0..N {
            gap -= a[i] * cosines[i][j].abs();
        }
        if gap > best {
            (best, axis) = (gap, Axis::B(j));
        }
    }
    let mut best = best * best;
    for i in 0..N {
        let (k, l) = ((i + 1) % N, (i + 2) % N);
        let (near, far) = (of_t_a[k] * inverse_a[k], of_t_a[l] * inverse_a[l]);
        for j in 0..M {
            let (m, n) = ((j + 1) % M, (j + 2) % M);
            let (u, v) = (cosines[k][j], cosines[l][j]);
            let reach_a = a[k] * v.abs() + a[l] * u.abs();
            let reach_b = b[m] * cosines[i][n].abs() + b[n] * cosines[i][m].abs();
            let gap = (far * u - near * v).abs() - (reach_a + reach_b);
            let square = 1.0 - cosines[i][j] * cosines[i][j];
            // Edges that are about parallel have no axis.
            if gap > 0.0 && square > 1e-6 && gap * gap > best * square {
                (best, axis) = (gap * gap / square, Axis::Edges(i, j));
            }
        }
    }
    axis
}
