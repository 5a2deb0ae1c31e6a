//! Nodes with links, still without planes and widths.

use crate::construct::split::Assignment;
use crate::node::{Child, Node, Width};
use alloc::vec::Vec;

/// Nodes with their links, without planes, and the primitives in leaf order.
pub(super) struct TreeShape<N> {
    pub(super) nodes: Vec<N>,
    pub(super) sources: Vec<u32>,
    pub(super) depth: usize,
}

impl<N: Node> TreeShape<N> {
    pub(super) fn new(assignment: &Assignment, leaf_size: u32) -> Self {
        let count = assignment.ends.len() / N::ARITY;
        let mut nodes = Vec::with_capacity(count);
        let mut sources = Vec::with_capacity(assignment.order.len());
        // Start of the range and level of each node, in order.
        let mut starts = Vec::with_capacity(count);
        starts.push((0, 1));
        let mut depth = 0;
        for (index, ends) in assignment.ends.chunks_exact(N::ARITY).enumerate() {
            let (mut start, level) = starts[index];
            depth = level;
            let mut node = N::EMPTY;
            let mut lane = 0;
            for &end in ends {
                let count = end - start;
                if count > leaf_size {
                    node.set_child(lane, Child::inner(starts.len() as u32, Width::of(0.0)));
                    starts.push((start, level + 1));
                } else if count > 0 {
                    node.set_child(lane, Child::leaf(sources.len() as u32, count));
                    sources.extend_from_slice(&assignment.order[start as usize..end as usize]);
                }
                // Used lanes come first.
                lane += usize::from(count > 0);
                start = end;
            }
            nodes.push(node);
        }
        Self { nodes, sources, depth }
    }
}

/// The primitives of a tree, with their own table of vertices.
pub(super) struct InOrder<V, R> {
    pub(super) vertices: Vec<V>,
    pub(super) records: Vec<R>,
}

impl<V: Copy, R: Copy + AsRef<[u32]> + AsMut<[u32]>> InOrder<V, R> {
    /// The primitives in leaf order, and the vertices in the order of their first use, so that the data of a leaf are
    /// contiguous. Unused vertices are omitted.
    pub(super) fn of(vertices: &[V], primitives: &[R], sources: &[u32]) -> Self {
        const UNSEEN: u32 = u32::MAX;
        let mut places = alloc::vec![UNSEEN; vertices.len()];
        let mut used = Vec::with_capacity(vertices.len());
        let mut renumbered = |&source: &u32| {
            let mut record = primitives[source as usize];
            for vertex in record.as_mut() {
                let place = &mut places[*vertex as usize];
                if *place == UNSEEN {
                    *place = used.len() as u32;
                    used.push(vertices[*vertex as usize]);
                }
                *vertex = *place;
            }
            record
        };
        let records = sources.iter().map(&mut renumbered).collect();
        Self { vertices: used, records }
    }
}
