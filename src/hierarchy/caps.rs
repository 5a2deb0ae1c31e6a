//! The caps of a solid: triangles that close its holes for the test of what is inside, and for nothing else.
//!
//! They are a tree of their own, of the same node type and in the same frame, whose bytes follow those of the solid's
//! tree. So the code that traverses any tree traverses them, and a query that does not look for them does not pay.

use super::BvhRef;
use super::layout::Layout;
use crate::node::Node;
use crate::primitive::Primitive;

/// The holes of a solid that are capped: see [`Builder::solid_with_caps`](crate::construct::Builder::solid_with_caps).
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub struct CapStats {
    /// Number of holes.
    pub holes: usize,
    /// Number of triangles in their caps.
    pub triangles: usize,
    /// The greatest width of a hole, that is, the greatest distance of two corners of its border, in the mesh's unit.
    pub width: f64,
}

impl<'a, N: Node, P: Primitive> BvhRef<'a, N, P> {
    /// Whether holes are capped.
    #[inline(always)]
    pub(crate) const fn has_caps(&self) -> bool {
        !self.caps.is_empty()
    }

    /// The tree of the caps, if the solid has any. It has the frame of this tree, and is itself a surface.
    /// [`BvhRef::parts`] of it is one triangle of each hole, and [`BvhRef::source`] is the index, in this tree's leaf
    /// order, of a primitive at the border of the triangle's hole.
    #[must_use]
    pub fn caps(&self) -> Option<Self> {
        if self.has_caps() { self.tree_of_caps() } else { None }
    }

    #[cold]
    fn tree_of_caps(&self) -> Option<Self> {
        // Validation accepts no bytes without a layout.
        Self::of_layout(self.caps, &Layout::of::<N, P>(self.caps).ok()?)
    }

    /// The number and width of the holes that are capped; zeros without caps. The width is rounded up to an `f32`.
    #[must_use]
    pub fn cap_stats(&self) -> CapStats {
        let Some(caps) = self.caps() else { return CapStats::default() };
        let width = f64::from(self.header.cap_width) / self.frame().scale();
        CapStats { holes: caps.parts().len(), triangles: caps.len(), width }
    }
}
