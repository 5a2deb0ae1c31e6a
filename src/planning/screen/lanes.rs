//! Sixteen numbers at a time, one for each configuration.
//!
//! Plain loops over arrays, which the compiler vectorizes in functions compiled for an instruction set. No operation is
//! fused, and none comes from a library, so every instruction set gives the same bits.
//!
//! **Sine and cosine.** An angle of at most [`MOST_TURNED`] is reduced in `f64` to `r = angle - k pi/2` with pi/2 in
//! two parts, the first of which has 33 bits, so that its product with k is exact: r is off by less than 2^-40, and its
//! `f32` by 2^-25. `abs(r)` is at most pi/4 + 2^-25. The series of the sine ends before `r^11 / 11!`, that of the
//! cosine before `r^10 / 10!`, both below 2^-25. The last addition rounds by at most 2^-25, and the operations before
//! it by less than eight units of 2^-24 of 0.31. In all that is less than [`ANGLE_ERROR`].

use crate::exact::power_of_two;

/// Number of configurations tested at a time.
pub(in crate::planning) const LANES: usize = 16;

/// A number for each of sixteen configurations.
pub(super) type Lane16 = [f32; LANES];

/// A point for each of sixteen configurations.
pub(super) type Point16 = [Lane16; 3];

/// Relative rounding error of an operation.
pub(super) const UNIT: f64 = power_of_two(-24);

/// Largest accepted angle.
pub(super) const MOST_TURNED: f64 = 4096.0;

/// Upper bound of the error of a sine or cosine.
pub(super) const ANGLE_ERROR: f64 = 4.0 * UNIT;

/// Adding it rounds a number below 2^31 to an integer, in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
const QUARTERS: f64 = core::f64::consts::FRAC_2_PI;
/// The first 33 bits of pi/2, and the rest.
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

const SINE: [f32; 4] = [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0];
const COSINE: [f32; 4] = [-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0];

/// The sine and the cosine of each angle.
#[inline(always)]
pub(super) fn sine_and_cosine(angles: &[f64; LANES]) -> [Lane16; 2] {
    let (mut rest, mut quarters) = ([0.0_f32; LANES], [0_u32; LANES]);
    for lane in 0..LANES {
        let shifted = angles[lane] * QUARTERS + ROUND;
        let k = shifted - ROUND;
        rest[lane] = ((angles[lane] - k * QUARTER[0]) - k * QUARTER[1]) as f32;
        quarters[lane] = shifted.to_bits() as u32;
    }
    let [mut sines, mut cosines] = [[0.0_f32; LANES]; 2];
    for lane in 0..LANES {
        let (r, k) = (rest[lane], quarters[lane]);
        let z = r * r;
        let s = r + r * (z * (SINE[0] + z * (SINE[1] + z * (SINE[2] + z * SINE[3]))));
        let c = 1.0 + z * (COSINE[0] + z * (COSINE[1] + z * (COSINE[2] + z * COSINE[3])));
        let (s, c) = if k & 1 == 0 { (s, c) } else { (c, s) };
        sines[lane] = f32::from_bits(s.to_bits() ^ (k & 2) << 30);
        cosines[lane] = f32::from_bits(c.to_bits() ^ (k.wrapping_add(1) & 2) << 30);
    }
    [sines, cosines]
}

/// Flags of lanes: bit i of element i.
pub(super) type Flags = [u32; LANES];

/// The flags as one mask.
#[inline(always)]
pub(super) fn mask(flags: &Flags) -> u16 {
    flags.iter().fold(0, |mask, flag| mask | flag) as u16
}

/// The bit of a lane if a condition holds.
#[inline(always)]
pub(super) const fn flag(lane: usize, holds: bool) -> u32 {
    (holds as u32) << lane
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the library's sine in `f64`, in quadrants of both signs and near their ends.
    #[test]
    fn sines_are_within_their_error() {
        let mut random = crate::random::SplitMix64(1);
        let (mut worst, mut tried) = (0.0_f64, 0);
        let mut check = |angles: &[f64; LANES]| {
            let [sines, cosines] = sine_and_cosine(angles);
            for (lane, &angle) in angles.iter().enumerate() {
                let (s, c) = libm::sincos(angle);
                for off in [f64::from(sines[lane]) - s, f64::from(cosines[lane]) - c] {
                    worst = worst.max(off.abs());
                    assert!(off.abs() <= ANGLE_ERROR, "{angle}: {off}");
                }
                tried += 1;
            }
        };
        for reach in [1e-6, 0.8, 4.0, 100.0, MOST_TURNED] {
            for _ in 0..20_000 {
                let share = |random: &mut crate::random::SplitMix64| random.bits() as f64 / 2.0_f64.powi(64);
                check(&core::array::from_fn(|_| reach * (2.0 * share(&mut random) - 1.0)));
            }
        }
        for k in -2600..2600_i32 {
            let end = f64::from(k) * core::f64::consts::FRAC_PI_4;
            check(&core::array::from_fn(|i| end + (i as f64 - 7.5) * 1e-8));
        }
        // The bound is at most four times the observed error, so the test would detect a worse polynomial.
        assert!(worst > 0.25 * ANGLE_ERROR && tried > 1_000_000, "{worst} of {tried}");
    }
}
