//! Size statistics of a tree.

use super::BvhRef;
use super::layout::{Counts, Layout};
use crate::node::{Child, Node};
use crate::primitive::Primitive;

/// Counts and bytes of a tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Stats {
    /// Number of primitives.
    pub primitives: usize,
    /// Number of parts: primitives of different parts are not connected. Each sphere is one.
    pub parts: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Levels of nodes.
    pub depth: usize,
    /// Used lanes, of `nodes * arity`.
    pub lanes_used: usize,
    /// Bytes of planes and links.
    pub node_bytes: usize,
    /// Bytes of normal slabs.
    pub normal_slab_bytes: usize,
    /// Bytes of balls.
    pub ball_bytes: usize,
    /// Bytes of the whole baked tree, with vertices, primitives, source indices, caps and packing.
    pub total_bytes: usize,
}

impl<N: Node, P: Primitive> BvhRef<'_, N, P> {
    /// Counts lanes and bytes. Linear in the number of nodes.
    #[must_use]
    pub fn stats(&self) -> Stats {
        let used = |node: &N| node.children().iter().filter(|c| **c != Child::EMPTY).count();
        let h = self.header;
        let packing_bytes = self.packing_bytes().len();
        let layout = Layout::of_counts::<N, P>(Counts {
            nodes: h.node_count,
            has_normal_slabs: h.has_normal_slabs,
            has_balls: h.has_balls,
            vertices: h.vertex_count,
            vertex_size: h.vertex_size,
            primitives: h.primitive_count,
            parts: h.part_count,
            cap_lines: h.cap_lines,
        });
        Stats {
            primitives: self.len(),
            parts: self.parts().len(),
            nodes: self.nodes.len(),
            depth: self.header.depth as usize,
            lanes_used: self.nodes.iter().map(used).sum(),
            node_bytes: size_of_val(self.nodes),
            normal_slab_bytes: size_of_val(self.normal_slabs),
            ball_bytes: size_of_val(self.balls),
            total_bytes: layout.map_or(0, |layout| layout.end) + packing_bytes,
        }
    }
}
