//! Bodies far apart: lower bounds of distances along the line through their centres.
//!
//! Let s be the vector from the centre of B to that of A, and e a vector along s, of length at most 1. Points x of A
//! and y of B, each relative to the centre of its own body, are at least
//!
//! ```text
//! |s + x - y| >= e . s - (-e . x) - (e . y)
//! ```
//!
//! apart, and the supports of a volume along e and -e follow from three of its planes, as in re-alignment. The first
//! term is the same for all volumes, so the search compares only the others. They are as large as the bodies, and their
//! rounding is relative to that, whatever the distance. The rounding of squared gaps would be relative to the distance.
//!
//! The bound ignores the lateral offset of two volumes: an offset of w makes them farther apart by `w^2 / (2 |s|)`.
//! From [`FAR`] on that is small compared with their sizes.

use crate::exact::{power_of_two, round_up_f32};
use crate::frame::{BodyBounds, Frame};
use crate::pose::Pose;
use crate::primitive::{Primitive, radius_of};
use crate::query::lanes::{Along, Lanes};
use crate::range::Point;
use crate::realign::{shift, slack_of_shift};
use crate::vector::{dot, length};

/// Bodies are far apart if the distance of their centres is above this multiple of the sum of their radii.
const FAR: f64 = 16.0;

/// Shortens normalised vectors, and products of two, by more than their rounding errors.
const SHORTENED: f64 = 1.0 - power_of_two(-49);

/// The line through the centres of two bodies.
#[derive(Copy, Clone, Debug)]
pub(super) struct Axis {
    /// From B to A, of length at most 1.
    axis: Point,
    /// From the centre of B to that of A.
    shift: Point,
    /// Lower bound of the distance of the centres along the axis, minus all rounding errors in `f64`.
    between: f64,
    /// The scale of the unit of volumes.
    scale: f64,
    /// The supports of A's volumes towards B.
    pub(super) a: Along,
    /// The supports of B's volumes towards A.
    pub(super) b: Along,
}

impl Axis {
    /// For bodies that are far apart, with volumes in a unit of `2^-exponent`. A's rotated volumes may be too small by
    /// `shrinkage`.
    #[inline(always)]
    pub(super) fn new<N: Lanes>(
        pose: &Pose,
        a: &BodyBounds,
        b: &BodyBounds,
        shrinkage: f64,
        exponent: i32,
    ) -> Option<Self> {
        let shift = shift(pose, a, &b.frame);
        let far = FAR * (a.radius + b.radius);
        if dot(&shift, &shift) > far * far {
            let line = Self::between::<N>(pose, (a, b), &shift, exponent);
            Some(Self { between: line.between - shrinkage, ..line })
        } else {
            None
        }
    }

    #[inline(never)]
    fn between<N: Lanes>(
        pose: &Pose,
        (a, b): (&BodyBounds, &BodyBounds),
        shift: &Point,
        exponent: i32,
    ) -> Self {
        let length = length(shift);
        let axis = shift.map(|x| x / length * SHORTENED);
        let m = pose.rows();
        let turned = |i: usize| -((m[0][i] * axis[0] + m[1][i] * axis[1]) + m[2][i] * axis[2]);
        let slack = slack_of_shift(pose, a, &b.frame);
        Self {
            axis,
            shift: *shift,
            between: dot(&axis, shift) * SHORTENED - slack,
            scale: power_of_two(exponent),
            a: N::along([turned(0), turned(1), turned(2)], a, exponent),
            b: N::along(axis, b, exponent),
        }
    }

    /// Converts a distance to the form of the bounds: relative to the distance of the centres, rounded up.
    pub(super) fn relative(&self, distance: f64) -> f32 {
        round_up_f32((distance - self.between) * self.scale)
    }

    /// Converts a bound to a distance, in the bodies' unit.
    pub(super) fn distance(&self, bound: f32) -> f64 {
        (self.between + f64::from(bound) / self.scale) * SHORTENED
    }

    /// The support of A's moved primitives towards B.
    #[inline(always)]
    pub(super) fn reach<P: Primitive>(&self, b: &Frame, items: &[P::Item]) -> f32 {
        let mut greatest = f64::NEG_INFINITY;
        for item in items {
            let radius = radius_of::<P>(item);
            for p in P::corners(item) {
                // The slack in `between` covers the rounding errors of this.
                let x = [0, 1, 2].map(|i| (p[i] - b.centre[i]) - self.shift[i]);
                let mut reach = -dot(&self.axis, &x);
                if P::IS_ROUND {
                    reach += radius;
                }
                greatest = if reach > greatest { reach } else { greatest };
            }
        }
        // Covers the rounding of the sum to which the result is added.
        let reach = greatest * self.scale;
        round_up_f32(reach + power_of_two(-22) * reach.abs())
    }
}
