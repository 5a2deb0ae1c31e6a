//! Bounding volume hierarchies over triangles: one run of bytes, read in place.
//!
//! A baked tree is a [`Header`], the nodes in breadth-first order, the vertices, the triangles in the order of the leaves, and for
//! each triangle its index in the mesh that was built. All little-endian, each part aligned for its type, the whole to 64 bytes.
//! [`BvhRef::from_bytes`] borrows it from flash or a memory map after [checking](BvhRef::validate) that it is safe to walk;
//! [`Bvh`] owns such bytes.

mod header;
mod stats;
mod tree_stats;
mod validate;
mod verify;

pub use header::{BakeError, Header, MAGIC, VERSION};
pub use stats::Stats;
pub use tree_stats::TreeStats;
pub use verify::VerifyError;

use crate::frame::Frame;
use crate::node::Node;
use crate::primitive::triangle::Triangle;
use crate::range::Point;
#[cfg(feature = "alloc")]
use core::marker::PhantomData;

/// Levels of nodes, at most: it bounds the stack of every query. 16-ary trees of any practical size have fewer than 10.
pub const MAX_DEPTH: usize = 22;

/// Gives its content the alignment that [`BvhRef::from_bytes`] asks for.
///
/// ```
/// use simdop::hierarchy::Aligned;
/// static TREE: Aligned<[u8; 4]> = Aligned(*b"tree"); // Aligned(*include_bytes!("robot.simdop"))
/// assert_eq!(TREE.0.as_ptr() as usize % 64, 0);
/// ```
#[derive(Copy, Clone, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T: ?Sized>(pub T);

/// Vertices as stored: in single precision where that loses nothing, else in double.
#[derive(Copy, Clone, Debug)]
enum Vertices<'a> {
    F32(&'a [[f32; 3]]),
    F64(&'a [[f64; 3]]),
}

/// A hierarchy over borrowed bytes. Small and `Copy`: pass it by value or reference as you like.
#[derive(Debug)]
pub struct BvhRef<'a, N> {
    header: &'a Header,
    nodes: &'a [N],
    vertices: Vertices<'a>,
    triangles: &'a [[u32; 3]],
    sources: &'a [u32],
}

impl<N> Copy for BvhRef<'_, N> {}
impl<N> Clone for BvhRef<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'a, N: Node> BvhRef<'a, N> {
    /// Borrows a baked tree in place, without a copy, after [`BvhRef::validate`]: linear in its size.
    ///
    /// # Errors
    /// [`BakeError`] if the bytes are not a tree of this node type, all of it and nothing else, are not aligned to 64, or are not safe to walk.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, BakeError> {
        let view = Self::view(bytes)?;
        view.validate()?;
        Ok(view)
    }

    /// The parts of the bytes, their contents unchecked.
    fn view(bytes: &'a [u8]) -> Result<Self, BakeError> {
        let header = Header::read(bytes)?;
        header.check_type(N::K, N::ARITY)?;
        let layout = header.layout(size_of::<N>())?;
        match (bytes.len(), layout.end) {
            (have, need) if have < need => return Err(BakeError::Truncated { have, need }),
            (have, need) if have > need => return Err(BakeError::TooLong { have, need }),
            _ => {}
        }
        let cast_error = |_| BakeError::Misaligned;
        let vertex_bytes = &bytes[layout.vertices.clone()];
        Ok(Self {
            header,
            nodes: bytemuck::try_cast_slice(&bytes[layout.nodes.clone()]).map_err(cast_error)?,
            vertices: if header.vertex_size == 12 {
                Vertices::F32(bytemuck::try_cast_slice(vertex_bytes).map_err(cast_error)?)
            } else {
                Vertices::F64(bytemuck::try_cast_slice(vertex_bytes).map_err(cast_error)?)
            },
            triangles: bytemuck::try_cast_slice(&bytes[layout.triangles.clone()]).map_err(cast_error)?,
            sources: bytemuck::try_cast_slice(&bytes[layout.sources.clone()]).map_err(cast_error)?,
        })
    }

    /// The tree's description.
    #[inline]
    #[must_use]
    pub const fn header(&self) -> &'a Header {
        self.header
    }

    /// All nodes, breadth-first: the root, if there is one, is the first.
    #[inline]
    #[must_use]
    pub const fn nodes(&self) -> &'a [N] {
        self.nodes
    }

    /// The frame that the planes are written in.
    #[inline]
    #[must_use]
    pub const fn frame(&self) -> Frame {
        Frame { centre: self.header.centre, exponent: self.header.exponent }
    }

    /// Number of triangles.
    #[inline]
    #[must_use]
    pub const fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is no triangle. An empty body meets nothing.
    #[inline]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The corners of triangle `index`, an index in leaf order below [`len`](Self::len), in the body's unit.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline(always)]
    #[must_use]
    pub fn triangle(&self, index: u32) -> Triangle {
        let [p, q, r] = self.triangles[index as usize];
        [self.vertex(p), self.vertex(q), self.vertex(r)]
    }

    /// The index that the triangle at `index` in leaf order had in the mesh.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline]
    #[must_use]
    pub const fn source(&self, index: u32) -> u32 {
        self.sources[index as usize]
    }

    #[inline(always)]
    fn vertex(&self, index: u32) -> Point {
        match self.vertices {
            Vertices::F32(all) => {
                let [x, y, z] = all[index as usize];
                [x.into(), y.into(), z.into()]
            }
            Vertices::F64(all) => all[index as usize],
        }
    }
}

/// One aligned line of bytes.
#[cfg(feature = "alloc")]
#[derive(Copy, Clone, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// A hierarchy that owns its bytes.
#[cfg(feature = "alloc")]
#[derive(Clone, Debug)]
pub struct Bvh<N> {
    lines: alloc::vec::Vec<Line>,
    node: PhantomData<N>,
}

#[cfg(feature = "alloc")]
impl<N: Node> Bvh<N> {
    /// Copies a baked tree, of any alignment, and validates it.
    ///
    /// # Errors
    /// [`BakeError`] if the bytes are not a tree of this node type, all of it and nothing else, or are not safe to walk.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, BakeError> {
        let tree = Self::assemble(&[(64, bytes)]);
        // The copy's own length is a multiple of 64: what is checked is that of the bytes given.
        let copy = &bytemuck::cast_slice(&tree.lines)[..bytes.len()];
        BvhRef::<N>::from_bytes(copy)?;
        Ok(tree)
    }

    /// Takes parts, each with the alignment it needs, that are known to be a tree: the packer's.
    pub(crate) fn assemble(parts: &[(usize, &[u8])]) -> Self {
        let end_of = |end: usize, align: usize, part: &[u8]| end.next_multiple_of(align) + part.len();
        let end = parts.iter().fold(0, |end, (align, part)| end_of(end, *align, part));
        let mut tree = Self { lines: alloc::vec![Line([0; 64]); end.div_ceil(64)], node: PhantomData };
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut tree.lines);
        let mut end = 0;
        for (align, part) in parts {
            end = end_of(end, *align, part);
            bytes[end - part.len()..end].copy_from_slice(part);
        }
        tree
    }

    /// The baked tree: write this to a file or to flash.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.lines)
    }

    /// Borrows the tree for a query. Constant time.
    ///
    /// # Panics
    /// Never: the bytes were checked when the tree was made.
    #[must_use]
    pub fn view(&self) -> BvhRef<'_, N> {
        match BvhRef::view(self.as_bytes()) {
            Ok(view) => view,
            Err(error) => unreachable!("a tree that was valid when it was made: {error}"),
        }
    }
}
