//! Pairs of leaves: decided when their bits appear.

use super::Lanes;
use super::hint::Found;
use super::lanes::Rows;
use super::traverse::{Flow, Stop, Traversal, bits_of, primitives};
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::primitive::triangle::distance::within;
use crate::primitive::triangle::{Probe, Triangle};
use core::ops::ControlFlow;

/// Which body has the one leaf that is tested against several of the other.
const A: bool = true;
const B: bool = false;

/// Up to sixteen leaves.
struct Leaves {
    children: [Child; 16],
    len: usize,
}

impl<N: Lanes, E: Kernel, V: FnMut(Found) -> ControlFlow<()>> Traversal<'_, N, E, V> {
    /// Decides the pairs of leaves among the bits, and clears them.
    #[inline(always)]
    pub(super) fn decide_leaves(&mut self, a: Child, b: Child, rows: &mut Rows) -> Flow {
        match (a.link(), b.link()) {
            (Link::Inner(node_a), Link::Inner(node_b)) => {
                for row in bits_of(rows.pending) {
                    let child = self.child_a(node_a, row);
                    if let Link::Leaf { .. } = child.link() {
                        let (leaves, inner) =
                            leaves_among(self.b.nodes()[node_b as usize].children(), rows.rows[row]);
                        self.decide::<A>(child, &leaves)?;
                        rows.set(row, inner);
                    }
                }
            }
            (Link::Leaf { .. }, Link::Inner(node_b)) => {
                let (leaves, inner) = leaves_among(self.b.nodes()[node_b as usize].children(), rows.rows[0]);
                self.decide::<A>(a, &leaves)?;
                rows.set(0, inner);
            }
            (Link::Inner(node_a), Link::Leaf { .. }) => {
                let (leaves, inner) = leaves_among(self.a.nodes()[node_a as usize].children(), rows.rows[0]);
                self.decide::<B>(b, &leaves)?;
                rows.set(0, inner);
            }
            _ => {}
        }
        Flow::Continue(())
    }

    /// Every triangle of a leaf of body `ONE` against every triangle of some leaves of the other.
    #[inline(always)]
    fn decide<const ONE: bool>(&mut self, one: Child, leaves: &Leaves) -> Flow {
        for i in primitives(one) {
            let triangle = if ONE == A { self.moved(i) } else { self.b.triangle(i) };
            self.decide_one::<ONE>(i, &triangle, leaves)?;
        }
        Flow::Continue(())
    }

    /// Four triangles at a time go through the planes' filter.
    #[inline(always)]
    fn decide_one<const ONE: bool>(&mut self, i: u32, triangle: &Triangle, leaves: &Leaves) -> Flow {
        let probe = Probe::new(triangle);
        let (mut indices, mut others) = ([0; 4], [[[0.0; 3]; 3]; 4]);
        let mut rest = leaves.children[..leaves.len].iter();
        let mut range = 0..0;
        loop {
            let mut len = 0;
            while len < 4 {
                if let Some(j) = range.next() {
                    let other = if ONE == A { self.b.triangle(j) } else { self.moved(j) };
                    (indices[len], others[len]) = (j, other);
                    len += 1;
                } else if let Some(leaf) = rest.next() {
                    range = primitives(*leaf);
                } else {
                    break;
                }
            }
            // A margin makes the planes' filter wrong. A single pair is decided as fast by the test itself.
            let apart = if len > 1 && self.margin == 0.0 { self.kernel.apart_4(&probe, &others) } else { 0 };
            for k in bits_of(!apart & ((1 << len) - 1)) {
                let (other, exact) = (&others[k & 3], &mut self.counters.exact_pairs);
                let meets = if self.margin > 0.0 {
                    let (a, b) = if ONE == A { (triangle, other) } else { (other, triangle) };
                    within(a, b, self.margin, exact)
                } else {
                    probe.overlaps(other, exact)
                };
                let j = indices[k & 3];
                let found = if ONE == A { Found { a: i, b: j } } else { Found { a: j, b: i } };
                if meets && (self.visit)(found).is_break() {
                    self.counters.triangle_pairs += k as u64 + 1;
                    return Flow::Break(Stop::Visitor);
                }
            }
            self.counters.triangle_pairs += len as u64;
            if len < 4 {
                return Flow::Continue(());
            }
        }
    }
}

/// The leaves among the children that the bits name, and the bits of the others.
#[inline(always)]
fn leaves_among(children: &[Child], bits: u16) -> (Leaves, u16) {
    let mut leaves = Leaves { children: [Child::EMPTY; 16], len: 0 };
    let mut inner = bits;
    for lane in bits_of(bits) {
        let child = children[lane];
        if let Link::Leaf { .. } = child.link() {
            inner &= !(1 << lane);
            leaves.children[leaves.len & 15] = child;
            leaves.len += 1;
        }
    }
    (leaves, inner)
}
