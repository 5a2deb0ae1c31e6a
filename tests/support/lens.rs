//! What two balls share.

use core::f64::consts::PI;

/// The volume that balls of these radii share whose centres are `d` apart: the caps on both sides of the plane of the
/// circle in which they meet. The height of a cap as a quotient of what does not cancel, so that thin ones keep their
/// digits, and those of balls that nearly coincide.
pub(crate) fn lens(r_a: f64, r_b: f64, d: f64) -> f64 {
    let (r, s) = (r_a.max(r_b), r_a.min(r_b));
    let depth = (r + s) - d;
    let out = d - (r - s);
    if depth <= 0.0 {
        return 0.0;
    }
    if out <= 0.0 {
        return 4.0 / 3.0 * PI * s * s * s;
    }
    let cap = |radius: f64, height: f64| PI * height * height * (radius - height / 3.0);
    cap(r, depth * out / (2.0 * d)) + cap(s, depth * (d + (r - s)) / (2.0 * d))
}
