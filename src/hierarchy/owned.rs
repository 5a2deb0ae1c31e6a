//! A hierarchy that owns its bytes.

use super::layout::Layout;
use super::{AsBvh, BvhRef, FormatError, Header};
use crate::node::{Dop, Node};
use crate::primitive::{Primitive, Spheres, Triangles};
use alloc::vec::Vec;
use core::marker::PhantomData;

/// One aligned cache line.
#[derive(Copy, Clone, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(super) struct CacheLine([u8; 64]);

/// Concatenates the parts, each with an alignment, in whole lines.
pub(super) fn in_lines(parts: &[(usize, &[u8])]) -> Vec<CacheLine> {
    let end_of = |end: usize, align: usize, part: &[u8]| end.next_multiple_of(align) + part.len();
    let end = parts.iter().fold(0, |end, (align, part)| end_of(end, *align, part));
    let mut lines = alloc::vec![CacheLine([0; 64]); end.div_ceil(64)];
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
    let mut end = 0;
    for (align, part) in parts {
        end = end_of(end, *align, part);
        bytes[end - part.len()..end].copy_from_slice(part);
    }
    lines
}

/// A hierarchy that owns its bytes.
#[derive(Clone, Debug)]
pub struct Bvh<N, P = Triangles> {
    lines: Vec<CacheLine>,
    layout: Layout,
    kind: PhantomData<(N, P)>,
}

impl<N: Dop, P: Primitive> Bvh<N, P> {
    /// Copies a baked tree, of any alignment, and validates it.
    ///
    /// # Errors
    /// [`FormatError`] if the bytes are not exactly one tree of this node type and these primitives, or are not safe to
    /// traverse.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        // The layout of the given bytes, since their copy is padded to whole lines.
        let layout = Layout::of::<N, P>(bytes)?;
        let tree = Self { lines: in_lines(&[(64, bytes)]), layout, kind: PhantomData };
        BvhRef::<N, P>::from_bytes(tree.as_bytes())?;
        Ok(tree)
    }
}

impl<N: Node, P: Primitive> Bvh<N, P> {
    /// Concatenates the packer's parts, each with its alignment. They are known to form a tree.
    ///
    /// # Panics
    /// If they do not.
    pub(crate) fn assemble(parts: &[(usize, &[u8])]) -> Self {
        let lines = in_lines(parts);
        match Layout::of::<N, P>(bytemuck::cast_slice(&lines)) {
            Ok(layout) => Self { lines, layout, kind: PhantomData },
            Err(error) => unreachable!("the packer's parts are a tree: {error}"),
        }
    }

    /// The tree of a solid with its packing, if any, replaced by one that is known to be valid and inside.
    pub(crate) fn with_packing(&self, packing: &Bvh<N, Spheres>) -> Self {
        let bytes = self.as_bytes();
        let own = &bytes[..bytes.len() - self.view().packing_bytes().len()];
        let header = Header { has_packing: 1, ..*self.view().header() };
        Self::assemble(&[
            (64, bytemuck::bytes_of(&header)),
            (1, &own[size_of::<Header>()..]),
            (64, packing.as_bytes()),
        ])
    }

    /// The baked tree: write this to a file or to flash.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.lines)
    }

    /// Borrows the tree, in constant time and without further checks. Queries take the owned tree as well.
    ///
    /// # Panics
    /// Never: the bytes were checked when the tree was made.
    #[inline(always)]
    #[must_use]
    pub fn view(&self) -> BvhRef<'_, N, P> {
        let view = BvhRef::of_layout(self.as_bytes(), &self.layout);
        view.unwrap_or_else(|| unreachable!("the bytes are those that the layout was made of"))
    }
}

impl<N: Node, P: Primitive> AsBvh for Bvh<N, P> {
    type Node = N;
    type Primitive = P;

    #[inline(always)]
    fn as_bvh(&self) -> BvhRef<'_, N, P> {
        self.view()
    }

    #[inline(always)]
    fn header(&self) -> &Header {
        bytemuck::from_bytes(&self.as_bytes()[..size_of::<Header>()])
    }
}
