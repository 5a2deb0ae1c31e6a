//! Points and boxes of points, four lanes per register. The same operations as in [`super::super::scalar`].

use crate::isa::compiled_for_neon;
use crate::node::{Aabb16, Box3, Bucket};
use core::arch::aarch64::*;

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
    fn square_of([x, y, z]: [float32x4_t; 3]) -> float32x4_t {
        // No fused multiply-add: it would round differently from the specification.
        let two = vaddq_f32(vmulq_f32(x, x), vmulq_f32(y, y));
        vaddq_f32(two, vmulq_f32(z, z))
    }
}

compiled_for_neon! {
    /// The second unless the first is greater.
    #[inline]
    fn greater(x: float32x4_t, y: float32x4_t) -> float32x4_t {
        vbslq_f32(vcgtq_f32(x, y), x, y)
    }
}

compiled_for_neon! {
    #[inline]
    fn to_points(point: [f32; 3], bucket: &Bucket, quarter: usize) -> float32x4_t {
        let [x, y, z] = &bucket.coordinates;
        square_of([
            vsubq_f32(vdupq_n_f32(point[0]), load(x, quarter)),
            vsubq_f32(vdupq_n_f32(point[1]), load(y, quarter)),
            vsubq_f32(vdupq_n_f32(point[2]), load(z, quarter)),
        ])
    }
}

compiled_for_neon! {
    #[inline]
    fn gap((from, to): (f32, f32), lower: float32x4_t, upper: float32x4_t) -> float32x4_t {
        let (below, above) = (vsubq_f32(lower, vdupq_n_f32(to)), vsubq_f32(vdupq_n_f32(from), upper));
        greater(vdupq_n_f32(0.0), greater(below, above))
    }
}

compiled_for_neon! {
    #[inline]
    fn to_boxes(query: &Box3, node: &Aabb16, quarter: usize) -> float32x4_t {
        let side = |i: usize| (query.lower[i], query.upper[i]);
        square_of([
            gap(side(0), load(&node.lower[0], quarter), load(&node.upper[0], quarter)),
            gap(side(1), load(&node.lower[1], quarter), load(&node.upper[1], quarter)),
            gap(side(2), load(&node.lower[2], quarter), load(&node.upper[2], quarter)),
        ])
    }
}

compiled_for_neon! {
    #[inline]
    fn at_most(squares: [float32x4_t; 4], square: f32) -> u16 {
        // SAFETY: the array has the 16 bytes read.
        let bits = unsafe { vld1q_u32([1, 2, 4, 8].as_ptr()) };
        let bound = vdupq_n_f32(square);
        let mut mask = 0;
        for (quarter, squares) in squares.into_iter().enumerate() {
            mask |= (vaddvq_u32(vandq_u32(vcleq_f32(squares, bound), bits)) as u16) << (4 * quarter);
        }
        mask
    }
}

compiled_for_neon! {
    #[inline]
    fn store(numbers: &mut [f32; 16], squares: [float32x4_t; 4]) {
        for (place, squares) in numbers.as_chunks_mut::<4>().0.iter_mut().zip(squares) {
            // SAFETY: the array has the 16 bytes written.
            unsafe { vst1q_f32(place.as_mut_ptr(), squares) };
        }
    }
}

compiled_for_neon! {
    #[inline]
    fn all_boxes(query: &Box3, node: &Aabb16) -> [float32x4_t; 4] {
        [to_boxes(query, node, 0), to_boxes(query, node, 1), to_boxes(query, node, 2), to_boxes(query, node, 3)]
    }
}

compiled_for_neon! {
    #[inline]
    fn all_points(point: [f32; 3], bucket: &Bucket) -> [float32x4_t; 4] {
        [
            to_points(point, bucket, 0),
            to_points(point, bucket, 1),
            to_points(point, bucket, 2),
            to_points(point, bucket, 3),
        ]
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn boxes_near(query: &Box3, square: f32, node: &Aabb16) -> u16 {
        at_most(all_boxes(query, node), square)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn points_near(point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        at_most(all_points(point, bucket), square)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn box_squares(query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        store(squares, all_boxes(query, node));
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn point_squares(point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        store(squares, all_points(point, bucket));
    }
}
