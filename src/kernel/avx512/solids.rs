//! Sixteen lanes. `vmaxps` and `vminps` return their second operand unless the first is greater or less, as specified.

use super::super::solids::{self, Register};
#[cfg(miri)]
use super::points::{load, numbers};
use crate::isa::{Avx512, compiled_for_avx512};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use core::arch::x86_64::*;

/// A register. Made only from a token.
#[derive(Copy, Clone)]
pub(super) struct SixteenFloats(__m512);

impl Register for SixteenFloats {
    type Token = Avx512;
    const LANES: usize = 16;

    #[inline(always)]
    fn splat(_: Avx512, x: f32) -> Self {
        // SAFETY: the token proves the features that the intrinsic is compiled for.
        Self(unsafe { _mm512_set1_ps(x) })
    }

    #[inline(always)]
    fn load(_: Avx512, numbers: &[f32; 16], _: usize) -> Self {
        let some = numbers;
        // SAFETY: the token proves the features; the array has the 64 bytes read; the load needs no alignment.
        Self(unsafe { _mm512_loadu_ps(some.as_ptr()) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { greater(self.0, other.0) })
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { lesser(self.0, other.0) })
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> u16 {
        // SAFETY: a register exists only where a token does.
        unsafe { exceeds(self.0, other.0) }
    }
}

#[cfg(not(miri))]
compiled_for_avx512! {
    #[inline]
    fn greater(x: __m512, y: __m512) -> __m512 {
        _mm512_max_ps(x, y)
    }
}

#[cfg(not(miri))]
compiled_for_avx512! {
    #[inline]
    fn lesser(x: __m512, y: __m512) -> __m512 {
        _mm512_min_ps(x, y)
    }
}

#[cfg(not(miri))]
compiled_for_avx512! {
    #[inline]
    fn exceeds(x: __m512, y: __m512) -> u16 {
        _mm512_cmp_ps_mask::<_CMP_GT_OQ>(x, y)
    }
}

// Miri has none of these three in this width: this lets it run the rest.
#[cfg(miri)]
compiled_for_avx512! {
    fn greater(x: __m512, y: __m512) -> __m512 {
        let (p, q) = (numbers(x), numbers(y));
        load(&core::array::from_fn(|i| if p[i] > q[i] { p[i] } else { q[i] }))
    }
}

#[cfg(miri)]
compiled_for_avx512! {
    fn lesser(x: __m512, y: __m512) -> __m512 {
        let (p, q) = (numbers(x), numbers(y));
        load(&core::array::from_fn(|i| if p[i] < q[i] { p[i] } else { q[i] }))
    }
}

#[cfg(miri)]
compiled_for_avx512! {
    fn exceeds(x: __m512, y: __m512) -> u16 {
        let (p, q) = (numbers(x), numbers(y));
        (0..16).fold(0, |mask, lane| mask | u16::from(p[lane] > q[lane]) << lane)
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn decide<const M: usize, const N: usize>(
        token: Avx512,
        query: &Solid<M>,
        lanes: &SolidLanes<N>,
    ) -> Decided {
        solids::decide::<SixteenFloats, M, N>(token, query, lanes)
    }
}
