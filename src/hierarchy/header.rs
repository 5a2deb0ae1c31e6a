//! The head of a baked tree, and where its parts lie.

use core::fmt;
use core::ops::Range;

/// First bytes of every baked tree. The line feed and the control character show a transfer in text mode.
pub const MAGIC: [u8; 8] = *b"SIMDOP\x1a\n";

/// Version of the layout that this crate reads and writes.
pub const VERSION: u32 = 1;

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
    /// Bytes of a vertex: 12 (three `f32`) or 24 (three `f64`).
    pub vertex_size: u16,
    /// Largest number of triangles in a leaf.
    pub leaf_size: u16,
    /// Levels of nodes.
    pub depth: u32,
    /// Number of nodes.
    pub node_count: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Triangles without area: corners collinear or coincident. They are kept, and collide as the segments or points they are.
    pub degenerate_count: u32,
    /// Centre of the frame, in the body's unit.
    pub centre: [f64; 3],
    /// Largest absolute coordinate of a vertex or of the centre, in the body's unit.
    pub extent: f64,
    /// Scale of the frame: `2^exponent`.
    pub exponent: i32,
    /// Largest `|x|`, `|y|`, `|z|` of a vertex in the frame. At least.
    pub half_width: [f32; 3],
    /// Largest absolute finite plane.
    pub max_plane: f32,
    pub(crate) reserved: [u32; 9],
}

const _: () = assert!(size_of::<Header>() == 128 && align_of::<Header>() == 8, "the header has 128 bytes");

/// Why bytes are not a tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum BakeError {
    /// The bytes do not start at a multiple of 64: see [`crate::hierarchy::Aligned`].
    Misaligned,
    /// The bytes do not start with [`MAGIC`].
    NotATree,
    /// The layout has another version.
    Version {
        /// The version found.
        found: u32,
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
    /// A triangle names a vertex that there is not.
    Triangle {
        /// Index of the triangle in leaf order.
        index: u32,
    },
    /// A triangle's index in the mesh is not below the number of triangles.
    Source {
        /// Index of the triangle in leaf order.
        index: u32,
    },
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Misaligned => f.write_str("the tree's bytes do not start at a multiple of 64"),
            Self::NotATree => f.write_str("not a baked tree: the first bytes are not its magic number"),
            Self::Version { found } => write!(f, "layout version {found}, this library reads {VERSION}"),
            Self::OtherNode { k, arity } => write!(f, "the tree has k = {k} and arity {arity}"),
            Self::Truncated { have, need } => write!(f, "the tree ends early: {have} bytes of {need}"),
            Self::TooLong { have, need } => write!(f, "{have} bytes, of which the tree is the first {need}"),
            Self::Header { field } => write!(f, "bad header: {field}"),
            Self::Node { node, lane, problem } => write!(f, "node {node}, lane {lane}: {problem}"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite or out of range"),
            Self::Triangle { index } => write!(f, "triangle {index} names a vertex that there is not"),
            Self::Source { index } => write!(
                f,
                "triangle {index} has an index in its mesh that is not below the number of triangles"
            ),
        }
    }
}

impl core::error::Error for BakeError {}

/// Byte ranges of the parts.
pub(crate) struct Layout {
    pub(crate) nodes: Range<usize>,
    pub(crate) vertices: Range<usize>,
    pub(crate) triangles: Range<usize>,
    pub(crate) sources: Range<usize>,
    /// Length of the whole, a multiple of 64.
    pub(crate) end: usize,
}

impl Header {
    /// The header of some bytes, whatever the node type: to find out which.
    ///
    /// # Errors
    /// [`BakeError`] if the bytes are misaligned, too short, no tree or of another version.
    pub fn read(bytes: &[u8]) -> Result<&Self, BakeError> {
        let need = size_of::<Self>();
        if !bytes.starts_with(&MAGIC) {
            return Err(BakeError::NotATree);
        }
        if bytes.len() < need {
            return Err(BakeError::Truncated { have: bytes.len(), need });
        }
        if bytes.as_ptr().align_offset(64) != 0 {
            return Err(BakeError::Misaligned);
        }
        let header: &Self = bytemuck::try_from_bytes(&bytes[..need]).map_err(|_| BakeError::Misaligned)?;
        if header.version == VERSION { Ok(header) } else { Err(BakeError::Version { found: header.version }) }
    }

    pub(crate) fn check_type(&self, k: usize, arity: usize) -> Result<(), BakeError> {
        if usize::from(self.k) == k && usize::from(self.arity) == arity {
            Ok(())
        } else {
            Err(BakeError::OtherNode { k: self.k, arity: self.arity })
        }
    }

    /// Where the parts lie. On a 32-bit machine a tree may be too large to address.
    pub(crate) fn layout(&self, node_size: usize) -> Result<Layout, BakeError> {
        if self.vertex_size != 12 && self.vertex_size != 24 {
            return Err(BakeError::Header { field: "vertex_size" });
        }
        let mut end = size_of::<Self>();
        let mut part = |count: u32, size: usize, align: usize| {
            let start = end.checked_next_multiple_of(align)?;
            end = (count as usize).checked_mul(size).and_then(|bytes| start.checked_add(bytes))?;
            Some(start..end)
        };
        let parts = (|| {
            let nodes = part(self.node_count, node_size, 64)?;
            let vertices = part(self.vertex_count, self.vertex_size.into(), 8)?;
            let triangles = part(self.triangle_count, 12, 4)?;
            let sources = part(self.triangle_count, 4, 4)?;
            let end = part(0, 0, 64)?.end;
            Some(Layout { nodes, vertices, triangles, sources, end })
        })();
        parts.ok_or(BakeError::Header { field: "counts overflow the address space" })
    }
}
