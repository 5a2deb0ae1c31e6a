//! Certain bounds of the distance and depth of hulls of points, in pairs with each other and with shapes.
//!
//! As for two shapes, algorithms only propose points and directions, and their evaluation is certain: the algorithm of
//! Gilbert, Johnson and Keerthi for distances, a growing polytope ([`super::polytope`]) for depths.
//!
//! **Rounding.** With S the size of a pair, the sum of all magnitudes that a coordinate is computed from, and u =
//! 2^-53: a moved point is off by at most 4u S, and the rotated direction by which it is chosen by at most 4u |d|. Its
//! product with d is then at most 16u |d| S below the largest one. Points of shapes are those of [`super::support`],
//! whose 38u S and 19u S hold for this larger size, and their sum with the origin adds 3u S. [`ROUNDINGS`] covers the
//! sum of both bodies' errors, the difference, the product with d and its quotient.

use super::gjk::Simplex;
use super::polytope::{self, ConvexDifference};
use super::search::unit_scale;
use super::support::{Operand, each};
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::{MIN_COORDINATE, Point};
use crate::vector::{cross, difference, dot, length, sqrt};

#[cfg(test)]
mod tests;

/// The slack, in units of u times the size.
const ROUNDINGS: f64 = 128.0;
/// Maximum number of steps towards the closest points.
const STEPS: usize = 128;
/// Maximum number of corners of the polytope that grows towards the boundary.
const CORNERS: usize = 256;
const FACES: usize = 512;
/// Initial directions of the search for a tetrahedron around the origin.
const STARTS: [Point; 5] =
    [[0.36, 0.48, 0.81], [-0.6, 0.64, 0.45], [0.47, -0.8, 0.36], [-0.81, -0.36, -0.47], [0.1, 0.2, -0.97]];
/// Relative perturbation of directions.
const ASIDE: f64 = power_of_two(-20);
const COMFORTABLE: core::ops::RangeInclusive<f64> = power_of_two(-100)..=power_of_two(100);

/// The hull of points at a pose.
#[derive(Copy, Clone, Debug)]
pub(in crate::primitive::shape) struct PosedPoints<'p> {
    pub(in crate::primitive::shape) points: &'p [Point],
    pub(in crate::primitive::shape) pose: Pose,
}

impl PosedPoints<'_> {
    /// The point farthest along d.
    fn support(&self, d: &Point) -> Point {
        let r = self.pose.rows();
        let back: Point = each(|i| (r[0][i] * d[0] + r[1][i] * d[1]) + r[2][i] * d[2]);
        let (mut best, mut most) = ([0.0; 3], f64::NEG_INFINITY);
        for p in self.points {
            let along = dot(p, &back);
            if along > most {
                (best, most) = (*p, along);
            }
        }
        self.pose.unflushed(&best)
    }

    fn extent(&self) -> f64 {
        let farthest = self.points.iter().map(length).fold(0.0, f64::max);
        farthest * (1.0 + Pose::TOLERANCE) + length(&self.pose.translation())
    }
}

/// One of the two bodies, without its radius.
#[derive(Copy, Clone, Debug)]
pub(in crate::primitive::shape) enum ConvexBody<'p> {
    Shape(Shape),
    Points(PosedPoints<'p>),
}

#[derive(Copy, Clone, Debug)]
enum PosedConvex<'p> {
    Core(Operand),
    Points(PosedPoints<'p>),
}

/// Two bodies in one frame, and a translation of the first. All lengths are multiplied by a power of two.
#[derive(Copy, Clone, Debug)]
struct Hulls<'p> {
    a: PosedConvex<'p>,
    b: PosedConvex<'p>,
    shift: Point,
    scale: f64,
    size: f64,
    slack: f64,
}

/// Bounds of the distance between two bodies without their radii or, if they overlap, of minus their depth.
#[derive(Copy, Clone, Debug)]
pub(in crate::primitive::shape) struct CoreBounds {
    pub(in crate::primitive::shape) lower: f64,
    pub(in crate::primitive::shape) upper: f64,
    /// The unit vector along which A leaves B.
    pub(in crate::primitive::shape) normal: Point,
    /// The closest points or, if the bodies overlap, those that touch last when A leaves B along the normal; both as
    /// placed before that motion.
    pub(in crate::primitive::shape) a: Point,
    pub(in crate::primitive::shape) b: Point,
}

/// The result of a search for the closest points.
struct Approach {
    lower: f64,
    upper: f64,
    along: Point,
    /// From the point of B to that of A.
    between: Point,
    of_a: Point,
    simplex: Simplex,
    around: Option<[Point; 4]>,
}

impl<'p> PosedConvex<'p> {
    /// `None` for a half-space.
    fn of(body: &ConvexBody<'p>, scale: f64) -> Option<Self> {
        Some(match body {
            ConvexBody::Shape(shape) => Self::Core(Operand::of(shape.core(), scale)?),
            ConvexBody::Points(points) => Self::Points(*points),
        })
    }

    fn support(&self, d: &Point, scale: f64) -> Point {
        match self {
            Self::Core(core) => core.placed(&core.support(d)),
            Self::Points(points) => {
                let p = points.support(d);
                each(|k| p[k] * scale)
            }
        }
    }

    fn extent(&self, scale: f64) -> f64 {
        match self {
            Self::Core(core) => core.extent(),
            Self::Points(points) => points.extent() * scale,
        }
    }
}

impl<'p> Hulls<'p> {
    fn of(a: &ConvexBody<'p>, b: &ConvexBody<'p>, scale: f64) -> Option<Self> {
        let (a, b) = (PosedConvex::of(a, scale)?, PosedConvex::of(b, scale)?);
        let size = a.extent(scale) + b.extent(scale);
        let slack = ROUNDINGS * 0.5 * f64::EPSILON * size + 8.0 * MIN_COORDINATE * scale;
        Some(Self { a, b, shift: [0.0; 3], scale, size, slack })
    }

    /// The point of A - B farthest along -d, and its point of A.
    fn points(&self, d: &Point) -> (Point, Point) {
        let a = self.a.support(&each(|k| -d[k]), self.scale);
        let a: Point = each(|k| a[k] + self.shift[k]);
        let b = self.b.support(d, self.scale);
        (difference(&a, &b), a)
    }

    /// The algorithm of Gilbert, Johnson and Keerthi.
    fn approach(&self, mut d: Point, tolerance: f64) -> Approach {
        let zero = [0.0; 3];
        let mut found = Approach {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            along: zero,
            between: zero,
            of_a: zero,
            simplex: Simplex::new(),
            around: None,
        };
        for _ in 0..STEPS {
            let (point, of_a) = found.raise(self, &d);
            if found.upper - found.lower <= (tolerance * found.lower).max(2.5 * self.slack)
                || found.simplex.has(&point)
            {
                break;
            }
            found.simplex.add(point, of_a);
            let nearest = found.simplex.reduce();
            let upper = length(&nearest.point) + self.slack;
            if upper < found.upper {
                (found.upper, found.between, found.of_a) = (upper, nearest.point, nearest.of_a);
            }
            if nearest.inside {
                if found.simplex.surely_contains_origin(self.slack, self.size) {
                    (found.upper, found.around) = (0.0, Some(found.simplex.points));
                }
                break;
            }
            d = nearest.direction;
        }
        found
    }

    fn search(&self, tolerance: f64) -> Approach {
        let (p, _) = self.points(&[0.0, 0.0, 1.0]);
        let (q, _) = self.points(&[0.0, 0.0, -1.0]);
        let mut found = self.approach(each(|k| 0.5 * (p[k] + q[k])), tolerance);
        for start in STARTS {
            if found.lower > 0.0 || found.around.is_some() {
                break;
            }
            let next = self.approach(start, tolerance);
            found.around = next.around;
            if next.lower > found.lower {
                (found.lower, found.along) = (next.lower, next.along);
            }
            if next.upper < found.upper {
                (found.upper, found.between, found.of_a) = (next.upper, next.between, next.of_a);
            }
        }
        found
    }

    /// Three pairs of corners of A - B, each farthest along a direction across the pairs before. If A - B is symmetric
    /// about the origin, perhaps no tetrahedron of its corners contains the origin, but this octahedron is convex and
    /// does.
    fn octahedron(&self) -> [Point; 6] {
        let along = |d: &Point| self.support(&each(|k| -d[k]));
        let against = |d: &Point| self.support(d);
        // Perturb the direction: among several corners equally far along it, the search might not find opposite ones.
        let aside = |d: &Point, by: &Point| {
            let much = ASIDE * length(d);
            each(|k| d[k] + much * by[k])
        };
        let first = STARTS[0];
        let p = along(&first);
        let least = (0..3).fold(0, |least, k| if p[k].abs() < p[least].abs() { k } else { least });
        let mut axis = [0.0; 3];
        axis[least] = 1.0;
        let second = aside(&cross(&p, &axis), &STARTS[1]);
        let q = along(&second);
        let third = aside(&cross(&p, &q), &STARTS[2]);
        [p, against(&first), q, against(&second), along(&third), against(&third)]
    }

    /// Bounds of the depth of two bodies that are not certainly apart. Stores the direction in `found`.
    fn depth(&self, found: &mut Approach, tolerance: f64) -> (f64, f64) {
        let lower = -found.upper;
        let grown = match &found.around {
            Some(corners) => Some(polytope::depth_around::<CORNERS, FACES>(self, corners, tolerance)),
            None => polytope::depth_of_octahedron::<CORNERS, FACES>(self, &self.octahedron(), tolerance),
        };
        if let Some((below, above, along)) = grown {
            found.raise(self, &along);
            return (lower.max(below), above.min(-found.lower));
        }
        // The difference is flat, or the bodies barely touch: try the perpendiculars of the corners found.
        let (points, len) = (found.simplex.points, found.simplex.len);
        for i in 0..len {
            for j in 0..i {
                let edge = difference(&points[i], &points[j]);
                for k in 0..3 {
                    let mut axis = [0.0; 3];
                    axis[k] = 1.0;
                    found.raise_both(self, &cross(&edge, &axis));
                }
                for other in &points[..j] {
                    found.raise_both(self, &cross(&edge, &difference(other, &points[j])));
                }
            }
        }
        let [p, q, r, s, t, u] = self.octahedron();
        let across = [difference(&p, &q), difference(&r, &s), difference(&t, &u)];
        for k in 0..3 {
            let mut axis = [0.0; 3];
            axis[k] = 1.0;
            found.raise_both(self, &axis);
            found.raise_both(self, &cross(&across[k], &across[(k + 1) % 3]));
        }
        (lower, -found.lower)
    }
}

impl ConvexDifference for Hulls<'_> {
    fn support(&self, d: &Point) -> Point {
        self.points(d).0
    }

    fn slack(&self) -> f64 {
        self.slack
    }
}

impl Approach {
    /// Bounds the distance from below by the gap along d.
    fn raise(&mut self, pair: &Hulls<'_>, d: &Point) -> (Point, Point) {
        let (point, of_a) = pair.points(d);
        let square = dot(d, d);
        if square > f64::MIN_POSITIVE {
            let gap = dot(d, &point) / sqrt(square) - pair.slack;
            if gap > self.lower {
                (self.lower, self.along) = (gap, *d);
            }
        }
        (point, of_a)
    }

    fn raise_both(&mut self, pair: &Hulls<'_>, d: &Point) {
        self.raise(pair, d);
        self.raise(pair, &each(|k| -d[k]));
    }
}

/// Bounds of two bodies without their radii, at least one of them a hull of points; neither is a half-space. `None` if
/// a hull has no points.
pub(in crate::primitive::shape) fn bounds(
    a: &ConvexBody<'_>,
    b: &ConvexBody<'_>,
    tolerance: f64,
) -> Option<CoreBounds> {
    let is_empty =
        |body: &ConvexBody<'_>| matches!(body, ConvexBody::Points(points) if points.points.is_empty());
    if is_empty(a) || is_empty(b) {
        return None;
    }
    let mut pair = Hulls::of(a, b, 1.0)?;
    if !COMFORTABLE.contains(&pair.size) && pair.size > 0.0 {
        pair = Hulls::of(a, b, unit_scale(pair.size))?;
    }
    let mut found = pair.search(tolerance);
    let (mut lower, mut upper) = (found.lower, found.upper);
    let mut shift = [0.0; 3];
    let unit = |v: &Point| {
        let long = length(v);
        if long > 0.0 { v.map(|x| x / long) } else { [0.0, 0.0, 1.0] }
    };
    let normal;
    if lower > 0.0 {
        normal = unit(&found.between);
    } else {
        let (below, above) = pair.depth(&mut found, tolerance);
        (lower, upper) = (-above, -below);
        normal = unit(&found.along);
        // Where they touch when A has left B.
        shift = normal.map(|x| x * above);
        pair.shift = shift;
        let touching = pair.approach(normal, tolerance);
        (found.between, found.of_a) = (touching.between, touching.of_a);
    }
    let back = |x: f64| x / pair.scale;
    Some(CoreBounds {
        lower: back(lower),
        upper: back(upper),
        normal,
        a: each(|k| back(found.of_a[k] - shift[k])),
        b: each(|k| back(found.of_a[k] - found.between[k])),
    })
}

/// Bounds of points and a half-space, the points as A.
pub(in crate::primitive::shape) fn above(points: &PosedPoints<'_>, half_space: &Shape) -> Option<CoreBounds> {
    let Core::HalfSpace { normal, offset } = *half_space.core() else { return None };
    if points.points.is_empty() {
        return None;
    }
    let long = length(&normal);
    let up = normal.map(|x| x / long);
    let lowest = points.support(&up.map(|x| -x));
    let height = (dot(&normal, &lowest) - offset) / long;
    let slack =
        ROUNDINGS * 0.5 * f64::EPSILON * (points.extent() + offset.abs() / long) + 8.0 * MIN_COORDINATE;
    let b = each(|k| lowest[k] - height * up[k]);
    Some(CoreBounds { lower: height - slack, upper: height + slack, normal: up, a: lowest, b })
}
