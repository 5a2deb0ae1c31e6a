//! Pairs of leaves: decided when their bits appear.

use super::Lanes;
use super::hint::Found;
use super::lanes::Rows;
use super::traverse::{Flow, Stop, Traversal, bits_of, primitives};
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::triangle::distance::within;
use crate::triangle::{Probe, Triangle};
use core::ops::ControlFlow;

impl<N: Lanes, E: Kernel, V: FnMut(Found) -> ControlFlow<()>> Traversal<'_, N, E, V> {
    /// Decides the pairs of leaves among the bits, and clears them.
    #[inline(always)]
    pub(super) fn decide_leaves(&mut self, a: Child, b: Child, rows: &mut Rows) -> Flow {
        match (a.link(), b.link()) {
            (Link::Inner(node_a), Link::Inner(node_b)) => {
                for row in bits_of(rows.pending) {
                    let child = self.child_a(node_a, row);
                    if let Link::Leaf { .. } = child.link() {
                        rows.set(row, self.decide_row(child, node_b, rows.rows[row & 15])?);
                    }
                }
            }
            (Link::Leaf { .. }, Link::Inner(node_b)) => {
                rows.set(0, self.decide_row(a, node_b, rows.rows[0])?);
            }
            (Link::Inner(node_a), Link::Leaf { .. }) => {
                let mut inner = rows.rows[0];
                for lane in bits_of(inner) {
                    let child = self.child_a(node_a, lane);
                    if let Link::Leaf { .. } = child.link() {
                        inner &= !(1 << lane);
                        self.decide(child, &[b])?;
                    }
                }
                rows.set(0, inner);
            }
            _ => {}
        }
        Flow::Continue(())
    }

    /// Leaf `a` against the leaves among the children of `b` that `bits` names. Returns the bits of the others.
    // Not inlined: three places call it, and it is long.
    #[inline(always)]
    fn decide_row(&mut self, a: Child, b: u32, bits: u16) -> ControlFlow<Stop, u16> {
        let mut inner = bits;
        let mut leaves = [Child::EMPTY; 16];
        let mut len = 0;
        for lane in bits_of(bits) {
            let child = self.child_b(b, lane);
            if let Link::Leaf { .. } = child.link() {
                inner &= !(1 << lane);
                leaves[len & 15] = child;
                len += 1;
            }
        }
        self.decide(a, &leaves[..len])?;
        ControlFlow::Continue(inner)
    }

    /// Every triangle of a leaf of A against every triangle of leaves of B.
    #[inline(always)]
    fn decide(&mut self, a: Child, leaves: &[Child]) -> Flow {
        for i in primitives(a) {
            let moved = self.moved(i);
            if self.margin > 0.0 {
                self.decide_within(i, &moved, leaves)?;
            } else {
                self.decide_overlap(i, &moved, leaves)?;
            }
        }
        Flow::Continue(())
    }

    /// Four triangles of B at a time go through the planes' filter.
    #[inline(always)]
    fn decide_overlap(&mut self, a: u32, moved: &Triangle, leaves: &[Child]) -> Flow {
        let probe = Probe::new(moved);
        let (mut indices, mut triangles) = ([0; 4], [[[0.0; 3]; 3]; 4]);
        let mut rest = leaves.iter();
        let mut range = 0..0;
        loop {
            let mut len = 0;
            while len < 4 {
                if let Some(j) = range.next() {
                    (indices[len], triangles[len]) = (j, self.b.triangle(j));
                    len += 1;
                } else if let Some(leaf) = rest.next() {
                    range = primitives(*leaf);
                } else {
                    break;
                }
            }
            // A single pair is decided as fast by the test itself.
            let apart = if len > 1 { self.kernel.apart_4(&probe, &triangles) } else { 0 };
            for i in bits_of(!apart & ((1 << len) - 1)) {
                let meets = probe.overlaps(&triangles[i & 3], &mut self.counters.exact_pairs);
                if meets && (self.visit)(Found { a, b: indices[i & 3] }).is_break() {
                    self.counters.triangle_pairs += i as u64 + 1;
                    return Flow::Break(Stop::Visitor);
                }
            }
            self.counters.triangle_pairs += len as u64;
            if len < 4 {
                return Flow::Continue(());
            }
        }
    }

    #[inline(always)]
    fn decide_within(&mut self, a: u32, moved: &Triangle, leaves: &[Child]) -> Flow {
        for leaf in leaves {
            for b in primitives(*leaf) {
                self.counters.triangle_pairs += 1;
                let meets = within(moved, &self.b.triangle(b), self.margin, &mut self.counters.exact_pairs);
                if meets && (self.visit)(Found { a, b }).is_break() {
                    return Flow::Break(Stop::Visitor);
                }
            }
        }
        Flow::Continue(())
    }
}
