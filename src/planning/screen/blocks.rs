//! The spheres of a body, sixteen at a time.

use super::lanes::{LANES, Lane16, Point16};

/// Stands for the radius where there is no sphere: always free, and meets nothing.
const NO_SPHERE: f32 = -1e18;

/// Concentric spheres on a link, with radii that cover the error of the centre in the lanes.
#[derive(Copy, Clone, Debug)]
pub(super) struct LaneSphere {
    pub(super) centre: [f32; 3],
    pub(super) outer: f64,
    pub(super) inner: f64,
}

/// Outer and inner radii of sixteen spheres.
pub(super) type Radii16 = [Lane16; 2];

/// The centres of up to sixteen spheres. Lanes without a sphere have the centre of the first.
pub(super) fn block(spheres: &[LaneSphere]) -> Point16 {
    let at = |lane: usize| spheres.get(lane).unwrap_or(&spheres[0]).centre;
    [0, 1, 2].map(|i| core::array::from_fn(|lane| at(lane)[i]))
}

/// The radii of up to sixteen spheres. Lanes without a sphere are free.
pub(super) fn radii(spheres: &[LaneSphere], of: impl Fn(f64, f64) -> [f32; 2]) -> Radii16 {
    let at = |lane: usize| spheres.get(lane).map_or([NO_SPHERE; 2], |sphere| of(sphere.outer, sphere.inner));
    [0, 1].map(|i| core::array::from_fn(|lane| at(lane)[i]))
}

/// The same radii in all lanes.
pub(super) fn all_lanes([outer, inner]: [f32; 2]) -> Radii16 {
    [[outer; LANES], [inner; LANES]]
}
