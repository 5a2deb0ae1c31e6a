//! The planes of body a of a traversal in the frame of b: of the children of its nodes, and of its leaves.

use super::on_lattice::aim_on_lattice;
use super::placing::{Margin, Placing};
use super::traverse::{Traversal, primitives};
use super::{Lanes, PrimitivePair};
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::Child;
use crate::primitive::Primitive;

/// The planes of a node's children.
#[derive(Debug)]
// At the start of a line of the cache: vectors of 32 or 64 bytes elsewhere lie in two of them, each second or each.
#[cfg_attr(simdop_x86, repr(C, align(64)))]
pub(super) struct TurnedChildren<T> {
    pub(super) planes: T,
    pub(super) node: Child,
    /// Which of the children, where they are turned one by one.
    pub(super) whole: u16,
}

impl<N, P, Q, E, M> Traversal<'_, N, P, Q, E, M>
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    E: Kernel,
    M: Margin,
{
    /// Turns the children of node `a`, which is at `node`, into B's frame.
    #[inline(always)]
    pub(super) fn turn(&mut self, a: Child, node: u32) {
        if self.turned.node != a {
            self.stats.realignments += 1;
            self.turned.node = a;
            self.a.nodes()[node as usize].realign(self.kernel, self.map, &mut self.turned.planes);
        }
    }

    /// [`Self::turn`], as far as it is needed, and which of the children overlap a node of B: all of it, or what it holds
    /// in a lane.
    #[inline(always)]
    pub(super) fn turn_over(&mut self, a: Child, node: u32, (holder, lane): (u32, Option<u8>)) -> (u16, u64) {
        if self.turned.node != a {
            self.stats.realignments += 1;
            (self.turned.node, self.turned.whole) = (a, 0);
        }
        let holder = &self.b.nodes()[holder as usize];
        let turned = (&mut self.turned.planes, &mut self.turned.whole);
        let lane = lane.map(usize::from);
        self.a.nodes()[node as usize].realign_over(self.kernel, self.map, turned, holder, lane)
    }

    /// Computes the planes of leaf `a` from its moved corners.
    #[inline(always)]
    pub(super) fn aim(&mut self, a: Child) {
        let (body, aimed) = self.aimed.get_or_insert((Child::EMPTY, N::NO_AIMED));
        if *body != a {
            *body = a;
            let (trees, placing) = ((self.a, self.b), self.placing);
            let frame = self.b.frame();
            if E::ON_LATTICE && P::IS_ON_LATTICE {
                let left = aim_on_lattice(&mut self.lattice, trees, a.link(), placing, &frame, aimed);
                if left != 0 {
                    aim_some::<N, P>(aimed, &frame, (trees.0, a), placing, left);
                }
            } else {
                aim::<N, P>(aimed, &frame, (trees.0, a), placing);
            }
        }
    }

    /// Computes planes that hold all of node `a` from those of its children, which are turned.
    #[cold]
    pub(super) fn enclose(&mut self, a: Child, node: u32) {
        if E::TURNS_BY_PLANES && self.turned.whole != u16::MAX {
            self.a.nodes()[node as usize].realign(self.kernel, self.map, &mut self.turned.planes);
            self.turned.whole = u16::MAX;
        }
        let (body, aimed) = self.aimed.get_or_insert((Child::EMPTY, N::NO_AIMED));
        if *body != a {
            N::enclose(&self.turned.planes, aimed);
            *body = a;
        }
    }
}

/// The planes of leaf `a`, which `placing` places in body b, in a frame of b.
// A part of the gate, but on small machines, where it is seldom needed and would take stack of every visit.
#[cfg_attr(simdop_small, inline(never))]
#[cfg_attr(not(simdop_small), inline(always))]
fn aim<N: Lanes, P: Primitive>(
    aimed: &mut N::Aimed,
    frame_b: &Frame,
    (tree, leaf): (&BvhRef<'_, N, P>, Child),
    placing: &Placing<'_>,
) {
    N::aim::<P>(aimed, frame_b, moved::<N, P>(tree, leaf, placing), placing.outwards);
}

/// The same of those planes alone that `wanted` has bits for.
#[inline(never)]
fn aim_some<N: Lanes, P: Primitive>(
    aimed: &mut N::Aimed,
    frame_b: &Frame,
    (tree, leaf): (&BvhRef<'_, N, P>, Child),
    placing: &Placing<'_>,
    wanted: u32,
) {
    N::aim_some::<P>(aimed, frame_b, moved::<N, P>(tree, leaf, placing), placing.outwards, wanted);
}

/// The primitives of leaf `a` where `placing` places them in body b.
#[inline(always)]
fn moved<'t, N: Lanes, P: Primitive>(
    tree: &'t BvhRef<'_, N, P>,
    leaf: Child,
    placing: &'t Placing<'_>,
) -> impl Iterator<Item = P::Item> + 't {
    primitives(leaf.link()).map(|index| P::moved(&tree.primitive(index), placing.to_b))
}
