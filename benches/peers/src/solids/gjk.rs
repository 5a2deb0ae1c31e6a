//! Bounds of the distance of two convex shapes in `f64`: they place the bodies, and check witnesses.
//!
//! The algorithm of Gilbert, Johnson and Keerthi (1988), slow and simple: the point of a simplex nearest to the origin
//! is the nearest of those of all its faces. A convex combination bounds the distance from above, a supporting plane
//! from below. Both hold up to rounding, also where the iteration stalls.

use core::cell::Cell;
use simdop::primitive::shape::{Core, Shape};

type Point = [f64; 3];

const MOST: usize = 300;

/// Error of a coordinate or a distance, relative to the largest coordinate.
const ROUNDING: f64 = 2e-14;

/// Bounds of the distance, which are 0 if the shapes meet.
pub(super) struct Bounds {
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// The order of magnitude of rounding errors.
    pub(super) rounding: f64,
}

pub(super) fn bounds(a: &Shape, b: &Shape) -> Bounds {
    if let Core::HalfSpace { normal, offset } = *b.core() {
        let lowest = support(a.core(), &normal.map(|x| -x));
        let distance = (dot(&normal, &lowest) - offset) / length(&normal) - a.radius() - b.radius();
        let rounding = 1e-15 * (largest(&lowest) + offset.abs() + a.radius());
        return Bounds { lower: distance.max(0.0), upper: distance.max(0.0), rounding };
    }
    let Bounds { lower, upper, rounding } = of_cores(a.core(), b.core());
    let radii = a.radius() + b.radius();
    Bounds {
        lower: (lower - radii).max(0.0),
        upper: (upper - radii).max(0.0),
        rounding: rounding + 1e-15 * radii,
    }
}

fn of_cores(a: &Core, b: &Core) -> Bounds {
    let extent = Cell::new(0.0_f64);
    let vertex = |direction: &Point| {
        let (p, q) = (support(a, direction), support(b, &direction.map(|x| -x)));
        extent.set(extent.get().max(largest(&p)).max(largest(&q)));
        difference(&p, &q)
    };
    let mut nearest = vertex(&[1.0, 0.0, 0.0]);
    let mut simplex = vec![nearest];
    let (mut lower, mut upper) = (0.0_f64, length(&nearest));
    for _ in 0..MOST {
        if upper == 0.0 {
            break;
        }
        let next = vertex(&nearest.map(|x| -x / upper));
        lower = lower.max(dot(&nearest, &next) / upper);
        if upper - lower <= 1e-15 * upper || simplex.contains(&next) {
            break;
        }
        simplex.push(next);
        let (point, face) = next_to_origin(&simplex);
        if face.len() == 4 {
            if lower > ROUNDING * extent.get() {
                break;
            }
            return Bounds { lower: 0.0, upper: 0.0, rounding: 0.0 };
        }
        let now = length(&point);
        if now >= upper {
            break;
        }
        (nearest, simplex, upper) = (point, face, now);
    }
    Bounds { lower, upper, rounding: ROUNDING * extent.get() }
}

/// The point of the core farthest along the direction.
fn support(core: &Core, direction: &Point) -> Point {
    let farther = |p: Point, q: Point| if dot(direction, &p) >= dot(direction, &q) { p } else { q };
    let rim = |axis: &Point, radius: f64| {
        let without = |v: &Point| moved(v, axis, -dot(v, axis) / dot(axis, axis));
        // Twice: for a direction almost along the axis, the first result has a large relative error.
        let across = without(&without(direction));
        let long = length(&across);
        if long > 1e-14 * length(direction) { across.map(|x| x * (radius / long)) } else { [0.0; 3] }
    };
    match *core {
        Core::Point(p) => p,
        Core::Segment([p, q]) => farther(p, q),
        Core::Triangle([p, q, r]) => farther(farther(p, q), r),
        Core::Cuboid { centre, half } => {
            half.iter().fold(centre, |sum, edge| moved(&sum, edge, 1.0_f64.copysign(dot(direction, edge))))
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let disc = moved(&centre, &half_axis, 1.0_f64.copysign(dot(direction, &half_axis)));
            moved(&disc, &rim(&half_axis, radius), 1.0)
        }
        Core::Cone { base, axis, radius } => {
            farther(moved(&base, &axis, 1.0), moved(&base, &rim(&axis, radius), 1.0))
        }
        Core::HalfSpace { .. } => unreachable!("a half-space is the second shape"),
    }
}

/// The point of the simplex nearest to the origin, and the corners of the face that contains it. Four corners: the
/// origin is inside.
fn next_to_origin(simplex: &[Point]) -> (Point, Vec<Point>) {
    let mut best = (simplex[0], vec![simplex[0]], f64::INFINITY);
    for set in 1..1_usize << simplex.len() {
        let face: Vec<Point> = (0..simplex.len()).filter(|i| set >> i & 1 == 1).map(|i| simplex[i]).collect();
        let Some(weights) = weights(&face) else { continue };
        let sum: f64 = weights.iter().sum();
        let terms = weights.iter().zip(&face);
        let point = terms.fold([0.0; 3], |point, (weight, corner)| moved(&point, corner, weight / sum));
        let square = if face.len() == 4 { 0.0 } else { dot(&point, &point) };
        if square < best.2 {
            best = (point, face, square);
        }
    }
    (best.0, best.1)
}

/// The weights, up to a factor, of the point of the face's affine hull nearest to the origin, unless that point is
/// outside the face.
fn weights(face: &[Point]) -> Option<Vec<f64>> {
    let weights = match face {
        [_] => vec![1.0],
        [p, q] => {
            let edge = difference(q, p);
            vec![dot(q, &edge), -dot(p, &edge)]
        }
        [p, q, r] => {
            let normal = cross(&difference(q, p), &difference(r, p));
            [[q, r], [r, p], [p, q]].map(|[x, y]| dot(&normal, &cross(x, y))).to_vec()
        }
        [p, q, r, s] => {
            let volume = |x: &Point, y: &Point, z: &Point| dot(x, &cross(y, z));
            let parts = [volume(q, r, s), -volume(p, r, s), volume(p, q, s), -volume(p, q, r)];
            // A face that could be flat has no inside.
            let extent = face.iter().fold(0.0_f64, |most, corner| most.max(length(corner)));
            let (sign, rounding) = (parts[0].signum(), 1e-15 * extent.powi(3));
            parts.map(|part| sign * part - rounding).to_vec()
        }
        _ => unreachable!("a simplex has one to four corners"),
    };
    weights.iter().all(|weight| *weight > 0.0).then_some(weights)
}

pub(super) fn dot(a: &Point, b: &Point) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

fn cross(a: &Point, b: &Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn difference(a: &Point, b: &Point) -> Point {
    core::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn length(a: &Point) -> f64 {
    dot(a, a).sqrt()
}

fn moved(p: &Point, along: &Point, by: f64) -> Point {
    core::array::from_fn(|i| p[i] + by * along[i])
}

fn largest(a: &Point) -> f64 {
    a.iter().fold(0.0, |most, x| x.abs().max(most))
}
