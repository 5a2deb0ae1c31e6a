//! Balls against balls, eight lanes per register. The same operations as in [`super::super::scalar`].

use super::super::{LEAST_VOLUME, LENS, LENS_SLACK, WHOLE};
use crate::isa::compiled_for_avx2;
use crate::node::{Ball16, BoundingBall};
use core::arch::x86_64::*;

/// Eight balls.
struct Eight {
    centre: [__m256; 3],
    radius: __m256,
}

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
    fn eight(balls: &Ball16, half: usize) -> Eight {
        let [x, y, z] = &balls.centre;
        Eight { centre: [load(x, half), load(y, half), load(z, half)], radius: load(&balls.radius, half) }
    }
}

compiled_for_avx2! {
    #[inline]
    fn splat(ball: &BoundingBall) -> Eight {
        let [x, y, z] = ball.centre;
        Eight {
            centre: [_mm256_set1_ps(x), _mm256_set1_ps(y), _mm256_set1_ps(z)],
            radius: _mm256_set1_ps(ball.radius),
        }
    }
}

compiled_for_avx2! {
    /// The square of the distance between the centres, and the sum of the radii.
    #[inline]
    fn distances(a: &Eight, b: &Eight) -> (__m256, __m256) {
        let ([p, q, r], [u, v, w]) = (a.centre, b.centre);
        let (x, y, z) = (_mm256_sub_ps(p, u), _mm256_sub_ps(q, v), _mm256_sub_ps(r, w));
        // No fused multiply-add: it would round differently from the specification.
        let two = _mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y));
        (_mm256_add_ps(two, _mm256_mul_ps(z, z)), _mm256_add_ps(a.radius, b.radius))
    }
}

compiled_for_avx2! {
    /// All ones where the balls meet.
    #[inline]
    fn is_met((square, sum): (__m256, __m256)) -> __m256 {
        _mm256_cmp_ps::<_CMP_LE_OQ>(square, _mm256_mul_ps(sum, sum))
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn balls_meet(a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]) {
        let halves = [eight(b, 0), eight(b, 1)];
        let mut left = wanted;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let one = splat(&a.lane(lane));
            let mask = |half: &Eight| _mm256_movemask_ps(is_met(distances(&one, half))) as u16;
            rows[lane] = mask(&halves[0]) | mask(&halves[1]) << 8;
        }
    }
}

compiled_for_avx2! {
    #[inline]
    pub(super) fn balls_share(a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]) {
        let (one, volume) = (splat(a), _mm256_set1_ps(a.volume));
        for (half, out) in shared.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let other = eight(b, half);
            let (square, sum) = distances(&one, &other);
            let distance = _mm256_sqrt_ps(square);
            let signed = _mm256_sub_ps(one.radius, other.radius);
            let difference = _mm256_andnot_ps(_mm256_set1_ps(-0.0), signed);
            // `vminps` returns its second operand unless the first is less, as specified; `vmaxps` likewise.
            let smaller = _mm256_min_ps(one.radius, other.radius);
            let depth = _mm256_sub_ps(sum, distance);
            let wide = _mm256_add_ps(distance, _mm256_mul_ps(_mm256_set1_ps(3.0), difference));
            let rest = _mm256_add_ps(
                _mm256_mul_ps(_mm256_sub_ps(distance, difference), wide),
                _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(4.0), smaller), distance),
            );
            let product = _mm256_mul_ps(_mm256_mul_ps(depth, depth), rest);
            let lens = _mm256_mul_ps(_mm256_div_ps(product, distance), _mm256_set1_ps(LENS));
            let square_of_smaller = _mm256_mul_ps(smaller, smaller);
            let slack = _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(LENS_SLACK), sum), square_of_smaller);
            let lens = _mm256_add_ps(lens, slack);
            let cube = _mm256_mul_ps(square_of_smaller, smaller);
            let whole = _mm256_mul_ps(cube, _mm256_set1_ps(WHOLE));
            let lens = _mm256_blendv_ps(whole, lens, _mm256_cmp_ps::<_CMP_GT_OQ>(distance, difference));
            let bound = _mm256_min_ps(lens, _mm256_min_ps(volume, load(&b.volume, half)));
            let bound = _mm256_max_ps(bound, _mm256_set1_ps(LEAST_VOLUME));
            let bound = _mm256_and_ps(bound, is_met((square, sum)));
            // SAFETY: the array has the 32 bytes written; the store needs no alignment.
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), bound) };
        }
    }
}
