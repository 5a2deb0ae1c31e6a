//! A sphere and a triangle: compares the distance of the centre from the triangle with the radius.

use super::ball::Sphere;
use super::separation::Separation;
use super::sphere::against_sphere::{ROUNDING, bounds_of_gap};
use super::triangle::Triangle;
use super::triangle::point::{Foot, excess};
use crate::range::{MIN_COORDINATE, Point};
use crate::vector::sqrt;

/// Whether the two are at most `margin` apart. Exact; a margin above 0 and below [`MIN_COORDINATE`] counts as
/// [`MIN_COORDINATE`].
#[inline(always)]
pub(crate) fn is_within(a: &Sphere, b: &Triangle, margin: f64, exact: &mut u64) -> bool {
    let foot = Foot::of(&a.centre, b);
    let reach = a.radius + margin;
    if foot.upper < reach * (1.0 - ROUNDING) {
        return true;
    }
    if foot.lower > reach * (1.0 + ROUNDING) {
        return false;
    }
    *exact += 1;
    let margin = if margin > 0.0 && margin < MIN_COORDINATE { MIN_COORDINATE } else { margin };
    excess(&a.centre, b, [a.radius, margin]) <= 0.0
}

/// Whether a point of the triangle is nearer to the centre than the radius. Exact.
pub(crate) fn has_point_inside(a: &Sphere, b: &Triangle, exact: &mut u64) -> bool {
    let is_beside = (0..3).any(|i| {
        let [p, q, r] = b.each_ref().map(|corner| corner[i] - a.centre[i]);
        // Rounding keeps the order of numbers.
        p.min(q).min(r) > a.radius || p.max(q).max(r) < -a.radius
    });
    if is_beside {
        return false;
    }
    let foot = Foot::of(&a.centre, b);
    if foot.upper < a.radius * (1.0 - ROUNDING) {
        return true;
    }
    if foot.lower > a.radius * (1.0 + ROUNDING) {
        return false;
    }
    *exact += 1;
    excess(&a.centre, b, [a.radius, 0.0]) < 0.0
}

/// The distance between the two, or `None` if it is certainly greater than `limit`. The sphere's closest point comes
/// first. The relative difference of the bounds is at most `tolerance`, which is at least 2^-42.
#[inline(always)]
pub(crate) fn nearer(
    a: &Sphere,
    b: &Triangle,
    limit: f64,
    tolerance: f64,
    exact: &mut u64,
) -> Option<Separation> {
    let (foot, radius) = (Foot::of(&a.centre, b), a.radius);
    let error = ROUNDING * (foot.upper + radius);
    let (gap_below, gap_above) = ((foot.lower - radius) - error, (foot.upper - radius) + error);
    if gap_below > limit {
        return None;
    }
    let (lower, upper) = if gap_below > 0.0 && gap_above - gap_below <= tolerance * gap_below {
        (gap_below, gap_above)
    } else if foot.upper < radius * (1.0 - ROUNDING) {
        (0.0, 0.0)
    } else {
        *exact += 1;
        let excess = excess(&a.centre, b, [radius, 0.0]);
        // Used for a positive excess only. The root is the distance of the centre, more accurate than the foot's
        // bounds.
        bounds_of_gap(excess, sqrt(excess.abs() + radius * radius) + radius)
    };
    let [x, y, z] = foot.way;
    let length = sqrt((x * x + y * y) + z * z);
    let share = if upper > 0.0 && length > 0.0 { radius * foot.scale / length } else { 1.0 };
    let at = |share: f64| -> Point {
        let step = share / foot.scale;
        [a.centre[0] + x * step, a.centre[1] + y * step, a.centre[2] + z * step]
    };
    Some(Separation { lower, upper, a: at(share), b: at(1.0) })
}
