//! Eight lanes. `vmaxps` and `vminps` return their second operand unless the first is greater or less, as specified.

use super::super::solids::{self, Register};
use crate::isa::{Avx2, compiled_for_avx2};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use core::arch::x86_64::*;

/// A register. Made only from a token.
#[derive(Copy, Clone)]
pub(super) struct EightFloats(__m256);

impl Register for EightFloats {
    type Token = Avx2;
    const LANES: usize = 8;

    #[inline(always)]
    fn splat(_: Avx2, x: f32) -> Self {
        // SAFETY: the token proves the features that the intrinsic is compiled for.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(_: Avx2, numbers: &[f32; 16], part: usize) -> Self {
        let some = &numbers.as_chunks::<8>().0[part];
        // SAFETY: the token proves the features; the array has the 32 bytes read; the load needs no alignment.
        Self(unsafe { _mm256_loadu_ps(some.as_ptr()) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        // SAFETY: a register exists only where a token does.
        let sign = unsafe { _mm256_set1_ps(-0.0) };
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_andnot_ps(sign, self.0) })
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> u16 {
        // SAFETY: a register exists only where a token does.
        let greater = unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) };
        // SAFETY: a register exists only where a token does.
        (unsafe { _mm256_movemask_ps(greater) }) as u16
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn decide<const M: usize, const N: usize>(
        token: Avx2,
        query: &Solid<M>,
        lanes: &SolidLanes<N>,
    ) -> Decided {
        solids::decide::<EightFloats, M, N>(token, query, lanes)
    }
}
