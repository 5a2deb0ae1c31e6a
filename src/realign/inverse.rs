//! The way back: body B in the frame of body A, for queries that turn B's volumes instead of A's.
//!
//! A query is about A's corners as [`Pose::apply`] moves them. Let c be the centre of A's frame, `q = M c + t` where the
//! pose puts it, and y a point of B. The way back takes y to `c + M^T (y - q)`. If y is a point of A as moved, then
//! `y = q + M d + e`, with d the way of that point from c, at most `R_A` long, and e what rounding has moved it by, so that
//!
//! ```text
//! M^T (y - q) = d + (M^T M - 1) d + M^T e
//! ```
//!
//! and what volumes of B have to be moved out by, for none to be apart from a volume of A that it meets, is the length of
//! the last two terms, and of the error of the way back itself. Where bodies come within a margin of each other, or
//! spheres have radii, a vector w as long as these is between y and A's point, and `M^T w` may be longer than w.
//!
//! | source | at most | paid by |
//! |---|---|---|
//! | `(M^T M - 1) d` | `skew R_A` | itself |
//! | w of the margin and of A's radius, as M turns it | `skew / 2` of these | `skew` of margin and of `R_A` |
//! | that of B's radius | `skew / 2` of it | [`shrinkage`], which pays for `abs(n) r` besides where planes are turned |
//! | e: `2^-50 (abs(M) abs(p) + abs(t))` on an axis, and less than [`MIN_COORDINATE`] | `2^-49 X + 2 MIN_COORDINATE` | `2^-46 X + 4 MIN_COORDINATE` |
//! | q and the translation `c - M^T q`, a dozen roundings | `2^-48 X` | the same |
//!
//! with `X = 8 max_coordinate_A + max abs(t) + max abs(c_B)`. How B's corners are moved along it, and how its planes are
//! turned, is padded as on the way there.

use super::{F64_SLACK, coordinates, shrinkage};
use crate::frame::BodyBounds;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::range::MIN_COORDINATE;

/// Places body B in the frame of A.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct InversePose {
    /// Takes a point of B to the frame of A, up to what [`InversePose::outwards`] pays for.
    pub pose: Pose,
    /// By how much of itself the pose may make a vector longer.
    skew: f64,
    pad: f64,
}

impl InversePose {
    /// The way back of `pose`, which places body `a` in the frame of `b`.
    #[must_use]
    pub fn new(pose: &Pose, a: &BodyBounds, b: &BodyBounds) -> Self {
        let skew = pose.skew();
        let rounding = F64_SLACK * coordinates(pose, a, &b.frame) + 4.0 * MIN_COORDINATE;
        Self { pose: pose.back_to(&a.frame.centre), skew, pad: 2.0 * skew * a.radius + rounding }
    }

    /// How far volumes of B, of primitives `Q`, have to be moved out, in the bodies' unit, so that they meet all of A that
    /// is within `margin` of B.
    #[must_use]
    pub fn outwards<Q: Primitive>(&self, margin: f64, b: &BodyBounds) -> f64 {
        (margin + self.skew * margin) + (self.pad + shrinkage::<Q>(&self.pose, b))
    }
}
