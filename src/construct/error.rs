//! Errors of construction.

use crate::hierarchy::NodeType;
#[cfg(doc)]
use crate::node::Child;
use crate::node::MAX_LEAF_SIZE;
use crate::range::Point;
use core::fmt;

/// Why a mesh, or another geometry, cannot be built.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum BuildError {
    /// The leaf size is not 1 to 16.
    LeafSize {
        /// The size asked for.
        asked: u32,
    },
    /// More primitives than [`Child::MAX_PRIMITIVES`], or more vertices than fit in 32 bits.
    TooLarge {
        /// The number given.
        count: usize,
    },
    /// A coordinate is NaN, infinite, or beyond [`crate::range::MAX_COORDINATE`].
    Vertex {
        /// Index of the vertex.
        index: usize,
    },
    /// A radius is negative, NaN or infinite, or a point of the sphere is beyond [`crate::range::MAX_COORDINATE`].
    Radius {
        /// Index of the sphere, or of the vertex with this radius.
        index: usize,
    },
    /// All coordinates are below [`crate::range::MIN_COORDINATE`], and not all are zero: the body would become a point.
    TooSmall,
    /// A triangle, or other primitive, refers to a vertex that does not exist.
    Primitive {
        /// Index of the primitive.
        index: usize,
    },
    /// The mesh should be [solid](super::Builder::solid), but along some edge different numbers of triangles run in
    /// the two directions: there is a hole, or the triangles are not consistently oriented.
    Open {
        /// The edge's two vertices; of vertices with equal coordinates, the first.
        edge: [u32; 2],
        /// Their coordinates, in the body's unit.
        corners: [Point; 2],
        /// Triangles that run from the first vertex to the second.
        forward: usize,
        /// Triangles that run from the second vertex to the first.
        backward: usize,
    },
    /// A hole of the mesh is wider than [allowed](super::Builder::solid_with_caps). This is the widest hole.
    Hole {
        /// The two vertices of an edge at its border; of vertices with equal coordinates, the first.
        edge: [u32; 2],
        /// Their coordinates, in the body's unit.
        corners: [Point; 2],
        /// Its width, the greatest distance between two corners of its border.
        width: f64,
        /// The greatest width allowed.
        limit: f64,
    },
    /// The holes of the mesh would take more than 16,384 triangles to cap.
    TooManyCaps {
        /// Number of triangles.
        count: usize,
        /// The two vertices of an edge at the border of the hole with the most corners.
        edge: [u32; 2],
        /// Their coordinates, in the body's unit.
        corners: [Point; 2],
    },
    /// No node type has this k and arity.
    NodeType {
        /// What was asked for.
        node: NodeType,
    },
    /// The tree would be deeper than [`crate::hierarchy::MAX_DEPTH`].
    TooDeep,
    /// The assignment is not the shape of a tree over the primitives.
    Assignment {
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A packing cannot be [added](super::Builder::add_packing) to a tree.
    Packing {
        /// Why not.
        problem: &'static str,
    },
    /// A sphere of a packing is not inside the solid.
    NotInside {
        /// Index of the sphere.
        index: usize,
    },
    /// The observer of [`super::Builder::build_with`] stopped the build.
    Cancelled,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::LeafSize { asked } => write!(f, "leaf size {asked}, must be 1 to {MAX_LEAF_SIZE}"),
            Self::TooLarge { count } => write!(f, "{count} primitives or vertices are too many"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite, or beyond 2^300"),
            Self::Radius { index } => {
                write!(f, "the radius of sphere {index} is negative or not finite, or takes it beyond 2^300")
            }
            Self::TooSmall => f.write_str("all coordinates are below 2^-250: choose a smaller unit"),
            Self::Primitive { index } => write!(f, "primitive {index} names a vertex that there is not"),
            Self::Open { edge, corners, forward, backward } => {
                OpenEdge { edge, corners, forward, backward }.fmt(f)
            }
            Self::Hole { edge: [a, b], corners: [p, q], width, limit } => write!(
                f,
                "the mesh has a hole {width} wide, more than {limit}, at the edge of vertices {a} and {b}, {p:?} to \
                 {q:?}"
            ),
            Self::TooManyCaps { count, edge: [a, b], corners: [p, q] } => write!(
                f,
                "{count} triangles to cap the holes of the mesh are too many; the longest border passes the edge of \
                 vertices {a} and {b}, {p:?} to {q:?}"
            ),
            #[cfg(feature = "all-nodes")]
            Self::NodeType { node } => write!(
                f,
                "no nodes of {node} at run time: k is 6, 14, 18 or 26 at arity 16, and 18 at arity 4; half floats take \
                 k = 14, 18 or 26 at arity 16"
            ),
            #[cfg(not(feature = "all-nodes"))]
            Self::NodeType { node } => write!(
                f,
                "no nodes of {node} at run time: k is 18 at arity 16; the feature `all-nodes` adds k = 6, 14 and 26, \
                 and arity 4"
            ),
            Self::TooDeep => f.write_str("the tree would be too deep"),
            Self::Assignment { problem } => write!(f, "the assignment is no tree: {problem}"),
            Self::Packing { problem } => write!(f, "no packing can be added: {problem}"),
            Self::NotInside { index } => {
                write!(f, "sphere {index} of the packing is not inside of the solid")
            }
            Self::Cancelled => f.write_str("the build was cancelled"),
        }
    }
}

impl core::error::Error for BuildError {}

/// An edge along which different numbers of triangles run in the two directions.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct OpenEdge {
    /// Its two vertices; of vertices with equal coordinates, the first.
    pub(crate) edge: [u32; 2],
    /// Their coordinates.
    pub(crate) corners: [Point; 2],
    /// Triangles that run from the first vertex to the second.
    pub(crate) forward: usize,
    /// Triangles that run from the second vertex to the first.
    pub(crate) backward: usize,
}

impl fmt::Display for OpenEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { edge: [a, b], corners: [p, q], forward, backward } = self;
        write!(
            f,
            "the mesh is open, or not oriented alike, at the edge of vertices {a} and {b}, {p:?} to {q:?}: {forward} \
             of its triangles run from {a} to {b}, {backward} back"
        )
    }
}
