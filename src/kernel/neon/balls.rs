//! Balls against balls, four lanes per register. The same operations as in [`super::super::scalar`].

use super::super::{LEAST_VOLUME, LENS, LENS_SLACK, WHOLE};
use crate::isa::compiled_for_neon;
use crate::node::{Ball16, BoundingBall};
use core::arch::aarch64::*;

/// Four balls.
struct Four {
    centre: [float32x4_t; 3],
    radius: float32x4_t,
}

compiled_for_neon! {
    /// Lanes `4 quarter ..` of sixteen numbers.
    #[inline]
    fn load(numbers: &[f32; 16], quarter: usize) -> float32x4_t {
        let four = &numbers.as_chunks::<4>().0[quarter];
        // SAFETY: the array has the 16 bytes read.
        unsafe { vld1q_f32(four.as_ptr()) }
    }
}

compiled_for_neon! {
    #[inline]
    fn four(balls: &Ball16, quarter: usize) -> Four {
        let [x, y, z] = &balls.centre;
        Four { centre: [load(x, quarter), load(y, quarter), load(z, quarter)], radius: load(&balls.radius, quarter) }
    }
}

compiled_for_neon! {
    #[inline]
    fn splat(ball: &BoundingBall) -> Four {
        let [x, y, z] = ball.centre;
        Four { centre: [vdupq_n_f32(x), vdupq_n_f32(y), vdupq_n_f32(z)], radius: vdupq_n_f32(ball.radius) }
    }
}

compiled_for_neon! {
    /// The square of the distance between the centres, and the sum of the radii.
    #[inline]
    fn distances(a: &Four, b: &Four) -> (float32x4_t, float32x4_t) {
        let ([p, q, r], [u, v, w]) = (a.centre, b.centre);
        let (x, y, z) = (vsubq_f32(p, u), vsubq_f32(q, v), vsubq_f32(r, w));
        // No fused multiply-add: it would round differently from the specification.
        let two = vaddq_f32(vmulq_f32(x, x), vmulq_f32(y, y));
        (vaddq_f32(two, vmulq_f32(z, z)), vaddq_f32(a.radius, b.radius))
    }
}

compiled_for_neon! {
    /// All ones where the balls meet.
    #[inline]
    fn is_met((square, sum): (float32x4_t, float32x4_t)) -> uint32x4_t {
        vcleq_f32(square, vmulq_f32(sum, sum))
    }
}

compiled_for_neon! {
    /// The second unless the first is less.
    #[inline]
    fn least(x: float32x4_t, y: float32x4_t) -> float32x4_t {
        vbslq_f32(vcltq_f32(x, y), x, y)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn balls_meet(a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]) {
        let quarters = [four(b, 0), four(b, 1), four(b, 2), four(b, 3)];
        // SAFETY: the array has the 16 bytes read.
        let bits = unsafe { vld1q_u32([1, 2, 4, 8].as_ptr()) };
        let mut left = wanted;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let one = splat(&a.lane(lane));
            let mut row = 0;
            for (i, quarter) in quarters.iter().enumerate() {
                row |= (vaddvq_u32(vandq_u32(is_met(distances(&one, quarter)), bits)) as u16) << (4 * i);
            }
            rows[lane] = row;
        }
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn balls_share(a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]) {
        let (one, volume) = (splat(a), vdupq_n_f32(a.volume));
        for (quarter, out) in shared.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let other = four(b, quarter);
            let (square, sum) = distances(&one, &other);
            let distance = vsqrtq_f32(square);
            let difference = vabsq_f32(vsubq_f32(one.radius, other.radius));
            let smaller = least(one.radius, other.radius);
            let depth = vsubq_f32(sum, distance);
            let wide = vaddq_f32(distance, vmulq_f32(vdupq_n_f32(3.0), difference));
            let rest = vaddq_f32(
                vmulq_f32(vsubq_f32(distance, difference), wide),
                vmulq_f32(vmulq_f32(vdupq_n_f32(4.0), smaller), distance),
            );
            let product = vmulq_f32(vmulq_f32(depth, depth), rest);
            let lens = vmulq_f32(vdivq_f32(product, distance), vdupq_n_f32(LENS));
            let square_of_smaller = vmulq_f32(smaller, smaller);
            let slack = vmulq_f32(vmulq_f32(vdupq_n_f32(LENS_SLACK), sum), square_of_smaller);
            let lens = vaddq_f32(lens, slack);
            let cube = vmulq_f32(square_of_smaller, smaller);
            let whole = vmulq_f32(cube, vdupq_n_f32(WHOLE));
            let lens = vbslq_f32(vcgtq_f32(distance, difference), lens, whole);
            let bound = least(lens, least(volume, load(&b.volume, quarter)));
            let floor = vdupq_n_f32(LEAST_VOLUME);
            let bound = vbslq_f32(vcgtq_f32(bound, floor), bound, floor);
            let bound = vbslq_f32(is_met((square, sum)), bound, vdupq_n_f32(0.0));
            // SAFETY: the array has the 16 bytes written.
            unsafe { vst1q_f32(out.as_mut_ptr(), bound) };
        }
    }
}
