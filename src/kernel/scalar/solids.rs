//! One lane.

use super::super::solids::Register;
use crate::isa::Scalar;
use crate::vector::sqrt_f32;

impl Register for f32 {
    type Token = Scalar;
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(_: Scalar, x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn load(_: Scalar, numbers: &[f32; 16], part: usize) -> Self {
        numbers[part]
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn root(self) -> Self {
        root(self)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> u16 {
        u16::from(self > other)
    }
}

#[cfg(not(miri))]
#[inline(always)]
fn root(x: f32) -> f32 {
    sqrt_f32(x)
}

/// Bit by bit: libm has inline assembly, which Miri does not run. Squares of 25 bits are exact in `f64`.
#[cfg(miri)]
fn root(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 || x.is_infinite() {
        return if x < 0.0 { f32::NAN } else { x };
    }
    let is_at_most = |y: f64| y * y <= f64::from(x);
    let mut low = 0_u32;
    for bit in (0..31).rev() {
        let next = low | 1 << bit;
        if next < f32::INFINITY.to_bits() && is_at_most(f64::from(f32::from_bits(next))) {
            low = next;
        }
    }
    let (root, next) = (f32::from_bits(low), f32::from_bits(low + 1));
    if is_at_most(0.5 * (f64::from(root) + f64::from(next))) { next } else { root }
}
