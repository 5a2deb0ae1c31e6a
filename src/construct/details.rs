//! Parts of a tree that are too fine for its frame, once more in frames of their own ([`Detail`]).

use super::Geometry;
use super::bake::{half_width, max_coordinate, max_plane};
use super::geometry::{Record, bounding_box};
use super::normal_slabs::normal_slabs;
use super::wrap::wrap;
use crate::frame::Frame;
use crate::hierarchy::Detail;
use crate::node::{Child, Dop, INDEX, Link, NormalSlab};
use crate::primitive::Primitive;
use alloc::borrow::Cow;
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use bytemuck::Zeroable;

/// A part is a detail if primitives spread evenly over a square as wide as it would be narrower than this, in steps of the
/// frame: then the half step that a plane is rounded up by on average is an eighth of a primitive's width, on either side.
pub(super) const STEPS: i64 = 4;
/// How many powers of two finer the frame of a detail is, at least.
const GAIN: i32 = 3;
/// Details and what they add to a tree.
pub(super) struct Details<N> {
    pub(super) details: Vec<Detail>,
    pub(super) nodes: Vec<N>,
    pub(super) normal_slabs: Vec<NormalSlab>,
}

impl<N: Dop> Details<N> {
    pub(super) const NONE: Self = Self { details: Vec::new(), nodes: Vec::new(), normal_slabs: Vec::new() };

    /// Of a tree with planes, in a frame.
    pub(super) fn of<G: Geometry>(
        body: &[N],
        frame: &Frame,
        vertices: &[<G::Primitive as Primitive>::Double],
        records: &[Record<G>],
        has_normal_slabs: bool,
    ) -> Self {
        let mut all = Self::NONE;
        // Trees that may have details: the body's, then those of details. With where their first node is, and the scale of
        // their frame.
        let mut waiting = VecDeque::from([(0, Cow::Borrowed(body), frame.exponent)]);
        while let Some((base, nodes, exponent)) = waiting.pop_front() {
            for node in fine_nodes(&nodes) {
                let first = body.len() + all.nodes.len();
                let node = base + node;
                let mut subtree = Subtree::<N, G>::of(body, &all.nodes, node, vertices, records);
                if first + subtree.nodes.len() > INDEX as usize {
                    continue;
                }
                let detail = Detail { node, first: first as u32, ..subtree.wrap() };
                // No frame makes a point wider.
                let is_point = detail.half_width == [0.0; 3];
                if is_point || detail.exponent < exponent.saturating_add(GAIN) {
                    continue;
                }
                all.details.push(detail);
                if has_normal_slabs {
                    let Subtree { nodes, vertices, records, .. } = &subtree;
                    all.normal_slabs.extend(normal_slabs::<N, G>(nodes, &detail.frame(), vertices, records));
                }
                all.nodes.extend(subtree.linked(body, &all.nodes, detail.first));
                waiting.push_back((detail.first, Cow::Owned(subtree.nodes), detail.exponent));
            }
        }
        all
    }
}

/// The uppermost nodes of a tree whose primitives are too fine for its frame, ascending; never the root.
fn fine_nodes<N: Dop>(nodes: &[N]) -> Vec<u32> {
    let mut counts = alloc::vec![0_u32; nodes.len()];
    // Children come after their parents.
    for node in (0..nodes.len()).rev() {
        let below = |child: &Child| match child.link() {
            Link::Empty => 0,
            Link::Inner(below) => counts[below as usize],
            Link::Leaf { count, .. } => count,
        };
        counts[node] = nodes[node].children().iter().map(below).sum();
    }
    let mut found = Vec::new();
    let mut open: Vec<u32> = if nodes.is_empty() { Vec::new() } else { alloc::vec![0] };
    while let Some(node) = open.pop() {
        let node = &nodes[node as usize];
        for (lane, child) in node.children().iter().enumerate() {
            let Link::Inner(below) = child.link() else { continue };
            let side = |s: usize| i64::from(node.plane(2 * s, lane)) + i64::from(node.plane(2 * s + 1, lane));
            let side = side(0).max(side(1)).max(side(2)).max(0);
            let is_fine = side * side < STEPS * STEPS * i64::from(counts[below as usize]);
            if is_fine { found.push(below) } else { open.push(below) }
        }
    }
    found.sort_unstable();
    found
}

/// What is below a node, as a tree of its own.
struct Subtree<N, G: Geometry> {
    /// What each of the nodes is a copy of.
    originals: Vec<u32>,
    nodes: Vec<N>,
    vertices: Vec<<G::Primitive as Primitive>::Double>,
    records: Vec<Record<G>>,
}

impl<N: Dop, G: Geometry> Subtree<N, G> {
    /// Of a node of the body, or of the details so far; its planes are still to be made.
    fn of(
        body: &[N],
        details: &[N],
        node: u32,
        vertices: &[<G::Primitive as Primitive>::Double],
        records: &[Record<G>],
    ) -> Self {
        let mut originals = alloc::vec![node];
        let (mut nodes, mut copied) = (Vec::new(), Vec::new());
        while let Some(&original) = originals.get(nodes.len()) {
            let mut copy = N::EMPTY;
            for (lane, child) in original_node(body, details, original).children().iter().enumerate() {
                match child.link() {
                    Link::Empty => {}
                    Link::Inner(below) => {
                        copy.set_child(lane, Child::inner(originals.len() as u32, child.width()));
                        originals.push(below);
                    }
                    Link::Leaf { first, count } => {
                        copy.set_child(lane, Child::leaf(copied.len() as u32, count));
                        copied.extend_from_slice(&records[first as usize..][..count as usize]);
                    }
                }
            }
            nodes.push(copy);
        }
        // Its own vertices only.
        let mut used: Vec<u32> = copied.iter().flat_map(|record| record.as_ref()).copied().collect();
        used.sort_unstable();
        used.dedup();
        for vertex in copied.iter_mut().flat_map(|record| record.as_mut()) {
            *vertex = used.partition_point(|other| other < vertex) as u32;
        }
        let vertices = used.iter().map(|&vertex| vertices[vertex as usize]).collect();
        Self { originals, nodes, vertices, records: copied }
    }

    /// Makes its planes, and says how large the detail is.
    fn wrap(&mut self) -> Detail {
        let (low, high) = bounding_box(self.vertices.iter().map(G::Primitive::ball));
        let frame = Frame::around(low, high, N::DIRECTIONS);
        wrap::<N, G::Primitive>(&mut self.nodes, &frame, &self.vertices, &self.records);
        Detail {
            centre: frame.centre,
            max_coordinate: max_coordinate(low, high, &frame),
            exponent: frame.exponent,
            half_width: half_width::<G::Primitive>(&frame, &self.vertices),
            max_plane: max_plane(&self.nodes),
            ..Detail::zeroed()
        }
    }

    /// The nodes, with links to what comes from `first` on, and to the leaves of the originals.
    fn linked(&self, body: &[N], details: &[N], first: u32) -> Vec<N> {
        let mut linked = self.nodes.clone();
        for (node, &original) in linked.iter_mut().zip(&self.originals) {
            let original = original_node(body, details, original);
            for (lane, leaf) in original.children().iter().enumerate() {
                let child = node.children()[lane];
                let child = match child.link() {
                    Link::Inner(below) => Child::inner(first + below, child.width()),
                    _ => *leaf,
                };
                node.set_child(lane, child);
            }
        }
        linked
    }
}

/// A node of the body, or of the details after it.
fn original_node<'n, N>(body: &'n [N], details: &'n [N], node: u32) -> &'n N {
    let node = node as usize;
    body.get(node).unwrap_or_else(|| &details[node - body.len()])
}
