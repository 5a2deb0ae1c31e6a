//! Spheres of two bodies that both move.
//!
//! Centres are `f32`, with errors that are in the radii. A difference of coordinates, its square, and the sum of three
//! are off by less than 8 u of the squared distance, u being 2^-24, as are the sum of the radii and its square; 2^-19 of
//! the radii covers both.

use super::lanes::{Flags, LANES, Lane16, Point16, flag};
use crate::exact::power_of_two;

/// Allowance for roundings, relative to a radius.
const ROUNDING: f64 = power_of_two(-19);
/// In place of a radius where there is no sphere: its sum with any radius is negative.
pub(super) const NO_SPHERE: f32 = -1e18;

/// The radii of an outer and an inner sphere, as [`compare`] takes them.
pub(super) fn radii(outer: f64, inner: f64) -> [f32; 2] {
    let inner = if inner > 0.0 { (inner * (1.0 - ROUNDING)) as f32 } else { NO_SPHERE };
    [(outer * (1.0 + ROUNDING)) as f32, inner]
}

/// In which lanes two spheres are certainly apart, and in which their inner ones certainly meet.
#[inline(always)]
pub(super) fn compare(
    (a, of_a): (&Point16, &[Lane16; 2]),
    (b, of_b): (&Point16, &[Lane16; 2]),
) -> [Flags; 2] {
    let [mut free, mut hit] = [[0_u32; LANES]; 2];
    for lane in 0..LANES {
        let (x, y, z) = (a[0][lane] - b[0][lane], a[1][lane] - b[1][lane], a[2][lane] - b[2][lane]);
        let square = (x * x + y * y) + z * z;
        let (outer, inner) = (of_a[0][lane] + of_b[0][lane], of_a[1][lane] + of_b[1][lane]);
        free[lane] = flag(lane, (outer < 0.0) | (square > outer * outer));
        hit[lane] = flag(lane, (inner > 0.0) & (square < inner * inner));
    }
    [free, hit]
}
