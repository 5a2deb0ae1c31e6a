//! A hierarchy over borrowed bytes.

use super::layout::Layout;
use super::{FormatError, Header, Walk};
use crate::frame::{BodyBounds, Frame};
use crate::node::{Ball16, Dop, Node, NormalSlab};
use crate::primitive::{Primitive, Store, Triangles};

/// A hierarchy over borrowed bytes, safe to traverse. Small and `Copy`: pass it by value or reference.
#[derive(Debug)]
pub struct BvhRef<'a, N, P: Primitive = Triangles> {
    pub(super) header: &'a Header,
    pub(super) nodes: &'a [N],
    pub(super) normal_slabs: &'a [NormalSlab],
    pub(super) balls: &'a [Ball16],
    pub(super) store: Store<'a, P>,
    /// The source index of each primitive; then, if the body has several parts, one primitive of each.
    pub(super) indices: &'a [u32],
    /// The bytes of the trees of the caps and of the packing; empty without either.
    pub(super) attached: &'a [u8],
}

impl<N, P: Primitive> Copy for BvhRef<'_, N, P> {}
impl<N, P: Primitive> Clone for BvhRef<'_, N, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<'a, N: Dop, P: Primitive> BvhRef<'a, N, P> {
    /// Borrows a baked tree in place, without a copy, after [`BvhRef::validate`]: linear in its size.
    ///
    /// # Errors
    /// [`FormatError`] if the bytes are not exactly one tree of this node type and these primitives, are not aligned to
    /// 64, or are not safe to traverse.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
        // First, so that bytes too short for a header give that error.
        Header::read(bytes)?;
        let layout = Layout::of::<N, P>(bytes)?;
        let view = Self::of_layout(bytes, &layout).ok_or(FormatError::Misaligned)?;
        view.validate()?;
        Ok(view)
    }
}

impl<'a, N: Node, P: Primitive> BvhRef<'a, N, P> {
    /// The parts of the bytes, their contents unchecked. `None` if they are misaligned.
    #[inline(always)]
    pub(super) fn of_layout(bytes: &'a [u8], layout: &Layout) -> Option<Self> {
        // An empty part may be misaligned.
        let balls = match layout.balls.of(bytes)? {
            [] => &[],
            balls => bytemuck::try_cast_slice(balls).ok()?,
        };
        let header: &Header = bytemuck::try_from_bytes(bytes.get(..size_of::<Header>())?).ok()?;
        let (vertices, records) = (layout.vertices.of(bytes)?, layout.records.of(bytes)?);
        Some(Self {
            header,
            nodes: bytemuck::try_cast_slice(layout.nodes.of(bytes)?).ok()?,
            normal_slabs: bytemuck::try_cast_slice(layout.normal_slabs.of(bytes)?).ok()?,
            balls,
            store: Store::read(layout.vertex_size, vertices, records)?,
            indices: bytemuck::try_cast_slice(layout.indices.of(bytes)?).ok()?,
            attached: layout.attached.of(bytes)?,
        })
    }

    /// All used lanes, depth first.
    #[must_use]
    pub fn walk(&self) -> Walk<'a, N> {
        Walk::below(self.nodes, if self.is_empty() { None } else { Some(0) })
    }

    /// The tree's header.
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

    /// The normal slabs of all lanes, `ARITY` per node; empty if the tree was built without them.
    #[inline(always)]
    #[must_use]
    pub const fn normal_slabs(&self) -> &'a [NormalSlab] {
        self.normal_slabs
    }

    /// The bounding balls of all lanes, one item per node. Empty unless the primitives are spheres, the arity is 16
    /// and the tree was built with balls.
    #[inline(always)]
    #[must_use]
    pub const fn balls(&self) -> &'a [Ball16] {
        self.balls
    }

    /// The normal slab of a lane, if the tree has them.
    #[inline(always)]
    pub(crate) fn normal_slab(&self, node: u32, lane: usize) -> Option<NormalSlab> {
        self.normal_slabs.get(node as usize * N::ARITY + lane).copied()
    }

    /// The normal slabs of a node's lanes.
    #[inline(always)]
    pub(crate) fn normal_slabs_of(&self, node: u32) -> Option<&'a [NormalSlab]> {
        self.normal_slabs.get(node as usize * N::ARITY..)?.get(..N::ARITY)
    }

    /// The frame of the planes.
    #[inline]
    #[must_use]
    pub const fn frame(&self) -> Frame {
        Frame { centre: self.header.centre, exponent: self.header.exponent }
    }

    /// The bounds of the body.
    #[inline(always)]
    #[must_use]
    pub const fn extent(&self) -> BodyBounds {
        self.header.extent()
    }

    /// Number of primitives.
    #[inline]
    #[must_use]
    pub const fn len(&self) -> usize {
        self.header.primitive_count as usize
    }

    /// Whether there are no primitives. An empty body meets nothing.
    #[inline]
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.header.primitive_count == 0
    }

    /// Whether the triangles bound a [solid](Header::is_solid).
    #[inline(always)]
    #[must_use]
    pub const fn is_solid(&self) -> bool {
        P::BOUNDS_SOLIDS && self.header.is_solid != 0
    }

    /// A primitive of each part of the body, as ascending indices in leaf order. A part is a set of primitives
    /// connected by shared vertices. Each sphere is a part; an empty body has none.
    #[must_use]
    pub fn parts(&self) -> impl ExactSizeIterator<Item = u32> + 'a {
        let count = self.len();
        let parts = &self.indices[count..];
        let several = if P::ARE_PARTS { count } else { parts.len().max(usize::from(count > 0)) };
        (0..several).map(move |index| parts.get(index).map_or(index as u32, |part| *part))
    }

    /// The primitive with an index in leaf order, below [`len`](Self::len), in the body's unit: for a triangle its
    /// corners.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline(always)]
    #[must_use]
    pub fn primitive(&self, index: u32) -> P::Item {
        P::item(&self.store, index)
    }

    /// The storage of the primitives.
    #[inline(always)]
    pub(crate) const fn store(&self) -> &Store<'a, P> {
        &self.store
    }

    /// The source index of the primitive at `index` in leaf order: its index in the geometry that the tree was built
    /// from.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline]
    #[must_use]
    pub const fn source(&self, index: u32) -> u32 {
        self.indices.split_at(self.len()).0[index as usize]
    }
}

/// A tree that queries take: borrowed or owned. This trait lets a struct hold an owned tree and query it without
/// storing a view.
pub trait AsBvh {
    /// Its nodes.
    type Node: Node;
    /// Its primitives.
    type Primitive: Primitive;

    /// Borrows the tree. Constant time: nothing is checked again.
    fn as_bvh(&self) -> BvhRef<'_, Self::Node, Self::Primitive>;

    /// Calls `f` with the tree in place: a borrowed one is not copied.
    #[inline(always)]
    fn with_bvh<R>(&self, f: impl FnOnce(&BvhRef<'_, Self::Node, Self::Primitive>) -> R) -> R {
        f(&self.as_bvh())
    }

    /// Its header, which is all that a query reads of a distant body.
    #[inline(always)]
    fn header(&self) -> &Header {
        self.as_bvh().header()
    }
}

impl<N: Node, P: Primitive> AsBvh for BvhRef<'_, N, P> {
    type Node = N;
    type Primitive = P;

    #[inline(always)]
    fn as_bvh(&self) -> BvhRef<'_, N, P> {
        *self
    }

    #[inline(always)]
    fn with_bvh<R>(&self, f: impl FnOnce(&Self) -> R) -> R {
        f(self)
    }

    #[inline(always)]
    fn header(&self) -> &Header {
        self.header
    }
}

/// Calls `ask` with both trees in place.
#[inline(always)]
pub(crate) fn with_bvhs<A: AsBvh, B: AsBvh, R>(
    a: &A,
    b: &B,
    ask: impl FnOnce(&BvhRef<'_, A::Node, A::Primitive>, &BvhRef<'_, B::Node, B::Primitive>) -> R,
) -> R {
    a.with_bvh(|a| b.with_bvh(|b| ask(a, b)))
}
