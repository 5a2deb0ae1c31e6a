//! Broad phase: which pairs of bodies have bounding boxes near each other in the world?

use super::body_size::widened;
use super::placement::Scene;
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Box3;
use crate::query::Query;

/// Two bodies whose boxes are near each other.
#[derive(Copy, Clone, Debug)]
pub(super) struct NearPair {
    /// The body in whose row of the matrix the pair is.
    pub(super) a: u32,
    pub(super) b: u32,
    /// Depth of the boxes' overlap; minus the gap between them if they are disjoint.
    pub(super) depth: f32,
}

/// Capacity of a batch.
const BATCH: usize = 32;

/// Candidate pairs, the deepest first.
#[derive(Debug)]
pub(super) struct Batch {
    candidates: [NearPair; BATCH],
    len: usize,
    /// Where the search continues: the row, the group of sixteen bodies, and the bits of those left in it.
    row: usize,
    sixteen: usize,
    rest: u16,
}

impl Batch {
    pub(super) const fn new() -> Self {
        const NONE: NearPair = NearPair { a: 0, b: 0, depth: 0.0 };
        Self { candidates: [NONE; BATCH], len: 0, row: 0, sixteen: 0, rest: u16::MAX }
    }

    /// The next candidates whose boxes are at most `margin` apart. Empty at the end.
    pub(super) fn next<N>(&mut self, scene: &Scene<'_, N>, query: &Query, margin: f64) -> &[NearPair] {
        self.len = 0;
        on_isa!(query.isa(), kernel => kernel.run(
            #[inline(always)]
            || self.gather(kernel, scene, margin),
        ));
        &self.candidates[..self.len]
    }

    #[inline(always)]
    fn gather<N>(&mut self, kernel: impl Kernel, scene: &Scene<'_, N>, margin: f64) {
        let memory = &scene.memory;
        let stride = memory.stride();
        while self.row < memory.slots.len() {
            let mut around = None;
            while self.sixteen < stride {
                let asked = memory.row(self.row, self.sixteen) & self.rest;
                if asked != 0 {
                    let (bounds, around) = *around.get_or_insert_with(
                        #[inline(always)]
                        || {
                            let bounds = memory.bounds(self.row);
                            // Boxes are rounded outwards already.
                            (bounds, if margin > 0.0 { widened(&bounds, margin) } else { bounds })
                        },
                    );
                    let mut near = asked & kernel.boxes_near(&around, 0.0, &memory.boxes[self.sixteen]);
                    while near != 0 {
                        let lane = near.trailing_zeros() as usize;
                        if self.len == BATCH {
                            self.rest = near;
                            return;
                        }
                        near &= near - 1;
                        let depth = depth(&bounds, &memory.bounds(16 * self.sixteen + lane));
                        let candidate =
                            NearPair { a: self.row as u32, b: (16 * self.sixteen + lane) as u32, depth };
                        insert_by_depth(&mut self.candidates, &mut self.len, candidate);
                    }
                }
                self.rest = u16::MAX;
                self.sixteen += 1;
            }
            self.sixteen = 0;
            self.row += 1;
        }
    }
}

/// Inserts a candidate into `len` others, which are sorted by descending depth.
#[inline(always)]
pub(super) fn insert_by_depth(candidates: &mut [NearPair], len: &mut usize, candidate: NearPair) {
    let mut place = *len;
    while place > 0 && candidates[place - 1].depth < candidate.depth {
        candidates[place] = candidates[place - 1];
        place -= 1;
    }
    candidates[place] = candidate;
    *len += 1;
}

impl<N> Scene<'_, N> {
    /// Two bodies with the depth of their current boxes.
    pub(super) fn pair_now(&self, a: u32, b: u32) -> NearPair {
        let [p, q] = [a, b].map(|i| self.memory.bounds(i as usize));
        NearPair { a, b, depth: depth(&p, &q) }
    }
}

/// Depth of the overlap of two boxes: the least over the three axes. Negative for a gap.
#[inline(always)]
pub(super) fn depth(a: &Box3, b: &Box3) -> f32 {
    let mut depth = f32::INFINITY;
    for i in 0..3 {
        let (p, q) = (a.upper[i] - b.lower[i], b.upper[i] - a.lower[i]);
        let least = if p < q { p } else { q };
        depth = if least < depth { least } else { depth };
    }
    depth
}
