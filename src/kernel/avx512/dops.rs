//! Re-alignment in AVX-512: a rotated plane of sixteen children is one zmm register, and the two planes of a slab are
//! encoded and stored together.
//!
//! It is long enough to be called from code compiled for AVX2 ([`super::super::Kernel::Narrow`]). Comparisons of
//! children are not, and primitive slabs gain nothing from AVX-512: both use AVX2, which is inlined there.

use super::super::{SEPARATED, Turned};
use crate::isa::compiled_for_avx512;
use crate::key::{EMPTY, Storage};
#[cfg(miri)]
use crate::key::{Half, half_code};
use crate::node::Node16;
use crate::realign::Realignment;
use core::arch::x86_64::*;
use core::mem::MaybeUninit;

compiled_for_avx512! {
    /// Sixteen codes, as floats.
    #[inline]
    fn decode<S: Storage>(planes: &[i16; 16]) -> __m512 {
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        let codes = unsafe { _mm256_loadu_si256(planes.as_ptr().cast()) };
        if S::IS_HALF {
            // One `vpternlogq` after the shift, as below.
            let flip = _mm256_and_si256(_mm256_srai_epi16::<15>(codes), _mm256_set1_epi16(i16::MAX));
            halves_to_floats(_mm256_xor_si256(codes, flip))
        } else {
            _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(codes))
        }
    }
}

compiled_for_avx512! {
    #[cfg(not(miri))]
    #[inline]
    fn halves_to_floats(halves: __m256i) -> __m512 {
        _mm512_cvtph_ps(halves)
    }
}

compiled_for_avx512! {
    /// Rounded towards positive infinity. NaN is an unbounded plane.
    #[cfg(not(miri))]
    #[inline]
    fn floats_to_halves(values: __m512) -> __m256i {
        _mm512_cvtps_ph::<_MM_FROUND_TO_POS_INF>(_mm512_min_ps(values, _mm512_set1_ps(f32::INFINITY)))
    }
}

#[cfg(miri)]
compiled_for_avx512! {
    fn halves_to_floats(halves: __m256i) -> __m512 {
        let mut codes = [0_i16; 16];
        // SAFETY: the array has the 32 bytes written; the store needs no alignment.
        unsafe { _mm256_storeu_si256(codes.as_mut_ptr().cast(), halves) };
        let floats = codes.map(|bits| Half::number(half_code(bits)));
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        unsafe { _mm512_loadu_ps(floats.as_ptr()) }
    }
}

#[cfg(miri)]
compiled_for_avx512! {
    fn floats_to_halves(values: __m512) -> __m256i {
        let bits = super::points::numbers(values).map(|x| half_code(Half::around(x)));
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        unsafe { _mm256_loadu_si256(bits.as_ptr().cast()) }
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
    /// Rounds values to the nearest integers, at most the code of infinity. Values below the range of `i32` become the
    /// least one.
    #[cfg(not(miri))]
    #[inline]
    fn nearest<S: Storage>(values: __m512) -> __m512i {
        // NaN is an unbounded plane: if the first operand is NaN, `vminps` returns the second.
        let bounded = _mm512_min_ps(values, _mm512_set1_ps(f32::from(S::INFINITY)));
        _mm512_cvtps_epi32(bounded)
    }
}

#[cfg(miri)] // Miri has none of these instructions in this width: this lets it run the rest.
compiled_for_avx512! {
    fn nearest<S: Storage>(values: __m512) -> __m512i {
        let most = f32::from(S::INFINITY);
        let nearest = |x: f32| if x < most { x.round_ties_even() as i32 } else { most as i32 };
        let integers = super::points::numbers(values).map(nearest);
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        unsafe { _mm512_loadu_si512(integers.as_ptr().cast()) }
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn realign_16<const K: usize, S: Storage>(
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        // Not zeroed: that would be a kilobyte of stores.
        let mut planes = [const { MaybeUninit::<__m512>::uninit() }; K];
        for (decoded, codes) in planes.iter_mut().zip(&node.planes) {
            decoded.write(decode::<S>(codes));
        }
        for slab in 0..K / 2 {
            let [p, q, r, _] = map.sources[slab];
            let weights = [0, 1, 2].map(|l| _mm512_set1_ps(map.weights[l][slab]));
            let turned = |side: usize| {
                // SAFETY: the loop above initialized all planes.
                let sources = [p, q, r].map(|source| unsafe { planes[usize::from(source) ^ side].assume_init() });
                let offset = _mm512_set1_ps(map.offset[2 * slab + side]);
                _mm512_add_ps(weighted_sum(weights, sources), offset)
            };
            // The complements of the codes, at most the greatest.
            let codes = if S::IS_HALF {
                let (low, high) = (floats_to_halves(turned(1)), floats_to_halves(turned(0)));
                let halves = _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high);
                let flip = _mm512_and_si512(_mm512_srai_epi16::<15>(halves), _mm512_set1_epi16(i16::MAX));
                let complements = _mm512_xor_si512(_mm512_xor_si512(halves, flip), _mm512_set1_epi16(-1));
                _mm512_min_epi16(complements, _mm512_set1_epi16(S::GREATEST))
            } else {
                let packed = _mm512_packs_epi32(nearest::<S>(turned(1)), nearest::<S>(turned(0)));
                // `vpackssdw` takes four codes of each plane alternately.
                let codes = _mm512_permutexvar_epi64(_mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7), packed);
                let codes = _mm512_max_epi16(codes, _mm512_set1_epi16(!S::GREATEST));
                _mm512_xor_si512(codes, _mm512_set1_epi16(-1))
            };
            let (slabs, _) = query.as_chunks_mut::<2>();
            let slab = slabs[slab].as_mut_ptr();
            // SAFETY: the two arrays have the 64 bytes written; the store needs no alignment.
            unsafe { _mm512_storeu_si512(slab.cast(), codes) };
        }
        for (turned, code) in query[0].iter_mut().zip(&node.planes[0]) {
            *turned = if *code == EMPTY { SEPARATED } else { *turned };
        }
    }
}
