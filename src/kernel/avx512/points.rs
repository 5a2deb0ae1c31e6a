//! Points and boxes of points, sixteen lanes per register. The same operations as in [`super::super::scalar`].

use crate::isa::compiled_for_avx512;
use crate::node::{Aabb16, Box3, Bucket};
use core::arch::x86_64::*;

compiled_for_avx512! {
    #[inline]
    pub(super) fn load(numbers: &[f32; 16]) -> __m512 {
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        unsafe { _mm512_loadu_ps(numbers.as_ptr()) }
    }
}

compiled_for_avx512! {
    #[inline]
    fn square_of([x, y, z]: [__m512; 3]) -> __m512 {
        // No fused multiply-add: it would round differently from the specification.
        let two = _mm512_add_ps(_mm512_mul_ps(x, x), _mm512_mul_ps(y, y));
        _mm512_add_ps(two, _mm512_mul_ps(z, z))
    }
}

compiled_for_avx512! {
    #[inline]
    fn to_points(point: [f32; 3], bucket: &Bucket) -> __m512 {
        let [x, y, z] = &bucket.coordinates;
        square_of([
            _mm512_sub_ps(_mm512_set1_ps(point[0]), load(x)),
            _mm512_sub_ps(_mm512_set1_ps(point[1]), load(y)),
            _mm512_sub_ps(_mm512_set1_ps(point[2]), load(z)),
        ])
    }
}

compiled_for_avx512! {
    /// `vmaxps` returns its second operand unless the first is greater, as specified.
    #[cfg(not(miri))]
    #[inline]
    fn greater(x: __m512, y: __m512) -> __m512 {
        _mm512_max_ps(x, y)
    }
}

#[cfg(miri)] // Miri has no `vmaxps` of this width: this lets it run the rest.
compiled_for_avx512! {
    fn greater(x: __m512, y: __m512) -> __m512 {
        let (x, y) = (numbers(x), numbers(y));
        load(&core::array::from_fn(|i| if x[i] > y[i] { x[i] } else { y[i] }))
    }
}

#[cfg(miri)]
compiled_for_avx512! {
    pub(super) fn numbers(sixteen: __m512) -> [f32; 16] {
        let mut numbers = [0.0; 16];
        store(&mut numbers, sixteen);
        numbers
    }
}

compiled_for_avx512! {
    #[inline]
    fn gap((from, to): (f32, f32), lower: &[f32; 16], upper: &[f32; 16]) -> __m512 {
        let below = _mm512_sub_ps(load(lower), _mm512_set1_ps(to));
        let above = _mm512_sub_ps(_mm512_set1_ps(from), load(upper));
        greater(_mm512_setzero_ps(), greater(below, above))
    }
}

compiled_for_avx512! {
    #[inline]
    fn to_boxes(query: &Box3, node: &Aabb16) -> __m512 {
        let side = |i: usize| (query.lower[i], query.upper[i]);
        square_of([
            gap(side(0), &node.lower[0], &node.upper[0]),
            gap(side(1), &node.lower[1], &node.upper[1]),
            gap(side(2), &node.lower[2], &node.upper[2]),
        ])
    }
}

compiled_for_avx512! {
    #[cfg(not(miri))]
    #[inline]
    fn at_most(squares: __m512, square: f32) -> u16 {
        _mm512_cmp_ps_mask::<_CMP_LE_OQ>(squares, _mm512_set1_ps(square))
    }
}

#[cfg(miri)] // Nor `vcmpps` of this width.
compiled_for_avx512! {
    fn at_most(squares: __m512, square: f32) -> u16 {
        let squares = numbers(squares);
        (0..16).fold(0, |mask, lane| mask | u16::from(squares[lane] <= square) << lane)
    }
}

compiled_for_avx512! {
    #[inline]
    fn store(numbers: &mut [f32; 16], sixteen: __m512) {
        // SAFETY: the array has the 64 bytes written; the store needs no alignment.
        unsafe { _mm512_storeu_ps(numbers.as_mut_ptr(), sixteen) };
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn boxes_near(query: &Box3, square: f32, node: &Aabb16) -> u16 {
        at_most(to_boxes(query, node), square)
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn points_near(point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        at_most(to_points(point, bucket), square)
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn box_squares(query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        store(squares, to_boxes(query, node));
    }
}

compiled_for_avx512! {
    #[inline]
    pub(super) fn point_squares(point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        store(squares, to_points(point, bucket));
    }
}

compiled_for_avx512! {
    #[cfg(not(miri))]
    #[inline]
    fn packed(mask: u16, all: __m512i) -> __m512i {
        _mm512_maskz_compress_epi32(mask, all)
    }
}

#[cfg(miri)] // Nor `vpcompressd`.
compiled_for_avx512! {
    fn packed(mask: u16, all: __m512i) -> __m512i {
        let (mut indices, mut first) = ([0; 16], [0; 16]);
        // SAFETY: the array has the 64 bytes written; the store needs no alignment.
        unsafe { _mm512_storeu_si512(indices.as_mut_ptr().cast(), all) };
        crate::kernel::scalar::points::pick(mask, &indices, &mut first);
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        unsafe { _mm512_loadu_si512(first.as_ptr().cast()) }
    }
}

compiled_for_avx512! {
    /// Packs in a register: `vpcompressd` to memory is microcoded on Zen 4.
    #[inline]
    pub(super) fn pick(mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
        // SAFETY: the array has the 64 bytes read; the load needs no alignment.
        let all = unsafe { _mm512_loadu_si512(indices.as_ptr().cast()) };
        let packed = packed(mask, all);
        // SAFETY: the array has the 64 bytes written; the store needs no alignment.
        unsafe { _mm512_storeu_si512(found.as_mut_ptr().cast(), packed) };
    }
}
