//! The intersection of two balls.

use core::f64::consts::PI;

/// The volume of the intersection of two balls whose centres are `d` apart: the caps on both sides of the plane
/// of the circle in which the spheres meet. The height of a cap is a quotient without cancellation, so that
/// thin caps, and caps of nearly coincident balls, keep their digits.
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
