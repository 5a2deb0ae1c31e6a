//! AVX-512F, BW and VL.
//!
//! One slab of sixteen children is one zmm: a masked broadcast puts the query's two planes in its two halves, one `vpcmpgtw` gives 32
//! bits, `korord` collects them. The low 16 bits are planes 2s, the high 16 planes 2s + 1.
//!
//! Re-alignment is the AVX2 code under this token: Miri runs `vcvtph2ps ymm` but not its zmm form, and what no machine at hand
//! has run is not worth a kernel.

#![expect(unsafe_code, reason = "intrinsics that load, and calls that the token makes sound")]

use super::{Kernel, Query};
use crate::isa::{Avx512, compiled_for_avx512};
use crate::node::{Node4, Node16};
use crate::realign::Realignment;
use core::arch::x86_64::*;

impl Kernel for Avx512 {
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        Self::run(self, f)
    }

    #[inline(always)]
    fn overlap_1v16<const K: usize>(self, query: &Query<16, K>, lane: usize, node: &Node16<K>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { overlap_1v16(query, lane, node) }
    }

    #[inline(always)]
    fn overlap_16v1<const K: usize>(self, query: &Query<16, K>, node: &Node16<K>, lane: usize) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { overlap_16v1(query, node, lane) }
    }

    #[inline(always)]
    fn overlap_4v4<const K: usize>(self, query: &Query<4, K>, node: &Node4<K>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { overlap_4v4(query, node) }
    }

    #[inline(always)]
    fn realign_16<const K: usize>(self, map: &Realignment<K>, node: &Node16<K>) -> Query<16, K> {
        self.as_avx2().realign_16(map, node)
    }

    #[inline(always)]
    fn realign_4<const K: usize>(self, map: &Realignment<K>, node: &Node4<K>) -> Query<4, K> {
        self.as_avx2().realign_4(map, node)
    }
}

/// Lanes of the upper half of a zmm: planes 2s + 1.
const UPPER: __mmask32 = 0xffff_0000;

/// Whether to ask, after this slab, if every lane is separated already.
const fn may_exit<const K: usize>(slab: usize) -> bool {
    slab % 2 == 1 && slab + 1 < K / 2
}

/// Bit i: neither plane of any slab separated lane i.
const fn overlapping(separated: __mmask32) -> u16 {
    !(separated | separated >> 16) as u16
}

compiled_for_avx512! {
    #[inline]
    fn load_slab(planes: &[[i16; 16]; 2]) -> __m512i {
        // SAFETY: the two arrays have the 64 bytes that are read; the load asks for no alignment.
        unsafe { _mm512_loadu_si512(planes.as_ptr().cast()) }
    }
}

compiled_for_avx512! {
    #[inline]
    fn overlap_1v16<const K: usize>(query: &Query<16, K>, lane: usize, node: &Node16<K>) -> u16 {
        let lane = lane & 15;
        let mut separated: __mmask32 = 0;
        for slab in 0..K / 2 {
            let low = _mm512_set1_epi16(query[2 * slab][lane]);
            let both = _mm512_mask_set1_epi16(low, UPPER, query[2 * slab + 1][lane]);
            separated |= _mm512_cmpgt_epi16_mask(both, load_slab(pair(&node.planes, slab)));
            if may_exit::<K>(slab) && overlapping(separated) == 0 {
                return 0;
            }
        }
        overlapping(separated)
    }
}

compiled_for_avx512! {
    #[inline]
    fn overlap_16v1<const K: usize>(query: &Query<16, K>, node: &Node16<K>, lane: usize) -> u16 {
        let lane = lane & 15;
        let mut separated: __mmask32 = 0;
        for slab in 0..K / 2 {
            let low = _mm512_set1_epi16(node.planes[2 * slab][lane]);
            let both = _mm512_mask_set1_epi16(low, UPPER, node.planes[2 * slab + 1][lane]);
            separated |= _mm512_cmpgt_epi16_mask(load_slab(pair(query, slab)), both);
        }
        overlapping(separated)
    }
}

compiled_for_avx512! {
    #[inline]
    fn overlap_4v4<const K: usize>(query: &Query<4, K>, node: &Node4<K>) -> u16 {
        // A 128-bit register holds a slab: planes 2s in words 0..4, planes 2s + 1 in words 4..8. Broadcast to four quarters, a shuffle
        // within quarters spreads A's; B's are tiled.
        let slab_of = |planes: &[[i16; 4]; 2]| {
            // SAFETY: the two arrays have the 16 bytes that are read; the load asks for no alignment.
            let slab = unsafe { _mm_loadu_si128(planes.as_ptr().cast()) };
            _mm512_broadcast_i32x4(slab)
        };
        let spread = _mm512_set_epi16(
            7, 7, 7, 7, 6, 6, 6, 6, 5, 5, 5, 5, 4, 4, 4, 4, 3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0,
        );
        let tile = _mm512_set_epi16(
            7, 6, 5, 4, 7, 6, 5, 4, 7, 6, 5, 4, 7, 6, 5, 4, 3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0,
        );
        let mut separated: __mmask32 = 0;
        for slab in 0..K / 2 {
            let a = _mm512_permutexvar_epi16(spread, slab_of(pair(query, slab)));
            let b = _mm512_permutexvar_epi16(tile, slab_of(pair(&node.planes, slab)));
            separated |= _mm512_cmpgt_epi16_mask(a, b);
            if may_exit::<K>(slab) && overlapping(separated) == 0 {
                return 0;
            }
        }
        overlapping(separated)
    }
}

/// The two planes of a slab.
///
/// # Panics
/// If there is no such slab.
#[inline(always)]
fn pair<T, const K: usize>(planes: &[T; K], slab: usize) -> &[T; 2] {
    &planes.as_chunks::<2>().0[slab]
}
