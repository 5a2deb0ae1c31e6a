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
        sqrt_f32(self)
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
