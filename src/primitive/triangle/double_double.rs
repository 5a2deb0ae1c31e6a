//! Numbers of 106 bits: an unevaluated sum of two `f64` (Dekker 1971; Joldes, Muller & Popescu, *Tight and rigorous
//! error bounds for basic building blocks of double-word arithmetic*, ACM TOMS 2017).
//!
//! The distance between two triangles uses them where 53 bits do not suffice. No fused multiply-add: Veltkamp's method
//! splits the factors of a product, so the bits are the same on every platform.

use super::features::Real;
use crate::exact::two_sum;
use core::ops::{Add, Div, Mul, Sub};
use glam::DVec3;

/// The sum `high + low`, not evaluated; `high` is the nearest `f64` to it.
#[derive(Copy, Clone, PartialEq, PartialOrd, Debug)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

/// [`two_sum`] for `|a| >= |b|`.
#[inline]
fn renormalised(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

/// The upper 26 bits of a number below 2^990, and the rest.
#[inline]
fn split(x: f64) -> (f64, f64) {
    const FACTOR: f64 = ((1_u64 << 27) + 1) as f64;
    let scaled = FACTOR * x;
    let high = scaled - (scaled - x);
    (high, x - high)
}

/// `a * b` as a rounded product and its error; exact unless the error underflows.
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

impl Add for DoubleDouble {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.high, other.high);
        let (low_sum, low_error) = two_sum(self.low, other.low);
        let first = renormalised(sum, error + low_sum);
        renormalised(first.high, first.low + low_error)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

// Products and quotients are not inlined, since the code would be several times as large. Sums are: a call takes longer
// than a sum.
impl Mul for DoubleDouble {
    type Output = Self;

    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let (product, error) = two_product(self.high, other.high);
        renormalised(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    /// Long division in three digits of 53 bits.
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        let digit = |rest: Self| Self { high: rest.high / other.high, low: 0.0 };
        let first = digit(self);
        let rest = self - other * first;
        let second = digit(rest);
        let third = digit(rest - other * second);
        renormalised(first.high, second.high) + third
    }
}

impl Real for DoubleDouble {
    const ZERO: Self = Self { high: 0.0, low: 0.0 };
    const ONE: Self = Self { high: 1.0, low: 0.0 };
    /// 2^-98. The bounds in the paper are below 10 units of 2^-106.
    const ROUNDOFF: f64 = f64::EPSILON * f64::EPSILON * 64.0;

    #[inline]
    fn scaled_difference(x: f64, y: f64, scale: f64) -> Self {
        let (high, low) = two_sum(x, -y);
        Self { high: high * scale, low: low * scale }
    }

    /// One Newton step from the root in `f64`, which squares the error.
    #[inline]
    fn length(v: &[Self; 3]) -> Self {
        let near = DVec3::new(v[0].high, v[1].high, v[2].high).length();
        if near == 0.0 {
            return Self::ZERO;
        }
        let root = Self { high: near, low: 0.0 };
        let square = (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2];
        root + (square - root * root) / (root + root)
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.high
    }

    #[inline]
    fn placed(self, origin: f64, unscale: f64) -> f64 {
        (Self { high: self.high * unscale, low: self.low * unscale } + Self { high: origin, low: 0.0 }).high
    }

    #[inline(never)]
    fn call<X, Y>(f: impl Fn(X) -> Y, x: X) -> Y {
        f(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use dashu_int::IBig;

    /// The exact value of a double-double of integers.
    fn value(x: DoubleDouble) -> IBig {
        IBig::from(x.high as i128) + IBig::from(x.low as i128)
    }

    fn random(rng: &mut Rng) -> DoubleDouble {
        let mut word = || ((rng.u64() >> 12) as i64 - (1 << 51)) as f64;
        let (high, low) = (word(), word());
        renormalised(high * (1_u64 << 50) as f64, low)
    }

    /// `|x| 2^-98 >= |error|`.
    fn close(error: IBig, x: IBig) -> bool {
        let magnitude = |x: IBig| if x < IBig::ZERO { -x } else { x };
        magnitude(error) << 98 <= magnitude(x)
    }

    #[test]
    fn sums_and_products_are_right_to_98_bits() {
        let rng = &mut Rng::new(1);
        for _ in 0..10_000 {
            let (x, y) = (random(rng), random(rng));
            let (a, b) = (value(x), value(y));
            assert!(close(value(x + y) - (&a + &b), &a + &b), "{x:?} + {y:?}");
            assert!(close(value(x - y) - (&a - &b), &a - &b), "{x:?} - {y:?}");
            // The product has 200 bits: an f64 holds it, an i128 does not.
            let unscale = |z: DoubleDouble| {
                value(DoubleDouble { high: z.high / 2_f64.powi(75), low: z.low / 2_f64.powi(75) })
            };
            let (product, exact) = (unscale(x * y), (&a * &b) >> 75);
            assert!(close((product - &exact) >> 1, exact), "{x:?} * {y:?}");
        }
    }

    #[test]
    fn quotients_and_roots_invert() {
        let rng = &mut Rng::new(2);
        for _ in 0..10_000 {
            let (x, y) = (random(rng), random(rng));
            let error = (x / y) * y - x;
            assert!(
                error.high.abs() <= x.high.abs() * 2.0 * DoubleDouble::ROUNDOFF,
                "{x:?} / {y:?}: {error:?}"
            );
            let length = DoubleDouble::length(&[x, y, x]);
            let error = length * length - ((x * x + y * y) + x * x);
            assert!(
                error.high.abs() <= (length * length).high * 3.0 * DoubleDouble::ROUNDOFF,
                "{x:?} {y:?}: {error:?}"
            );
        }
    }
}
