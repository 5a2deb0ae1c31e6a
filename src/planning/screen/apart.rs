//! Compares the spheres around two bodies that both move.
//!
//! Centres are `f32`; the radii include their errors. The differences of coordinates, their squares, and the sum of the
//! three are off by less than 8 u of the squared distance, with u = 2^-24. So are the sum of the radii and its square;
//! 2^-19 of the radii covers both.

use super::lanes::{Flags, LANES, Lane16, Point16, flag};
use crate::exact::power_of_two;

/// Allowance for roundings, relative to a radius.
const ROUNDING: f64 = power_of_two(-19);

/// The radius of a sphere in the form that [`are_apart`] takes.
pub(super) fn radius(radius: f64) -> f32 {
    (radius * (1.0 + ROUNDING)) as f32
}

/// The lanes in which two spheres are certainly apart.
#[inline(always)]
pub(super) fn are_apart((a, of_a): (&Point16, &Lane16), (b, of_b): (&Point16, &Lane16)) -> Flags {
    let mut apart = [0_u32; LANES];
    for lane in 0..LANES {
        let (x, y, z) = (a[0][lane] - b[0][lane], a[1][lane] - b[1][lane], a[2][lane] - b[2][lane]);
        let radii = of_a[lane] + of_b[lane];
        apart[lane] = flag(lane, (x * x + y * y) + z * z > radii * radii);
    }
    apart
}
