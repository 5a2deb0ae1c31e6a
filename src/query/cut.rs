//! A leaf that waits for the other tree cuts its nodes, by slabs of its primitive's own
//! ([`crate::realign::primitive_slabs`]): each in the frame of its own tree, where its planes are tight.

use super::frontier::Side;
use super::placing::{Margin, placed};
use super::stack::Volumes;
use super::traverse::{Traversal, bits_of};
use super::{Lanes, PrimitivePair};
use crate::frame::BodyBounds;
use crate::kernel::Kernel;
use crate::node::{Child, Link, Width};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::realign::{PrimitiveSlabs, shrinkage};

/// A leaf of one primitive that waits for the other tree, by the index of the primitive.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Cutter {
    A(u32),
    B(u32),
}

#[inline(never)]
fn primitive_slabs<N: Lanes, P: Primitive, E: Kernel>(
    kernel: E,
    item: &P::Item,
    margin: f64,
    body: &BodyBounds,
    pose: Option<&Pose>,
) -> PrimitiveSlabs {
    kernel.run(
        #[inline(always)]
        || N::primitive_slabs::<P>(item, margin, body, pose),
    )
}

/// A leaf's primitive cuts where it can clear as many leaves as this, a child that is a node counting as
/// several: it would be visited.
const WORTH_CUTTING: usize = 16;
const WEIGHT_OF_INNER: usize = 8;

/// What a child weighs in that.
#[inline(always)]
pub(super) const fn weight_of(child: Child) -> usize {
    if let Link::Leaf { .. } = child.link() { 1 } else { WEIGHT_OF_INNER }
}

/// A leaf of b cuts nodes of a alone if it is wider than they are by this many powers of two.
const WIDER: i32 = 1;

/// Which lanes of a node lead somewhere.
#[inline(always)]
pub(super) fn used_lanes(children: &[Child]) -> u16 {
    let mut used = 0;
    for (lane, child) in children.iter().enumerate() {
        used |= u16::from(*child != Child::EMPTY) << lane;
    }
    used
}

impl<N, P, Q, E, M> Traversal<'_, N, P, Q, E, M>
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    E: Kernel,
    M: Margin,
{
    /// Whether the children of one node that the bits name are worth being cut by the leaf that waits for them.
    #[inline(always)]
    pub(super) fn is_worth_cutting(&self, a: Child, b: Child, bits: u16) -> bool {
        let children = match (a.link(), b.link()) {
            (Link::Leaf { .. }, Link::Inner(node)) => self.b.nodes()[node as usize].children(),
            (Link::Inner(node), Link::Leaf { .. }) => self.a.nodes()[node as usize].children(),
            _ => return false,
        };
        bits_of(bits).map(|lane| weight_of(children[lane])).sum::<usize>() >= WORTH_CUTTING
    }

    /// Whether the leaf b, which was the last to cut nodes of the other tree, cuts the children of `a` without these being turned into its
    /// frame and compared with its k-DOP: the slabs say nearly as much of a large triangle, and are in a's frame.
    #[inline(always)]
    pub(super) fn cuts_alone(&self, volumes: &Volumes) -> bool {
        let (Link::Inner(_), Link::Leaf { first, .. }) = (volumes.a.link(), volumes.b.link()) else {
            return false;
        };
        match self.cutter {
            Some((Cutter::B(last), _)) if last == first && self.turned.node != volumes.a => {
                let Some(holder) = self.b.nodes().get(volumes.holder_b as usize) else { return false };
                let leaf = Width::of_lane(holder, volumes.lane_b.into());
                volumes.a.width().excess(leaf, -self.units) <= -WIDER
            }
            _ => false,
        }
    }

    /// The slabs of a primitive, for nodes of the other body, of primitives `Others`. Of the query's bodies it is B's
    /// nodes that keep their frame: those of A are turned by the pose.
    #[inline(always)]
    fn slabs<One: Primitive, Others: Primitive>(
        &self,
        item: One::Item,
        is_of_a: bool,
        others: &BodyBounds,
    ) -> PrimitiveSlabs {
        let (pose, margin) = (self.placing.pose, self.margin.value());
        let (margin, pose) =
            if is_of_a { (margin, None) } else { (margin + shrinkage::<Others>(pose, others), Some(pose)) };
        primitive_slabs::<N, One, E>(self.kernel, &item, margin, others, pose)
    }

    /// Where a leaf waits for a node: which of the children that the bits name do not lie beyond its
    /// primitive's primitive slabs.
    // Not a part of the loop, which is faster without it, but behind a gate of its own.
    #[inline(never)]
    pub(super) fn cut(&mut self, a: Child, b: Child, bits: u16) -> u16 {
        let (cutter, node) = match (a.link(), b.link()) {
            (Link::Leaf { first, count: 1 }, Link::Inner(node)) => {
                (Cutter::A(first), &self.b.nodes()[node as usize])
            }
            (Link::Inner(node), Link::Leaf { first, count: 1 }) => {
                (Cutter::B(first), &self.a.nodes()[node as usize])
            }
            _ => return bits,
        };
        if self.cutter.is_none_or(|(last, _)| last != cutter) {
            let (of_a, of_b) = placed((self.a, self.b), self.placing);
            let slabs = match cutter {
                Cutter::A(index) => {
                    self.slabs::<P, Q>(of_a.item(index), self.placing.turned == Side::A, &self.b.extent())
                }
                Cutter::B(index) => {
                    self.slabs::<Q, P>(of_b.item(index), self.placing.turned == Side::B, &self.a.extent())
                }
            };
            self.cutter = Some((cutter, slabs));
        }
        let Some((_, slabs)) = &self.cutter else { return bits };
        let kernel = self.kernel;
        kernel.run(
            #[inline(always)]
            || {
                let mut left = bits;
                for slab in slabs {
                    left &= !node.beyond(kernel, slab);
                    if left == 0 {
                        break;
                    }
                }
                left
            },
        )
    }
}
