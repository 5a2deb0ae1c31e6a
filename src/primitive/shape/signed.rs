//! The signed separation of two convex sets: shapes and hulls of points.

use super::bounds::depth;
use super::bounds::hulls::{self, ConvexBody, CoreBounds, PosedPoints};
use super::convex::Shape;
use super::pair::separation;
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::range::Point;
use crate::vector::{difference, unit};

/// A convex set: a shape, or the hull of points, such as the corners of a `construct::ConvexHull`.
#[derive(Copy, Clone, Debug)]
pub enum Convex<'p> {
    /// A shape.
    Shape(Shape),
    /// The hull of points, each moved by the pose. They may be in any order, and need not be corners of the hull.
    Hull {
        /// The points. The range of coordinates is that of a body's vertices.
        points: &'p [Point],
        /// Where they are.
        pose: Pose,
    },
}

/// How far two convex sets are apart, or how deep they are in each other.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SignedSeparation {
    /// Lower bound: above 0 only if the two are certainly apart. If they meet, minus the upper bound of the depth.
    pub lower: f64,
    /// Upper bound: below 0 only if the two certainly overlap.
    pub upper: f64,
    /// The unit vector along which A moves away from B, or out of it by the least translation. Zeros if it is unknown.
    pub normal: Point,
    /// The point of A nearest to B, or the one that touches B last when A leaves it along the normal. NaN if there is
    /// none.
    pub a: Point,
    /// The point of B.
    pub b: Point,
}

/// The least relative tolerance.
const TIGHT: f64 = power_of_two(-42);

/// Bounds of the signed separation of two convex sets in one frame: their distance, or minus their depth.
///
/// The bounds differ by at most `tolerance` times the greater of them, or by rounding, about 2^-45 of the coordinates.
/// For round shapes that meet they may be wider: the search ends with 128 faces for two shapes ([`depth`]), and with
/// 512 for hulls. The time is proportional to the number of points of a hull: a distance to 2^-42 takes some 20 passes
/// over all points, a depth up to 256.
///
/// An empty hull is infinitely far from anything, and two half-spaces may overlap infinitely.
///
/// ```
/// use simdop::pose::Pose;
/// use simdop::primitive::Shape;
/// use simdop::primitive::shape::{Convex, signed_separation};
///
/// let tetrahedron = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let hull = Convex::Hull { points: &tetrahedron, pose: Pose::IDENTITY };
/// let up = |z| Pose::from_rows([[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, 0.1], [0.0, 0.0, 1.0, z]]);
/// let cuboid = |z| Ok::<_, Box<dyn std::error::Error>>(Convex::Shape(Shape::cuboid([0.1; 3])?.moved(&up(z)?)));
/// let below = signed_separation(&cuboid(-0.25)?, &hull, 1e-9);
/// assert!((below.upper - 0.2).abs() < 1e-12 && below.normal[2] == -1.0);
/// let inside = signed_separation(&cuboid(-0.03)?, &hull, 1e-9);
/// assert!((inside.lower + 0.02).abs() < 1e-12 && inside.upper - inside.lower < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn signed_separation(a: &Convex<'_>, b: &Convex<'_>, tolerance: f64) -> SignedSeparation {
    let tolerance = if tolerance > TIGHT { tolerance } else { TIGHT };
    let ((body_a, radius_a), (body_b, radius_b)) = (side(a), side(b));
    let found = match (&body_a, &body_b) {
        (ConvexBody::Shape(a), ConvexBody::Shape(b)) => return of_shapes(a, b, tolerance),
        (ConvexBody::Points(points), ConvexBody::Shape(b)) if b.is_half_space() => hulls::above(points, b),
        (ConvexBody::Shape(a), ConvexBody::Points(points)) if a.is_half_space() => hulls::above(points, a)
            .map(|CoreBounds { lower, upper, normal, a, b }| CoreBounds {
                lower,
                upper,
                normal: normal.map(|x| -x),
                a: b,
                b: a,
            }),
        _ => hulls::bounds(&body_a, &body_b, tolerance),
    };
    let Some(CoreBounds { lower, upper, normal, a, b }) = found else {
        let (lower, upper) = (f64::INFINITY, f64::INFINITY);
        return SignedSeparation { lower, upper, normal: [0.0; 3], a: [f64::NAN; 3], b: [f64::NAN; 3] };
    };
    let sum = radius_a + radius_b;
    let (less, more) = (sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON));
    SignedSeparation {
        lower: down(lower - more),
        upper: up(upper - less),
        normal,
        a: core::array::from_fn(|i| a[i] - radius_a * normal[i]),
        b: core::array::from_fn(|i| b[i] + radius_b * normal[i]),
    }
}

/// The set without its radius, and the radius.
fn side<'p>(set: &Convex<'p>) -> (ConvexBody<'p>, f64) {
    match *set {
        Convex::Shape(shape) => (ConvexBody::Shape(shape), shape.radius()),
        Convex::Hull { points, pose } => (ConvexBody::Points(PosedPoints { points, pose }), 0.0),
    }
}

/// Covers the rounding of a difference.
fn up(x: f64) -> f64 {
    x + 2.0 * f64::EPSILON * x.abs()
}

fn down(x: f64) -> f64 {
    -up(-x)
}

fn of_shapes(a: &Shape, b: &Shape, tolerance: f64) -> SignedSeparation {
    let none = [f64::NAN; 3];
    if let Some(near) = separation(a, b, f64::INFINITY, tolerance)
        && near.upper > 0.0
    {
        let normal = unit(&difference(&near.a, &near.b)).unwrap_or_default();
        return SignedSeparation { lower: near.lower, upper: near.upper, normal, a: near.a, b: near.b };
    }
    let found = depth(a, b, tolerance);
    let (lower, upper, normal) = (-found.upper, -found.lower, found.direction);
    let out = normal.map(|x| x * found.upper);
    let touching = if out.iter().all(|x| x.is_finite()) {
        separation(&a.moved(&Pose::IDENTITY.shifted(&out)), b, f64::INFINITY, tolerance)
    } else {
        None
    };
    let (a, b) = touching.map_or((none, none), |touching| (difference(&touching.a, &out), touching.b));
    SignedSeparation { lower, upper, normal, a, b }
}
