//! Polygons as triangles.

use alloc::vec::Vec;

/// Cuts a polygon, convex and without corners on its edges, into a fan around its lowest corner.
pub(super) fn add_fan(polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let lowest = (0..polygon.len()).min_by_key(|&i| polygon[i]).unwrap_or(0);
    let corner = |i: usize| polygon[(lowest + i) % polygon.len()];
    triangles.extend((2..polygon.len()).map(|i| [corner(0), corner(i - 1), corner(i)]));
}
