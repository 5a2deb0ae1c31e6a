//! Primitives: what the leaves of a hierarchy contain.
//!
//! A [`Primitive`] is a type of geometry: triangles, spheres or shapes. Hierarchies, their header, the packer and the
//! traversal are the same for all types. This module contains what differs: how primitives are stored and read, how a
//! pose moves them, and whether a plane bounds them. The trait [`crate::query::PrimitivePair`] tests one primitive
//! against another.

mod ball;
mod kind;
pub(crate) mod lattice;
mod separation;
pub mod shape;
pub mod sphere;
pub(crate) mod sphere_against_triangle;
mod store;
pub mod triangle;

pub use ball::Sphere;
pub use kind::Kind;
pub use lattice::{Lattice, LatticeCorners};
pub use separation::Separation;
pub use shape::{Shape, Shapes};
pub use sphere::Spheres;
pub(crate) use store::{Fault, radius_of};
pub use store::{OWN_DIRECTIONS, Primitive, Store};
pub use triangle::Triangles;
