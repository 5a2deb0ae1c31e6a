//! Four lanes.

use super::super::solids::{self, Register};
use crate::isa::{Neon, compiled_for_neon};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use core::arch::aarch64::*;

/// A register. Made only from a token.
#[derive(Copy, Clone)]
pub(super) struct FourFloats(float32x4_t);

impl Register for FourFloats {
    type Token = Neon;
    const LANES: usize = 4;

    #[inline(always)]
    fn splat(_: Neon, x: f32) -> Self {
        // SAFETY: the token proves the features that the intrinsic is compiled for.
        Self(unsafe { vdupq_n_f32(x) })
    }

    #[inline(always)]
    fn load(_: Neon, numbers: &[f32; 16], part: usize) -> Self {
        let some = &numbers.as_chunks::<4>().0[part];
        // SAFETY: the token proves the features; the array has the 16 bytes read; the load needs no alignment.
        Self(unsafe { vld1q_f32(some.as_ptr()) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vaddq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vsubq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vmulq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vdivq_f32(self.0, other.0) })
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vabsq_f32(self.0) })
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vsqrtq_f32(self.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        let greater = unsafe { vcgtq_f32(self.0, other.0) };
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vbslq_f32(greater, self.0, other.0) })
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        // SAFETY: a register exists only where a token does.
        let less = unsafe { vcltq_f32(self.0, other.0) };
        // SAFETY: a register exists only where a token does.
        Self(unsafe { vbslq_f32(less, self.0, other.0) })
    }

    #[inline(always)]
    fn exceeds(self, other: Self) -> u16 {
        // SAFETY: a register exists only where a token does.
        let greater = unsafe { vcgtq_f32(self.0, other.0) };
        // SAFETY: the array has the 16 bytes read; a register exists only where a token does.
        let bits = unsafe { vld1q_u32([1, 2, 4, 8].as_ptr()) };
        // SAFETY: a register exists only where a token does.
        let bits = unsafe { vandq_u32(greater, bits) };
        // SAFETY: a register exists only where a token does.
        (unsafe { vaddvq_u32(bits) }) as u16
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn decide<const M: usize, const N: usize>(
        token: Neon,
        query: &Solid<M>,
        lanes: &SolidLanes<N>,
    ) -> Decided {
        solids::decide::<FourFloats, M, N>(token, query, lanes)
    }
}
