//! The spheres of a body, sixteen at a time.

use super::apart::NO_SPHERE;
use super::lanes::{LANES, Lane16, Point16};
use alloc::vec::Vec;

/// Spheres about one centre on a link, with radii that hold wherever the lanes put the centre.
#[derive(Copy, Clone, Debug)]
pub(super) struct LaneSphere {
    pub(super) centre: [f32; 3],
    pub(super) outer: f64,
    pub(super) inner: f64,
}

/// Outer and inner radii of sixteen spheres.
pub(super) type Radii16 = [Lane16; 2];

/// The centres of spheres. Lanes without a sphere have the centre of the first.
pub(super) fn centres(spheres: &[LaneSphere]) -> Vec<Point16> {
    let block = |block: &[LaneSphere]| {
        let at = |lane: usize| block.get(lane).unwrap_or(&block[0]).centre;
        [0, 1, 2].map(|i| core::array::from_fn(|lane| at(lane)[i]))
    };
    spheres.chunks(LANES).map(block).collect()
}

/// Radii of spheres. Lanes without a sphere are free.
pub(super) fn radii(spheres: &[LaneSphere], of: impl Fn(f64, f64) -> [f32; 2]) -> Vec<Radii16> {
    let block = |block: &[LaneSphere]| {
        let at =
            |lane: usize| block.get(lane).map_or([NO_SPHERE; 2], |sphere| of(sphere.outer, sphere.inner));
        [0, 1].map(|i| core::array::from_fn(|lane| at(lane)[i]))
    };
    spheres.chunks(LANES).map(block).collect()
}

/// The same radii in all lanes.
pub(super) fn all_lanes([outer, inner]: [f32; 2]) -> Radii16 {
    [[outer; LANES], [inner; LANES]]
}
