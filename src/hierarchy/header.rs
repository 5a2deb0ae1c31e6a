//! The header of a baked tree.

use crate::frame::{BodyBounds, Frame};
use crate::key::StorageKind;
use crate::node::Child;
#[cfg(doc)]
use crate::node::Width;
#[cfg(doc)]
use crate::primitive::Kind;
use crate::range::Point;
use core::fmt;

/// First bytes of every baked tree. The line feed and the control character reveal a transfer in text mode.
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
    /// Number of degenerate triangles, whose corners are collinear or coincide. They are kept, and collide as segments
    /// or points.
    pub degenerate_count: u32,
    /// Centre of the frame, in the body's unit.
    pub centre: Point,
    /// Upper bound of the absolute coordinates of the body's points and of the centre, in the body's unit.
    pub max_coordinate: f64,
    /// Upper bound of the distances of the body's points from the centre, in the body's unit.
    pub radius: f64,
    /// Scale of the frame: `2^exponent`.
    pub exponent: i32,
    /// Upper bounds of `|x|`, `|y|` and `|z|` of the body's points in the frame.
    pub half_width: [f32; 3],
    /// Largest absolute finite plane.
    pub max_plane: f32,
    /// How much wider the volumes become when they are rotated, in the unit of the frame. A query rotates the body
    /// whose volumes grow less.
    pub rotation_growth: f32,
    /// The link to the root, with the [`Width`] of a box of twice [`Header::half_width`].
    pub root: Child,
    /// Bytes per vertex: 12 (three `f32`) or 24 (three `f64`) for triangles, 16 or 32 for spheres.
    pub vertex_size: u16,
    /// 1 if the tree has normal slabs, else 0.
    pub has_normal_slabs: u16,
    /// 1 if the tree has bounding balls of its lanes, else 0.
    pub has_balls: u16,
    /// 1 if the triangles bound a solid, 0 if they are a surface. 0 for spheres, each of which is solid.
    pub is_solid: u8,
    /// 1 if the tree of a [packing](super::BvhRef::packing) follows, else 0.
    pub has_packing: u8,
    /// Number of parts (connected components of the body) with an entry after the source indices: the index of one
    /// primitive of the part. 0 for a body with a single part, which primitive 0 represents, and for spheres, each of
    /// which is a part.
    pub part_count: u32,
    /// How planes are stored: [`Storage::CODE`](crate::low_level::key::Storage::CODE).
    pub storage: u16,
    /// Bytes of the tree of the [caps](super::BvhRef::caps), divided by 64; 0 if the solid has none.
    pub cap_lines: u16,
    /// The greatest width of a capped hole, rounded up, in the unit of the frame; 0 without caps.
    pub cap_width: f32,
}

const _: () = assert!(size_of::<Header>() == 128 && align_of::<Header>() == 8, "the header has 128 bytes");

/// Why bytes are not a valid tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum FormatError {
    /// The bytes do not start at a multiple of 64: see [`crate::hierarchy::Aligned`].
    Misaligned,
    /// The bytes do not start with [`MAGIC`].
    NotATree,
    /// The layout has a different version.
    Version {
        /// The version found.
        found: u32,
    },
    /// The tree's primitives are of a different kind than requested.
    OtherPrimitive {
        /// The code of the kind found: see [`Kind::code`].
        kind: u16,
    },
    /// The tree's k or arity differs from that of the requested node type.
    OtherNode {
        /// k found.
        k: u16,
        /// Arity found.
        arity: u16,
    },
    /// The storage of the tree's planes differs from that of the requested node type.
    OtherStorage {
        /// The storage found: [`Header::storage`].
        storage: u16,
    },
    /// The bytes end early.
    Truncated {
        /// Bytes given.
        have: usize,
        /// Bytes needed.
        need: usize,
    },
    /// There are bytes after the end of the tree.
    TooLong {
        /// Bytes given.
        have: usize,
        /// Bytes of the tree.
        need: usize,
    },
    /// A field of the header is invalid, or contradicts the contents.
    Header {
        /// Its name.
        field: &'static str,
    },
    /// A plane or link of a node is invalid.
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
    /// A primitive refers to a vertex that does not exist.
    Primitive {
        /// Index of the primitive in leaf order.
        index: u32,
    },
    /// The source index of a primitive is not below the number of primitives.
    Source {
        /// Index of the primitive in leaf order.
        index: u32,
    },
    /// The entry of a part is not the index of a primitive, or is not above the entry of the part before.
    Part {
        /// Index of the part.
        index: u32,
    },
    /// The tree of the caps is invalid, or does not belong to this tree.
    Caps {
        /// What is wrong.
        problem: &'static str,
    },
    /// The tree of the packing is invalid, or does not belong to this tree.
    Packing {
        /// What is wrong.
        problem: &'static str,
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
            Self::OtherStorage { storage } => match StorageKind::from_code(*storage) {
                Some(kind) => write!(f, "the tree's planes are {kind}"),
                None => write!(f, "the tree's planes are in an unknown storage, {storage}"),
            },
            Self::Truncated { have, need } => write!(f, "the tree ends early: {have} bytes of {need}"),
            Self::TooLong { have, need } => write!(f, "{have} bytes, of which the tree is the first {need}"),
            Self::Header { field } => write!(f, "bad header: {field}"),
            Self::Node { node, lane, problem } => write!(f, "node {node}, lane {lane}: {problem}"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite or out of range"),
            Self::Primitive { index } => write!(f, "primitive {index} names a vertex that there is not"),
            Self::Source { index } => {
                write!(f, "primitive {index} has a source index that is not below the number of primitives")
            }
            Self::Part { index } => {
                write!(f, "the entry of part {index} is not a primitive, or is out of order")
            }
            Self::Caps { problem } => write!(f, "the tree of the caps: {problem}"),
            Self::Packing { problem } => write!(f, "the tree of the packing: {problem}"),
        }
    }
}

impl core::error::Error for FormatError {}

impl Header {
    /// The bounds of the body.
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
