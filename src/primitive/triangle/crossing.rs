//! How a ray along the first axis crosses a triangle. Exact, and consistent for triangles that share edges and corners.
//!
//! Project along the ray: the triangle becomes one in the y-z plane, and the ray becomes a point p. Whether p is in the
//! triangle is a sum over the edges: an edge that passes p on its right, at greater y, counts 1 if it goes up and -1 if
//! it goes down. The sum is 1 if the triangle runs around p counterclockwise, that is, if its normal points along the
//! ray; -1 if clockwise; else 0.
//!
//! **Ties.** A corner level with p counts as below it, and an edge through p does not pass on its right. This is the
//! result for the point `(y + d, z + e)` instead of p, for all sufficiently small d > 0, and all e > 0 sufficiently
//! small compared with d: a point on no edge of any triangle. So, of all triangles that meet in an edge or a corner,
//! the ray crosses exactly those that this perturbed ray crosses.
//!
//! The side of the triangle's plane on which the origin lies decides whether the crossing is ahead of the origin or
//! behind it. An origin in the triangle counts as a crossing.

use super::sides::{Signs, Triangle};
use crate::range::Point;

/// The two coordinates that a projection along the first axis keeps.
const ACROSS: (usize, usize) = (1, 2);

/// 1 if the ray crosses the triangle along its normal (it appears counterclockwise), -1 if against it, 0 if not. Adds 1
/// to `exact_calls` if integers were needed.
pub(super) fn crossing(t: &Triangle, p: &Point, exact_calls: &mut u64) -> i8 {
    let [a, b, c] = t;
    let is_any_beyond = |axis: usize| (a[axis] > p[axis]) | (b[axis] > p[axis]) | (c[axis] > p[axis]);
    let are_all_beyond = |axis: usize| (a[axis] > p[axis]) & (b[axis] > p[axis]) & (c[axis] > p[axis]);
    let is_behind = (a[0] < p[0]) & (b[0] < p[0]) & (c[0] < p[0]);
    // Comparisons only: most triangles in the leaves near the ray end here.
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
