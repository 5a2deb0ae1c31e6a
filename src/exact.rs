//! Exact sums of `f64`, and multi-word integers. The packer rounds up with them; the verifier and the exact tests
//! decide with them.

pub(crate) mod determinant;
pub(crate) mod wide;

/// `a + b` as its rounded sum and the exact error (Knuth's `TwoSum`).
#[inline]
pub(crate) const fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// A sum of up to `N` numbers as non-overlapping components of increasing magnitude (Shewchuk 1997, "Adaptive
/// precision floating-point arithmetic", `Grow-Expansion`). Exact if nothing overflows.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Expansion<const N: usize> {
    components: [f64; N],
    len: usize,
}

impl<const N: usize> Expansion<N> {
    pub(crate) const ZERO: Self = Self { components: [0.0; N], len: 0 };

    /// Adds one number. May be called at most `N` times in total.
    pub(crate) fn add(&mut self, term: f64) {
        let mut carry = term;
        for component in &mut self.components[..self.len] {
            (carry, *component) = two_sum(carry, *component);
        }
        self.components[self.len] = carry;
        self.len += 1;
    }

    /// Adds `n * x` exactly, by the powers of two in `n`: as many numbers as [`terms_of_multiple`] returns.
    pub(crate) fn add_multiple(&mut self, n: i16, x: f64) {
        let signed = if n < 0 { -x } else { x };
        let magnitude = n.unsigned_abs();
        for bit in 0..u16::BITS {
            if magnitude & (1 << bit) != 0 {
                self.add(signed * f64::from(1_u16 << bit));
            }
        }
    }

    /// -1, 0 or 1: the sign of the exact sum. The last nonzero component decides, since the others are smaller.
    pub(crate) fn sign(&self) -> i32 {
        let top = self.components[..self.len].iter().rev().find(|c| **c != 0.0);
        top.map_or(0, |c| if *c > 0.0 { 1 } else { -1 })
    }
}

/// How many numbers [`Expansion::add_multiple`] adds for `n`: one for each bit that is set.
pub(crate) const fn terms_of_multiple(n: i16) -> usize {
    n.unsigned_abs().count_ones() as usize
}

/// 2^`exponent`, for -1022 ..= 1023.
#[inline]
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The smallest `f32` that is not below `x`; +infinity for NaN.
#[inline]
pub(crate) fn round_up_f32(x: f64) -> f32 {
    // Branch-free, since the branch would be taken half of the time. The bits of the next number up are one more for
    // a positive number, one less for a negative one. Zero is only below a positive x, so -0 needs no successor.
    let nearest = x as f32;
    let bits = nearest.to_bits();
    let next = bits.wrapping_add(1_u32.wrapping_sub(2 * (bits >> 31)));
    let up = f32::from_bits(if f64::from(nearest) < x { next } else { bits });
    if up.is_nan() { f32::INFINITY } else { up }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_survives_cancellation() {
        let mut sum = Expansion::<6>::ZERO;
        for term in [1e30, 1.0, -1e30, -1.0, 1e-30] {
            sum.add(term);
        }
        assert_eq!(sum.sign(), 1);
        sum.add(-1e-30);
        assert_eq!(sum.sign(), 0);
    }

    #[test]
    fn multiples_are_exact() {
        let x = 1.0 + f64::EPSILON;
        for n in (-130..=130).chain([i16::MIN, -2047, -1024, 1023, 2047, i16::MAX]) {
            let mut sum = Expansion::<150>::ZERO;
            sum.add_multiple(n, x);
            assert_eq!(sum.len, terms_of_multiple(n), "{n}");
            assert_eq!(sum.sign(), i32::from(n.signum()));
            if n.unsigned_abs() > 130 {
                // The product as two exact numbers: x is one plus one ulp.
                sum.add(-f64::from(n));
                sum.add(-f64::from(n) * f64::EPSILON);
            }
            for _ in 0..n.unsigned_abs() % 131 * u16::from(n.unsigned_abs() <= 130) {
                sum.add(if n < 0 { x } else { -x });
            }
            assert_eq!(sum.sign(), 0, "{n}");
        }
    }

    #[test]
    fn f32_rounds_up() {
        assert_eq!(round_up_f32(1.0), 1.0);
        assert_eq!(round_up_f32(1.0 + 1e-12), 1.0_f32.next_up());
        assert_eq!(round_up_f32(-1.0 - 1e-12), -1.0);
        assert_eq!(round_up_f32(1e300), f32::INFINITY);
        assert_eq!(round_up_f32(-1e300), f32::MIN);
        assert_eq!(round_up_f32(f64::NAN), f32::INFINITY);
    }
}
