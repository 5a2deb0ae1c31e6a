//! What a tree costs.

use super::BvhRef;
use crate::node::{Child, Node};

/// Counts and bytes of a tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Stats {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Levels of nodes.
    pub depth: usize,
    /// Lanes in use, of `nodes * arity`.
    pub lanes_used: usize,
    /// Bytes of planes and links.
    pub node_bytes: usize,
    /// Bytes of the whole baked tree, with vertices, triangles and their indices in the mesh.
    pub total_bytes: usize,
}

impl<N: Node> BvhRef<'_, N> {
    /// Counts lanes and bytes. Linear in the number of nodes.
    #[must_use]
    pub fn stats(&self) -> Stats {
        let used = |node: &N| node.children().iter().filter(|c| **c != Child::EMPTY).count();
        Stats {
            triangles: self.len(),
            nodes: self.nodes.len(),
            depth: self.header.depth as usize,
            lanes_used: self.nodes.iter().map(used).sum(),
            node_bytes: size_of_val(self.nodes),
            total_bytes: self.header.layout(size_of::<N>()).map_or(0, |layout| layout.end),
        }
    }
}
