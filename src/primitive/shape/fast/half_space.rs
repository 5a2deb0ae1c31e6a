//! Half-spaces against every other core.

use super::margins::FEW;
use crate::exact::power_of_two;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::Point;
use crate::vector::{cross, dot, sqrt};

/// A half-space against another shape.
///
/// The shape is within `reach` if and only if the least `normal . x - offset` of its core is at most `reach |normal|`.
/// A dot product errs by at most 3 u of the sum of its terms' magnitudes, all of which `size` includes; the part of a
/// disc across the normal by a relative 8 u. Products of two coordinates are at least 2^-500 or zero. The squares of a
/// cross product need the test of `size`.
pub(super) fn decide(a: &Shape, b: &Shape, reach: f64) -> Option<bool> {
    let (normal, offset, other) = match (&a.core, &b.core) {
        (Core::HalfSpace { normal, .. }, Core::HalfSpace { normal: other, .. }) => {
            return both(normal, other);
        }
        (Core::HalfSpace { normal, offset }, other) | (other, Core::HalfSpace { normal, offset }) => {
            (normal, *offset, other)
        }
        _ => return None,
    };
    let n = normal;
    let terms = |v: &Point| (n[0] * v[0]).abs() + (n[1] * v[1]).abs() + (n[2] * v[2]).abs();
    let least = |x: f64, y: f64| if x < y { x } else { y };
    // The radius of a disc times |normal| times the sine of the angle between normal and axis.
    let disc = |axis: &Point, radius: f64| {
        let across = cross(n, axis);
        radius * sqrt(dot(&across, &across) / dot(axis, axis))
    };
    let (low, size) = match other {
        Core::Point(p) => (dot(n, p), terms(p)),
        Core::Segment([p, q]) => (least(dot(n, p), dot(n, q)), terms(p) + terms(q)),
        Core::Triangle([p, q, r]) => {
            (least(least(dot(n, p), dot(n, q)), dot(n, r)), (terms(p) + terms(q)) + terms(r))
        }
        Core::Cuboid { centre, half: [x, y, z] } => {
            let spread = (dot(n, x).abs() + dot(n, y).abs()) + dot(n, z).abs();
            (dot(n, centre) - spread, (terms(centre) + terms(x)) + (terms(y) + terms(z)))
        }
        Core::Cylinder { centre, half_axis, radius } => {
            in_range(half_axis)?;
            let spread = dot(n, half_axis).abs() + disc(half_axis, *radius);
            // 8 exceeds |normal|: the cross product errs by a multiple of its factors.
            (dot(n, centre) - spread, (terms(centre) + terms(half_axis)) + 8.0 * *radius)
        }
        Core::Cone { base, axis, radius } => {
            in_range(axis)?;
            let (disc, tip) = (-disc(axis, *radius), dot(n, axis));
            (dot(n, base) + least(disc, tip), (terms(base) + terms(axis)) + 8.0 * *radius)
        }
        Core::HalfSpace { .. } => return None,
    };
    let margin = reach * sqrt(dot(n, n));
    let error = ((size + offset.abs()) + margin) * FEW;
    let gap = (low - offset) - margin;
    if gap > error {
        Some(false)
    } else if gap < -error {
        Some(true)
    } else {
        None
    }
}

fn in_range(axis: &Point) -> Option<()> {
    let square = dot(axis, axis);
    (square > power_of_two(-300) && square < power_of_two(300)).then_some(())
}

/// Two half-spaces meet unless their normals point in opposite directions.
fn both(n: &Point, m: &Point) -> Option<bool> {
    let across = cross(n, m);
    // The normals are at most sqrt(12) long, so the cross product errs by less than 2^-45.
    let is_skew = dot(&across, &across) > power_of_two(-80);
    (is_skew || dot(n, m) > power_of_two(-40)).then_some(true)
}
