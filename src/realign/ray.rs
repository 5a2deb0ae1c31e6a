//! Rays as k-DOPs: which volumes of a solid may a ray cross?
//!
//! To test whether a point p is inside a solid, a query casts a ray from p along the first axis of its own frame, that
//! of B. Only the first part of the ray, of length L, can reach the solid. Let w be the vector to p from the centre of
//! the frame of the solid's tree, and u the ray's direction in that frame. Then plane j of that part of the ray is
//!
//! ```text
//! max over 0 <= s <= L of n . (w + s u) = n . w + max(0, n . u) L
//! ```
//!
//! so the kernels treat the ray like any other body. If the solid is B, then `w = p - c` and `u = (1, 0, 0)`. If it is
//! A, w is the image of p under the [inverse pose](InversePose), and u, the first row of M, is that of the ray's
//! direction: exactly, since M transposed maps the first axis to that row. A point `y = p + s u` of a moved triangle of
//! A is then within [`InversePose::outwards`] of a point of A. The table there also holds for points between moved
//! corners, as these lie between the corners that were moved and rounded.
//!
//! **Outside.** Most points are outside the ball of radius R around the centre, or outside the box of half widths h.
//! This is tested first: for B on `p - c`, and for A on `p - q` and `M^T (p - q)`, where q is the image of the centre c
//! under the pose. A moved point of A is farther from the centre than the point of A that it comes from by at most
//! `skew R` and the roundings in the table. No accepted matrix has a skew above 3.01e-4, so the ball and the box are
//! widened by `2^-11 R` and twice `2^-46 X`.
//!
//! **The length.** |u| is at least 1 - 1e-4. If p is not outside, then w and every point of the solid are in the
//! solid's box, widened by o and by `2^-11 R`. So the magnitudes of the vector between them sum to less than
//! `2.01 (sum h + 2^-9 R + 3 o)`, and `L = 4 (sum h + 2^-8 R + 3 o)`.
//!
//! **The pads**, in the bodies' unit, along a direction n, whose magnitudes sum to |n|. o is the result of `outwards`.
//! X is eight times the greatest magnitude of p, plus those of the solid's centre and of the inverse pose's
//! translation; m is [`MIN_COORDINATE`]:
//!
//! | rounded | error, at most | pad |
//! |---|---|---|
//! | the inverse pose | o | `abs(n) o` |
//! | p, moved and flushed to zero; its vector from the centre | `2^-49 X` and m | for A: `2^-46 abs(n) X` and m |
//! | `w = p - c` for B, once; `n . w` and its sums | `2^-50 abs(n) abs(w)` | `2^-46 abs(n) abs(w)` |
//! | `n . u` and its product with L, sums | `2^-50 abs(n) L` | `2^-46 abs(n) L` |
//!
//! The sum is then rounded up to a key.

use super::{F64_SLACK, InversePose, coordinates, greatest, shift};
use crate::directions::Directions;
use crate::exact::power_of_two;
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::Header;
use crate::key::{Key, Storage};
use crate::pose::Pose;
use crate::primitive::Triangles;
use crate::range::{MIN_COORDINATE, Point};

/// A ray from a point along the first axis of the query's frame, in the frame of a solid's tree.
#[derive(Copy, Clone, Debug)]
pub struct Ray {
    /// The origin, relative to the centre of the frame.
    way: Point,
    direction: Point,
    /// Length of the part that can reach the solid.
    length: f64,
    /// The pad along a direction whose magnitudes sum to 1.
    pad: f64,
}

/// Bounds how far an accepted matrix moves a point away from the centre, relative to the radius.
const SKEW: f64 = power_of_two(-11);

/// Factor on the widths of a box that covers a few roundings.
const GROWN: f64 = 1.0 + power_of_two(-40);

impl Ray {
    /// From a point in the query's frame. The solid is B, or A if a pose places it relative to B. `None` if the point
    /// is certainly outside the solid.
    // Inlined up to the test that rejects most points.
    #[inline(always)]
    pub(crate) fn new(origin: &Point, solid: &Header, placed: Option<(&Pose, &BodyBounds)>) -> Option<Self> {
        if is_outside(origin, solid, placed) { None } else { Some(Self::aimed(origin, solid, placed)) }
    }

    #[inline(never)]
    fn aimed(origin: &Point, solid: &Header, placed: Option<(&Pose, &BodyBounds)>) -> Self {
        let (solid, c) = (solid.extent(), solid.centre);
        let (from, direction, moved) = match placed {
            None => (*origin, [1.0, 0.0, 0.0], 0.0),
            Some((pose, b)) => {
                let back = InversePose::new(pose, &solid, b);
                let size = (8.0 * greatest(origin) + greatest(&back.pose.translation())) + greatest(&c);
                let rounding = F64_SLACK * size + MIN_COORDINATE;
                let moved = back.outwards::<Triangles>(0.0, b) + rounding;
                (back.pose.apply(*origin), pose.rows()[0], moved)
            }
        };
        let way = [from[0] - c[0], from[1] - c[1], from[2] - c[2]];
        let [x, y, z] = solid.half_width;
        let widths = ((f64::from(x) + f64::from(y)) + f64::from(z)) * power_of_two(-solid.frame.exponent);
        let length = 4.0 * ((widths + 8.0 * SKEW * solid.radius) + 3.0 * moved);
        let pad = (moved + F64_SLACK * moved) + F64_SLACK * (greatest(&way) + length);
        Self { way, direction, length, pad }
    }

    /// The ray's planes in the frame of the solid's tree, rounded up.
    #[inline(always)]
    pub(crate) fn planes<const K: usize, S: Storage>(&self, frame: &Frame) -> [Key<S>; K] {
        let (w, u, scale) = (&self.way, &self.direction, frame.scale());
        let mut planes = [Key::LOWEST; K];
        for (j, plane) in planes.iter_mut().enumerate() {
            let n = &Directions::<K>::VECTORS[j];
            let along = (n[0] * u[0] + n[1] * u[1]) + n[2] * u[2];
            let ahead = if along > 0.0 { along * self.length } else { 0.0 };
            let start = (n[0] * w[0] + n[1] * w[1]) + n[2] * w[2];
            let pad = ((n[0].abs() + n[1].abs()) + n[2].abs()) * self.pad;
            *plane = Key::above(((start + ahead) + pad) * scale);
        }
        planes
    }
}

/// Whether a point is certainly outside the ball around the centre of a solid, or outside its box.
#[inline(always)]
fn is_outside(origin: &Point, solid: &Header, placed: Option<(&Pose, &BodyBounds)>) -> bool {
    let (extent, c) = (solid.extent(), solid.centre);
    let beyond = |way: &Point, reach: f64| {
        (way[0] * way[0] + way[1] * way[1]) + way[2] * way[2] > (reach * reach) * GROWN
    };
    let (way, slack) = match placed {
        None => {
            let way = [origin[0] - c[0], origin[1] - c[1], origin[2] - c[2]];
            if beyond(&way, extent.radius) {
                return true;
            }
            (way, 0.0)
        }
        Some((pose, b)) => {
            let (m, s, o) = (pose.rows(), shift(pose, &extent, &b.frame), b.frame.centre);
            let d = [(origin[0] - o[0]) - s[0], (origin[1] - o[1]) - s[1], (origin[2] - o[2]) - s[2]];
            let coordinates = coordinates(pose, &extent, &b.frame) + greatest(origin);
            let slack = SKEW * extent.radius + 2.0 * (F64_SLACK * coordinates + MIN_COORDINATE);
            if beyond(&d, extent.radius + slack) {
                return true;
            }
            let along = |i: usize| (m[0][i] * d[0] + m[1][i] * d[1]) + m[2][i] * d[2];
            ([along(0), along(1), along(2)], slack)
        }
    };
    let (inverse, widths) = (power_of_two(-solid.exponent), &solid.half_width);
    let is_wide = |i: usize| way[i].abs() > (f64::from(widths[i]) * inverse + slack) * GROWN;
    is_wide(0) | is_wide(1) | is_wide(2)
}
