//! A pending leaf culls nodes of the other tree by the slabs of its primitive's own directions
//! ([`crate::realign::primitive_slabs`]): this is done in the frame of that tree, where the planes are tight.

use super::bodies::Bodies;
use super::stack::Volumes;
use crate::frame::BodyBounds;
use crate::kernel::Kernel;
use crate::node::{Child, Link, Width};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::lanes::{Lanes, bits_of, weight_of, within_slabs};
use crate::query::setup::{Cutter, Margin, Placing, Side};
use crate::realign::{PrimitiveSlabs, shrinkage};

/// The last leaf that culled nodes of the other tree, and the slabs of its primitive.
#[derive(Default, Debug)]
pub(super) struct PrimitiveCut {
    last: Option<(Cutter, PrimitiveSlabs)>,
}

/// Primitive slabs are tested if they may cull at least this weight of children ([`weight_of`]).
const WORTH_CUTTING: usize = 16;

/// The slabs of a leaf of b suffice to cull nodes of a if the leaf is wider than the nodes by this many powers of two.
const WIDER: i32 = 1;

/// Whether testing the children of a node that have a bit against the primitive slabs of the pending leaf pays.
#[inline(always)]
pub(super) fn is_worth_cutting<N: Lanes, P: Primitive, Q: Primitive>(
    bodies: &Bodies<'_, N, P, Q>,
    a: Child,
    b: Child,
    bits: u16,
) -> bool {
    let children = match (a.link(), b.link()) {
        (Link::Leaf { .. }, Link::Inner(node)) => bodies.b.nodes()[node as usize].children(),
        (Link::Inner(node), Link::Leaf { .. }) => bodies.a.nodes()[node as usize].children(),
        _ => return false,
    };
    bits_of(bits).map(|lane| weight_of(children[lane])).sum::<usize>() >= WORTH_CUTTING
}

impl PrimitiveCut {
    /// Whether the slabs of leaf b alone cull the children of `a`, without rotating them into b's frame and comparing
    /// them with the leaf's k-DOP. Leaf b must be the last one that culled nodes. The slabs of a large triangle cull
    /// nearly as much as that, and are in a's frame.
    #[inline(always)]
    pub(super) fn cuts_alone<N: Lanes, P: Primitive, Q: Primitive>(
        &self,
        bodies: &Bodies<'_, N, P, Q>,
        rotated: Child,
        volumes: &Volumes,
    ) -> bool {
        let (Link::Inner(_), Link::Leaf { first, .. }) = (volumes.a.link(), volumes.b.link()) else {
            return false;
        };
        match self.last {
            Some((Cutter::B(last), _)) if last == first && rotated != volumes.a => {
                let Some(holder) = bodies.b.nodes().get(volumes.holder_b as usize) else { return false };
                let leaf = Width::of_lane(holder, volumes.lane_b.into());
                bodies.excess(volumes.a.width(), leaf) <= -WIDER
            }
            _ => false,
        }
    }

    /// For a leaf that is pending against a node: which of the children with a bit do not lie beyond its primitive's
    /// slabs.
    // Not inlined, since the loop is faster that way; it has a gate of its own.
    #[inline(never)]
    pub(super) fn cut<N: Lanes, P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        margin: impl Margin,
        (a, b): (Child, Child),
        bits: u16,
    ) -> u16 {
        let (cutter, node) = match (a.link(), b.link()) {
            (Link::Leaf { first, count: 1 }, Link::Inner(node)) => {
                (Cutter::A(first), &bodies.b.nodes()[node as usize])
            }
            (Link::Inner(node), Link::Leaf { first, count: 1 }) => {
                (Cutter::B(first), &bodies.a.nodes()[node as usize])
            }
            _ => return bits,
        };
        if self.last.is_none_or(|(last, _)| last != cutter) {
            let ((of_a, of_b), placing) = (bodies.placed(), bodies.placing);
            let turned = placing.turned;
            let slabs = match cutter {
                Cutter::A(index) => slabs::<N, P, Q, E>(
                    kernel,
                    placing,
                    margin.value(),
                    (of_a.item(index), turned == Side::A),
                    &bodies.b.extent(),
                ),
                Cutter::B(index) => slabs::<N, Q, P, E>(
                    kernel,
                    placing,
                    margin.value(),
                    (of_b.item(index), turned == Side::B),
                    &bodies.a.extent(),
                ),
            };
            self.last = Some((cutter, slabs));
        }
        let Some((_, slabs)) = &self.last else { return bits };
        kernel.run(
            #[inline(always)]
            || within_slabs(kernel, node, slabs, bits),
        )
    }
}

/// The slabs of a primitive in the frame of the other body, whose primitives are `Others`. Nodes of the query's B keep
/// their frame, and the pose rotates those of A.
#[inline(always)]
fn slabs<N: Lanes, One: Primitive, Others: Primitive, E: Kernel>(
    kernel: E,
    placing: &Placing<'_>,
    margin: f64,
    (item, is_of_a): (One::Item, bool),
    others: &BodyBounds,
) -> PrimitiveSlabs {
    let pose = placing.pose;
    let (margin, pose) =
        if is_of_a { (margin, None) } else { (margin + shrinkage::<Others>(pose, others), Some(pose)) };
    primitive_slabs::<N, One, E>(kernel, &item, margin, others, pose)
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
