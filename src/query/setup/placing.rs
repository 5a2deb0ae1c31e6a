//! The placement of a query's bodies: which of them is rotated into the frame of the other.

use crate::hierarchy::BvhRef;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::lanes::Lanes;

/// One of the two bodies.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::query) enum Side {
    A,
    B,
}

/// A leaf of one primitive that is pending against the other tree, by the index of the primitive. The primitive's slabs
/// cull nodes of that tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::query) enum Cutter {
    A(u32),
    B(u32),
}

/// Index in place of the node that holds the root as a child, which does not exist.
pub(in crate::query) const ABOVE_ROOT: u32 = u32::MAX;

/// Body a of a traversal, which is rotated, and body b, which keeps its frame.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) struct Placing<'t> {
    /// Moves the primitives of the query's A.
    pub(in crate::query) pose: &'t Pose,
    /// Which body of the query is rotated.
    pub(in crate::query) turned: Side,
    /// Places body a in the frame of b: `pose`, or its inverse.
    pub(in crate::query) to_b: &'t Pose,
    /// The distance by which the volumes of a are widened, in the bodies' unit: the margin plus the pad of the inverse
    /// pose.
    pub(in crate::query) outwards: f64,
}

impl Placing<'_> {
    /// A primitive of a, as placed for tests.
    #[inline(always)]
    pub(in crate::query) fn item_a<N: Lanes, P: Primitive>(
        &self,
        a: &BvhRef<'_, N, P>,
        index: u32,
    ) -> P::Item {
        self.place::<P>(a.primitive(index), Side::A)
    }

    /// A primitive of b, as placed for tests.
    #[inline(always)]
    pub(in crate::query) fn item_b<N: Lanes, Q: Primitive>(
        &self,
        b: &BvhRef<'_, N, Q>,
        index: u32,
    ) -> Q::Item {
        self.place::<Q>(b.primitive(index), Side::B)
    }

    /// A primitive of a or of b in the frame of the query's B. The pose moves the one that belongs to the query's A.
    #[inline(always)]
    fn place<P: Primitive>(&self, item: P::Item, of: Side) -> P::Item {
        if self.turned == of { P::moved(&item, self.pose) } else { item }
    }
}

/// One body of a query.
pub(in crate::query) struct PlacedTree<'t, N: Lanes, P: Primitive> {
    pub(in crate::query) tree: &'t BvhRef<'t, N, P>,
    /// Moves its primitives, if it is the query's A.
    pub(in crate::query) pose: Option<&'t Pose>,
}

impl<N: Lanes, P: Primitive> PlacedTree<'_, N, P> {
    /// The pose of its primitives, if it is the query's A.
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    pub(in crate::query) fn item(&self, index: u32) -> P::Item {
        let item = self.tree.primitive(index);
        match self.pose {
            Some(pose) => P::moved(&item, pose),
            None => item,
        }
    }
}

/// The placed primitive. Not for inner loops.
pub(in crate::query) fn placed<'t, N: Lanes, P: Primitive, Q: Primitive>(
    (a, b): (&'t BvhRef<'t, N, P>, &'t BvhRef<'t, N, Q>),
    placing: &'t Placing<'_>,
) -> (PlacedTree<'t, N, P>, PlacedTree<'t, N, Q>) {
    let pose = |side: Side| (placing.turned == side).then_some(placing.pose);
    (PlacedTree { tree: a, pose: pose(Side::A) }, PlacedTree { tree: b, pose: pose(Side::B) })
}

/// Both bodies of a traversal.
#[cold]
#[inline(never)]
pub(in crate::query) fn corner_distance<N: Lanes, P: Primitive, Q: Primitive>(
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    placing: &Placing<'_>,
    (a, b): (Child, Child),
) -> f64 {
    let (of_a, of_b) = placed(trees, placing);
    let p = of_a.item(first_primitive(trees.0, a.link()));
    let q = of_b.item(first_primitive(trees.1, b.link()));
    let d = glam::DVec3::from_array(P::point(&p)).distance(glam::DVec3::from_array(Q::point(&q)));
    d * (1.0 + 8.0 * f64::EPSILON)
}

/// An upper bound of the distance of two bodies: the distance between a corner below volume a and one below b, rounded
/// up.
pub(in crate::query) fn first_primitive<N: Lanes, P: Primitive>(
    tree: &BvhRef<'_, N, P>,
    mut link: Link,
) -> u32 {
    loop {
        match link {
            Link::Leaf { first, .. } => return first,
            // Links lead to later nodes, so this ends. A node without a used lane bounds nothing, and any primitive
            // will do.
            Link::Inner(node) => {
                let children = tree.nodes()[node as usize].children();
                link = children.iter().map(|c| c.link()).find(|l| *l != Link::Empty).unwrap_or(Link::Empty);
            }
            Link::Empty => return 0,
        }
    }
}
