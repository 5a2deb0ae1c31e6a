//! Why a mesh cannot be filled.

use crate::construct::{BuildError, OpenEdge};
use crate::range::Point;
use core::fmt;

/// Why a mesh cannot be packed with spheres.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum PackError {
    /// The mesh has no triangle.
    Empty,
    /// The mesh is malformed: a coordinate is not finite or out of [range](crate::range), a vertex index is out of
    /// bounds, or there are too many elements.
    Mesh(BuildError),
    /// The numbers of triangles that run along an edge in the two directions differ: the mesh has a border there, or
    /// its triangles are not oriented consistently.
    Open {
        /// The edge's two vertices; of several with the same coordinates the first.
        edge: [u32; 2],
        /// Their coordinates.
        corners: [Point; 2],
        /// Triangles that run from the first vertex to the second.
        forward: usize,
        /// Triangles that run from the second vertex to the first.
        backward: usize,
    },
    /// The mesh encloses no volume, up to rounding.
    Flat,
    /// The observer of [`super::Packer::pack_with`] cancelled.
    Cancelled,
}

impl fmt::Display for PackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => f.write_str("there is no triangle, and so nothing to fill"),
            Self::Mesh(error) => error.fmt(f),
            Self::Open { edge, corners, forward, backward } => {
                OpenEdge { edge, corners, forward, backward }.fmt(f)
            }
            Self::Flat => f.write_str("the mesh encloses no volume"),
            Self::Cancelled => f.write_str("the packing was cancelled"),
        }
    }
}

impl core::error::Error for PackError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Mesh(error) => Some(error),
            _ => None,
        }
    }
}
