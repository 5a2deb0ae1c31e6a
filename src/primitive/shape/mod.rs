//! Convex shapes: spheres, capsules, cuboids, cylinders, cones and half-spaces, each optionally widened by a radius.
//!
//! A [`Shape`] is a core and a radius: all points at most the radius from the core. A sphere is a widened point, a
//! capsule a widened segment. Shapes are closed solids.
//!
//! **Poses.** A pose moves the points of a core by [`Pose::apply`] and rotates its vectors (half edges, axes, normals)
//! without a translation, coordinate by coordinate and rounded to `f64`. Radii stay as they are. Verdicts are those of
//! the shape with these numbers.

mod bounds;
mod convex;
mod core;
mod error;
mod exact;
pub(crate) mod fast;
mod hull;
pub mod lanes;
mod pair;
mod stored;

pub use self::core::Core;
pub use bounds::{Depth, depth};
pub use convex::Shape;
pub use error::ShapeError;
pub(crate) use hull::hull_of;
pub(crate) use pair::{is_near, nearer};
pub use pair::{is_within, meets, separation};
pub use stored::{ShapeNumbers, Shapes, SingleShapeNumbers};

#[cfg(doc)]
use crate::pose::Pose;
