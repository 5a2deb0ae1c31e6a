//! Certain bounds of the depth of two shapes that meet, in `f64`.
//!
//! The depth is the distance of the origin from the boundary of A - B. The projection on any direction bounds it from
//! above: a translation by the overlap separates the two. For polytopes the boundary's faces are perpendicular to
//! finitely many axes ([`super::axes`]); for round shapes a polytope inside A - B bounds it from below
//! ([`super::polytope`]).

use super::certified::Depth;
use super::search::{DistanceSearch, unit_scale};
use super::support::Operands;
use super::{axes, half_space, polytope};
use crate::exact::power_of_two;
use crate::primitive::shape::convex::Shape;
use crate::vector::{dot, sqrt};

#[cfg(test)]
mod tests;

/// Maximum number of corners of the polytope that grows towards the boundary.
const CORNERS: usize = 64;
const FACES: usize = 128;

/// Bounds of the depth of two shapes in one frame; zero for shapes that are apart. They differ by at most `tolerance`
/// times the upper one, or by rounding, unless round shapes need more than the 128 faces of the search.
#[must_use]
pub fn depth(a: &Shape, b: &Shape, tolerance: f64) -> Depth {
    let Some(pair) = Operands::of(&a.core, &b.core, 1.0) else {
        return half_space::depth(a, b);
    };
    let comfortable = power_of_two(-100)..=power_of_two(100);
    if comfortable.contains(&pair.size) || pair.size == 0.0 {
        of_pair(&pair, [a.radius, b.radius], tolerance)
    } else {
        rescaled(a, b, tolerance, pair.size)
    }
}

#[cold]
#[inline(never)]
fn rescaled(a: &Shape, b: &Shape, tolerance: f64, size: f64) -> Depth {
    let scale = unit_scale(size);
    let Some(pair) = Operands::of(&a.core, &b.core, scale) else {
        return half_space::depth(a, b);
    };
    let found = of_pair(&pair, [a.radius * scale, b.radius * scale], tolerance);
    Depth { lower: found.lower / scale, upper: found.upper / scale, ..found }
}

fn of_pair(pair: &Operands, radii: [f64; 2], tolerance: f64) -> Depth {
    let sum = radii[0] + radii[1];
    let [less, more] = [sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON)];
    let mut search = DistanceSearch::new(pair, [0.0; 2], more, 0.0);
    let (wide, narrow) = (1.0 + 2.0 * f64::EPSILON, 1.0 - 2.0 * f64::EPSILON);
    search.approach();
    // Bounds for the cores, negative if they are apart.
    let (mut lower, mut upper, mut along) = (-search.upper, -search.lower, search.along);
    if search.lower <= 0.0 {
        if let Some((below, above, axis)) = axes::depth(pair) {
            lower = lower.max(below);
            if above < upper {
                (upper, along) = (above, axis);
            }
        }
        let goal = (tolerance * (less + upper)).max(3.0 * pair.slack);
        let is_tight = upper < f64::INFINITY && upper - lower <= goal;
        if !is_tight {
            let corners = search.overlap();
            search.edges();
            if -search.lower < upper {
                (upper, along) = (-search.lower, search.along);
            }
            if let Some((below, above, axis)) = polytope::depth::<CORNERS, FACES>(pair, corners, tolerance) {
                lower = lower.max(below);
                if above < upper {
                    (upper, along) = (above, axis);
                }
            }
        }
    }
    let length = sqrt(dot(&along, &along));
    let direction = if length > 0.0 { along.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    if length == 0.0 {
        // No direction has been tried: the cores are one point up to rounding, and no direction has a gap below
        // -slack.
        upper = upper.min(pair.size + pair.slack);
    }
    let lower = if lower >= 0.0 { (less + lower) * narrow } else { ((less + lower) * narrow).max(0.0) };
    Depth { lower, upper: ((more + upper) * wide).max(0.0), direction }
}
