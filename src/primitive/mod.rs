//! Primitives: what the leaves of a hierarchy contain.
//!
//! A [`Primitive`] is a type of geometry: triangles and spheres today. Hierarchies, their header, the packer and the
//! traversal are the same for all types. This module has what differs: how primitives are stored and read, how a pose
//! moves them, and whether a plane bounds them. The tests of one primitive against another have a trait of their own,
//! [`crate::query::PrimitivePair`].

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
