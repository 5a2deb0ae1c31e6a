//! Bodies far apart: lower bounds of distances along the line through their centres.
//!
//! Let s be the way from the centre of B to that of A, and e a vector along s, at most of length 1. Points x of A and
//! y of B, each seen from the centre of its own body, are at least
//!
//! ```text
//! |s + x - y| >= e . s - (-e . x) - (e . y)
//! ```
//!
//! apart, and how far a volume reaches along e or -e follows from three of its planes, as in re-alignment. The
//! first term is the same for all volumes, so that only the others are compared: they are as large as the bodies,
//! and are rounded relative to that, whatever the distance. Squares of gaps ([`super::gaps`]) are rounded relative to the
//! distance.
//!
//! Along the line one does not see how far aside volumes are of each other: by w, say, which makes them farther apart
//! by `w^2 / (2 |s|)`. From [`FAR`] on that is little beside their sizes.

use super::Lanes;
use crate::directions::Directions;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::{BodyBounds, Frame};
use crate::key::decode;
use crate::pose::Pose;
use crate::primitive::{Primitive, radius_of};
use crate::range::Point;
use crate::realign::{F64_SLACK, GAMMA_5, HALF_PLACE, UNDERFLOW, shift, slack_of_shift};
use crate::vector::{dot, length};

/// Bodies are far apart whose centres are farther apart than this many times the sum of their sizes.
const FAR: f64 = 16.0;

/// Shortens vectors that were brought to length 1, and products of two, by more than their roundings.
const SHORTENED: f64 = 1.0 - power_of_two(-49);

/// The line through the centres of two bodies.
#[derive(Copy, Clone, Debug)]
pub(super) struct Axis {
    /// From B to A, at most of length 1.
    axis: Point,
    /// From the centre of B to that of A.
    shift: Point,
    /// How far the centres are apart along the axis, less all that is lost in `f64`. At least.
    between: f64,
    /// Of the unit of volumes.
    scale: f64,
    /// How far volumes of A reach towards B.
    pub(super) a: Along,
    /// How far volumes of B reach towards A.
    pub(super) b: Along,
}

impl Axis {
    /// Of bodies that are far apart, with volumes in a unit of `2^-exponent`, of which A's fall short by
    /// `shrinkage` once turned.
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

    /// A distance as bounds are: relative, rounded up.
    pub(super) fn relative(&self, distance: f64) -> f32 {
        round_up_f32((distance - self.between) * self.scale)
    }

    /// A bound as a distance, in the bodies' unit.
    pub(super) fn distance(&self, bound: f32) -> f64 {
        (self.between + f64::from(bound) / self.scale) * SHORTENED
    }

    /// How far moved primitives of A reach towards B.
    #[inline(always)]
    pub(super) fn reach<P: Primitive>(&self, b: &Frame, items: &[P::Item]) -> f32 {
        let mut greatest = f64::NEG_INFINITY;
        for item in items {
            let radius = radius_of::<P>(item);
            for p in P::corners(item) {
                // Its own roundings are within the slack of `between`.
                let x = [0, 1, 2].map(|i| (p[i] - b.centre[i]) - self.shift[i]);
                let mut reach = -dot(&self.axis, &x);
                if P::IS_ROUND {
                    reach += radius;
                }
                greatest = if reach > greatest { reach } else { greatest };
            }
        }
        // The sum that it goes into is rounded once.
        let reach = greatest * self.scale;
        round_up_f32(reach + power_of_two(-22) * reach.abs())
    }
}

/// How far volumes of one body reach along an axis: as far as three of their planes allow, by weights. Re-alignment
/// into one direction, relative to the centre of the body's own frame.
#[derive(Copy, Clone, Debug)]
pub struct Along {
    /// The planes.
    sources: [u8; 3],
    /// Not negative. They take planes to the wanted unit.
    weights: [f32; 3],
    /// Pays for every rounding on the way, the one of the sum that the result goes into too.
    pad: f32,
}

impl Along {
    /// For an axis in the body's own frame, at most a little longer than 1, in a unit of `2^-exponent`, which is not
    /// smaller than that of the body's frame.
    pub(crate) fn new<const K: usize>(axis: Point, body: &BodyBounds, exponent: i32) -> Self {
        let found = Directions::<K>::decompose(axis);
        let ratio = power_of_two(exponent - body.frame.exponent);
        let weights = found.weights.map(|c| (ratio * c) as f32);
        let weight_sum = (f64::from(weights[0]) + f64::from(weights[1])) + f64::from(weights[2]);
        let width_sum = body.width_sum();
        let residual = weight_sum * (HALF_PLACE * (Directions::<K>::MAX_COMPONENT * width_sum));
        let in_f64 = F64_SLACK * (4.0 * ratio * width_sum);
        let rounding = GAMMA_5 * (weight_sum * f64::from(body.max_plane));
        let pad = round_up_f32((((residual + in_f64) + rounding) + UNDERFLOW) * (1.0 + GAMMA_5));
        Self { sources: found.directions, weights, pad }
    }
}

/// How far the child in `lane` of a node with these codes reaches.
#[inline(always)]
pub(crate) fn reach_of<const W: usize, const K: usize>(
    codes: &[[i16; W]; K],
    along: &Along,
    lane: usize,
) -> f32 {
    let lane = lane % W;
    let mut reach = [0.0; 1];
    reaches(&along.sources.map(|source| [codes[usize::from(source)][lane]]), along, &mut reach);
    reach[0]
}

/// The bounds between the children of a node with these codes and a volume of the other body that reaches `other`
/// towards them.
#[inline(always)]
pub(crate) fn bounds<const W: usize, const K: usize>(
    codes: &[[i16; W]; K],
    along: &Along,
    other: f32,
) -> [f32; W] {
    let mut bounds = [0.0; W];
    reaches(&along.sources.map(|source| codes[usize::from(source)]), along, &mut bounds);
    for bound in &mut bounds {
        let apart = -(*bound + other);
        *bound = if apart > f32::MIN { apart } else { f32::MIN };
    }
    bounds
}

/// How far volumes reach of which `codes` are the planes that count.
#[inline(always)]
fn reaches<const W: usize>(codes: &[[i16; W]; 3], along: &Along, reach: &mut [f32; W]) {
    let [x, y, z] = codes;
    let [u, v, w] = along.weights;
    for lane in 0..W {
        reach[lane] = ((u * decode(x[lane]) + v * decode(y[lane])) + w * decode(z[lane])) + along.pad;
    }
}
