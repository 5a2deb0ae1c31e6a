//! The points of the cloud, and the search radii. All numbers are exact in `f32`, so that many points are exactly at
//! the radius.

/// Number of points.
pub const COUNT: usize = 300;

/// The radii.
pub const RADII: [f32; 3] = [0.0, 0.5, 1.25];

/// Point `i`, after this many steps of its motion.
pub fn point(i: usize, steps: usize) -> [f32; 3] {
    let at = |factor: usize, size: usize| ((factor * i) % size) as f32 / 8.0;
    let [x, y, z] = [at(37, 41), at(53, 31), at(29, 23)];
    [x + steps as f32 * 0.125, y, z - (i % 3) as f32 * steps as f32 * 0.25]
}
