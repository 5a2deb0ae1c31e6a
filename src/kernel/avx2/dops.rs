//! Children against children, and re-alignment, in AVX2.
//!
//! # 1vs16
//!
//! ```text
//! for each slab, planes j = 2s and 2s + 1:
//!     separated |= vpcmpgtw(vpbroadcastw(query[j][lane]), planes[j])      2 x (broadcast load, load + compare, or)
//!     k = 32, after the fourth slab: leave if all lanes are separated     vptest, branch
//! mask = !vpmovmskb(vpacksswb(separated))
//! ```
//!
//! Two 256-bit loads per plane, of which Zen 3 does two per cycle, give a lower bound of k cycles. **Tried, and
//! slower** (`benches/kernel.rs`, calls of real queries, L1, ns per node for k = 14 / 18 / 32, Zen 3; chosen: 5.6 / 7.0
//! / 12.2): an exit after every second slab 9.2 / 11.7 / 17.7, after every slab 11.4 / 15.2 / 16.1, after the second
//! only 7.1 / 8.2 / 13.4, none at k = 32 12.7. Half of the masks are empty, unpredictably, so an exit mispredicts as
//! often as it saves slabs. The same for 4vs4: 6.7 / 8.2 / 14.2 without an exit, 9.1 / 10.1 / 16.5 with one; loading
//! both planes of four children at once, 7.9 / 9.7 / 13.2.
//!
//! # 4vs4
//!
//! The four planes of A's children are broadcast, and one `vpshufb` spreads each to four lanes. Those of B's are
//! broadcast unchanged.
//!
//! # Re-alignment
//!
//! Codes are converted to floats once per plane of the node. Each rotated plane takes three multiplications and three
//! additions on 2 x 8 lanes; the two planes of a slab share their weights.
//!
//! | | decode | encode |
//! |---|---|---|
//! | fixed point | `vpunpcklwd`, `vpunpckhwd` with the signs, `vcvtdq2ps` | `vcvtps2dq` to the nearest code; `vpackssdw` joins sixteen in the order in which they were split |
//! | half float | codes to bits in three instructions, `vcvtph2ps` | `vcvtps2ph` towards positive infinity, bits to codes |

use super::super::{SEPARATED, Turned};
use crate::isa::compiled_for_avx2;
use crate::key::{EMPTY, Storage};
#[cfg(miri)]
use crate::key::{Half, half_code};
use crate::node::{Node4, Node16};
use crate::realign::{PrimitiveSlab, Realignment};
use core::arch::x86_64::*;
use core::mem::MaybeUninit;

/// Whether 1vs16 tests after this slab if all lanes are already separated. Measured: see the top of this file.
const fn may_exit<const K: usize>(slab: usize) -> bool {
    K > 26 && slab == 3
}

compiled_for_avx2! {
    #[inline]
    fn load(planes: &[i16; 16]) -> __m256i {
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        unsafe { _mm256_loadu_si256(planes.as_ptr().cast()) }
    }
}

compiled_for_avx2! {
    #[inline]
    fn load_4(planes: &[i16; 4]) -> __m128i {
        // SAFETY: the array has the 8 bytes read; the load needs no alignment.
        unsafe { _mm_loadl_epi64(planes.as_ptr().cast()) }
    }
}

compiled_for_avx2! {
    /// Bit i: lane i is all zeros.
    #[inline]
    fn zero_lanes(separated: __m256i) -> u16 {
        let bytes = _mm_packs_epi16(_mm256_castsi256_si128(separated), _mm256_extracti128_si256::<1>(separated));
        !(_mm_movemask_epi8(bytes) as u16)
    }
}

compiled_for_avx2! {
    #[inline]
    fn all_ones(separated: __m256i) -> bool {
        _mm256_testc_si256(separated, _mm256_set1_epi16(-1)) != 0
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K, S>,
    ) -> u16 {
        let lane = lane % W;
        let mut separated = _mm256_setzero_si256();
        for slab in 0..K / 2 {
            let beyond = |j: usize| {
                _mm256_cmpgt_epi16(_mm256_set1_epi16(query[j][lane]), load(&node.planes[j]))
            };
            separated = _mm256_or_si256(separated, _mm256_or_si256(beyond(2 * slab), beyond(2 * slab + 1)));
            if may_exit::<K>(slab) && all_ones(separated) {
                return 0;
            }
        }
        zero_lanes(separated)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn overlap_16v1<const K: usize, S: Storage>(
        query: &Turned<16, K>,
        node: &Node16<K, S>,
        lane: usize,
    ) -> u16 {
        let lane = lane & 15;
        let mut separated = _mm256_setzero_si256();
        for (bodies, planes) in query.iter().zip(&node.planes) {
            let beyond = _mm256_cmpgt_epi16(load(bodies), _mm256_set1_epi16(planes[lane]));
            separated = _mm256_or_si256(separated, beyond);
        }
        zero_lanes(separated)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn overlap_16v_hull<const K: usize, S: Storage>(query: &Turned<16, K>, node: &Node16<K, S>) -> u16 {
        // `vphminposuw` finds the least of eight unsigned words. The exclusive or maps the greatest signed word to the
        // least unsigned one, and back.
        let flip = _mm_set1_epi16(0x7fff);
        let mut separated = _mm256_setzero_si256();
        for (bodies, planes) in query.iter().zip(&node.planes) {
            let planes = load(planes);
            let eight = _mm_max_epi16(_mm256_castsi256_si128(planes), _mm256_extracti128_si256::<1>(planes));
            let greatest = _mm_xor_si128(_mm_minpos_epu16(_mm_xor_si128(eight, flip)), flip);
            let beyond = _mm256_cmpgt_epi16(load(bodies), _mm256_broadcastw_epi16(greatest));
            separated = _mm256_or_si256(separated, beyond);
        }
        zero_lanes(separated)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn overlap_4v4<const K: usize, S: Storage>(query: &Turned<4, K>, node: &Node4<K, S>) -> u16 {
        // Each half of the register holds all four planes. The lower half spreads the first two, the upper half the
        // last two.
        let spread = _mm256_setr_epi8(
            0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3, 2, 3, //
            4, 5, 4, 5, 4, 5, 4, 5, 6, 7, 6, 7, 6, 7, 6, 7,
        );
        let mut separated = _mm256_setzero_si256();
        for (a, b) in query.iter().zip(&node.planes) {
            let a = _mm256_shuffle_epi8(_mm256_broadcastq_epi64(load_4(a)), spread);
            let b = _mm256_broadcastq_epi64(load_4(b));
            separated = _mm256_or_si256(separated, _mm256_cmpgt_epi16(a, b));
        }
        zero_lanes(separated)
    }
}

compiled_for_avx2! {
    /// The bits of half floats with these codes, and the codes of bits.
    #[inline]
    fn flipped(codes: __m256i) -> __m256i {
        _mm256_xor_si256(codes, _mm256_srli_epi16::<1>(_mm256_srai_epi16::<15>(codes)))
    }
}

compiled_for_avx2! {
    /// Four codes, as floats; only the lowest quarter of the result is used.
    #[inline]
    fn decode_4<S: Storage>(codes: __m128i) -> __m256 {
        if S::IS_HALF {
            halves_to_floats(_mm256_castsi256_si128(flipped(_mm256_zextsi128_si256(codes))))
        } else {
            _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(codes))
        }
    }
}

compiled_for_avx2! {
    /// Sixteen codes, as floats. Half floats stay in order; in fixed point, lanes 0 to 3 and 8 to 11 come first, then
    /// the others. [`encode_query`] and [`in_order`] restore the order.
    #[inline]
    fn decode<S: Storage>(codes: __m256i) -> [__m256; 2] {
        if S::IS_HALF {
            let halves = flipped(codes);
            [
                halves_to_floats(_mm256_castsi256_si128(halves)),
                halves_to_floats(_mm256_extracti128_si256::<1>(halves)),
            ]
        } else {
            let signs = _mm256_srai_epi16::<15>(codes);
            [
                _mm256_cvtepi32_ps(_mm256_unpacklo_epi16(codes, signs)),
                _mm256_cvtepi32_ps(_mm256_unpackhi_epi16(codes, signs)),
            ]
        }
    }
}

compiled_for_avx2! {
    /// Sixteen 16-bit lanes that `vpackssdw` made of two registers of [`decode`]'s order.
    #[inline]
    fn in_order<S: Storage>(packed: __m256i) -> __m256i {
        if S::IS_HALF { _mm256_permute4x64_epi64::<0b11_01_10_00>(packed) } else { packed }
    }
}

compiled_for_avx2! {
    /// Rounds sixteen values to codes ([`Storage::around`]), and returns their complements.
    #[inline]
    fn encode_query<S: Storage>(values: [__m256; 2]) -> __m256i {
        // No closures here and in the kernels below: LLVM does not always inline them.
        let most = _mm256_set1_ps(if S::IS_HALF { f32::INFINITY } else { f32::from(S::INFINITY) });
        // NaN is an unbounded plane: if the first operand is NaN, `vminps` returns the second.
        let (low, high) = (_mm256_min_ps(values[0], most), _mm256_min_ps(values[1], most));
        let codes = if S::IS_HALF {
            let low = _mm256_castsi128_si256(floats_to_halves(low));
            flipped(_mm256_inserti128_si256::<1>(low, floats_to_halves(high)))
        } else {
            // Values below the range of `i32` become the least one.
            _mm256_packs_epi32(_mm256_cvtps_epi32(low), _mm256_cvtps_epi32(high))
        };
        let codes = _mm256_max_epi16(codes, _mm256_set1_epi16(!S::GREATEST));
        _mm256_xor_si256(codes, _mm256_set1_epi16(-1))
    }
}

compiled_for_avx2! {
    #[cfg(not(miri))]
    #[inline]
    fn halves_to_floats(halves: __m128i) -> __m256 {
        _mm256_cvtph_ps(halves)
    }
}

compiled_for_avx2! {
    /// Rounded towards positive infinity.
    #[cfg(not(miri))]
    #[inline]
    fn floats_to_halves(floats: __m256) -> __m128i {
        _mm256_cvtps_ph::<_MM_FROUND_TO_POS_INF>(floats)
    }
}

#[cfg(miri)] // Miri has none of the two instructions: these let it run the rest.
compiled_for_avx2! {
    fn halves_to_floats(halves: __m128i) -> __m256 {
        let mut codes = [0_i16; 8];
        // SAFETY: the array has the 16 bytes written; the store needs no alignment.
        unsafe { _mm_storeu_si128(codes.as_mut_ptr().cast(), halves) };
        let floats = codes.map(|bits| Half::number(half_code(bits)));
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        unsafe { _mm256_loadu_ps(floats.as_ptr()) }
    }
}

#[cfg(miri)]
compiled_for_avx2! {
    fn floats_to_halves(floats: __m256) -> __m128i {
        let mut numbers = [0.0_f32; 8];
        // SAFETY: the array has the 32 bytes written; the store needs no alignment.
        unsafe { _mm256_storeu_ps(numbers.as_mut_ptr(), floats) };
        let bits = numbers.map(|x| half_code(Half::around(x)));
        // SAFETY: the array has the 16 bytes read; the load needs no alignment.
        unsafe { _mm_loadu_si128(bits.as_ptr().cast()) }
    }
}

compiled_for_avx2! {
    #[inline]
    fn turn(weights: [__m256; 3], offset: __m256, planes: [__m256; 3]) -> __m256 {
        _mm256_add_ps(weighted_sum(weights, planes), offset)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn realign_16<const K: usize, S: Storage>(
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        // Not zeroed: that would be a kilobyte of stores.
        let mut planes = [const { MaybeUninit::<[__m256; 2]>::uninit() }; K];
        for (decoded, codes) in planes.iter_mut().zip(&node.planes) {
            decoded.write(decode::<S>(load(codes)));
        }
        for slab in 0..K / 2 {
            let [p, q, r, _] = map.sources[slab];
            let [u, v, w] = &map.weights;
            let weights = [_mm256_set1_ps(u[slab]), _mm256_set1_ps(v[slab]), _mm256_set1_ps(w[slab])];
            for side in 0..2 {
                // SAFETY: the loop above initialized all planes.
                let a = unsafe { planes[usize::from(p) ^ side].assume_init_ref() };
                // SAFETY: as above.
                let b = unsafe { planes[usize::from(q) ^ side].assume_init_ref() };
                // SAFETY: as above.
                let c = unsafe { planes[usize::from(r) ^ side].assume_init_ref() };
                let offset = _mm256_set1_ps(map.offset[2 * slab + side]);
                let low = turn(weights, offset, [a[0], b[0], c[0]]);
                let codes = encode_query::<S>([low, turn(weights, offset, [a[1], b[1], c[1]])]);
                // SAFETY: the array has the 32 bytes written; the store needs no alignment.
                unsafe { _mm256_storeu_si256(query[2 * slab + (side ^ 1)].as_mut_ptr().cast(), codes) };
            }
        }
        let unused = _mm256_cmpeq_epi16(load(&node.planes[0]), _mm256_set1_epi16(EMPTY));
        let codes = _mm256_blendv_epi8(load(&query[0]), _mm256_set1_epi16(SEPARATED), unused);
        // SAFETY: the array has the 32 bytes written; the store needs no alignment.
        unsafe { _mm256_storeu_si256(query[0].as_mut_ptr().cast(), codes) };
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn realign_4<const K: usize, S: Storage>(
        map: &Realignment<K, S>,
        node: &Node4<K, S>,
        query: &mut Turned<4, K>,
    ) {
        let mut planes = [_mm256_setzero_ps(); K];
        for (decoded, codes) in planes.iter_mut().zip(&node.planes) {
            *decoded = decode_4::<S>(load_4(codes));
        }
        for j in 0..K {
            let [(p, u), (q, v), (r, w)] = map.terms(j);
            let weights = [_mm256_set1_ps(u), _mm256_set1_ps(v), _mm256_set1_ps(w)];
            let turned = turn(weights, _mm256_set1_ps(map.offset[j]), [planes[p], planes[q], planes[r]]);
            let codes = _mm256_castsi256_si128(encode_query::<S>([turned, turned]));
            // SAFETY: the array has the 8 bytes written; the store needs no alignment.
            unsafe { _mm_storel_epi64(query[j ^ 1].as_mut_ptr().cast(), codes) };
        }
        let unused = _mm_cmpeq_epi16(load_4(&node.planes[0]), _mm_set1_epi16(EMPTY));
        let codes = _mm_blendv_epi8(load_4(&query[0]), _mm_set1_epi16(SEPARATED), unused);
        // SAFETY: the array has the 8 bytes written; the store needs no alignment.
        unsafe { _mm_storel_epi64(query[0].as_mut_ptr().cast(), codes) };
    }
}

compiled_for_avx2! {
    /// Weighted planes of eight children, added from left to right.
    #[inline]
    fn weighted_sum([u, v, w]: [__m256; 3], [x, y, z]: [__m256; 3]) -> __m256 {
        _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(u, x), _mm256_mul_ps(v, y)), _mm256_mul_ps(w, z))
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn beyond_16<const K: usize, S: Storage>(slab: &PrimitiveSlab, node: &Node16<K, S>) -> u16 {
        let [u, v, w] = slab.weights;
        let weights = [_mm256_set1_ps(u), _mm256_set1_ps(v), _mm256_set1_ps(w)];
        let [p, q, r] = slab.sources;
        let mut beyond = 0;
        for (side, limit) in slab.limits.into_iter().enumerate() {
            let a = decode::<S>(load(&node.planes[usize::from(p) ^ side]));
            let b = decode::<S>(load(&node.planes[usize::from(q) ^ side]));
            let c = decode::<S>(load(&node.planes[usize::from(r) ^ side]));
            let limit = _mm256_set1_ps(limit);
            let low = _mm256_cmp_ps::<_CMP_LT_OQ>(weighted_sum(weights, [a[0], b[0], c[0]]), limit);
            let high = _mm256_cmp_ps::<_CMP_LT_OQ>(weighted_sum(weights, [a[1], b[1], c[1]]), limit);
            let (low, high) = (_mm256_castps_si256(low), _mm256_castps_si256(high));
            beyond |= !zero_lanes(in_order::<S>(_mm256_packs_epi32(low, high)));
        }
        beyond
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn beyond_4<const K: usize, S: Storage>(slab: &PrimitiveSlab, node: &Node4<K, S>) -> u16 {
        let [u, v, w] = slab.weights;
        let weights = [_mm256_set1_ps(u), _mm256_set1_ps(v), _mm256_set1_ps(w)];
        let [p, q, r] = slab.sources;
        let mut beyond = 0;
        for (side, limit) in slab.limits.into_iter().enumerate() {
            let a = decode_4::<S>(load_4(&node.planes[usize::from(p) ^ side]));
            let b = decode_4::<S>(load_4(&node.planes[usize::from(q) ^ side]));
            let c = decode_4::<S>(load_4(&node.planes[usize::from(r) ^ side]));
            let sum = weighted_sum(weights, [a, b, c]);
            beyond |= _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(sum, _mm256_set1_ps(limit)));
        }
        // The upper lanes are zeros, not children.
        beyond as u16 & 0xf
    }
}
