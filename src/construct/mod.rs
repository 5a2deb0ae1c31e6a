//! Construction: a splitter assigns primitives to lanes, level by level; then the planes of the nodes are computed, and
//! the bytes are assembled.
//!
//! Splitters return only an [`Assignment`]. Only `bake` makes planes, links and bytes, so equal assignments by
//! different splitters or machines give equal bytes.

mod any;
mod bake;
mod builder;
mod clustering;
mod cover;
mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
mod hull;
mod input;
mod packing;
mod split;

pub use crate::primitive::shape::ShapeError;
pub use builder::Builder;
#[doc(hidden)]
pub use clustering::Clustering;
pub use cover::CoverError;
pub(crate) use cover::{ROUNDING as COVER_ROUNDING, check_error as check_cover_error, cut};
pub use error::BuildError;
pub(crate) use error::OpenEdge;
pub use hull::ConvexHull;
pub use input::{Caps, Geometry, Mesh, OwnedMesh, ShapeSet, SphereSet};
pub(crate) use input::{Unclosed, check_closed};
pub(crate) use split::assign_points;
pub use split::{Assignment, Magnification, Progress, Splitter};
