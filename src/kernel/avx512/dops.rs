//! Children against children in AVX-512.
//!
//! One slab of sixteen children is one zmm: a masked broadcast puts the query's two planes in its two halves,
//! one `vpcmpgtw` gives 32 bits, `korord` collects them. The low 16 bits are planes 2s, the high 16 planes
//! 2s + 1.
//!
//! Re-alignment has a turned plane of sixteen children in one zmm, and the two of a slab are made codes and stored together. Own slabs
//! are compared sixteen children at a time. The hull of a root, re-alignment of four children and triangles are the AVX2 code under
//! this token.

use super::super::{SEPARATED, Turned};
use crate::isa::compiled_for_avx512;
use crate::key::Key;
use crate::node::{Node4, Node16};
use crate::realign::{OwnSlab, Realignment};
use core::arch::x86_64::*;
use core::mem::MaybeUninit;

/// Lanes of the upper half of a zmm: planes 2s + 1.
const UPPER: __mmask32 = 0xffff_0000;

/// Whether 1vs16 asks, after this slab, if every lane is separated already: as measured for AVX2, no more.
const fn may_exit<const K: usize>(slab: usize) -> bool {
    K > 26 && slab == 3
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
    fn load_bytes(bytes: &[u8; 64]) -> __m512i {
        // SAFETY: the array has the 64 bytes that are read; the load asks for no alignment.
        unsafe { _mm512_loadu_si512(bytes.as_ptr().cast()) }
    }
}

/// For 4vs4: where each byte of a zmm comes from in the slab of four bodies that every quarter of it holds.
/// Lane `4 a + b` of the lower half takes word a, or b, of plane 2s; of the upper half, of plane 2s + 1.
const fn bytes_of_bodies(of_a: bool) -> [u8; 64] {
    let mut bytes = [0; 64];
    let mut i = 0;
    while i < 64 {
        let (word, byte) = (i / 2, i % 2);
        let (plane, lane) = (word / 16, word % 16);
        let body = if of_a { lane / 4 } else { lane % 4 };
        bytes[i] = (2 * (4 * plane + body) + byte) as u8;
        i += 1;
    }
    bytes
}

const SPREAD: [u8; 64] = bytes_of_bodies(true);
const TILE: [u8; 64] = bytes_of_bodies(false);

compiled_for_avx512! {
    #[inline]
    pub(super) fn overlap_1v16<const W: usize, const K: usize>(
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K>,
    ) -> u16 {
        let lane = lane % W;
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
    pub(super) fn overlap_16v1<const K: usize>(query: &Turned<16, K>, node: &Node16<K>, lane: usize) -> u16 {
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
    pub(super) fn overlap_4v4<const K: usize>(query: &Turned<4, K>, node: &Node4<K>) -> u16 {
        // A 128-bit register holds a slab: planes 2s in words 0..4, planes 2s + 1 in words 4..8. All four quarters get it, and pick theirs.
        let slab_of = |planes: &[[i16; 4]; 2]| {
            // SAFETY: the two arrays have the 16 bytes that are read; the load asks for no alignment.
            let slab = unsafe { _mm_loadu_si128(planes.as_ptr().cast()) };
            _mm512_broadcast_i32x4(slab)
        };
        let (spread, tile) = (load_bytes(&SPREAD), load_bytes(&TILE));
        let mut separated: __mmask32 = 0;
        for slab in 0..K / 2 {
            let a = _mm512_shuffle_epi8(slab_of(pair(query, slab)), spread);
            let b = _mm512_shuffle_epi8(slab_of(pair(&node.planes, slab)), tile);
            separated |= _mm512_cmpgt_epi16_mask(a, b);
        }
        overlapping(separated)
    }
}

compiled_for_avx512! {
    /// Sixteen codes, as floats.
    #[inline]
    fn decode(planes: &[i16; 16]) -> __m512 {
        // SAFETY: the array has the 32 bytes that are read; the load asks for no alignment.
        let codes = unsafe { _mm256_loadu_si256(planes.as_ptr().cast()) };
        _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(codes))
    }
}

compiled_for_avx512! {
    /// Weighted planes of sixteen children, added from left to right.
    #[inline]
    fn weighted_sum([u, v, w]: [__m512; 3], [x, y, z]: [__m512; 3]) -> __m512 {
        _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(u, x), _mm512_mul_ps(v, y)), _mm512_mul_ps(w, z))
    }
}

compiled_for_avx512! {
    /// The nearest integers, of what is not above [`Key::INFINITY`]; below an `i32` the least one.
    #[cfg(not(miri))]
    #[inline]
    fn nearest(values: __m512) -> __m512i {
        // NaN is an unbounded plane: with it as the first operand, `vminps` gives the second.
        let bounded = _mm512_min_ps(values, _mm512_set1_ps(f32::from(Key::INFINITY.code())));
        _mm512_cvtps_epi32(bounded)
    }
}

#[cfg(miri)] // Miri has neither instruction of this width: this lets it run the rest.
compiled_for_avx512! {
    fn nearest(values: __m512) -> __m512i {
        let most = f32::from(Key::INFINITY.code());
        let nearest = |x: f32| if x < most { x.round_ties_even() as i32 } else { most as i32 };
        let integers = super::points::numbers(values).map(nearest);
        // SAFETY: the array has the 64 bytes that are read; the load asks for no alignment.
        unsafe { _mm512_loadu_si512(integers.as_ptr().cast()) }
    }
}

compiled_for_avx512! {
    #[cfg(not(miri))]
    #[inline]
    fn below(sums: __m512, limit: f32) -> u16 {
        _mm512_cmp_ps_mask::<_CMP_LT_OQ>(sums, _mm512_set1_ps(limit))
    }
}

#[cfg(miri)] // Nor `vcmpps` of this width.
compiled_for_avx512! {
    fn below(sums: __m512, limit: f32) -> u16 {
        let sums = super::points::numbers(sums);
        (0..16).fold(0, |mask, lane| mask | u16::from(sums[lane] < limit) << lane)
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn realign_16<const K: usize>(map: &Realignment<K>, node: &Node16<K>, query: &mut Turned<16, K>) {
        // Not zeroed: a kilobyte of stores.
        let mut planes = [const { MaybeUninit::<__m512>::uninit() }; K];
        for (decoded, codes) in planes.iter_mut().zip(&node.planes) {
            decoded.write(decode(codes));
        }
        // `vpackssdw` takes four of either plane in turns.
        let in_order = _mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7);
        for slab in 0..K / 2 {
            let [p, q, r, _] = map.sources[slab];
            let weights = [0, 1, 2].map(|l| _mm512_set1_ps(map.weights[l][slab]));
            let turned = |side: usize| {
                // SAFETY: the loop above wrote all of them.
                let sources = [p, q, r].map(|source| unsafe { planes[usize::from(source) ^ side].assume_init() });
                let offset = _mm512_set1_ps(map.offset[2 * slab + side]);
                nearest(_mm512_add_ps(weighted_sum(weights, sources), offset))
            };
            let codes = _mm512_max_epi16(_mm512_packs_epi32(turned(1), turned(0)), _mm512_set1_epi16(Key::LOWEST.code()));
            let complements = _mm512_xor_si512(codes, _mm512_set1_epi16(-1));
            let codes = _mm512_permutexvar_epi64(in_order, complements);
            let (slabs, _) = query.as_chunks_mut::<2>();
            let slab = slabs[slab].as_mut_ptr();
            // SAFETY: the two arrays have the 64 bytes that are written; the store asks for no alignment.
            unsafe { _mm512_storeu_si512(slab.cast(), codes) };
        }
        for (turned, code) in query[0].iter_mut().zip(&node.planes[0]) {
            *turned = if *code == Key::EMPTY.code() { SEPARATED } else { *turned };
        }
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn beyond_16<const K: usize>(slab: &OwnSlab, node: &Node16<K>) -> u16 {
        let weights = slab.weights.map(|weight| _mm512_set1_ps(weight));
        let mut beyond = 0;
        for (side, limit) in slab.limits.into_iter().enumerate() {
            let planes = slab.sources.map(|source| decode(&node.planes[usize::from(source) ^ side]));
            beyond |= below(weighted_sum(weights, planes), limit);
        }
        beyond
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
