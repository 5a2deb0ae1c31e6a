//! Fixed-point storage.

use super::storage::{Storage, StorageKind, sealed};

/// Planes are 16-bit fixed point: code c is `c + 1/2` steps of the frame.
///
/// Rotated planes are rounded to the nearest code, which is never below them: the value is half a step above the code.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Fixed;

impl sealed::Sealed for Fixed {}

impl Storage for Fixed {
    const KIND: StorageKind = StorageKind::Fixed;
    const OFFSET: f32 = 0.5;
    const INFINITY: i16 = i16::MAX - 1;
    const GREATEST: i16 = i16::MAX - 2;

    #[inline(always)]
    fn number(code: i16) -> f32 {
        f32::from(code)
    }

    /// The nearest code, ties to even, since there are instructions for it.
    #[inline(always)]
    fn around(x: f32) -> i16 {
        // 1.5 * 2^23: its ulp is 1, so the sum is rounded to an integer, with the code in its low bits.
        const ROUNDING: f32 = 12_582_912.0;
        let x = if x < f32::from(Self::INFINITY) { x } else { f32::from(Self::INFINITY) };
        let x = if x > f32::from(!Self::GREATEST) { x } else { f32::from(!Self::GREATEST) };
        (x + ROUNDING).to_bits() as i16
    }

    fn round_up(x: f64) -> i16 {
        const MOST: f64 = Fixed::GREATEST as f64 + 0.5;
        if x.is_nan() || x > MOST {
            return Self::INFINITY;
        }
        if x < -MOST {
            return !Self::GREATEST;
        }
        // A cast truncates towards zero. All numbers here are exact.
        let cut = x as i32;
        let below = cut - i32::from(f64::from(cut) > x);
        (below + i32::from(x > f64::from(below) + 0.5)) as i16
    }

    #[inline]
    fn is_plane(code: i16) -> bool {
        (!Self::GREATEST..=Self::GREATEST).contains(&code)
    }
}
