//! Balls against balls.

use super::super::{LEAST_VOLUME, LENS, LENS_SLACK, WHOLE};
use crate::node::{Ball16, BoundingBall};
use crate::vector::sqrt_f32;

/// Lanes of `b` that a ball meets: `|c_a - c_b|^2 <= (r_a + r_b)^2`, which is false for NaN.
pub(super) fn meet(a: &BoundingBall, b: &Ball16) -> u16 {
    (0..16).filter(|&i| is_met(&distances(a, &b.lane(i)))).fold(0, |mask, i| mask | 1 << i)
}

/// The square of the distance between the centres, and the sum of the radii.
fn distances(a: &BoundingBall, b: &BoundingBall) -> (f32, f32) {
    let [x, y, z] = [0, 1, 2].map(|i| a.centre[i] - b.centre[i]);
    ((x * x + y * y) + z * z, a.radius + b.radius)
}

fn is_met(&(square, sum): &(f32, f32)) -> bool {
    square <= sum * sum
}

/// For each lane of `b`, an upper bound of the volume that its spheres share with those in `a`: 0 if the balls do not
/// meet, else the least of both volumes and of the balls' lens, enlarged by more than its rounding error.
pub(super) fn shared(a: &BoundingBall, b: &Ball16) -> [f32; 16] {
    core::array::from_fn(|i| {
        let b = b.lane(i);
        let (square, sum) = distances(a, &b);
        let distance = sqrt_f32(square);
        let difference = (a.radius - b.radius).abs();
        let smaller = least(a.radius, b.radius);
        let depth = sum - distance;
        let rest = (distance - difference) * (distance + 3.0 * difference) + (4.0 * smaller) * distance;
        let slack = (LENS_SLACK * sum) * (smaller * smaller);
        let lens = (((depth * depth) * rest) / distance) * LENS + slack;
        let whole = ((smaller * smaller) * smaller) * WHOLE;
        let lens = if distance > difference { lens } else { whole };
        // The addition quiets a signalling NaN: LLVM compiles the comparison below to a maximum, and that of aarch64
        // returns NaN for a signalling one.
        let bound = least(lens, least(a.volume, b.volume)) + 0.0;
        let bound = if bound > LEAST_VOLUME { bound } else { LEAST_VOLUME };
        if is_met(&(square, sum)) { bound } else { 0.0 }
    })
}

/// The second unless the first is less.
fn least(x: f32, y: f32) -> f32 {
    if x < y { x } else { y }
}
