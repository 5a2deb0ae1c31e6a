//! Re-alignment in AVX-512: a rotated plane of sixteen children is one zmm register, and the two planes of a slab are
//! encoded and stored together.
//!
//! It is long enough to be called from code compiled for AVX2 ([`super::super::Kernel::Narrow`]). Comparisons of
//! children are not, and primitive slabs gain nothing from AVX-512: both use AVX2, which is inlined there.

use super::super::{SEPARATED, Turned};
use crate::isa::compiled_for_avx512;
use crate::key::Key;
use crate::node::Node16;
use crate::realign::Realignment;
use core::arch::x86_64::*;
use core::mem::MaybeUninit;

compiled_for_avx512! {
    /// Sixteen codes, as floats.
    #[inline]
    fn decode(planes: &[i16; 16]) -> __m512 {
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
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
    /// Rounds values to the nearest integers, with [`Key::INFINITY`] as the maximum. Values below the range of `i32`
    /// become the least one.
    #[cfg(not(miri))]
    #[inline]
    fn nearest(values: __m512) -> __m512i {
        // NaN is an unbounded plane: if the first operand is NaN, `vminps` returns the second.
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
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        unsafe { _mm512_loadu_si512(integers.as_ptr().cast()) }
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn realign_16<const K: usize>(map: &Realignment<K>, node: &Node16<K>, query: &mut Turned<16, K>) {
        // Not zeroed: that would be a kilobyte of stores.
        let mut planes = [const { MaybeUninit::<__m512>::uninit() }; K];
        for (decoded, codes) in planes.iter_mut().zip(&node.planes) {
            decoded.write(decode(codes));
        }
        // `vpackssdw` takes four codes of each plane alternately.
        let in_order = _mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7);
        for slab in 0..K / 2 {
            let [p, q, r, _] = map.sources[slab];
            let weights = [0, 1, 2].map(|l| _mm512_set1_ps(map.weights[l][slab]));
            let turned = |side: usize| {
                // SAFETY: the loop above initialized all planes.
                let sources = [p, q, r].map(|source| unsafe { planes[usize::from(source) ^ side].assume_init() });
                let offset = _mm512_set1_ps(map.offset[2 * slab + side]);
                nearest(_mm512_add_ps(weighted_sum(weights, sources), offset))
            };
            let codes = _mm512_max_epi16(
                _mm512_packs_epi32(turned(1), turned(0)),
                _mm512_set1_epi16(Key::LOWEST.code()),
            );
            let complements = _mm512_xor_si512(codes, _mm512_set1_epi16(-1));
            let codes = _mm512_permutexvar_epi64(in_order, complements);
            let (slabs, _) = query.as_chunks_mut::<2>();
            let slab = slabs[slab].as_mut_ptr();
            // SAFETY: the two arrays have the 64 bytes written; the store needs no alignment.
            unsafe { _mm512_storeu_si512(slab.cast(), codes) };
        }
        for (turned, code) in query[0].iter_mut().zip(&node.planes[0]) {
            *turned = if *code == Key::EMPTY.code() { SEPARATED } else { *turned };
        }
    }
}
