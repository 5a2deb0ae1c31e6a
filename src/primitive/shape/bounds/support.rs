//! Cores relative to their centres, and their support points.
//!
//! [`ROUNDINGS`] has the error analysis that all bounds of [`super::bounds`] and [`super::depth`] rely on.

use crate::primitive::shape::core::Core;
use crate::range::Point;
use crate::vector::{difference, dot, length, sqrt};

/// A pair's `slack` is this many unit roundoffs of its `size` ([`Operands`]). With u = 2^-53, S the size, and a factor
/// 1 + 2^-40 for terms of second order:
///
/// * **Places.** `between` is `(origin - origin) + (shift - shift)`. A shift is within 2u S of the exact one, so each
///   of its coordinates has an error of at most 2u (|t| + S), and all three together of at most 6u S.
/// * **Bodies.** Half edges and axes are given numbers or half of them. A triangle's corners relative to its centroid
///   have an error of at most 3u per coordinate, 6u S together. For a disc, an axis of unit length has an error of at
///   most 4u. The two vectors of its frame, linear in the axis except for products of numbers below 1, have an error
///   of at most 12u. So a disc is within 16u S of the exact one.
/// * **Points.** A computed support point is a sum of at most four such vectors with coefficients of at most 1, off by
///   at most 4u: 6u S. The coefficients of convex combinations of points are normalised to 2u. So a difference of
///   computed points is within 6 + 16 + 12 + 4 = 38u S of one of the exact cores. This is what an upper bound needs.
/// * **Choices.** A support point is chosen by products with d, each wrong by at most 3u |d||x|: the product of the
///   chosen point is at most 12u |d| S below the largest one. (On a rim, an error e of the products with the two
///   vectors costs at most 2 e: the chosen unit vector c maximises `c . (g + e)`, and `c . g >= |g + e| - |e|`.)
/// * **Products.** `d . w` of the chosen point is off by at most 3u |d| S, its quotient by the length of d by 4u of
///   itself.
///
/// The last two add 19u S to the 38u S for a lower bound. The rest covers the norms and the additions of the slack
/// itself.
const ROUNDINGS: f64 = 64.0;

/// A core relative to its centre, which is `origin + shift`.
#[derive(Copy, Clone, Debug)]
pub(super) struct Operand {
    origin: Point,
    shift: Point,
    pub(super) form: Form,
    /// No point is farther from the centre.
    pub(super) reach: f64,
}

/// The kinds of cores, relative to the centre.
#[derive(Copy, Clone, Debug)]
pub(super) enum Form {
    Point,
    /// From the middle to one end.
    Segment(Point),
    /// From the centroid to the corners.
    Triangle([Point; 3]),
    /// The half edges.
    Cuboid([Point; 3]),
    /// The half axis; and two perpendicular radii of a disc.
    Cylinder(Point, [Point; 2]),
    /// From the middle of the axis to the tip; and two perpendicular radii of the disc.
    Cone(Point, [Point; 2]),
}

/// Two bodies.
#[derive(Copy, Clone, Debug)]
pub(super) struct Operands {
    pub(super) a: Operand,
    pub(super) b: Operand,
    /// From the centre of B to that of A.
    pub(super) between: Point,
    /// At least the length of `between` and the reaches together.
    pub(super) size: f64,
    /// Bounds the rounding errors of a distance ([`ROUNDINGS`]).
    pub(super) slack: f64,
}

impl Operand {
    /// All numbers are multiplied by `scale`, a power of two. `None` for a half-space.
    #[inline(always)]
    pub(super) fn of(core: &Core, scale: f64) -> Option<Self> {
        let scaled = |p: &Point| each(|k| p[k] * scale);
        let body = match core {
            Core::Point(p) => Self { origin: scaled(p), shift: [0.0; 3], form: Form::Point, reach: 0.0 },
            Core::Segment([p, q]) => {
                let half = each(|k| 0.5 * (q[k] - p[k]) * scale);
                Self { origin: scaled(p), shift: half, form: Form::Segment(half), reach: length(&half) }
            }
            Core::Triangle([p, q, r]) => {
                let (u, v) = (scaled(&difference(q, p)), scaled(&difference(r, p)));
                let shift = each(|k| (u[k] + v[k]) * (1.0 / 3.0));
                let corners = [each(|k| -shift[k]), difference(&u, &shift), difference(&v, &shift)];
                let reach = length(&corners[0]).max(length(&corners[1])).max(length(&corners[2]));
                Self { origin: scaled(p), shift, form: Form::Triangle(corners), reach }
            }
            Core::Cuboid { centre, half } => {
                let half = [scaled(&half[0]), scaled(&half[1]), scaled(&half[2])];
                let squares = (dot(&half[0], &half[0]) + dot(&half[1], &half[1])) + dot(&half[2], &half[2]);
                // The factor covers half edges that are not quite perpendicular, which make the diagonal longer.
                let reach = 1.001 * sqrt(squares);
                Self { origin: scaled(centre), shift: [0.0; 3], form: Form::Cuboid(half), reach }
            }
            Core::Cylinder { centre, half_axis, radius } => {
                let (half, radius) = (scaled(half_axis), radius * scale);
                let form = Form::Cylinder(half, radii(half_axis, radius));
                Self { origin: scaled(centre), shift: [0.0; 3], form, reach: length(&half) + radius }
            }
            Core::Cone { base, axis, radius } => {
                let (half, radius) = (each(|k| 0.5 * axis[k] * scale), radius * scale);
                let form = Form::Cone(half, radii(axis, radius));
                Self { origin: scaled(base), shift: half, form, reach: length(&half) + radius }
            }
            Core::HalfSpace { .. } => return None,
        };
        Some(body)
    }

    /// The least of `normal . p - offset`, an upper bound of its error, and the point p, relative to the centre. The
    /// components of the normal are at most 2, and the error is that of a pair whose size includes the distance of the
    /// plane.
    pub(super) fn above(&self, normal: &Point, offset: f64) -> (f64, f64, Point) {
        let lowest = self.support(&each(|k| -normal[k]));
        let local: Point = each(|k| self.shift[k] + lowest[k]);
        let height = (dot(normal, &self.origin) - offset) + dot(normal, &local);
        let size = (length(&self.origin) + self.reach) * length(normal) + offset.abs();
        (height, ROUNDINGS * 0.5 * f64::EPSILON * size, lowest)
    }

    /// Bounds the coordinates of all points, and the numbers that they are computed from.
    pub(super) fn extent(&self) -> f64 {
        length(&self.origin) + length(&self.shift) + self.reach
    }

    /// Converts a point relative to the centre to the frame of the shapes.
    #[inline(always)]
    pub(super) fn placed(&self, p: &Point) -> Point {
        each(|k| self.origin[k] + (self.shift[k] + p[k]))
    }

    /// The point farthest along d, relative to the centre.
    #[inline(always)]
    pub(super) fn support(&self, d: &Point) -> Point {
        match &self.form {
            Form::Point => [0.0; 3],
            Form::Segment(half) => {
                let sign = 1.0_f64.copysign(dot(d, half));
                each(|k| sign * half[k])
            }
            Form::Triangle([p, q, r]) => {
                let (x, y, z) = (dot(d, p), dot(d, q), dot(d, r));
                if x >= y && x >= z {
                    *p
                } else if y >= z {
                    *q
                } else {
                    *r
                }
            }
            Form::Cuboid([x, y, z]) => {
                let i = 1.0_f64.copysign(dot(d, x));
                let j = 1.0_f64.copysign(dot(d, y));
                let k = 1.0_f64.copysign(dot(d, z));
                [
                    (i * x[0] + j * y[0]) + k * z[0],
                    (i * x[1] + j * y[1]) + k * z[1],
                    (i * x[2] + j * y[2]) + k * z[2],
                ]
            }
            Form::Cylinder(half, disc) => {
                let sign = 1.0_f64.copysign(dot(d, half));
                let (rim, _) = on_rim(disc, d);
                each(|k| sign * half[k] + rim[k])
            }
            Form::Cone(half, disc) => {
                let (rim, out) = on_rim(disc, d);
                if 2.0 * dot(d, half) > out { *half } else { each(|k| rim[k] - half[k]) }
            }
        }
    }
}

impl Operands {
    /// `None` if one is a half-space.
    #[inline(always)]
    pub(super) fn of(a: &Core, b: &Core, scale: f64) -> Option<Self> {
        let (a, b) = (Operand::of(a, scale)?, Operand::of(b, scale)?);
        let between: Point = each(|k| (a.origin[k] - b.origin[k]) + (a.shift[k] - b.shift[k]));
        let size = length(&between) + (a.reach + b.reach);
        Some(Self { a, b, between, size, slack: ROUNDINGS * 0.5 * f64::EPSILON * size })
    }

    /// The point of A - B that is farthest along -d, and its point of A, relative to A's centre.
    #[inline(always)]
    pub(super) fn support(&self, d: &Point) -> (Point, Point) {
        let a = self.a.support(&each(|k| -d[k]));
        let b = self.b.support(d);
        (each(|k| self.between[k] + (a[k] - b[k])), a)
    }
}

/// A vector by its coordinates. (`map` of an array is not always inlined.)
#[inline(always)]
pub(super) fn each(f: impl Fn(usize) -> f64) -> Point {
    [f(0), f(1), f(2)]
}

/// The point of a disc's rim that is farthest along d, relative to the middle of the disc, and its dot product with d.
/// The middle itself if d is perpendicular to the disc.
#[inline(always)]
fn on_rim([u, v]: &[Point; 2], d: &Point) -> (Point, f64) {
    let (x, y) = (dot(d, u), dot(d, v));
    let out = sqrt(x * x + y * y);
    let inverse = if out > 0.0 { 1.0 / out } else { 0.0 };
    let (x, y) = (x * inverse, y * inverse);
    (each(|k| x * u[k] + y * v[k]), out)
}

/// Two vectors of this length that are perpendicular to an axis and to each other (Duff et al. 2017, "Building an
/// orthonormal basis, revisited").
#[inline(always)]
fn radii(axis: &Point, radius: f64) -> [Point; 2] {
    let length = length(axis);
    // A rotation can flush an axis of less than twice the smallest coordinate to zero; then any direction will do,
    // such as z.
    let [x, y, z] = if length > 0.0 { each(|k| axis[k] / length) } else { [0.0, 0.0, 1.0] };
    let sign = 1.0_f64.copysign(z);
    let p = -1.0 / (sign + z);
    let q = x * y * p;
    let (u, v) = ([1.0 + sign * x * x * p, sign * q, -sign * x], [q, sign + y * y * p, -y]);
    [each(|k| radius * u[k]), each(|k| radius * v[k])]
}
