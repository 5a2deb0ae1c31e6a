//! The caps of a solid: triangles that close its holes. Only the inside test uses them.
//!
//! They form a separate tree of the same node type and in the same frame, whose bytes follow those of the solid's
//! tree. So the usual code traverses them, and queries that do not need them pay nothing.

use super::BvhRef;
use super::layout::Layout;
use crate::node::Node;
use crate::primitive::Primitive;

/// The capped holes of a solid: see [`Builder::solid_with_caps`](crate::construct::Builder::solid_with_caps).
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub struct CapStats {
    /// Number of holes.
    pub holes: usize,
    /// Number of triangles in their caps.
    pub triangles: usize,
    /// The greatest width of a hole, that is, the greatest distance between two corners of its border, in the mesh's
    /// unit.
    pub width: f64,
}

impl<'a, N: Node, P: Primitive> BvhRef<'a, N, P> {
    /// Whether holes are capped.
    #[inline(always)]
    pub(crate) const fn has_caps(&self) -> bool {
        self.header.cap_lines != 0
    }

    /// The bytes of the tree of the caps; empty without caps.
    pub(super) fn cap_bytes(&self) -> &'a [u8] {
        self.attached.get(..64 * usize::from(self.header.cap_lines)).unwrap_or_default()
    }

    /// The tree of the caps, if the solid has any. It has the frame of this tree, and is itself a surface. Its
    /// [`BvhRef::parts`] are one triangle per hole, and [`BvhRef::source`] of a cap is the index, in this tree's leaf
    /// order, of a primitive at the border of its hole.
    #[must_use]
    pub fn caps(&self) -> Option<Self> {
        if self.has_caps() { self.tree_of_caps() } else { None }
    }

    #[cold]
    fn tree_of_caps(&self) -> Option<Self> {
        // Validation accepts no bytes without a layout.
        let bytes = self.cap_bytes();
        Self::of_layout(bytes, &Layout::of::<N, P>(bytes).ok()?)
    }

    /// The number and width of the capped holes; zeros without caps. The width is rounded up to an `f32`.
    #[must_use]
    pub fn cap_stats(&self) -> CapStats {
        let Some(caps) = self.caps() else { return CapStats::default() };
        let width = f64::from(self.header.cap_width) / self.frame().scale();
        CapStats { holes: caps.parts().len(), triangles: caps.len(), width }
    }
}
