//! The connected parts of a body.

use crate::construct::input::first_at_place;
use crate::range::Point;
use alloc::vec::Vec;

/// The first primitive of each part, ascending. Empty if the body is one part, which primitive 0 represents.
///
/// Primitives are connected if they share a vertex, or have vertices at equal coordinates, as the triangles of STL
/// files have. `places` is called only if shared vertices leave several parts: the places must be sorted.
pub(super) fn parts<R: AsRef<[u32]>>(
    records: &[R],
    vertices: usize,
    places: impl FnOnce() -> Vec<Point>,
) -> Vec<u32> {
    let mut sets = Sets::new(vertices);
    for record in records {
        let corners = record.as_ref();
        corners.windows(2).for_each(|pair| sets.join(pair[0], pair[1]));
    }
    if sets.firsts(records).len() > 1 {
        let first = first_at_place(&places());
        (0..).zip(&first).for_each(|(vertex, &first)| sets.join(vertex, first));
    }
    let firsts = sets.firsts(records);
    if firsts.len() > 1 { firsts } else { Vec::new() }
}

/// Disjoint sets of vertices (Tarjan, *Efficiency of a Good But Not Linear Set Union Algorithm*, JACM 1975). The root
/// of a set is its least vertex.
struct Sets {
    parents: Vec<u32>,
}

impl Sets {
    fn new(vertices: usize) -> Self {
        Self { parents: (0..vertices as u32).collect() }
    }

    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.parents[vertex as usize] != vertex {
            // Path halving.
            let parent = self.parents[vertex as usize];
            let above = self.parents[parent as usize];
            self.parents[vertex as usize] = above;
            vertex = above;
        }
        vertex
    }

    fn join(&mut self, v: u32, w: u32) {
        let (v, w) = (self.root(v), self.root(w));
        self.parents[v.max(w) as usize] = v.min(w);
    }

    /// The first record of each set, ascending.
    fn firsts<R: AsRef<[u32]>>(&mut self, records: &[R]) -> Vec<u32> {
        let mut is_seen = alloc::vec![false; self.parents.len()];
        let mut firsts = Vec::new();
        for (index, record) in (0..).zip(records) {
            let Some(&corner) = record.as_ref().first() else { continue };
            let root = self.root(corner) as usize;
            if !core::mem::replace(&mut is_seen[root], true) {
                firsts.push(index);
            }
        }
        firsts
    }
}
