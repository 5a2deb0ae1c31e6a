//! Rays as k-DOPs: what of a solid a ray may cross.
//!
//! Whether a point p is inside of a solid is asked by a ray from it along the first axis of the frame that a query is in,
//! B's. Of the ray only the part of length L matters that can reach the solid. With w the way of p from the centre of the
//! frame in which the solid's tree is, and u the ray's direction there, plane j of that part is
//!
//! ```text
//! max over 0 <= s <= L of n . (w + s u) = n . w + max(0, n . u) L
//! ```
//!
//! so that for the kernels it is a body like any other. If the solid is B, then `w = p - c` and `u = (1, 0, 0)`. If it is A,
//! w is where the [way back](super::back) takes p to, and u, the first row of M, is where it takes the ray: exactly, since M
//! transposed turns the first axis into that row. A point `y = p + s u` of a triangle of A as moved is then within
//! [`InversePose::outwards`] of a point of A: the table there holds for the points between moved corners as well, as these are
//! between the corners that were moved, and rounded.
//!
//! **Outside.** Most points are beyond the ball of radius R about the centre, or the box of half widths h, which is told before
//! anything else is computed. For B by `p - c`. For A by `p - q` and `M^T (p - q)`, with q where the pose puts the centre
//! c: a point of A as moved is at most `skew R` and the roundings of the table farther from the centre than the point of A that
//! it comes from, and no accepted matrix has a skew above 3.01e-4, so ball and box are widened by `2^-11 R` and
//! twice `2^-46 X`.
//!
//! **The length.** |u| is at least 1 - 1e-4. Where p is not outside, both ends of the way from w to a point of the solid are in
//! its box, padded by o and by `2^-11 R`, so the sum of the way's magnitudes is below `2.01 (sum h + 2^-9 R + 3 o)`, and
//! `L = 4 (sum h + 2^-8 R + 3 o)`.
//!
//! **The pads**, in the bodies' unit, along a direction n of which |n| is the sum of magnitudes; X bounds the magnitudes of p,
//! of the solid's centre and of the way back's translation, eight times that of p:
//!
//! | what was rounded | at most | the pad |
//! |---|---|---|
//! | the way back, as `outwards` o says | o | `abs(n) o` |
//! | p as it is moved back and flushed to zero, and its way from the centre | `2^-49 X` and [`MIN_COORDINATE`] | `2^-46 abs(n) X` and [`MIN_COORDINATE`] for A, which B has no need of |
//! | `w = p - c` for B, once; `n . w` and its sums | `2^-50 abs(n) abs(w)` | `2^-46 abs(n) abs(w)` |
//! | `n . u` and its product with L, sums | `2^-50 abs(n) L` | `2^-46 abs(n) L` |
//!
//! The whole is then rounded up to a key.

use super::{F64_SLACK, InversePose, coordinates, greatest, shift};
use crate::directions::Directions;
use crate::exact::power_of_two;
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::Header;
use crate::key::Key;
use crate::pose::Pose;
use crate::primitive::Triangles;
use crate::range::{MIN_COORDINATE, Point};

/// A ray from a point along the first axis of the query's frame, in the frame of a solid's tree.
#[derive(Copy, Clone, Debug)]
pub struct Ray {
    /// Of the origin, from the centre of the frame.
    way: Point,
    direction: Point,
    /// What of it is looked at.
    length: f64,
    /// Along a direction whose magnitudes sum up to 1.
    pad: f64,
}

/// Of a radius: more than what an accepted matrix moves a point by, away from the centre.
const SKEW: f64 = power_of_two(-11);

/// Of the widths of a box, for a few roundings.
const GROWN: f64 = 1.0 + power_of_two(-40);

impl Ray {
    /// From a point that is given in the query's frame. The solid is B, or A where a pose places it beside B. `None` if the
    /// point is certainly outside of the solid.
    // Inlined up to where most points are outside.
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

    /// Its planes in the frame of the solid's tree, rounded up.
    #[inline(always)]
    pub(crate) fn planes<const K: usize>(&self, frame: &Frame) -> [Key; K] {
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

/// Whether a point is certainly beyond the ball about the centre of a solid, or beyond its box.
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
