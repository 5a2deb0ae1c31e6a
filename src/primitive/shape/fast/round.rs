//! A point against a cylinder or a cone.
//!
//! The point's height and its distance from the axis give its distance from the solid. Let w be the vector from the
//! reference point, and S the sum of its length and the lengths of the solid, which `size` bounds. The height is wrong
//! by 8 u S and the vector across the axis by 11 u S, so its length by 14 u S. The distance from a convex set in the
//! half plane of both changes by at most their errors. Its own computation, for a cone with a projection on the side,
//! adds at most 16 u S. So 2^-47 `size` bounds all.

use super::bodies::{clamp, norm_1};
use super::margins::compare;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{difference, dot, sqrt};

/// The error of a distance, relative to `size`.
const ERROR: f64 = power_of_two(-47);

/// The height of a point, in units of the axis, and its squared distance from the axis.
#[inline(always)]
fn coordinates(w: &Point, axis: &Point, square: f64) -> (f64, f64) {
    let along = dot(w, axis) / square;
    let across = difference(w, &[along * axis[0], along * axis[1], along * axis[2]]);
    (along, dot(&across, &across))
}

/// `None` if products of the four lengths could leave the range of `f64`.
#[inline(always)]
fn size(w: &Point, axis: &Point, radius: f64) -> Option<f64> {
    let size = (norm_1(w) + norm_1(axis)) + radius;
    (size > power_of_two(-100) && size < power_of_two(100)).then_some(size)
}

/// The point at `w` from the centre of a cylinder.
#[inline(always)]
pub(super) fn cylinder(w: &Point, half_axis: &Point, radius: f64, reach: f64) -> Option<bool> {
    let size = size(w, half_axis, radius)?;
    let square = dot(half_axis, half_axis);
    let (along, out_square) = coordinates(w, half_axis, square);
    let up = along.abs() - 1.0;
    let up_square = if up > 0.0 { (up * up) * square } else { 0.0 };
    let out = if out_square > radius * radius { sqrt(out_square) - radius } else { 0.0 };
    compare(up_square + out * out, reach, size * ERROR)
}

/// The point at `w` from the middle of a cone's base.
#[inline(always)]
pub(super) fn cone(w: &Point, axis: &Point, radius: f64, reach: f64) -> Option<bool> {
    let size = size(w, axis, radius)?;
    let square = dot(axis, axis);
    let (up, out_square) = coordinates(w, axis, square);
    let out = sqrt(out_square);
    let beyond = out - radius;
    let distance = if up < 0.0 {
        let beyond = if beyond > 0.0 { beyond } else { 0.0 };
        (up * up) * square + beyond * beyond
    } else if up * radius + beyond <= 0.0 {
        0.0
    } else {
        let share = (up * square - beyond * radius) / (square + radius * radius);
        let share = clamp(share, 0.0, 1.0);
        let (x, y) = (beyond + share * radius, up - share);
        x * x + (y * y) * square
    };
    compare(distance, reach, size * ERROR)
}
