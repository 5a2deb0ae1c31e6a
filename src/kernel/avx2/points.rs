//! Points and boxes of points, eight lanes per register. The same operations as in [`super::super::scalar`].

use crate::isa::compiled_for_avx2;
use crate::node::{Aabb16, Box3, Bucket};
use core::arch::x86_64::*;

/// A coordinate of a query, or a corner of its box, in all lanes.
type Splat = [__m256; 3];

compiled_for_avx2! {
    /// Lanes `8 half ..` of sixteen numbers.
    #[inline]
    fn load(numbers: &[f32; 16], half: usize) -> __m256 {
        let eight = &numbers.as_chunks::<8>().0[half];
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        unsafe { _mm256_loadu_ps(eight.as_ptr()) }
    }
}

compiled_for_avx2! {
    #[inline]
    fn store(numbers: &mut [f32; 16], half: usize, eight: __m256) {
        let place = &mut numbers.as_chunks_mut::<8>().0[half];
        // SAFETY: the array has the 32 bytes written; the store needs no alignment.
        unsafe { _mm256_storeu_ps(place.as_mut_ptr(), eight) };
    }
}

compiled_for_avx2! {
    #[inline]
    fn splat([x, y, z]: [f32; 3]) -> Splat {
        [_mm256_set1_ps(x), _mm256_set1_ps(y), _mm256_set1_ps(z)]
    }
}

compiled_for_avx2! {
    #[inline]
    fn square_of([x, y, z]: Splat) -> __m256 {
        // No fused multiply-add: it would round differently from the specification.
        let two = _mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y));
        _mm256_add_ps(two, _mm256_mul_ps(z, z))
    }
}

compiled_for_avx2! {
    #[inline]
    fn to_points(point: &Splat, bucket: &Bucket, half: usize) -> __m256 {
        let [x, y, z] = &bucket.coordinates;
        square_of([
            _mm256_sub_ps(point[0], load(x, half)),
            _mm256_sub_ps(point[1], load(y, half)),
            _mm256_sub_ps(point[2], load(z, half)),
        ])
    }
}

compiled_for_avx2! {
    /// `vmaxps` returns its second operand unless the first is greater, as specified.
    #[inline]
    fn gap(query: (__m256, __m256), lower: __m256, upper: __m256) -> __m256 {
        let (below, above) = (_mm256_sub_ps(lower, query.1), _mm256_sub_ps(query.0, upper));
        _mm256_max_ps(_mm256_setzero_ps(), _mm256_max_ps(below, above))
    }
}

compiled_for_avx2! {
    #[inline]
    fn to_boxes((lower, upper): (&Splat, &Splat), node: &Aabb16, half: usize) -> __m256 {
        square_of([
            gap((lower[0], upper[0]), load(&node.lower[0], half), load(&node.upper[0], half)),
            gap((lower[1], upper[1]), load(&node.lower[1], half), load(&node.upper[1], half)),
            gap((lower[2], upper[2]), load(&node.lower[2], half), load(&node.upper[2], half)),
        ])
    }
}

compiled_for_avx2! {
    #[inline]
    fn at_most(low: __m256, high: __m256, square: f32) -> u16 {
        let bound = _mm256_set1_ps(square);
        let low = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(low, bound)) as u16;
        low | (_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(high, bound)) as u16) << 8
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn boxes_near(query: &Box3, square: f32, node: &Aabb16) -> u16 {
        let (lower, upper) = (splat(query.lower), splat(query.upper));
        at_most(to_boxes((&lower, &upper), node, 0), to_boxes((&lower, &upper), node, 1), square)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn points_near(point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        let point = splat(point);
        at_most(to_points(&point, bucket, 0), to_points(&point, bucket, 1), square)
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn box_squares(query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        let (lower, upper) = (splat(query.lower), splat(query.upper));
        store(squares, 0, to_boxes((&lower, &upper), node, 0));
        store(squares, 1, to_boxes((&lower, &upper), node, 1));
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn point_squares(point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        let point = splat(point);
        store(squares, 0, to_points(&point, bucket, 0));
        store(squares, 1, to_points(&point, bucket, 1));
    }
}

/// `PLACES[mask]`: the indices of the set bits of the mask, one byte each, from the front.
static PLACES: [[u8; 8]; 256] = places();

const fn places() -> [[u8; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                table[mask][count] = bit as u8;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
}

compiled_for_avx2! {
    /// Eight indices, with those in the mask at the front.
    #[inline]
    fn packed(mask: u8, indices: &[u32; 8]) -> __m256i {
        // SAFETY: the array has the 32 bytes read; the load needs no alignment.
        let eight = unsafe { _mm256_loadu_si256(indices.as_ptr().cast()) };
        let places = _mm_cvtsi64_si128(i64::from_le_bytes(PLACES[mask as usize]));
        _mm256_permutevar8x32_epi32(eight, _mm256_cvtepu8_epi32(places))
    }
}

compiled_for_avx2! {
    #[inline]
    fn put(eight: __m256i, place: &mut [u32; 8]) {
        // SAFETY: the array has the 32 bytes written; the store needs no alignment.
        unsafe { _mm256_storeu_si256(place.as_mut_ptr().cast(), eight) };
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn pick(mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
        let (low, high) = (mask as u8, (mask >> 8) as u8);
        let halves = indices.as_chunks::<8>().0;
        put(packed(low, &halves[0]), &mut found.as_chunks_mut::<8>().0[0]);
        // At most 8, so at least eight entries follow.
        let after = &mut found[low.count_ones() as usize..];
        if let Some(place) = after.first_chunk_mut::<8>() {
            put(packed(high, &halves[1]), place);
        }
    }
}
