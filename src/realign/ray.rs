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
//! [`WayBack::outwards`] of a point of A: the table there holds for the points between moved corners as well, as these are
//! between the corners that were moved, and rounded.
//!
//! **The length.** |u| is at least 1 - 1e-4. Where p is not left outside at once, both ends of the way from w to a point of the
//! solid are in its box of half widths h, which is padded by o, so the way's length is at most `2 (sum h + 3 o)`, and
//! `L = 4 (sum h + 3 o)`.
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
//! The whole is then rounded up to a half.

use super::{F64_SLACK, WayBack, coordinates, greatest, shift};
use crate::directions::Directions;
use crate::exact::power_of_two;
use crate::frame::{Extent, Frame};
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

/// Of radii: what an accepted matrix may make longer, and a few roundings.
const SKEW: f64 = 1.0 + power_of_two(-11);

impl Ray {
    /// From a point that is given in the query's frame. The solid is B, or A where a pose places it, together with the
    /// extent of B. `None` if the point is certainly outside of the solid.
    #[inline(always)]
    pub(crate) fn new(origin: &Point, solid: &Extent, placed: Option<(&Pose, &Extent)>) -> Option<Self> {
        let c = solid.frame.centre;
        // Outside of the ball about the centre, wherever the pose puts it?
        let (at, slack) = match placed {
            None => (c, 0.0),
            Some((pose, b)) => {
                let (s, o) = (shift(pose, solid, &b.frame), b.frame.centre);
                let slack = F64_SLACK * (coordinates(pose, solid, &b.frame) + greatest(origin));
                ([o[0] + s[0], o[1] + s[1], o[2] + s[2]], 2.0 * (slack + MIN_COORDINATE))
            }
        };
        let d = [origin[0] - at[0], origin[1] - at[1], origin[2] - at[2]];
        let reach = (solid.radius + slack) * SKEW;
        if (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2] > reach * reach {
            return None;
        }
        let (way, direction, moved) = match placed {
            None => (d, [1.0, 0.0, 0.0], 0.0),
            Some((pose, b)) => {
                let back = WayBack::new(pose, solid, b);
                let p = back.pose.apply(*origin);
                let size = (8.0 * greatest(origin) + greatest(&back.pose.translation())) + greatest(&c);
                let moved = back.outwards::<Triangles>(0.0, b) + (F64_SLACK * size + MIN_COORDINATE);
                ([p[0] - c[0], p[1] - c[1], p[2] - c[2]], pose.rows()[0], moved)
            }
        };
        let inverse = power_of_two(-solid.frame.exponent);
        let mut widths = 0.0;
        for (along, width) in way.iter().zip(solid.half_width) {
            let width = f64::from(width) * inverse;
            widths += width;
            if along.abs() > (width + moved) * SKEW {
                return None;
            }
        }
        let length = 4.0 * (widths + 3.0 * moved);
        let pad = (moved + F64_SLACK * moved) + F64_SLACK * (greatest(&way) + length);
        Some(Self { way, direction, length, pad })
    }

    /// Its planes in the frame of the solid's tree, rounded up.
    #[inline(always)]
    pub(crate) fn planes<const K: usize>(&self, frame: &Frame) -> [Key; K] {
        let (w, u, scale) = (&self.way, &self.direction, frame.scale());
        let mut planes = [Key::ZERO; K];
        for (j, plane) in planes.iter_mut().enumerate() {
            let n = &Directions::<K>::VECTORS[j];
            let along = (n[0] * u[0] + n[1] * u[1]) + n[2] * u[2];
            let ahead = if along > 0.0 { along * self.length } else { 0.0 };
            let start = (n[0] * w[0] + n[1] * w[1]) + n[2] * w[2];
            let pad = ((n[0].abs() + n[1].abs()) + n[2].abs()) * self.pad;
            *plane = Key::round_up_or_unbounded(((start + ahead) + pad) * scale);
        }
        planes
    }
}
