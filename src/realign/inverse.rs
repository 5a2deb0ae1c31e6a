//! The inverse pose: body B in the frame of body A, for queries that rotate B's volumes instead of A's.
//!
//! A query concerns A's corners as [`Pose::apply`] moves them. Let c be the centre of A's frame, `q = M c + t` its
//! image, and y a point of B. The inverse pose maps y to `c + M^T (y - q)`. If y is a moved point of A, then
//! `y = q + M d + e`, where d is the vector from c to that point, at most `R_A` long, and e is the rounding error of
//! the moved point. So
//!
//! ```text
//! M^T (y - q) = d + (M^T M - 1) d + M^T e
//! ```
//!
//! Volumes of B must be moved out by the length of the last two terms, plus the error of the inverse pose itself, so
//! that none is separated from a volume of A that it meets. If the query has a margin, or spheres have radii, a vector
//! w of that length lies between y and A's point, and `M^T w` may be longer than w.
//!
//! | source | at most | pad |
//! |---|---|---|
//! | `(M^T M - 1) d` | `skew R_A` | the same |
//! | w of the margin and of A's radius, rotated by M | `skew / 2` of these | `skew` of the margin and of `R_A` |
//! | w of B's radius | `skew / 2` of it | [`shrinkage`], which also covers `abs(n) r` of rotated planes |
//! | e on each axis: `2^-50 (abs(M) abs(p) + abs(t))`, and m | `2^-49 X + 2 m` | `2^-46 X + 4 m` |
//! | q and the translation `c - M^T q`, a dozen roundings | `2^-48 X` | the same |
//!
//! with `X = 8 max_coordinate_A + max abs(t) + max abs(c_B)` and m = [`MIN_COORDINATE`]. The corners of B that it
//! moves, and the planes of B that it rotates, are padded as those of A are for the pose itself.

use super::{F64_SLACK, coordinates, shrinkage};
use crate::frame::BodyBounds;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::range::MIN_COORDINATE;

/// Places body B in the frame of A.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct InversePose {
    /// Maps a point of B to the frame of A, up to the error that [`InversePose::outwards`] covers.
    pub pose: Pose,
    /// Upper bound of the relative growth of a vector's length under the pose.
    skew: f64,
    pad: f64,
}

impl InversePose {
    /// The inverse of `pose`, which places body `a` in the frame of `b`.
    #[must_use]
    pub fn new(pose: &Pose, a: &BodyBounds, b: &BodyBounds) -> Self {
        let skew = pose.skew();
        let rounding = F64_SLACK * coordinates(pose, a, &b.frame) + 4.0 * MIN_COORDINATE;
        Self { pose: pose.back_to(&a.frame.centre), skew, pad: 2.0 * skew * a.radius + rounding }
    }

    /// How far, in the bodies' unit, to move out volumes of B, with primitives `Q`, so that they meet all of A that is
    /// within `margin` of B.
    #[must_use]
    pub fn outwards<Q: Primitive>(&self, margin: f64, b: &BodyBounds) -> f64 {
        (margin + self.skew * margin) + (self.pad + shrinkage::<Q>(&self.pose, b))
    }
}
