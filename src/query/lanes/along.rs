//! Supports of volumes along an axis.

use crate::directions::Directions;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::BodyBounds;
use crate::key::Storage;
use crate::range::Point;
use crate::realign::{F64_SLACK, GAMMA_5, HALF_PLACE, UNDERFLOW};

/// Bounds the supports of one body's volumes along an axis, from three of their planes with weights: a re-alignment to
/// one direction, relative to the centre of the body's own frame.
#[derive(Copy, Clone, Debug)]
pub struct Along {
    /// The planes.
    sources: [u8; 3],
    /// Not negative. They convert planes to the wanted unit.
    weights: [f32; 3],
    /// Covers every rounding, including that of the sum to which the result is added.
    pad: f32,
}

impl Along {
    /// Takes an axis in the body's own frame, of length at most slightly above 1. The unit is `2^-exponent`, which is
    /// not smaller than that of the body's frame.
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

/// Upper bound of the support of child `lane` of a node with these codes.
#[inline(always)]
pub(crate) fn reach_of<const W: usize, const K: usize, S: Storage>(
    codes: &[[i16; W]; K],
    along: &Along,
    lane: usize,
) -> f32 {
    let lane = lane % W;
    let mut reach = [0.0; 1];
    reaches::<_, S>(&along.sources.map(|source| [codes[usize::from(source)][lane]]), along, &mut reach);
    reach[0]
}

/// Lower bounds of the gaps between the children of a node with these codes and a volume of the other body, whose
/// support towards them is `other`.
#[inline(always)]
pub(crate) fn bounds<const W: usize, const K: usize, S: Storage>(
    codes: &[[i16; W]; K],
    along: &Along,
    other: f32,
) -> [f32; W] {
    let mut bounds = [0.0; W];
    reaches::<_, S>(&along.sources.map(|source| codes[usize::from(source)]), along, &mut bounds);
    for bound in &mut bounds {
        let apart = -(*bound + other);
        *bound = if apart > f32::MIN { apart } else { f32::MIN };
    }
    bounds
}

/// Upper bounds of the supports of volumes; `codes` are their planes along the three sources.
#[inline(always)]
fn reaches<const W: usize, S: Storage>(codes: &[[i16; W]; 3], along: &Along, reach: &mut [f32; W]) {
    let [x, y, z] = codes;
    let [u, v, w] = along.weights;
    for lane in 0..W {
        reach[lane] = ((u * S::value(x[lane]) + v * S::value(y[lane])) + w * S::value(z[lane])) + along.pad;
    }
}
