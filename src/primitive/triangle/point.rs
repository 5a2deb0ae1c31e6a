//! The distance of a point from a triangle: certain bounds in `f64`, and an exact comparison of its square.
//!
//! The bounds hold for the reasons given in [`super::distance`]: any point of the triangle gives an upper bound, any
//! axis a lower one, and only their evaluation has an error.

use super::distance::{COMFORTABLE, ROUNDINGS, SHORT, unit_scale};
use super::features::{Corners, Vector, along, clamped, greatest, least};
use super::sides::{Triangle, UNIT_ROUNDOFF};
use crate::exact::wide::{Wide, unit_of};
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

/// The point of a triangle nearest to a given point, and bounds of the distance.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Foot {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// The vector from the given point to it, times `scale`.
    pub(crate) way: Point,
    /// A power of two.
    pub(crate) scale: f64,
}

impl Foot {
    /// For coordinates within the [range](super#range).
    #[inline(always)]
    pub(crate) fn of(c: &Point, [p, q, r]: &Triangle) -> Self {
        let far = |d: &Point| greatest(greatest(d[0].abs(), d[1].abs()), d[2].abs());
        let corners = [difference(p, c), difference(q, c), difference(r, c)];
        let size = greatest(greatest(far(&corners[0]), far(&corners[1])), far(&corners[2]));
        let scale = if COMFORTABLE.contains(&size) || size == 0.0 { 1.0 } else { unit_scale(size) };
        let scaled = |[x, y, z]: Point| [x * scale, y * scale, z * scale];
        let corners = [scaled(corners[0]), scaled(corners[1]), scaled(corners[2])];
        let (way, axis) = nearest(&corners);
        let slack = ROUNDINGS * UNIT_ROUNDOFF * (size * scale);
        let (wide, narrow) = (1.0 + 4.0 * f64::EPSILON, 1.0 - 4.0 * f64::EPSILON);
        let upper = (sqrt(dot(&way, &way)) + slack) * wide / scale;
        let length = sqrt(dot(&axis, &axis));
        let [x, y, z] = [dot(&axis, &corners[0]), dot(&axis, &corners[1]), dot(&axis, &corners[2])];
        let gap = greatest(least(least(x, y), z), -greatest(greatest(x, y), z));
        let lower = if length > SHORT { (gap / length - slack) * narrow / scale } else { 0.0 };
        Self { lower: greatest(lower, 0.0), upper, way, scale }
    }
}

/// The point of a triangle nearest to the origin, and an axis. If the point is the nearest, the triangle's projection
/// on the axis is as far from the origin as the triangle.
#[inline(always)]
fn nearest(corners: &Corners<f64>) -> (Vector<f64>, Vector<f64>) {
    let [p, q, r] = corners;
    let (u, v) = (difference(q, p), difference(r, p));
    let normal = cross(&u, &v);
    // NaN or infinite for a triangle without area, so the point is not in the face.
    let inverse = -1.0 / dot(&normal, &normal);
    let s = dot(p, &cross(&v, &normal)) * inverse;
    let t = dot(p, &cross(&normal, &u)) * inverse;
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return (along(&along(p, s, &u), t, &v), normal);
    }
    let (mut best, mut square) = ([0.0; 3], f64::INFINITY);
    for i in 0..3 {
        let (from, to) = (&corners[i], &corners[(i + 1) % 3]);
        let u = difference(to, from);
        // Coincident corners give NaN, and so an end of the edge.
        let s = clamped(-dot(&u, from) / dot(&u, &u));
        let point = if s < 1.0 { along(from, s, &u) } else { *to };
        let of_point = dot(&point, &point);
        if of_point < square {
            (best, square) = (point, of_point);
        }
    }
    (best, best)
}

/// Differences of coordinates are multiples of 2^-302 below 2^303, and sums of radii are below 2^305: they have 607
/// bits. The comparison of a height with a radius is of degree six, and has 3644.
type Length = Wide<10>;
type Second = Wide<20>;
type Third = Wide<30>;
type Fourth = Wide<40>;
type Sixth = Wide<60>;

/// The squared distance of a point from a triangle minus the square of the sum of two numbers. Its sign is exact, and
/// its value is accurate to 2^-50. Both numbers must be zero or positive numbers in the range of coordinates.
#[cold]
#[inline(never)]
pub(crate) fn excess(c: &Point, t: &Triangle, reach: [f64; 2]) -> f64 {
    let unit = unit_of(t.as_flattened().iter().chain(c).chain(&reach).copied());
    let number = |x: f64| Length::new(x, unit);
    // Recomputed at each use, so that few of them are on the stack at once.
    let corner = |i: usize| move |k: usize| number(t[i % 3][k]).minus(&number(c[k]));
    let edge = |i: usize| move |k: usize| number(t[(i + 1) % 3][k]).minus(&number(t[i][k]));
    let sum = number(reach[0]).plus(&number(reach[1]));
    let square: Second = sum.times(&sum);
    // Each candidate is the squared distance of some point of the triangle, and one of them that of the nearest.
    let mut least = f64::INFINITY;
    for i in 0..3 {
        let over = product::<10, 10, 20>(corner(i), corner(i)).minus(&square);
        least = least.min(over.over(&Length::new(1.0, 0), 2 * unit));
        let length: Second = product(edge(i), edge(i));
        let back: Second = product(edge(i), corner(i));
        if back.sign() < 0 && length.plus(&back).sign() > 0 {
            let over: Fourth = over.times(&length);
            least = least.min(over.minus(&back.times(&back)).over(&length, 2 * unit));
        }
    }
    let normal = [0, 1, 2].map(|k| minor(edge(0), edge(1), k));
    let length: Fourth = product(|k| normal[k], |k| normal[k]);
    let is_over = |i: usize| {
        let inside: Fourth = product(|k| normal[k], |k| minor(corner(i), corner(i + 1), k));
        inside.sign() >= 0
    };
    if length.sign() > 0 && is_over(0) && is_over(1) && is_over(2) {
        let height: Third = product(|k| normal[k], corner(0));
        let over: Sixth = height.times(&height);
        least = least.min(over.minus(&square.times(&length)).over(&length, 2 * unit));
    }
    least
}

#[inline(never)]
fn product<const M: usize, const N: usize, const R: usize>(
    u: impl Fn(usize) -> Wide<M>,
    v: impl Fn(usize) -> Wide<N>,
) -> Wide<R> {
    (0..3).fold(Wide::ZERO, |sum: Wide<R>, k| sum.plus(&u(k).times(&v(k))))
}

/// Coordinate `k` of the cross product.
#[inline(never)]
fn minor(u: impl Fn(usize) -> Length, v: impl Fn(usize) -> Length, k: usize) -> Second {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let product: Second = u(i).times(&v(j));
    product.minus(&u(j).times(&v(i)))
}
