//! Exact orientations. Coordinates are in [range](crate::range): zero or from 2^-250 to 2^300, so that no product of
//! three differences, and none of their errors, overflows or underflows.

use crate::range::Point;
use core::cmp::Ordering;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The determinant of three edges, rounded, with the exact sign: positive if `p` is on that side of the plane of a
/// triangle where its corners are counterclockwise.
#[inline]
pub(super) fn height([a, b, c]: [&Point; 3], p: &Point) -> f64 {
    let place = |&[x, y, z]: &Point| Coord3D { x, y, z };
    -orient3d(place(a), place(b), place(c), place(p))
}

/// Twice the area of a triangle, rounded, with the exact sign: positive if counterclockwise.
pub(super) fn area(corners: [[f64; 2]; 3]) -> f64 {
    let [a, b, c] = corners.map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

/// Points as seen along an axis.
pub(super) fn projected<const N: usize>(points: &[Point; N], axis: usize) -> [[f64; 2]; N] {
    points.map(|p| [p[(axis + 1) % 3], p[(axis + 2) % 3]])
}

/// Lexicographic order. No coordinate is NaN or -0.
// Not inlined: a sort compares in many places.
#[inline(never)]
pub(super) fn compare(p: &Point, q: &Point) -> Ordering {
    let axes = (0..3).map(|i| p[i].total_cmp(&q[i]));
    axes.fold(Ordering::Equal, Ordering::then)
}
