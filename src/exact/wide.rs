//! Multi-word integers, for signs of so high a degree that expansions would have thousands of components.

use super::power_of_two;

/// A signed integer of at most `64 L` bits.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Wide<const L: usize> {
    is_negative: bool,
    /// Number of words in use, least significant first. The last of them is nonzero; the words above are zero.
    len: usize,
    words: [u64; L],
}

/// The greatest `e` such that all numbers are multiples of 2^e; 0 if all are zero.
pub(crate) fn unit_of(numbers: impl IntoIterator<Item = f64>) -> i32 {
    numbers.into_iter().filter(|x| *x != 0.0).map(|x| parts(x).1).min().unwrap_or(0)
}

/// The odd m, or zero, and the e such that a finite number has the magnitude m 2^e.
fn parts(x: f64) -> (u64, i32) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    let (m, e) = if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    if m == 0 { (0, 0) } else { (m >> m.trailing_zeros(), e + m.trailing_zeros() as i32) }
}

impl<const L: usize> Wide<L> {
    pub(crate) const ZERO: Self = Self { is_negative: false, len: 0, words: [0; L] };

    /// `x`, a multiple of `2^unit`, in units of `2^unit`.
    ///
    /// # Panics
    /// If it does not fit. Sums and products panic likewise.
    pub(crate) fn new(x: f64, unit: i32) -> Self {
        let (m, e) = parts(x);
        let mut wide = Self::ZERO;
        if m != 0 {
            let shift = (e - unit) as usize;
            let (first, bits) = (shift / 64, shift % 64);
            let shifted = u128::from(m) << bits;
            wide.words[first] = shifted as u64;
            if shifted >> 64 != 0 {
                wide.words[first + 1] = (shifted >> 64) as u64;
            }
            wide.is_negative = x < 0.0;
            wide.trim(first + 2);
        }
        wide
    }

    /// Sets the number of words in use, which is at most `most`.
    fn trim(&mut self, most: usize) {
        let words = &self.words[..if most < L { most } else { L }];
        self.len = words.iter().rposition(|word| *word != 0).map_or(0, |last| last + 1);
    }

    /// -1, 0 or 1.
    pub(crate) const fn sign(&self) -> i32 {
        if self.len == 0 {
            0
        } else if self.is_negative {
            -1
        } else {
            1
        }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        self.combined(other, other.is_negative)
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.combined(other, !other.is_negative)
    }

    /// The sum of `self` and a number with the magnitude of `other` and the sign `is_negative`.
    fn combined(&self, other: &Self, is_negative: bool) -> Self {
        let order = |x: &Self, y: &Self| {
            let (p, q) = (x.words[..x.len].iter().rev(), y.words[..y.len].iter().rev());
            x.len.cmp(&y.len).then_with(|| p.cmp(q))
        };
        let is_less = order(self, other).is_lt();
        let (large, small) = if is_less { (other, self) } else { (self, other) };
        let mut result = *large;
        result.is_negative = if is_less { is_negative } else { self.is_negative };
        let adds = self.is_negative == is_negative;
        let mut carry = false;
        for i in 0..large.len {
            let (x, y) = (large.words[i], small.words[i]);
            let (half, first) = if adds { x.overflowing_add(y) } else { x.overflowing_sub(y) };
            let one = u64::from(carry);
            let (whole, second) = if adds { half.overflowing_add(one) } else { half.overflowing_sub(one) };
            (result.words[i], carry) = (whole, first | second);
        }
        if carry {
            result.words[large.len] = 1;
        }
        result.trim(large.len + 1);
        result
    }

    /// The product, in a width that must have room for it.
    pub(crate) fn times<const M: usize, const R: usize>(&self, other: &Wide<M>) -> Wide<R> {
        let mut result = Wide::<R>::ZERO;
        for (i, x) in self.words[..self.len].iter().enumerate() {
            let mut carry = 0;
            for (j, y) in other.words[..other.len].iter().enumerate() {
                // At most (2^64 - 1)^2 + 2 (2^64 - 1), which is 2^128 - 1.
                let sum = u128::from(*x) * u128::from(*y) + u128::from(result.words[i + j]) + carry;
                result.words[i + j] = sum as u64;
                carry = sum >> 64;
            }
            if carry != 0 {
                result.words[i + other.len] = carry as u64;
            }
        }
        result.is_negative = self.is_negative != other.is_negative;
        result.trim(self.len + other.len);
        result
    }

    /// `self / other * 2^exponent`, with a relative error of at most 2^-50. Nonzero results below the least normal
    /// `f64` become that number with their sign, never zero. `other` must not be zero.
    pub(crate) fn over<const M: usize>(&self, other: &Wide<M>, exponent: i32) -> f64 {
        let ((x, e), (y, f)) = (self.leading(), other.leading());
        let exponent = (exponent + e - f).clamp(-2000, 2000);
        let ratio = x / y * power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2);
        if self.len > 0 && ratio.abs() < f64::MIN_POSITIVE {
            return f64::MIN_POSITIVE.copysign(x / y);
        }
        ratio
    }

    /// The two leading words as a number below 2^128, and the exponent of its unit.
    fn leading(&self) -> (f64, i32) {
        let first = self.len.saturating_sub(2);
        let high =
            self.words[first..self.len].iter().rev().fold(0, |sum, word| sum << 64 | u128::from(*word));
        (if self.is_negative { -(high as f64) } else { high as f64 }, 64 * first as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use dashu_int::IBig;

    type Short = Wide<12>;

    fn value(x: &Short) -> IBig {
        let magnitude = x.words.iter().rev().fold(IBig::ZERO, |sum, word| (sum << 64) + IBig::from(*word));
        assert!(x.words[x.len..].iter().all(|word| *word == 0) && (x.len == 0 || x.words[x.len - 1] != 0));
        if x.is_negative { -magnitude } else { magnitude }
    }

    /// Sums, differences, products and quotients of numbers whose words are often all zeros or all ones.
    #[test]
    fn arithmetic_is_that_of_integers() {
        let mut rng = Rng::new(3);
        let mut word = || rng.u64() >> 11;
        let mut random = || {
            let mut wide = Short::ZERO;
            let len = word() as usize % 6;
            for place in &mut wide.words[..len] {
                *place = [0, u64::MAX, 1 << 63, word().wrapping_mul(word())][word() as usize % 4];
            }
            wide.trim(len);
            wide.is_negative = wide.len > 0 && word() % 2 == 0;
            wide
        };
        for _ in 0..20_000 {
            let (x, y) = (random(), random());
            let (a, b) = (value(&x), value(&y));
            assert_eq!(value(&x.plus(&y)), &a + &b);
            assert_eq!(value(&x.minus(&y)), &a - &b);
            assert_eq!(value(&x.times::<12, 12>(&y)), &a * &b);
            assert_eq!(x.sign(), if a == IBig::ZERO { 0 } else { i32::from(a > IBig::ZERO) * 2 - 1 });
            assert_eq!(x.minus(&x).sign(), 0);
            if y.len > 0 {
                // Compare in units of 2^-500, to 2^-50 relatively.
                let (ratio, scaled) = (x.over(&y, 0), (&a << 500) / &b);
                let (m, e) = parts(ratio);
                let got = IBig::from(m) << (500 + e) as usize;
                let (magnitude, sign) = if scaled < IBig::ZERO { (-scaled, -1.0) } else { (scaled, 1.0) };
                let off = if got > magnitude { &got - &magnitude } else { &magnitude - &got };
                assert!(off <= (&magnitude >> 50) + IBig::ONE && ratio * sign >= 0.0, "{ratio:e}");
            }
        }
    }

    #[test]
    fn numbers_of_any_size_become_integers() {
        for (x, unit, words) in [(1.5, -1, 1), (-0.75, -130, 3), (0.0, -5, 0), (5e-324, -1074, 1)] {
            let wide = Short::new(x, unit);
            assert_eq!((wide.len, wide.sign()), (words, i32::from(x > 0.0) - i32::from(x < 0.0)), "{x:e}");
            assert_eq!(wide.over(&Short::new(1.0, 0), unit), if x == 5e-324 { f64::MIN_POSITIVE } else { x });
            assert!(x == 0.0 || unit_of([x, 0.0]) >= unit);
        }
        assert_eq!(unit_of([3.0, 0.0, 0.25]), -2);
        assert_eq!(unit_of([0.0]), 0);
    }
}
