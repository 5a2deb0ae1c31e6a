//! How a ray along the first axis crosses a triangle: exactly, and so that triangles which share edges and corners agree.
//!
//! Seen along the ray, the triangle is one of the y-z plane and the ray is a point p in it. Whether p is in the triangle is
//! a sum over the edges: those that pass p on its right, of greater y, count 1 upwards and -1 downwards. The sum is 1 if the
//! triangle runs around p counterclockwise, that is if its normal points along the ray, -1 if it runs clockwise, else 0.
//!
//! **Ties.** A corner that is level with p counts as below it, and an edge that p lies on does not pass on its right. That is
//! what comes out for the point `(y + d, z + e)` in place of p, for all d > 0 that are small enough, and all e > 0 that are
//! small enough compared with d: a point on no edge of any triangle. So the ray crosses, of all triangles that meet in
//! an edge or a corner, just those that this neighbour of it does.
//!
//! Whether the triangle is crossed ahead of the origin, or behind it, is its side of the triangle's plane. An origin in the
//! triangle is crossed.

use super::{Signs, Triangle};
use crate::range::Point;

/// The two coordinates that stay when space is seen along the first axis.
const ACROSS: (usize, usize) = (1, 2);

/// 1 if the triangle is crossed along its normal, seen counterclockwise, -1 if against it, 0 if not. Adds 1 to
/// `exact_calls` if integers took part.
pub(super) fn crossing(t: &Triangle, p: &Point, exact_calls: &mut u64) -> i8 {
    let [a, b, c] = t;
    let is_any_beyond = |axis: usize| (a[axis] > p[axis]) | (b[axis] > p[axis]) | (c[axis] > p[axis]);
    let are_all_beyond = |axis: usize| (a[axis] > p[axis]) & (b[axis] > p[axis]) & (c[axis] > p[axis]);
    let is_behind = (a[0] < p[0]) & (b[0] < p[0]) & (c[0] < p[0]);
    // Comparisons only: of the leaves that the ray comes near, most end here.
    if is_behind | !is_any_beyond(1) | !is_any_beyond(2) | are_all_beyond(1) | are_all_beyond(2) {
        return 0;
    }
    let mut signs = Signs { exact: false };
    let mut around = 0;
    for (u, v) in [(a, b), (b, c), (c, a)] {
        let (is_from_above, is_to_above) = (u[2] > p[2], v[2] > p[2]);
        if is_from_above != is_to_above {
            let side = signs.area(ACROSS, u, v, p);
            if is_to_above && side > 0 {
                around += 1;
            } else if is_from_above && side < 0 {
                around -= 1;
            }
        }
    }
    let is_ahead = around != 0 && signs.side(t, p) != around;
    *exact_calls += u64::from(signs.exact);
    if is_ahead { around } else { 0 }
}
