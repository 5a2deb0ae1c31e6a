//! Half-spaces: their distances and depths are linear.

use super::certified::{Certified, Depth};
use super::support::Operand;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::Point;
use crate::vector::{dot, sqrt};

/// The height of a core, or of the plane of an opposite half-space, above the plane of a half-space; negative below
/// it.
struct Height {
    /// Certain bounds.
    lower: f64,
    upper: f64,
    /// The unit vector out of the half-space.
    up: Point,
    /// The lowest point of the core, and its projection to the plane.
    lowest: Point,
    on_plane: Point,
}

/// Which of two shapes is the half-space; for two half-spaces, whether they are opposite.
enum Case {
    /// The first shape is the half-space.
    First(Height),
    Second(Height),
    /// Half-spaces that are not opposite, and a point of both.
    Meet(Point),
}

/// Bounds of the distance, of shapes of which at least one is a half-space.
#[cold]
pub(super) fn bounds(a: &Shape, b: &Shape) -> Certified {
    let (is_first, height, plane, body) = match case(a, b) {
        Case::First(height) => (true, height, a.radius, b.radius),
        Case::Second(height) => (false, height, b.radius, a.radius),
        Case::Meet(p) => return Certified { lower: 0.0, upper: 0.0, a: p, b: p },
    };
    let [less, more] = sum_of_radii(a, b);
    let meets = height.upper <= less;
    let lower = if height.lower > more { (height.lower - more) * (1.0 - 2.0 * f64::EPSILON) } else { 0.0 };
    let upper = if meets { 0.0 } else { (height.upper - less) * (1.0 + 2.0 * f64::EPSILON) };
    let raised = |p: &Point, by: f64| -> Point { [0, 1, 2].map(|k| p[k] + by * height.up[k]) };
    let lowest = raised(&height.lowest, -body);
    let on_plane = if meets { lowest } else { raised(&height.on_plane, plane) };
    let (a, b) = if is_first { (on_plane, lowest) } else { (lowest, on_plane) };
    Certified { lower, upper, a, b }
}

/// Bounds of the depth, of shapes of which at least one is a half-space.
#[cold]
pub(super) fn depth(a: &Shape, b: &Shape) -> Depth {
    let (sign, height) = match case(a, b) {
        Case::First(height) => (-1.0, height),
        Case::Second(height) => (1.0, height),
        Case::Meet(_) => {
            return Depth { lower: f64::INFINITY, upper: f64::INFINITY, direction: [1.0, 0.0, 0.0] };
        }
    };
    let [less, more] = sum_of_radii(a, b);
    let (wide, narrow) = (1.0 + 2.0 * f64::EPSILON, 1.0 - 2.0 * f64::EPSILON);
    let lower = ((less - height.upper) * narrow).max(0.0);
    let upper = ((more - height.lower) * wide).max(0.0);
    Depth { lower, upper, direction: height.up.map(|x| sign * x) }
}

/// The sum of the radii, rounded down and up.
fn sum_of_radii(a: &Shape, b: &Shape) -> [f64; 2] {
    let sum = a.radius + b.radius;
    [sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON)]
}

fn case(a: &Shape, b: &Shape) -> Case {
    match (&a.core, &b.core) {
        (Core::HalfSpace { normal, offset }, Core::HalfSpace { normal: other, offset: far }) => {
            two(normal, *offset, other, *far)
        }
        (Core::HalfSpace { normal, offset }, body) => Case::First(above(normal, *offset, body)),
        (body, Core::HalfSpace { normal, offset }) => Case::Second(above(normal, *offset, body)),
        _ => Case::Meet([0.0; 3]),
    }
}

fn above(normal: &Point, offset: f64, core: &Core) -> Height {
    let length = sqrt(dot(normal, normal));
    let up = normal.map(|x| x / length);
    let Some(body) = Operand::of(core, 1.0) else {
        return Height { lower: 0.0, upper: 0.0, up, lowest: [0.0; 3], on_plane: [0.0; 3] };
    };
    let (height, error, lowest) = body.above(normal, offset);
    let lowest = body.placed(&lowest);
    let on_plane = [0, 1, 2].map(|k| lowest[k] - height / length * up[k]);
    // Together, the length and the quotient have a relative error of 2^-51, which `error` includes.
    Height { lower: (height - error) / length, upper: (height + error) / length, up, lowest, on_plane }
}

fn two(normal: &Point, offset: f64, other: &Point, far: f64) -> Case {
    let is_parallel = (0..3).all(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        product(normal[i], other[j]) == product(normal[j], other[i])
    });
    let [m, n] = [normal, other].map(|v| sqrt(dot(v, v)));
    let [x, y] = [offset / m, far / n];
    let [u, v] = [normal.map(|x| x / m), other.map(|x| x / n)];
    let cosine = dot(&u, &v);
    if is_parallel && cosine < 0.0 {
        let error = 16.0 * f64::EPSILON * (x.abs() + y.abs());
        let height = -(x + y);
        let on_plane = u.map(|c| c * x);
        let lowest = v.map(|c| c * y);
        return Case::First(Height { lower: height - error, upper: height + error, up: u, lowest, on_plane });
    }
    // The point on both planes nearest to the origin, or the one on the lower of two parallel planes.
    let square = 1.0 - cosine * cosine;
    if is_parallel || square <= 0.0 {
        return Case::Meet(u.map(|c| c * x.min(y)));
    }
    let (s, t) = ((x - cosine * y) / square, (y - cosine * x) / square);
    Case::Meet([0, 1, 2].map(|k| s * u[k] + t * v[k]))
}

/// A product and its rounding error, exact for magnitudes from 2^-450 to 2^450 (Dekker 1971).
fn product(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let c = x * 134_217_729.0;
        let high = c - (c - x);
        (high, x - high)
    };
    let ((p, q), (r, s)) = (split(a), split(b));
    let high = a * b;
    (high, ((p * r - high) + p * s + q * r) + q * s)
}
