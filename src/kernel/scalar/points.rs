//! Points and boxes of points.

use crate::node::Box3;

/// Bit i: `is_near(i)`.
pub(super) fn mask_of(is_near: impl Fn(usize) -> bool) -> u16 {
    (0..16).filter(|&i| is_near(i)).fold(0, |mask, i| mask | 1 << i)
}

pub(super) fn point_square(p: [f32; 3], q: [f32; 3]) -> f32 {
    square([0, 1, 2].map(|i| p[i] - q[i]))
}

/// NaN for a box that is NaN, since `greater` returns the second unless the first is greater.
pub(super) fn box_square(query: &Box3, of: &Box3) -> f32 {
    square(
        [0, 1, 2].map(|i| greater(0.0, greater(of.lower[i] - query.upper[i], query.lower[i] - of.upper[i]))),
    )
}

fn square([x, y, z]: [f32; 3]) -> f32 {
    (x * x + y * y) + z * z
}

/// The second unless the first is greater.
fn greater(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

#[inline(always)]
pub(in crate::kernel) fn pick(mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
    let (mut left, mut count) = (mask, 0);
    while left != 0 {
        // Below 16, which the compiler cannot infer from a bit count.
        found[count & 15] = indices[left.trailing_zeros() as usize & 15];
        (left, count) = (left & (left - 1), count + 1);
    }
}
