//! Certain bounds of the distance between two shapes, and of their depth, in `f64`.
//!
//! Newton's method and GJK propose points and directions, and [`support`] evaluates them with an error bound. Only
//! these evaluations have to be certain.

mod axes;
mod certified;
#[expect(clippy::needless_range_loop, reason = "several arrays share the index")]
mod closed;
mod depth;
mod gjk;
mod goal;
mod half_space;
pub(super) mod hulls;
mod newton;
mod place;
mod polytope;
mod search;
mod support;

pub(super) use certified::Certified;
pub use certified::Depth;
pub use depth::depth;

use super::convex::Shape;
use super::place::{InPlace, Placement};

/// Bounds of the distance, in closed form if there is one.
#[inline(never)]
pub(super) fn bounds(a: &Shape, b: &Shape, limit: f64, tolerance: f64) -> Certified {
    bounds_placed(a, InPlace, b, limit, tolerance)
}

/// [`bounds`] for `a` where it is.
#[inline(always)]
pub(super) fn bounds_placed<P: Placement>(
    a: &Shape,
    at: P,
    b: &Shape,
    limit: f64,
    tolerance: f64,
) -> Certified {
    closed::bounds(a, at, b, limit, tolerance)
        .unwrap_or_else(|| at.with(a, |a| search::bounds(a, b, limit, tolerance)))
}
