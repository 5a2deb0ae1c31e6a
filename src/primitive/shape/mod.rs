//! Convex shapes: spheres, capsules, cuboids, cylinders, cones and half-spaces, each optionally widened by a radius.
//!
//! A [`Shape`] is a core and a radius: all points at most the radius from the core. A sphere is a widened point, a
//! capsule a widened segment. Shapes are closed solids.
//!
//! **Poses.** A pose moves the points of a core by [`Pose::apply`] and rotates its vectors (half edges, axes, normals)
//! without a translation, coordinate by coordinate and rounded to `f64`. Radii stay as they are. Verdicts are those of
//! the shape with these numbers.
//!
//! **Exactness.** For two shapes, with R the sum of their radii and the margin:
//!
//! | pair | verdict |
//! |---|---|
//! | points, segments, triangles, cuboids among each other | exact |
//! | half-space and any shape, widened round ones among them | exact |
//! | cylinder or cone, and a point (a sphere) | exact |
//! | cylinder or cone, and a segment, triangle or cuboid, R = 0 | exact |
//! | the same with R > 0 | certain if free; a hit may be 2^-40 of the size apart |
//! | cylinders and cones among each other | certain if free; a hit may be 2^-40 of the size apart |
//!
//! The convex hull of points is a body of triangles, decided as exactly as these: `construct::ConvexHull`.
//!
//! Distances ([`separation`]) and depths ([`depth`]) are certain bounds, also for hulls of points
//! ([`signed_separation`]).
//!
//! ```
//! use simdop::glam::{DAffine3, DVec3};
//! use simdop::pose::Pose;
//! use simdop::primitive::Shape;
//! use simdop::primitive::shape::{depth, meets, separation};
//!
//! let (can, shelf) = (Shape::cylinder(0.03, 0.14)?, Shape::cuboid([0.2, 0.6, 0.5])?);
//! let at = |x: f64| Pose::try_from(DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)));
//! let beside = can.moved(&at(0.1300001)?);
//! assert!(!meets(&beside, &shelf) && meets(&can.moved(&at(0.1299999)?), &shelf));
//! let gap = separation(&beside, &shelf, f64::INFINITY, 0.0).ok_or("no limit")?;
//! assert!((gap.upper - 1e-7).abs() < 1e-14 && gap.lower <= gap.upper);
//! let inside = depth(&can.moved(&at(0.12)?), &shelf, 1e-6);
//! assert!((inside.upper - 0.01).abs() < 1e-8 && inside.direction[0] > 0.999);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bounds;
mod convex;
mod core;
mod error;
mod exact;
pub(crate) mod fast;
mod hull;
pub mod lanes;
mod pair;
mod place;
mod signed;
mod stored;

pub use self::core::Core;
pub use bounds::{Depth, depth};
pub use convex::Shape;
pub use error::ShapeError;
#[cfg(feature = "alloc")]
pub(crate) use error::length;
pub(crate) use hull::hull_of;
pub(crate) use pair::{is_near, is_near_posed, nearer, nearer_posed};
pub use pair::{is_within, meets, separation};
pub use signed::{Convex, SignedSeparation, signed_separation};
pub use stored::{ShapeNumbers, Shapes, SingleShapeNumbers};

#[cfg(doc)]
use crate::pose::Pose;
