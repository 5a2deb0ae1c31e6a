//! The corners below each node of a tree.

use crate::node::{Link, Node};
use crate::primitive::Primitive;
use alloc::vec::Vec;

/// The corners below each node, as one run of a list per node. A corner appears once for each node with a leaf that
/// uses it.
pub(super) struct CornersBelow<P: Primitive> {
    corners: Vec<P::Double>,
    /// Start and end of the run of each node.
    runs: Vec<(usize, usize)>,
}

impl<P: Primitive<Record: AsRef<[u32]>>> CornersBelow<P> {
    pub(super) fn new<N: Node>(nodes: &[N], vertices: &[P::Double], records: &[P::Record]) -> Self {
        let mut own = Vec::with_capacity(vertices.len());
        let mut own_ends = Vec::with_capacity(nodes.len());
        let mut last_used_by = alloc::vec![usize::MAX; vertices.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in node.children() {
                let Link::Leaf { first, count } = child.link() else { continue };
                for &vertex in records[first as usize..][..count as usize].iter().flat_map(|r| r.as_ref()) {
                    if last_used_by[vertex as usize] != index {
                        last_used_by[vertex as usize] = index;
                        own.push(vertex);
                    }
                }
            }
            own_ends.push(own.len());
        }
        // Children come after their parents.
        let own_of =
            |node: usize| if node == 0 { 0..own_ends[0] } else { own_ends[node - 1]..own_ends[node] };
        let mut counts = alloc::vec![0; nodes.len()];
        for node in (0..nodes.len()).rev() {
            let inner = inner_links(&nodes[node]);
            counts[node] = own_of(node).len() + inner.map(|below| counts[below]).sum::<usize>();
        }
        // A node's own corners, then its children's.
        let mut corners = alloc::vec![bytemuck::Zeroable::zeroed(); own.len()];
        let mut runs = alloc::vec![(0, own.len()); nodes.len()];
        for node in 0..nodes.len() {
            let mut next = runs[node].0;
            for &vertex in &own[own_of(node)] {
                corners[next] = vertices[vertex as usize];
                next += 1;
            }
            for below in inner_links(&nodes[node]) {
                runs[below] = (next, next + counts[below]);
                next += counts[below];
            }
        }
        Self { corners, runs }
    }

    pub(super) fn below(&self, node: u32) -> &[P::Double] {
        let (start, end) = self.runs[node as usize];
        &self.corners[start..end]
    }
}

fn inner_links<N: Node>(node: &N) -> impl Iterator<Item = usize> {
    node.children().iter().filter_map(|child| match child.link() {
        Link::Inner(below) => Some(below as usize),
        _ => None,
    })
}
