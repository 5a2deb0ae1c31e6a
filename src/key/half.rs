//! Half-float storage: IEEE 754 binary16, as its ordered code.

use super::storage::{Storage, StorageKind, sealed};

/// Planes are half floats, rounded up. The code of the bits h is h where the sign bit is clear, and `!(h & 0x7fff)`
/// where it is set, so that codes order as values do.
///
/// Half floats have eleven significant bits at any distance from the centre of the frame.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Half;

/// The code of the bits of a half float, and the bits of a code.
#[inline(always)]
pub(crate) const fn half_code(bits: i16) -> i16 {
    bits ^ (bits >> 15) & 0x7fff
}

/// Infinity of binary16.
const INFINITE: i16 = 0x7c00;

impl sealed::Sealed for Half {}

impl Storage for Half {
    const KIND: StorageKind = StorageKind::Half;
    const OFFSET: f32 = 0.0;
    const INFINITY: i16 = INFINITE;
    const GREATEST: i16 = INFINITE - 1;

    /// A code that is not a number gives NaN.
    #[inline(always)]
    fn number(code: i16) -> f32 {
        let bits = half_code(code) as u16;
        let magnitude = u32::from(bits & 0x7fff);
        // The exponent's bias is 127 instead of 15; the product is exact, also for subnormal halves.
        let scaled = f32::from_bits(magnitude << 13) * f32::from_bits((127 + 112) << 23);
        let special =
            if magnitude >= INFINITE as u32 { 0x7f80_0000 | magnitude << 13 } else { scaled.to_bits() };
        f32::from_bits(special | u32::from(bits & 0x8000) << 16)
    }

    /// Rounded towards positive infinity; negative numbers nearer to zero than any half become -0, whose code is -1.
    #[inline(always)]
    fn around(x: f32) -> i16 {
        // 65,536 is where infinity would be if it were a number.
        let x = if x < 65536.0 { x } else { 65536.0 };
        let x = if x > -65504.0 { x } else { -65504.0 };
        let bits = x.to_bits();
        let magnitude = bits & 0x7fff_ffff;
        // The exponent, at least that of the least normal half, 2^-14. One ulp of the half is 2^-10 of that.
        let exponent = magnitude & 0x7f80_0000;
        let exponent = if exponent > 113 << 23 { exponent } else { 113 << 23 };
        let places = f32::from_bits(magnitude) * f32::from_bits((254 << 23) - (exponent - (10 << 23)));
        // Below 2^12: the sum is rounded to an integer, in its low bits. Unlike casts, this compiles to vectors.
        const ROUNDING: f32 = 8_388_608.0;
        let sum = places + ROUNDING;
        let (nearest, rounded) = ((sum.to_bits() & 0xffff) as i32, sum - ROUNDING);
        let is_negative = bits >> 31 != 0;
        let correction =
            i32::from(!is_negative & (rounded < places)) - i32::from(is_negative & (rounded > places));
        let half = (((exponent >> 23) as i32 - 113) << 10) + nearest + correction;
        (if is_negative { !half } else { half }) as i16
    }

    fn round_up(x: f64) -> i16 {
        if x.is_nan() || x > 65504.0 {
            return Self::INFINITY;
        }
        if x < -65504.0 {
            return !Self::GREATEST;
        }
        let magnitude = x.abs();
        let exponent = (magnitude.to_bits() >> 52) as i32 - 1023;
        let exponent = if exponent > -14 { exponent } else { -14 };
        // A power of two, from its exponent.
        let places = magnitude * f64::from_bits(((1023 + 10 - exponent) as u64) << 52);
        let cut = places as i32;
        let up = i32::from(x > 0.0 && f64::from(cut) != places);
        let half = ((exponent + 14) << 10) + cut + up;
        // A plane of a body is never -0: compared with a plane that is exactly opposite, -0 would be beyond 0.
        (if x < 0.0 && half != 0 { !half } else { half }) as i16
    }

    #[inline]
    fn is_plane(code: i16) -> bool {
        (!Self::GREATEST..=Self::GREATEST).contains(&code) && code != -1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use half::f16;

    fn value(code: i16) -> f16 {
        f16::from_bits(half_code(code) as u16)
    }

    #[test]
    fn every_code_has_the_value_of_its_half() {
        for code in i16::MIN..=i16::MAX {
            let (number, half) = (Half::number(code), value(code).to_f32());
            assert!(
                number.to_bits() == half.to_bits() || number.is_nan() && half.is_nan(),
                "{code}: {number} {half}"
            );
            assert_eq!(half_code(half_code(code)), code);
            if !number.is_nan() {
                assert_eq!(Half::number(!code), -number, "{code}");
            }
            assert_eq!(Half::is_plane(code), number.is_finite() && code != -1, "{code}");
        }
        let finite = || (i16::MIN..=i16::MAX).filter(|code| Half::is_plane(*code));
        assert!(finite().zip(finite().skip(1)).all(|(a, b)| Half::number(a) < Half::number(b)));
    }

    /// The least half that is not below x, by the crate `half`.
    fn least(x: f64) -> f16 {
        let near = f16::from_f64(x);
        let code = half_code(near.to_bits() as i16);
        if f64::from(near) < x { value(code + 1 + i16::from(code == -1)) } else { near }
    }

    fn check(x: f32) {
        // Arithmetic never gives a signalling NaN, which AArch64's minimum instructions treat differently.
        if x.is_nan() && x.to_bits() & 1 << 22 == 0 {
            return;
        }
        let found = value(Half::around(x));
        let want = match x {
            _ if x.is_nan() || x > 65504.0 => f16::INFINITY,
            _ if x < -65504.0 => f16::MIN,
            _ => least(f64::from(x)),
        };
        assert!(found == want, "{x:e}: {found} {want}");
        // Negative numbers that round to zero give -0, as in the conversion instructions.
        if found == f16::ZERO {
            assert_eq!(found.is_sign_negative(), x.is_sign_negative(), "{x:e}");
        }
        let exact = Half::round_up(f64::from(x));
        assert!(value(exact) == want && exact != -1, "{x:e}: {exact}");
    }

    #[test]
    fn rounding_is_upwards_at_every_boundary_and_at_random() {
        for code in i16::MIN..=i16::MAX {
            let number = Half::number(code);
            let next = Half::number(code.wrapping_add(1));
            for x in [number, number.next_up(), number.next_down(), 0.5 * (number + next)] {
                check(x);
            }
            let exact = f64::from(number);
            if Half::is_plane(code) {
                assert_eq!(Half::round_up(exact), code);
                let above = if code == -2 { 0 } else { code + 1 };
                assert_eq!(Half::round_up(exact.next_up()), above, "just above {exact}");
            }
        }
        let mut rng = Rng::new(16);
        // All signs and exponents equally often.
        (0..1_000_000).for_each(|_| check(f32::from_bits(rng.u64() as u32)));
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e-45, -1e-45, 0.0, -0.0] {
            check(x);
        }
    }

    #[test]
    #[ignore = "seconds"]
    fn rounding_is_upwards_a_hundred_million_times() {
        let mut rng = Rng::new(17);
        (0..100_000_000).for_each(|_| check(f32::from_bits(rng.u64() as u32)));
    }
}
