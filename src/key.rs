//! Keys: the codes of planes, 16 bits that compare as integers, in one of two storages.
//!
//! | storage | the value of code c | precision |
//! |---|---|---|
//! | [`Fixed`] | `c + 1/2` steps of the frame | 16 bits over the whole body |
//! | [`Half`] | the half float with the ordered code c | 11 bits anywhere, more about the centre |
//!
//! The unit of a tree's frame is one step of fixed point, chosen so that 16 bits cover the whole body
//! ([`crate::frame`]): a half float then counts these steps, up to 2^15.
//!
//! In both storages a plane is rounded **up**, keys order as their values do, and `value(!c) = -value(c)`. So the hot
//! loop compares a plane with the opposite plane of the other body by one 16-bit integer compare, without conversion,
//! and does not know the storage.
//!
//! Three codes are not planes of a body. [`Key::INFINITY`], in queries only, means that a rotated body is unbounded in
//! that direction, or extends farther than any plane. **[`Key::EMPTY`]** (`i16::MIN`) marks an unused lane: it is
//! below the complement of infinity, so that even a query that is unbounded in every direction is separated from it.
//! Its complement 32767 is in the queries of unused lanes, and is separated from everything.

mod fixed;
mod half;
mod storage;

pub use fixed::Fixed;
pub use half::Half;
#[cfg(all(miri, simdop_x86))]
pub(crate) use half::half_code;
pub(crate) use storage::EMPTY;
pub use storage::{Storage, StorageKind};

use core::fmt;
use core::marker::PhantomData;

/// The upper bound of a slab, in a storage. See the [module](crate::low_level::key) for the encoding.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Key<S = Fixed>(i16, PhantomData<S>);

/// The number to round was NaN, which is not a bound.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct NotANumber;

impl fmt::Display for NotANumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("NaN is not a bound")
    }
}

impl core::error::Error for NotANumber {}

impl<S: Storage> Key<S> {
    /// The greatest plane of a body.
    pub const GREATEST: Self = Self::of(S::GREATEST);
    /// Its negation, the lowest bound of a body.
    pub const LOWEST: Self = Self::of(!S::GREATEST);
    /// Unbounded in this direction. Never in a node.
    pub const INFINITY: Self = Self::of(S::INFINITY);
    /// The plane of an unused lane, separated from every query.
    pub const EMPTY: Self = Self::of(EMPTY);

    #[inline(always)]
    const fn of(code: i16) -> Self {
        Self(code, PhantomData)
    }

    /// The lowest bound not below `x`, in steps: [`Key::INFINITY`] if `x` is above [`Key::GREATEST`], and
    /// [`Key::LOWEST`] if it is below that.
    ///
    /// # Errors
    /// [`NotANumber`] if `x` is NaN.
    #[inline]
    pub fn round_up_f64(x: f64) -> Result<Self, NotANumber> {
        if x.is_nan() { Err(NotANumber) } else { Ok(Self::round_up_or_unbounded(x)) }
    }

    /// [`Key::round_up_f64`] for an `f32`.
    ///
    /// # Errors
    /// [`NotANumber`] if `x` is NaN.
    #[inline]
    pub fn round_up_f32(x: f32) -> Result<Self, NotANumber> {
        Self::round_up_f64(f64::from(x))
    }

    /// [`Key::round_up_f64`], with infinity for NaN: in re-alignment `0 * infinity` means "unbounded".
    #[inline]
    #[must_use]
    pub fn round_up_or_unbounded(x: f64) -> Self {
        Self::of(S::round_up(x))
    }

    /// [`Storage::around`].
    #[inline(always)]
    #[must_use]
    pub(crate) fn around(x: f32) -> Self {
        Self::of(S::around(x))
    }

    /// A fast bound not below `x`, by [`Key::around`]: in fixed point at most 1 + 2^-8 steps above `x`. For planes that
    /// are computed in a query.
    #[inline(always)]
    #[must_use]
    pub(crate) fn above(x: f64) -> Self {
        // Twice the error of rounding to `f32`.
        const MORE: f64 = 1.0 / (1 << 23) as f64;
        Self::around((x + x.abs() * MORE) as f32)
    }

    /// The key that both numbers round up to, if it is the same.
    #[cfg(any(test, feature = "alloc"))]
    #[inline]
    pub(crate) fn round_up_alike(low: f64, high: f64) -> Option<Self> {
        let (low, high) = (Self::round_up_or_unbounded(low), Self::round_up_or_unbounded(high));
        if low == high { Some(low) } else { None }
    }

    /// The key with this code, if it can be a plane of a body.
    #[inline]
    #[must_use]
    pub fn from_code(code: i16) -> Option<Self> {
        if S::is_plane(code) { Some(Self::of(code)) } else { None }
    }

    /// The next lower key, if there is one.
    #[cfg(feature = "alloc")]
    pub(crate) fn below(self) -> Option<Self> {
        let code = self.0 - 1;
        Self::from_code(code).or_else(|| Self::from_code(code - 1))
    }

    /// The next higher key, or [`Key::INFINITY`].
    #[cfg(feature = "alloc")]
    pub(crate) fn next(self) -> Self {
        let code = self.0 + 1;
        Self::from_code(code).or_else(|| Self::from_code(code + 1)).unwrap_or(Self::INFINITY)
    }

    /// The key with this code, which must be a plane of a body or [`Key::INFINITY`].
    #[inline(always)]
    #[must_use]
    pub(crate) const fn bounded(code: i16) -> Self {
        Self::of(code)
    }

    /// The stored 16 bits.
    #[inline]
    #[must_use]
    pub const fn code(self) -> i16 {
        self.0
    }

    /// The bound, in steps. Exact.
    #[inline]
    #[must_use]
    pub fn to_f32(self) -> f32 {
        S::value(self.0)
    }

    /// The bound, in steps. Exact.
    #[inline]
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.to_f32())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Key = super::Key<Fixed>;

    fn decode(code: i16) -> f32 {
        Fixed::value(code)
    }

    /// All planes of bodies, ascending.
    fn ascending() -> impl Iterator<Item = Key> {
        (i16::MIN..=i16::MAX).filter_map(Key::from_code)
    }

    #[test]
    fn keys_order_as_their_values_and_complement_negates() {
        assert_eq!(
            ascending().count(),
            65_532,
            "all codes but those of infinity, its complement, and unused lanes"
        );
        let mut last = f64::NEG_INFINITY;
        for key in ascending() {
            assert!(key.to_f64() > last, "{key:?}");
            last = key.to_f64();
            assert_eq!(f64::from(decode(!key.code())), -last, "complement of {key:?}");
            assert_eq!(last, f64::from(key.code()) + 0.5);
        }
    }

    #[test]
    fn rounds_up_exactly_at_every_boundary() {
        for key in ascending() {
            let value = key.to_f64();
            let above = Key::bounded(key.code() + 1);
            assert_eq!(Key::round_up_f64(value).unwrap(), key, "{value} is a bound");
            assert_eq!(Key::round_up_f64(value.next_up()).unwrap(), above, "just above {value}");
            assert_eq!(Key::round_up_f32(value as f32).unwrap(), key, "{value} is a bound, f32");
            assert_eq!(
                Key::round_up_f32((value as f32).next_up()).unwrap(),
                above,
                "just above {value}, f32"
            );
            for between in [value + 0.25, value + 0.5, (value + 1.0).next_down(), value + 1.0] {
                assert_eq!(Key::round_up_f64(between).unwrap(), above, "{between}");
            }
        }
        for tiny in [0.0, -0.0, f64::from_bits(1), -f64::from_bits(1), f64::MIN_POSITIVE, -1e-17] {
            assert_eq!(Key::round_up_f64(tiny).unwrap().code(), 0, "{tiny:e}");
        }
    }

    #[test]
    fn the_nearest_code_is_a_bound() {
        let check = |x: f32| {
            let (least, key) = (Key::round_up_or_unbounded(f64::from(x)), Key::around(x));
            let is_even_one_above =
                key.code() == least.code() + 1 && key.code() % 2 == 0 && decode(least.code()) == x;
            assert!(key == least || is_even_one_above, "{x:e}: {key:?}, the least is {least:?}");
        };
        // Arithmetic never gives a signalling NaN, which AArch64's minimum instructions treat differently.
        let signals = |x: &f32| x.is_nan() && x.to_bits() & 1 << 22 == 0;
        (0..=u32::MAX).step_by(997).map(f32::from_bits).filter(|x| !signals(x)).for_each(check);
        for code in i16::MIN..=i16::MAX {
            let value = decode(code);
            [value, value.next_up(), value.next_down(), value + 0.5, value + 0.25]
                .into_iter()
                .for_each(check);
        }
        let odd = [-1.5_f32, -0.5, 0.5, 1.5, 2.5].map(|x| Key::around(x).code());
        assert_eq!(odd, [-2, 0, 0, 2, 2], "of two the even one");
    }

    #[test]
    fn planes_made_in_a_query_are_bounds() {
        let check = |x: f64| {
            let (least, key) = (Key::round_up_or_unbounded(x), Key::above(x));
            assert!(
                key == least || key.code() == least.code() + 1 && key.to_f64() - x <= 1.01,
                "{x:e}: {key:?}, the least is {least:?}"
            );
        };
        for code in Key::LOWEST.code()..=Key::INFINITY.code() {
            let bound = f64::from(decode(code));
            [bound, bound.next_up(), bound.next_down(), bound + 0.5, bound + 1e-9]
                .into_iter()
                .for_each(check);
        }
        [0.0, -0.0, 1e-300, -1e-300, 1e300, -1e300, f64::INFINITY, f64::NAN].into_iter().for_each(check);
    }

    #[test]
    fn numbers_that_round_alike_are_found() {
        for key in ascending().step_by(13) {
            let value = key.to_f64();
            assert_eq!(Key::round_up_alike(value - 0.5, value), Some(key));
            assert_eq!(Key::round_up_alike(value, value.next_up()), None);
        }
    }

    #[test]
    fn the_ends_of_the_range() {
        let up = |x| Key::round_up_f64(x).unwrap();
        assert_eq!(up(32_765.5), Key::GREATEST);
        assert_eq!(up(32_765.5_f64.next_up()), Key::INFINITY);
        assert_eq!(up(f64::INFINITY), Key::INFINITY);
        assert_eq!(up(-32_765.5), Key::LOWEST);
        assert_eq!(up(f64::NEG_INFINITY), Key::LOWEST);
        assert_eq!(up(-1e300), Key::LOWEST);
        assert_eq!(Key::round_up_f64(f64::NAN), Err(NotANumber));
        assert_eq!(Key::round_up_f32(f32::NAN), Err(NotANumber));
        assert_eq!(Key::round_up_or_unbounded(f64::NAN), Key::INFINITY);
        for x in [f32::NAN, f32::INFINITY, 1e30, 32_766.0] {
            assert_eq!(Key::around(x), Key::INFINITY, "{x}");
        }
        for x in [f32::NEG_INFINITY, -1e30, -32_766.0] {
            assert_eq!(Key::around(x), Key::LOWEST, "{x}");
        }
        assert!(
            !Key::EMPTY.code() > Key::INFINITY.code() && !Key::INFINITY.code() > Key::EMPTY.code(),
            "unused lanes are separated from what is unbounded, either way"
        );
        assert!(
            Key::from_code(Key::INFINITY.code()).is_none() && Key::from_code(!Key::INFINITY.code()).is_none()
        );
        assert!(Key::from_code(Key::EMPTY.code()).is_none() && Key::from_code(i16::MAX).is_none());
    }
}
