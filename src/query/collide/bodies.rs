//! The two bodies of a traversal.
//!
//! **Which body is rotated.** A query rotates the body whose k-DOPs grow less ([`Header::rotation_growth`]). In a
//! traversal, `a` is that body and `b` the one that keeps its frame, whichever of the query's A and B they are: the
//! pose or its inverse ([`InversePose`]) rotates volumes of a. Primitive tests always apply the pose to the primitives
//! of the query's A: [`Placing`] records which body that is.
//!
//! **Different sizes.** A visit opens two nodes at once only if their volumes are of similar width. Otherwise the
//! traversal would reach the leaves of a small body while the other body is still at nodes larger than all of the small
//! one, and every such leaf overlaps every such node. So a visit opens the wider node alone, and tests its children
//! against the narrower volume as a whole, until the two are similar. The links hold the widths ([`Width`]).

use super::stack::{Next, Volumes};
use crate::hierarchy::BvhRef;
#[cfg(doc)]
use crate::hierarchy::Header;
use crate::node::{Child, Link, Width};
use crate::primitive::Primitive;
use crate::query::lanes::{Descent, Lanes};
use crate::query::setup::{PlacedTree, Placing, placed};
#[cfg(doc)]
use crate::realign::InversePose;

/// Body a, which is rotated, body b, which keeps its frame, and the map between them.
pub(super) struct Bodies<'t, N: Lanes, P: Primitive, Q: Primitive> {
    pub(super) a: &'t BvhRef<'t, N, P>,
    pub(super) b: &'t BvhRef<'t, N, Q>,
    pub(super) placing: &'t Placing<'t>,
    /// Rotates volumes of a into the frame of b.
    pub(super) map: &'t N::Map,
    /// Binary logarithm of the unit of a's frame divided by that of b's.
    units: i32,
}

/// A node is opened alone if it is wider than the other by this many powers of two, that is by a factor of 4 to 16.
/// With a smaller limit, bodies of similar size would be opened alternately, which takes more visits.
const MUCH_WIDER: i32 = 3;

impl<'t, N: Lanes, P: Primitive, Q: Primitive> Bodies<'t, N, P, Q> {
    #[inline(always)]
    pub(super) fn new(
        (a, b): (&'t BvhRef<'t, N, P>, &'t BvhRef<'t, N, Q>),
        placing: &'t Placing<'t>,
        map: &'t N::Map,
    ) -> Self {
        Self { a, b, placing, map, units: b.frame().exponent - a.frame().exponent }
    }

    /// Binary logarithm of the width of volume `a` divided by that of volume `b`.
    #[inline(always)]
    pub(super) const fn excess(&self, a: Width, b: Width) -> i32 {
        a.excess(b, -self.units)
    }

    /// Selects the nodes to open next.
    #[inline(always)]
    pub(super) fn opened(&self, a: Child, b: Child) -> Descent {
        match (a.link(), b.link()) {
            (Link::Inner(_), Link::Inner(_)) => {
                let excess = self.excess(a.width(), b.width());
                if excess >= MUCH_WIDER {
                    Descent::A
                } else if excess <= -MUCH_WIDER {
                    Descent::B
                } else {
                    Descent::Both
                }
            }
            (Link::Inner(_), _) => Descent::A,
            _ => Descent::B,
        }
    }

    #[inline(always)]
    pub(super) fn child_a(&self, node: u32, lane: usize) -> Child {
        self.a.nodes()[node as usize].children()[lane]
    }

    #[inline(always)]
    pub(super) fn child_b(&self, node: u32, lane: usize) -> Child {
        self.b.nodes()[node as usize].children()[lane]
    }

    /// The pair of volumes that a bit on the stack stands for.
    #[inline(always)]
    pub(super) fn below(&self, Next { volumes, opened, row, bit }: Next) -> Volumes {
        let mut below = volumes;
        if opened != Descent::B
            && let Link::Inner(node) = volumes.a.link()
        {
            below.a = self.child_a(node, if opened == Descent::Both { row } else { bit });
        }
        if opened != Descent::A
            && let Link::Inner(node) = volumes.b.link()
        {
            below.b = self.child_b(node, bit);
            (below.holder_b, below.lane_b) = (node, bit as u8);
        }
        below
    }

    /// Both bodies, with the pose on the query's A.
    #[inline(always)]
    pub(super) fn placed(&self) -> (PlacedTree<'t, N, P>, PlacedTree<'t, N, Q>) {
        placed((self.a, self.b), self.placing)
    }
}
