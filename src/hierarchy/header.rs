//! The head of a baked tree.

use crate::frame::{BodyBounds, Frame};
use crate::node::Child;
#[cfg(doc)]
use crate::node::Width;
#[cfg(doc)]
use crate::primitive::Kind;
use crate::range::Point;
use core::fmt;

/// First bytes of every baked tree. The line feed and the control character show a transfer in text mode.
pub const MAGIC: [u8; 8] = *b"SIMDOP\x1a\n";

/// Version of the layout that this crate reads and writes.
pub const VERSION: u32 = 6;

#[cfg(target_endian = "big")]
compile_error!("baked trees are little-endian and read in place: big-endian targets are not supported");

/// Description of a tree: the first 128 bytes.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub(crate) magic: [u8; 8],
    /// [`VERSION`].
    pub version: u32,
    /// Planes of a child.
    pub k: u16,
    /// Children of a node.
    pub arity: u16,
    /// What the primitives are: [`Kind::code`].
    pub kind: u16,
    /// Largest number of primitives in a leaf.
    pub leaf_size: u16,
    /// Levels of nodes.
    pub depth: u32,
    /// Number of nodes.
    pub node_count: u32,
    /// Number of primitives.
    pub primitive_count: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Primitives that are flat in more ways than their kind is: triangles without area, whose corners are
    /// collinear or coincide. They are kept, and collide as the segments or points they are.
    pub degenerate_count: u32,
    /// Centre of the frame, in the body's unit.
    pub centre: Point,
    /// Largest absolute coordinate of a point of the body or of the centre, in the body's unit. At least.
    pub max_coordinate: f64,
    /// Largest distance of a point of the body from the centre, in the body's unit. At least.
    pub radius: f64,
    /// Scale of the frame: `2^exponent`.
    pub exponent: i32,
    /// Largest `|x|`, `|y|`, `|z|` of a point of the body in the frame. At least.
    pub half_width: [f32; 3],
    /// Largest absolute finite plane.
    pub max_plane: f32,
    /// How loose the planes get when they are turned, in the unit of the frame: of two bodies a query turns the one that
    /// loses less.
    pub rotation_growth: f32,
    /// The link to the root, with the [`Width`] of a box of twice [`Header::half_width`].
    pub root: Child,
    /// Bytes of a vertex. Of triangles: 12 (three `f32`) or 24 (three `f64`); of spheres 16 or 32.
    pub vertex_size: u16,
    /// 1 if the tree has normal slabs, else 0.
    pub has_normal_slabs: u16,
    /// 1 if the tree has the balls of its lanes, else 0.
    pub has_balls: u16,
    /// 1 if the triangles bound a solid, 0 if they are a surface; 0 of spheres, each of which is solid.
    pub is_solid: u16,
    /// Number of parts of which a primitive each is named at the end of the bytes: parts do not hang together. 0 of a body
    /// that is one part, which primitive 0 stands for, and of spheres, each of which is a part.
    pub part_count: u32,
    /// Zeros.
    pub(crate) reserved: [u32; 2],
}

const _: () = assert!(size_of::<Header>() == 128 && align_of::<Header>() == 8, "the header has 128 bytes");

/// Why bytes are not a tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum FormatError {
    /// The bytes do not start at a multiple of 64: see [`crate::hierarchy::Aligned`].
    Misaligned,
    /// The bytes do not start with [`MAGIC`].
    NotATree,
    /// The layout has another version.
    Version {
        /// The version found.
        found: u32,
    },
    /// The tree has other primitives than those asked for.
    OtherPrimitive {
        /// The code of the kind found: see [`Kind::code`].
        kind: u16,
    },
    /// The tree has another k or arity than the node type asked for.
    OtherNode {
        /// k found.
        k: u16,
        /// Arity found.
        arity: u16,
    },
    /// The bytes end early.
    Truncated {
        /// Bytes given.
        have: usize,
        /// Bytes needed.
        need: usize,
    },
    /// Bytes follow after the end of the tree.
    TooLong {
        /// Bytes given.
        have: usize,
        /// Bytes of the tree.
        need: usize,
    },
    /// A field of the header cannot be, or contradicts the contents.
    Header {
        /// Its name.
        field: &'static str,
    },
    /// A plane or link of a node cannot be.
    Node {
        /// Index of the node.
        node: u32,
        /// Lane in the node.
        lane: u32,
        /// What is wrong.
        problem: &'static str,
    },
    /// A vertex is not finite or out of range.
    Vertex {
        /// Index of the vertex.
        index: u32,
    },
    /// A primitive names a vertex that there is not.
    Primitive {
        /// Index of the primitive in leaf order.
        index: u32,
    },
    /// The index that a primitive had in what was built is not below the number of primitives.
    Source {
        /// Index of the primitive in leaf order.
        index: u32,
    },
    /// What stands for a part is no primitive, or does not come after what stands for the part before.
    Part {
        /// Index of the part.
        index: u32,
    },
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Misaligned => f.write_str("the tree's bytes do not start at a multiple of 64"),
            Self::NotATree => f.write_str("not a baked tree: the first bytes are not its magic number"),
            Self::Version { found } => write!(f, "layout version {found}, this library reads {VERSION}"),
            Self::OtherPrimitive { kind } => write!(f, "the tree has primitives of another kind, {kind}"),
            Self::OtherNode { k, arity } => write!(f, "the tree has k = {k} and arity {arity}"),
            Self::Truncated { have, need } => write!(f, "the tree ends early: {have} bytes of {need}"),
            Self::TooLong { have, need } => write!(f, "{have} bytes, of which the tree is the first {need}"),
            Self::Header { field } => write!(f, "bad header: {field}"),
            Self::Node { node, lane, problem } => write!(f, "node {node}, lane {lane}: {problem}"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite or out of range"),
            Self::Primitive { index } => write!(f, "primitive {index} names a vertex that there is not"),
            Self::Source { index } => {
                write!(f, "primitive {index} had an index that is not below the number of primitives")
            }
            Self::Part { index } => {
                write!(f, "what stands for part {index} is no primitive, or out of order")
            }
        }
    }
}

impl core::error::Error for FormatError {}

impl Header {
    /// How large the body is.
    #[inline(always)]
    #[must_use]
    pub const fn extent(&self) -> BodyBounds {
        BodyBounds {
            frame: Frame { centre: self.centre, exponent: self.exponent },
            max_coordinate: self.max_coordinate,
            radius: self.radius,
            half_width: self.half_width,
            max_plane: self.max_plane,
        }
    }
}
