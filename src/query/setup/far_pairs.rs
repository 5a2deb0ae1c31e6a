//! Far pairs: culls bodies that are certainly apart before a query sets anything up.
//!
//! The test uses the balls about the centres of the two frames. Let `c_A` and `c_B` be the centres, `R_A` and `R_B` the
//! radii of the bodies about them, M and t the pose, and `s = M c_A + t - c_B`. A moved point of A is `c_B + s + M d`
//! with `|d| <= R_A`, up to rounding, and a sphere keeps its radius. So for bodies that come within a margin m of each
//! other
//!
//! ```text
//! |s| <= |M| R_A + R_B + m
//! ```
//!
//! The offset s is computed in `f64`, so that bodies far from their origins are culled too, and the rest in `f32`,
//! which a microcontroller has in hardware. With u = 2^-24 and X the sum of both bodies' largest coordinates, the right
//! side grows by these errors:
//!
//! * s in `f64`, and corners of A as [`Pose::apply`] rounds them and flushes them to zero: at most
//!   `2^-46 (9 X + max abs(t))`, where `abs(t) <= abs(s) + 3 X`, and 2^-248. Covered by `2^-40 X`, [`GROWN`] and
//!   2^-100.
//! * M, which is accepted with `abs(M M^T - 1) <= 1e-4` in every entry, so that `|M|` is at most `1 + 1.5e-4`: at most
//!   `1.5e-4 R_A`. Covered by `2^-12 (R_A + R_B + m)`.
//! * s, radii and margin to `f32`, and a dozen roundings of the sides: at most `2^-20` of them. Covered by [`GROWN`],
//!   on each side of the square.
//! * numbers too small for a normal `f32`: at most 2^-125 a term, and 2^-140 in squares. Covered by 2^-100, and 2^-120
//!   in squares.
//!
//! If the right side overflows to infinity, or a side is NaN, the comparison is false, and the query decides.

use crate::exact::power_of_two;
use crate::hierarchy::Header;
use crate::pose::Pose;
use crate::vector::difference;

const GROWN: f32 = 1.0 + power_of_two(-18) as f32;
/// Covers rounding errors that are relative to the coordinates.
const ROUNDING: f32 = power_of_two(-40) as f32;
const SKEW: f32 = power_of_two(-12) as f32;
const LEAST: f32 = power_of_two(-100) as f32;
const LEAST_SQUARE: f32 = power_of_two(-120) as f32;

/// Whether the bodies are certainly more than `margin` apart. `pose` places A in the frame of B.
// Not inlined on small machines, so that it takes no stack of the query that follows.
#[cfg_attr(simdop_small, inline(never))]
#[cfg_attr(not(simdop_small), inline(always))]
pub(in crate::query) fn are_apart(a: &Header, b: &Header, pose: &Pose, margin: f64) -> bool {
    let (a, b) = (a.extent(), b.extent());
    let [x, y, z] = difference(&pose.unflushed(&a.frame.centre), &b.frame.centre);
    let [x, y, z] = [x as f32, y as f32, z as f32];
    let sizes = (a.radius as f32 + b.radius as f32) + margin as f32;
    let coordinates = a.max_coordinate as f32 + b.max_coordinate as f32;
    let reach = ((sizes + SKEW * sizes) + (ROUNDING * coordinates + LEAST)) * GROWN;
    (x * x + y * y) + z * z > reach * reach * GROWN + LEAST_SQUARE
}
