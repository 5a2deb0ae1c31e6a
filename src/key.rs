//! Ordered half keys: IEEE 754 binary16 bounds that compare as 16-bit integers.
//!
//! A plane of a node is a half, rounded **up**, stored as its key
//!
//! ```text
//! key(h) = if h >= 0 { bits(h) } else { bits(h) ^ 0x7fff }      as i16
//! ```
//!
//! Keys order as the halves do, `key(-h) = !key(h)`, and the next larger half is `key + 1`, so the hot loop
//! needs no conversion from half to float at all: one 16-bit integer compare decides one plane of one child.
//!
//! Two codes need care. **-0** has key -1, below +0: a stored -0 would let a touch at 0 be missed, so no
//! function here makes it. **[`Key::EMPTY`]** (`i16::MIN`) marks an unused lane: it is below the key of
//! -infinity, so that even a query that is unbounded in every direction is separated from it.

use core::fmt;

/// The upper bound of a slab as an ordered half key. See the [module](self) for the code.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Key(i16);

/// The number to round was NaN, which bounds nothing.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct NotANumber;

impl fmt::Display for NotANumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("NaN is not a bound")
    }
}

impl core::error::Error for NotANumber {}

/// Bits of the largest finite half, 65504.
const MAX_FINITE_BITS: u16 = 0x7bff;

impl Key {
    /// +0.
    pub const ZERO: Self = Self(0);
    /// +infinity: the body is not bounded in this direction. Legal in a node.
    pub const INFINITY: Self = Self(0x7c00);
    /// -65504, the lowest finite half and the lowest bound a body can have.
    pub const LOWEST: Self = Self(!(MAX_FINITE_BITS as i16));
    /// The plane of an unused lane, separated from every query.
    pub const EMPTY: Self = Self(i16::MIN);

    /// The smallest half that is not below `x`: exact if `x` is a half, +infinity above 65504,
    /// [`Key::LOWEST`] below -65504; zero, of either sign, is [`Key::ZERO`].
    ///
    /// # Errors
    /// [`NotANumber`] if `x` is NaN.
    #[inline]
    pub const fn round_up_f64(x: f64) -> Result<Self, NotANumber> {
        if x.is_nan() { Err(NotANumber) } else { Ok(Self::round_up_or_unbounded(x)) }
    }

    /// [`Key::round_up_f64`] for an `f32`.
    ///
    /// # Errors
    /// [`NotANumber`] if `x` is NaN.
    #[inline]
    pub const fn round_up_f32(x: f32) -> Result<Self, NotANumber> {
        Self::round_up_f64(x as f64)
    }

    /// [`Key::round_up_f64`], with +infinity for NaN: the rule of re-alignment, where `0 * infinity` stands
    /// for "unbounded".
    #[inline]
    #[must_use]
    pub const fn round_up_or_unbounded(x: f64) -> Self {
        if x.is_nan() {
            return Self::INFINITY;
        }
        let bits = x.to_bits();
        let exponent = (bits >> FRACTION) as i32 & 0x7ff;
        if exponent >= 1023 - 14 && exponent <= 1023 + 15 {
            // Every plane in practice, so the one branch is foreseen; the sign would not be.
            let sign = (bits as i64 >> 63) as i16;
            let magnitude = (((bits >> DROPPED) & 0x1f_ffff) as i32 - ((1023 - 15) << 10)) as i16;
            let inexact = (bits & ((1 << DROPPED) - 1) != 0) as i16;
            return Self((magnitude ^ sign) + (inexact & !sign));
        }
        let (magnitude, inexact) = truncate_to_half(x.abs());
        if x > 0.0 {
            // The code after the largest finite half is +infinity, as it should be.
            Self((magnitude + inexact as u16) as i16)
        } else if magnitude == 0 {
            Self::ZERO
        } else {
            Self(!(magnitude as i16))
        }
    }

    /// [`Key::round_up_or_unbounded`] of an `f32`, nearly always without `f64`, which a microcontroller has to emulate.
    #[inline(always)]
    #[must_use]
    pub(crate) const fn round_up_single(x: f32) -> Self {
        const DROPPED: u32 = 23 - 10;
        const BIAS: i32 = (127 - 15) << 10;
        let bits = x.to_bits() as i32;
        let exponent = bits >> 23 & 0xff;
        if exponent < 127 - 14 || exponent > 127 + 15 {
            return Self::round_up_or_unbounded(x as f64);
        }
        // The complement of a negative number's magnitude, as in codes: a shift rounds it up, and a positive one down.
        let sign = bits >> 31;
        let ordered = bits ^ (sign as u32 >> 1) as i32;
        let up = (ordered + (((1 << DROPPED) - 1) & !sign)) >> DROPPED;
        Self((up - ((BIAS ^ sign) - sign)) as i16)
    }

    /// What both numbers round up to, if it is the same.
    #[cfg(any(test, feature = "alloc"))]
    #[inline]
    pub(crate) fn round_up_alike(low: f64, high: f64) -> Option<Self> {
        const DROPPED: u32 = 42;
        const INEXACT: u64 = (1 << DROPPED) - 1;
        // By far the most: two numbers between the same two neighbours among the normal halves.
        let (a, b) = (low.to_bits(), high.to_bits());
        let magnitude = ((a & !(1 << 63)) >> DROPPED).wrapping_sub((1023 - 15) << 10);
        let normal = magnitude.wrapping_sub(1 << 10) < (30 << 10);
        if normal && a >> DROPPED == b >> DROPPED && a & INEXACT != 0 && b & INEXACT != 0 {
            let magnitude = magnitude as i16;
            return Some(Self(if low > 0.0 { magnitude + 1 } else { !magnitude }));
        }
        let (low, high) = (Self::round_up_or_unbounded(low), Self::round_up_or_unbounded(high));
        if low == high { Some(low) } else { None }
    }

    /// The key with this code, if it can be the plane of a body: -65504 to +infinity, without -0. `None` for
    /// the rest: -0, -infinity, the NaN codes, and [`Key::EMPTY`].
    #[inline]
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        if code >= Self::LOWEST.0 && code <= Self::INFINITY.0 && code != -1 { Some(Self(code)) } else { None }
    }

    /// The stored 16 bits.
    #[inline]
    #[must_use]
    pub const fn code(self) -> i16 {
        self.0
    }

    /// The half's value. Exact. [`Key::EMPTY`] has none and reads as NaN.
    #[inline]
    #[must_use]
    pub fn to_f32(self) -> f32 {
        decode(self.0)
    }

    /// The half's value. Exact. [`Key::EMPTY`] has none and reads as NaN.
    #[inline]
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.to_f32())
    }
}

/// The value of any code; NaN for the codes that are none.
#[inline]
#[must_use]
pub fn decode(code: i16) -> f32 {
    let sign = i32::from(code) >> 31;
    let magnitude = (i32::from(code) ^ sign) as u32;
    let sign = sign as u32 & 1 << 31;
    if magnitude >= INFINITE {
        return half::f16::from_bits((magnitude | sign >> 16) as u16).to_f32_const();
    }
    // The half's exponent and fraction where a single has its own, 2^112 too small: exact for subnormals too.
    const SCALE: f32 = f32::from_bits((127 + 112) << 23);
    f32::from_bits(magnitude << 13 | sign) * SCALE
}

/// The exponent of halves that are infinite, or no numbers.
const INFINITE: u32 = 0x7c00;

/// Bits of the fraction of an `f64`, and how many of them a half drops.
const FRACTION: u32 = 52;
const DROPPED: u32 = FRACTION - 10;

/// The bits of the largest finite half that is not above `x`, and whether it differs from `x`. `x` is not
/// negative, not NaN.
const fn truncate_to_half(x: f64) -> (u16, bool) {
    let bits = x.to_bits();
    let exponent = (bits >> FRACTION) as i32 - 1023;
    let fraction = bits & ((1 << FRACTION) - 1);
    if exponent > 15 {
        (MAX_FINITE_BITS, true)
    } else if exponent >= -14 {
        let code = (((exponent + 15) as u64) << 10) | (fraction >> DROPPED);
        (code as u16, fraction & ((1 << DROPPED) - 1) != 0)
    } else if exponent >= -24 {
        // Subnormal: the step stays 2^-24 while the significand moves right.
        let significand = fraction | (1 << FRACTION);
        let shift = DROPPED + (-14 - exponent) as u32;
        ((significand >> shift) as u16, significand & ((1 << shift) - 1) != 0)
    } else {
        (0, bits != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of half bits by the definition in IEEE 754, in f64, written apart from the code above.
    fn half_value(bits: u16) -> f64 {
        let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
        let exponent = i32::from((bits >> 10) & 0x1f);
        let fraction = f64::from(bits & 0x3ff);
        let power = |e: i32| f64::from_bits(((e + 1023) as u64) << 52);
        match exponent {
            31 if fraction == 0.0 => sign * f64::INFINITY,
            31 => f64::NAN,
            0 => sign * fraction * power(-24),
            e => sign * (1024.0 + fraction) * power(e - 25),
        }
    }

    /// All finite halves but -0, ascending, with their keys by the formula in the module's text.
    fn ascending() -> alloc::vec::Vec<(f64, i16)> {
        let key = |bits: u16| if bits & 0x8000 == 0 { bits as i16 } else { (bits ^ 0x7fff) as i16 };
        let mut all: alloc::vec::Vec<(f64, i16)> = (0..=u16::MAX)
            .filter(|&b| half_value(b).is_finite() && b != 0x8000)
            .map(|b| (half_value(b), key(b)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    #[test]
    fn every_code_decodes_to_its_half() {
        for code in i16::MIN..=i16::MAX {
            let bits = if code >= 0 { code as u16 } else { (code ^ 0x7fff) as u16 };
            let (want, got) = (half_value(bits), f64::from(decode(code)));
            assert!(want.to_bits() == got.to_bits() || want.is_nan() && got.is_nan(), "{code}: {want} {got}");
        }
    }

    #[test]
    fn singles_round_up_as_doubles_do() {
        let check = |bits: u32| {
            let x = f32::from_bits(bits);
            assert_eq!(Key::round_up_single(x), Key::round_up_or_unbounded(f64::from(x)), "{x:e}");
        };
        (0..=u32::MAX).step_by(997).for_each(check);
        // Every half, and the singles beside it.
        for code in i16::MIN..=i16::MAX {
            let bits = decode(code).to_bits();
            [bits, bits.wrapping_add(1), bits.wrapping_sub(1)].into_iter().for_each(check);
        }
    }

    #[test]
    fn numbers_that_round_alike_are_found() {
        let next = |x: f64, steps: i64| f64::from_bits((x.to_bits() as i64 + steps) as u64);
        let rounded = |x: f64| Key::round_up_or_unbounded(x);
        for (half, _) in ascending().into_iter().chain([(0.0, 0), (1e-8, 0), (65520.0, 0), (1e300, 0)]) {
            for (below, above) in [(0, 0), (1, 3), (-3, -1), (-1, 1), (0, 5), (-5, 0)] {
                let (x, y) = (next(half, below), next(half, above));
                let (low, high) = (x.min(y), x.max(y));
                let want = if rounded(low) == rounded(high) { Some(rounded(low)) } else { None };
                assert_eq!(Key::round_up_alike(low, high), want, "{low:e} {high:e}");
            }
        }
    }

    #[test]
    fn keys_order_as_the_halves_and_complement_negates() {
        let all = ascending();
        assert_eq!(all.len(), 2 * 0x7c00 - 1, "every finite half but -0");
        for pair in all.windows(2) {
            assert!(pair[0].1 < pair[1].1, "{pair:?}");
        }
        for &(value, key) in &all {
            assert_eq!(f64::from(decode(!key)), -value, "complement of {key}");
        }
    }

    #[test]
    fn from_code_takes_planes_only() {
        let planes = ascending();
        for code in i16::MIN..=i16::MAX {
            let plane = planes.binary_search_by_key(&code, |p| p.1).is_ok() || code == 0x7c00;
            assert_eq!(Key::from_code(code).is_some(), plane, "{code}");
        }
    }

    #[test]
    fn rounds_up_exactly_at_every_boundary() {
        let all = ascending();
        for (i, &(value, key)) in all.iter().enumerate() {
            let above = all.get(i + 1).map_or(Key::INFINITY.code(), |p| p.1);
            assert_eq!(Key::round_up_f64(value).unwrap().code(), key, "{value} is a half");
            assert_eq!(Key::round_up_f64(value.next_up()).unwrap().code(), above, "just above {value}");
            let x = value as f32;
            assert_eq!(Key::round_up_f32(x).unwrap().code(), key, "{x} is a half, f32");
            assert_eq!(Key::round_up_f32(x.next_up()).unwrap().code(), above, "just above {x}, f32");
            if let Some(&(next, next_key)) = all.get(i + 1) {
                let middle = 0.5 * (value + next);
                assert_eq!(Key::round_up_f64(middle).unwrap().code(), next_key, "middle {middle}");
                assert_eq!(
                    Key::round_up_f64(next.next_down()).unwrap().code(),
                    next_key,
                    "just below {next}"
                );
                assert_eq!(
                    Key::round_up_f32((next as f32).next_down()).unwrap().code(),
                    next_key,
                    "below {next}, f32"
                );
            }
        }
    }

    #[test]
    fn the_ends_of_the_range() {
        let up = |x| Key::round_up_f64(x).unwrap();
        assert_eq!(up(-0.0), Key::ZERO, "-0 is stored as +0");
        assert_eq!(up(-f64::MIN_POSITIVE), Key::ZERO);
        assert_eq!(up(f64::from_bits(1)).code(), 1, "the smallest positive f64 needs the smallest half");
        assert_eq!(up(-f64::from_bits(1)), Key::ZERO);
        assert_eq!(up(65504.0).code(), 0x7bff);
        assert_eq!(up(65504.000001), Key::INFINITY);
        assert_eq!(up(f64::INFINITY), Key::INFINITY);
        assert_eq!(up(f64::NEG_INFINITY), Key::LOWEST);
        assert_eq!(up(-1e300), Key::LOWEST);
        assert_eq!(Key::round_up_f64(f64::NAN), Err(NotANumber));
        assert_eq!(Key::round_up_f32(f32::NAN), Err(NotANumber));
        assert_eq!(Key::round_up_or_unbounded(f64::NAN), Key::INFINITY);
        assert!(
            !Key::EMPTY.code() > !Key::INFINITY.code(),
            "an unbounded query is separated from an empty lane"
        );
    }

    #[test]
    fn f32_inputs_agree_with_the_definition() {
        // Every 4099th f32 pattern (a prime stride: all exponents, odd fractions) against a search in the
        // sorted halves.
        let all = ascending();
        for bits in (0..=u32::MAX).step_by(4099) {
            let x = f32::from_bits(bits);
            let Ok(key) = Key::round_up_f32(x) else {
                assert!(x.is_nan(), "{bits:x}");
                continue;
            };
            let i = all.partition_point(|p| p.0 < f64::from(x));
            assert_eq!(key.code(), all.get(i).map_or(Key::INFINITY.code(), |p| p.1), "{x:e}");
        }
    }
}
