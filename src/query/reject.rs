//! Far pairs: bodies that are certainly apart, told before a query sets anything up.
//!
//! Of a planner's pairs nearly all are far apart. Three tests in `f32`, which a microcontroller has in hardware:
//! the balls about the centres of the two frames; the extents of both bodies along the axes of B; and along those
//! of A. Let c_A, c_B be the centres of the frames, R_A, R_B the radii of the bodies about them, h their half widths,
//! M and t the pose, `s = M c_A + t - c_B`. A point of A as moved is `c_B + s + M d` with `|d| <= R_A` and
//! `|d_j| <= h_Aj`, up to rounding, and a sphere's keeps its radius. So bodies that come within a margin m of each
//! other have, with v_j column j of M,
//!
//! ```text
//! |s|     <= |M| R_A + R_B + m
//! |s_i|   <= sum_j |M_ij| h_Aj + h_Bi + m                             for each axis i of B
//! |s.v_j| <= h_Aj + |M^T M - 1| R_A + sum_i |M_ij| h_Bi + |v_j| m     for each axis j of A
//! ```
//!
//! **What the right sides grow by**, with u = 2^-24, and X the sum of both bodies' largest coordinates and of the
//! largest of t:
//!
//! | source | at most | paid by |
//! |---|---|---|
//! | M, t and the centres to `f32`; products and sums of s | `8 u` of the magnitudes on an axis, so `14 u (1.74 X)` of its length | `32 u X` |
//! | products and sums of `s.v_j` | `4 u 3.1 X` besides | twice that |
//! | corners of A as [`Pose::apply`] rounds them and flushes them to zero | `2^-48 X + 2^-249` | the same, and 2^-100 |
//! | M is accepted with `abs(M M^T - 1) <= 1e-4` on every entry, so no singular value of M is farther from 1 than 1.5e-4, and no entry of `M^T M - 1` from 0 than 3e-4; the radius of a sphere is not turned | 3e-4 of A's side, 1.5e-4 of B's and of m | `2^-11 (R_A + R_B + m)` |
//! | roundings of the sides themselves, a dozen | `2^-20` of them | [`GROWN`] |
//! | numbers too small for a normal `f32` | 2^-125 a term, 2^-140 in squares | 2^-100, and 2^-120 in squares |
//!
//! Numbers beyond `f32` become infinite, or NaN, of which every comparison is false: such bodies are left to the
//! query, as are those that are close together far from their origins.

use crate::exact::power_of_two;
use crate::frame::Extent;
use crate::pose::Pose;
use crate::range::Point;

const GROWN: f32 = 1.0 + power_of_two(-18) as f32;
/// Of what is lost by rounding, relative to the coordinates.
const ROUNDING: f32 = power_of_two(-19) as f32;
const SKEW: f32 = power_of_two(-11) as f32;
const LEAST: f32 = power_of_two(-100) as f32;
const LEAST_SQUARE: f32 = power_of_two(-120) as f32;

/// Whether the bodies, of which `pose` places A in the frame of B, are certainly more than `margin` apart.
#[inline(always)]
pub(super) fn are_apart(pose: &Pose, a: &Extent, b: &Extent, margin: f64) -> bool {
    let (m, t) = (pose.rows().map(single), single(pose.translation()));
    let (centre_a, centre_b) = (single(a.frame.centre), single(b.frame.centre));
    let along = |i: usize| (dot(&m[i], &centre_a) + t[i]) - centre_b[i];
    let s = [along(0), along(1), along(2)];
    let coordinates = (a.max_coordinate as f32 + b.max_coordinate as f32) + greatest(&t);
    let (radius_a, radius_b, margin) = (a.radius as f32, b.radius as f32, margin as f32);
    let sizes = (radius_a + radius_b) + margin;
    let slack = SKEW * sizes + (ROUNDING * coordinates + LEAST);
    let reach = (sizes + slack) * GROWN;
    if dot(&s, &s) > reach * reach * GROWN + LEAST_SQUARE {
        return true;
    }
    let (half_a, half_b) = (half_widths(a), half_widths(b));
    let size = m.map(|row| row.map(f32::abs));
    let column = |m: &[[f32; 3]; 3], j: usize| [m[0][j], m[1][j], m[2][j]];
    let along_b = |i: usize| {
        let side = (dot(&size[i], &half_a) + half_b[i]) + (margin + slack);
        s[i].abs() > side * GROWN
    };
    let along_a = |j: usize| {
        let side = (half_a[j] + dot(&column(&size, j), &half_b)) + (margin + 2.0 * slack);
        dot(&column(&m, j), &s).abs() > side * GROWN
    };
    (along_b(0) | along_b(1) | along_b(2)) || (along_a(0) | along_a(1) | along_a(2))
}

#[inline(always)]
fn half_widths(body: &Extent) -> [f32; 3] {
    // Not in `f32`, which may hold neither the unit nor the width while it holds their product.
    let unit = power_of_two(-body.frame.exponent);
    body.half_width.map(|x| (f64::from(x) * unit) as f32)
}

#[inline(always)]
fn single(p: Point) -> [f32; 3] {
    p.map(|x| x as f32)
}

#[inline(always)]
fn dot(p: &[f32; 3], q: &[f32; 3]) -> f32 {
    (p[0] * q[0] + p[1] * q[1]) + p[2] * q[2]
}

#[inline(always)]
fn greatest(p: &[f32; 3]) -> f32 {
    p[0].abs().max(p[1].abs()).max(p[2].abs())
}
