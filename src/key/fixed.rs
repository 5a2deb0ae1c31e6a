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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const GREATEST: i32 = Fixed::GREATEST as i32;

    /// The value of a code, in f64, where it is exact.
    fn value(code: i32) -> f64 {
        f64::from(code) + 0.5
    }

    fn check(x: f32) {
        // Arithmetic never gives a signalling NaN, which AArch64's minimum instructions treat differently.
        if x.is_nan() && x.to_bits() & 1 << 22 == 0 {
            return;
        }
        let exact = f64::from(x);
        let rotated = Fixed::around(x);
        let want = match exact.round_ties_even() {
            nearest if nearest.is_nan() || nearest > f64::from(GREATEST) => Fixed::INFINITY,
            nearest if nearest < f64::from(-GREATEST - 1) => !Fixed::GREATEST,
            nearest => nearest as i16,
        };
        assert_eq!(rotated, want, "{x:e}");
        if rotated != Fixed::INFINITY {
            assert!(value(rotated.into()) >= exact, "{x:e}: {rotated}");
        }
        check_exact(exact);
    }

    /// The code bounds the number, and the next lower one does not.
    fn check_exact(x: f64) {
        let code = Fixed::round_up(x);
        if x.is_nan() || x > value(GREATEST) {
            assert_eq!(code, Fixed::INFINITY, "{x:e}");
            return;
        }
        assert!(Fixed::is_plane(code) && value(code.into()) >= x, "{x:e}: {code}");
        assert!(code == !Fixed::GREATEST || value(i32::from(code) - 1) < x, "{x:e}: {code}");
    }

    #[test]
    fn rounding_is_upwards_at_every_boundary_and_at_random() {
        for code in i16::MIN..=i16::MAX {
            let number = Fixed::number(code);
            assert_eq!((number, Fixed::value(code)), (f32::from(code), f32::from(code) + 0.5));
            assert_eq!(Fixed::value(!code), -Fixed::value(code), "{code}");
            for x in [number, Fixed::value(code)] {
                [x, x.next_up(), x.next_down()].into_iter().for_each(check);
                [f64::from(x).next_up(), f64::from(x).next_down()].into_iter().for_each(check_exact);
            }
        }
        let mut rng = Rng::new(18);
        (0..1_000_000).for_each(|_| check(random(&mut rng)));
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e-45, -1e-45, 0.0, -0.0] {
            check(x);
        }
    }

    /// Half of them are any number, and half of them are near codes.
    fn random(rng: &mut Rng) -> f32 {
        let bits = rng.u64();
        let any = f32::from_bits(bits as u32);
        if bits >> 63 == 0 { any } else { ((bits as i32) as f32) * (33_000.0 / 2_147_483_648.0) }
    }

    #[test]
    #[ignore = "seconds"]
    fn rounding_is_upwards_a_hundred_million_times() {
        let mut rng = Rng::new(19);
        (0..100_000_000).for_each(|_| check(random(&mut rng)));
    }
}
