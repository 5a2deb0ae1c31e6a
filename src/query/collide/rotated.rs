//! The planes of body a of a traversal in the frame of b: of the children of its nodes, and of its leaves.

use super::bodies::Bodies;
use super::lattice::{TestLattice, aim_on_lattice};
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::Child;
use crate::primitive::Primitive;
use crate::query::entry::QueryStats;
use crate::query::lanes::Lanes;
use crate::query::setup::Placing;

/// The rotated planes of a node's children.
#[derive(Debug)]
// Aligned to a cache line: otherwise every second vector of 32 bytes, and every vector of 64, crosses a line.
#[cfg_attr(simdop_x86, repr(C, align(64)))]
// Aligned to a register: the kernels copy rows that are not.
#[cfg_attr(simdop_neon, repr(C, align(16)))]
pub(super) struct RotatedChildren<T> {
    pub(super) planes: T,
    pub(super) node: Child,
    /// Which of the children have been rotated, if they are rotated one by one.
    pub(super) whole: u16,
}

/// The planes that were rotated last.
pub(super) struct Rotated<N: Lanes> {
    /// Planes of the children of the node of a that was rotated last. Siblings in b follow each other, so the next
    /// visit often needs them too.
    pub(super) children: RotatedChildren<N::Turned>,
    /// The last leaf or node of a that was compared as a single volume with nodes of b, and its planes.
    pub(super) aimed: Option<(Child, N::Aimed)>,
}

impl<N: Lanes> Rotated<N> {
    #[inline(always)]
    pub(super) const fn none() -> Self {
        Self { children: RotatedChildren { planes: N::UNTURNED, node: Child::EMPTY, whole: 0 }, aimed: None }
    }

    /// The node whose children were rotated last.
    #[inline(always)]
    pub(super) const fn node(&self) -> Child {
        self.children.node
    }

    /// Rotates the children of node `a`, whose index is `node`, into b's frame.
    #[inline(always)]
    pub(super) fn rotate<P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        a: Child,
        node: u32,
        stats: &mut QueryStats,
    ) {
        if self.children.node != a {
            stats.realignments += 1;
            self.children.node = a;
            bodies.a.nodes()[node as usize].realign(kernel, bodies.map, &mut self.children.planes);
        }
    }

    /// [`Self::rotate`], as far as needed. Returns which of the children overlap a node of b, or one lane of it, and
    /// the number of kernel calls.
    #[inline(always)]
    pub(super) fn rotate_over<P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        a: Child,
        node: u32,
        (holder, lane): (u32, Option<u8>),
        stats: &mut QueryStats,
    ) -> (u16, u64) {
        if self.children.node != a {
            stats.realignments += 1;
            (self.children.node, self.children.whole) = (a, 0);
        }
        let holder = &bodies.b.nodes()[holder as usize];
        let turned = (&mut self.children.planes, &mut self.children.whole);
        let lane = lane.map(usize::from);
        bodies.a.nodes()[node as usize].realign_over(kernel, bodies.map, turned, holder, lane)
    }

    /// Computes the planes of leaf `a` from its moved corners.
    #[inline(always)]
    pub(super) fn aim<P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        bodies: &Bodies<'_, N, P, Q>,
        a: Child,
        lattice: &mut TestLattice,
    ) {
        let (body, aimed) = self.aimed.get_or_insert((Child::EMPTY, N::NO_AIMED));
        if *body != a {
            *body = a;
            let (trees, placing) = ((bodies.a, bodies.b), bodies.placing);
            let frame = trees.1.frame();
            if E::ON_LATTICE && P::IS_ON_LATTICE {
                let left = aim_on_lattice(lattice, trees, a.link(), placing, &frame, aimed);
                if left != 0 {
                    aim_some::<N, P>(aimed, &frame, (trees.0, a), placing, left);
                }
            } else {
                aim::<N, P>(aimed, &frame, (trees.0, a), placing);
            }
        }
    }

    /// Computes planes that enclose node `a` from the planes of its rotated children.
    #[cold]
    pub(super) fn enclose<P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        a: Child,
        node: u32,
    ) {
        if E::TURNS_BY_PLANES && self.children.whole != u16::MAX {
            bodies.a.nodes()[node as usize].realign(kernel, bodies.map, &mut self.children.planes);
            self.children.whole = u16::MAX;
        }
        let (body, aimed) = self.aimed.get_or_insert((Child::EMPTY, N::NO_AIMED));
        if *body != a {
            N::enclose(&self.children.planes, aimed);
            *body = a;
        }
    }
}

/// The planes of leaf `a`, placed by `placing`, in a frame of b.
// Inlined in the gate, except on small machines, where it is rarely needed and would take stack of every visit.
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

/// [`aim`], only for the planes that have a bit in `wanted`.
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

/// The primitives of leaf `a`, placed by `placing` in body b.
#[inline(always)]
fn moved<'t, N: Lanes, P: Primitive>(
    tree: &'t BvhRef<'_, N, P>,
    leaf: Child,
    placing: &'t Placing<'_>,
) -> impl Iterator<Item = P::Item> + 't {
    leaf.link().primitives().map(|index| P::moved(&tree.primitive(index), placing.to_b))
}
