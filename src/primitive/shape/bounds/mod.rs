//! Certain bounds of the distance of two shapes, and of their depth, in `f64`.
//!
//! Newton's method and GJK propose points and directions, [`support`] evaluates them with an error bound, and only what
//! is evaluated so is certain.

mod axes;
mod certified;
mod depth;
mod gjk;
mod half_space;
mod newton;
mod place;
mod polytope;
mod search;
mod support;

pub(super) use certified::Bounds;
pub use certified::Depth;
pub use depth::depth;
pub(super) use search::bounds;
