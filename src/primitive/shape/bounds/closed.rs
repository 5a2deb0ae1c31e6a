//! Bounds of the distance where a formula or a few cheap steps give the closest points: a point against any bounded
//! core, and segments and cuboids against each other.
//!
//! As in [`super::search`], only evaluations need error bounds. Below, u = 2^-53, and S is at least the sum of three
//! distances: between the two centres, and for each core from its centre to its farthest point. Factors 1 + 2^-40 for
//! terms of second order are implied. A `slack` bounds all errors of a length.

use super::certified::Certified;
use super::goal::{COMFORTABLE, Target};
use super::support::each;
use crate::exact::power_of_two;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::primitive::shape::place::Placement;
use crate::range::Point;
use crate::vector::{difference, dot, sqrt};

mod blocks;
mod products;
#[cfg(test)]
mod tests;
mod widest;

use blocks::blocks;
use products::Zonotope;

/// Bounds of the distance between two shapes as [`super::search::bounds`] gives them, or `None` if they would not be
/// as tight.
#[inline(always)]
pub(super) fn bounds<P: Placement>(
    a: &Shape,
    at: P,
    b: &Shape,
    limit: f64,
    tolerance: f64,
) -> Option<Certified> {
    let goal = || Target::new(a.radius, b.radius, limit, tolerance);
    let turned = || Target::new(b.radius, a.radius, limit, tolerance);
    match (&a.core, &b.core) {
        (Core::Point(p), Core::Point(q)) => Some(points(&at.point(p), q, &goal())),
        (Core::Point(p), Core::Segment(s)) => point_and_segment(&at.point(p), s, &goal()),
        (Core::Segment([p, q]), Core::Point(other)) => {
            point_and_segment(other, &[at.point(p), at.point(q)], &turned()).map(swapped)
        }
        (Core::Segment([p, q]), Core::Segment(t)) => {
            let s = [at.point(p), at.point(q)];
            let (g, h) = (half_of(&s), half_of(t));
            let (a, b) = (Zonotope { origin: &s[0], half: &g }, Zonotope { origin: &t[0], half: &h });
            blocks(&a, &b, &goal())
        }
        (Core::Point(p), Core::Cuboid { centre, half }) => {
            point_and_cuboid(&at.point(p), centre, half, &goal())
        }
        (Core::Cuboid { centre, half }, Core::Point(p)) => {
            let centre = at.point(centre);
            at.with_vectors(half, |half| point_and_cuboid(p, &centre, half, &turned())).map(swapped)
        }
        (Core::Point(p), Core::Triangle(t)) => point_and_triangle(&at.point(p), t, &goal()),
        (Core::Triangle([p, q, r]), Core::Point(other)) => {
            let t = [at.point(p), at.point(q), at.point(r)];
            point_and_triangle(other, &t, &turned()).map(swapped)
        }
        (Core::Segment([p, q]), Core::Cuboid { centre, half }) => {
            segment_and_cuboid(&[at.point(p), at.point(q)], centre, half, &goal())
        }
        (Core::Cuboid { centre, half }, Core::Segment(s)) => {
            let centre = at.point(centre);
            at.with_vectors(half, |half| segment_and_cuboid(s, &centre, half, &turned())).map(swapped)
        }
        (Core::Cuboid { centre: c, half: g }, Core::Cuboid { centre, half }) => {
            let c = at.point(c);
            at.with_vectors(g, |g| cuboids(&c, g, centre, half, &goal()))
        }
        (Core::Point(p), Core::Cylinder { centre, half_axis, radius }) => {
            point_and_cylinder(&at.point(p), centre, half_axis, *radius, &goal())
        }
        (Core::Cylinder { centre, half_axis, radius }, Core::Point(p)) => {
            point_and_cylinder(p, &at.point(centre), &at.vector(half_axis), *radius, &turned()).map(swapped)
        }
        (Core::Point(p), Core::Cone { base, axis, radius }) => {
            point_and_cone(&at.point(p), base, axis, *radius, &goal())
        }
        (Core::Cone { base, axis, radius }, Core::Point(p)) => {
            point_and_cone(p, &at.point(base), &at.vector(axis), *radius, &turned()).map(swapped)
        }
        _ => None,
    }
}

#[inline(always)]
fn swapped(found: Certified) -> Certified {
    Certified { a: found.b, b: found.a, ..found }
}

/// Two points. Three differences, three squares, two sums and a root are wrong by at most 4u of the result: differences
/// are multiples of 2^-302 below 2^304, whose squares neither underflow nor overflow.
#[inline(always)]
fn points(p: &Point, q: &Point, goal: &Target) -> Certified {
    let between = difference(p, q);
    let length = sqrt(dot(&between, &between));
    let slack = length * (4.0 * f64::EPSILON);
    goal.bounds(length - slack, length + slack, p, &between, length)
}

/// A point and a segment.
///
/// The differences are exact up to u of each coordinate: 2u S. The parameter is wrong by 8u of `|w| / |edge|`, which
/// moves the point of the segment by 8u S. The other errors are at most 3 + 1 + 3 roundings of S, of the point, the
/// difference and the norm. So 21u S bound all. Apart from these errors, a wrong parameter can only increase the
/// computed length.
#[inline(always)]
fn point_and_segment(p: &Point, [q, r]: &[Point; 2], goal: &Target) -> Option<Certified> {
    let (w, edge) = (difference(p, q), difference(r, q));
    let (along, square, far) = (dot(&w, &edge), dot(&edge, &edge), dot(&w, &w));
    // NaN if the segment is a point.
    let t = along / square;
    let t = if t > 0.0 { if t < 1.0 { t } else { 1.0 } } else { 0.0 };
    let between: Point = each(|k| w[k] - t * edge[k]);
    let length = sqrt(dot(&between, &between));
    // `sqrt(2 (x^2 + y^2))` is at least `x + y`.
    let slack = 12.0 * f64::EPSILON * sqrt(2.0 * (far + square));
    goal.bounds_of_length(p, &between, length, slack)
}

/// A point and a triangle: the foot of the perpendicular, or the closest of three points of the edges.
///
/// Differences are wrong by u of each coordinate. Up to 4u of their sum, the parameters are exactly those of a point
/// of the triangle. With the roundings of the products, of the difference and of the norm, an upper bound is wrong by
/// less than 17u S. A gap has three products with a vector d, each wrong by 4u, a difference and a quotient: less than
/// 27u S. S is at most the root of three times the sum of the squares of its parts.
#[inline(never)]
fn point_and_triangle(p: &Point, [q, r, s]: &[Point; 3], goal: &Target) -> Option<Certified> {
    const SLACK: f64 = 16.0 * f64::EPSILON;
    let (w, g, h) = (difference(p, q), difference(r, q), difference(s, q));
    let (gg, gh, hh) = (dot(&g, &g), dot(&g, &h), dot(&h, &h));
    let total = dot(&w, &w) + (gg + hh);
    if !COMFORTABLE.contains(&total) {
        return None;
    }
    let slack = SLACK * sqrt(3.0 * total);
    let (gw, hw) = (dot(&g, &w), dot(&h, &w));
    let from = |x: f64, y: f64| -> Point { each(|k| w[k] - (x * g[k] + y * h[k])) };
    let (x, y, all) = (hh * gw - gh * hw, gg * hw - gh * gw, gg * hh - gh * gh);
    let between = if x >= 0.0 && y >= 0.0 && x + y <= all && all > 0.0 {
        from(x / all, y / all)
    } else {
        // NaN if the edge is a point.
        let share = |t: f64| if t > 0.0 { if t < 1.0 { t } else { 1.0 } } else { 0.0 };
        let z = share(((hw - gw) + (gg - gh)) / ((gg - gh) + (hh - gh)));
        let mut least = from(share(gw / gg), 0.0);
        for other in [from(0.0, share(hw / hh)), from(1.0 - z, z)] {
            if dot(&other, &other) < dot(&least, &least) {
                least = other;
            }
        }
        least
    };
    let square = dot(&between, &between);
    let length = sqrt(square);
    let upper = length + slack;
    if upper <= goal.less {
        return Some(goal.bounds(0.0, upper, p, &between, length));
    }
    if square <= f64::MIN_POSITIVE {
        return None;
    }
    let (of_g, of_h) = (dot(&between, &g), dot(&between, &h));
    let farthest = if of_g > of_h { of_g } else { of_h };
    let farthest = if farthest > 0.0 { farthest } else { 0.0 };
    let lower = (dot(&between, &w) - farthest) / length - slack;
    let is_met = lower > 0.0 && goal.is_met(lower, upper, slack);
    is_met.then(|| goal.bounds(lower, upper, p, &between, length))
}

/// A point and a cylinder: both distances, along the axis and from it, are known.
///
/// The vector to the point and `along` times the axis are wrong by 8u S, the vector across by 11u S and its norm by
/// 14u S. The distance changes by at most the errors of the two excesses, 18u S together. Its vector and norm add 9u
/// S.
#[inline(always)]
fn point_and_cylinder(
    p: &Point,
    centre: &Point,
    half: &Point,
    radius: f64,
    goal: &Target,
) -> Option<Certified> {
    let w = difference(p, centre);
    let (far, square) = (dot(&w, &w), dot(half, half));
    let size = (far + square) + radius * radius;
    if !(COMFORTABLE.contains(&size) && square > size * power_of_two(-200)) {
        return None;
    }
    let along = dot(&w, half) / square;
    let across: Point = each(|k| w[k] - along * half[k]);
    let out = sqrt(dot(&across, &across));
    let excess = if along > 1.0 {
        along - 1.0
    } else if along < -1.0 {
        along + 1.0
    } else {
        0.0
    };
    let share = if out > radius { (out - radius) / out } else { 0.0 };
    let between: Point = each(|k| excess * half[k] + share * across[k]);
    let length = sqrt(dot(&between, &between));
    let slack = ROUND_SLACK * sqrt(3.0 * size);
    goal.bounds_of_length(p, &between, length, slack)
}

/// The slack for a point and a cylinder, relative to S; twice as much for a cone.
const ROUND_SLACK: f64 = 16.0 * f64::EPSILON;

/// A point and a cone, in the half plane through its axis and the point. The distance changes by at most the errors of
/// the two coordinates there, 18u S as for a cylinder, and of the height, 3u S. The parameter of the closest point of
/// the side is wrong by 10u of S plus the length of the side; differences and norms add 9u S.
#[inline(always)]
fn point_and_cone(p: &Point, base: &Point, axis: &Point, radius: f64, goal: &Target) -> Option<Certified> {
    let w = difference(p, base);
    let (far, square) = (dot(&w, &w), dot(axis, axis));
    let size = (far + square) + radius * radius;
    if !(COMFORTABLE.contains(&size) && square > size * power_of_two(-200)) {
        return None;
    }
    let along = dot(&w, axis) / square;
    let across: Point = each(|k| w[k] - along * axis[k]);
    let out_square = dot(&across, &across);
    let (out, height) = (sqrt(out_square), sqrt(square));
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
    let length = sqrt(dx * dx + dy * dy);
    let (x, y) = (if out > 0.0 { dx / out } else { 0.0 }, dy / height);
    let between: Point = each(|k| x * across[k] + y * axis[k]);
    let slack = 2.0 * ROUND_SLACK * sqrt(3.0 * size);
    goal.bounds_of_length(p, &between, length, slack)
}

// Separate functions, so that the others do not need their stack frames.

#[inline(never)]
fn cuboids(c: &Point, g: &[Point; 3], centre: &Point, half: &[Point; 3], goal: &Target) -> Option<Certified> {
    blocks(&Zonotope { origin: c, half: g }, &Zonotope { origin: centre, half }, goal)
}

#[inline(always)]
fn point_and_cuboid(p: &Point, centre: &Point, half: &[Point; 3], goal: &Target) -> Option<Certified> {
    blocks(&Zonotope { origin: p, half: &[] }, &Zonotope { origin: centre, half }, goal)
}

#[inline(never)]
fn segment_and_cuboid(s: &[Point; 2], centre: &Point, half: &[Point; 3], goal: &Target) -> Option<Certified> {
    let g = half_of(s);
    blocks(&Zonotope { origin: &s[0], half: &g }, &Zonotope { origin: centre, half }, goal)
}

#[inline(always)]
fn half_of([p, q]: &[Point; 2]) -> [Point; 1] {
    [each(|k| 0.5 * (q[k] - p[k]))]
}
