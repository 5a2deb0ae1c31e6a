//! How the bodies of a traversal stand to each other: which of them is turned, and how far apart counts as meeting.

use super::Lanes;
use super::ahead::{Ahead, LookAhead};
use super::frontier::Side;
use crate::exact::power_of_two;
use crate::hierarchy::BvhRef;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::range::Point;
use crate::realign::greatest;

/// How far apart primitives may be that count as meeting. A type, so that a program which asks only whether bodies
/// touch holds none of the code of distances: three quarters of the whole on a microcontroller.
pub(super) trait Margin: Copy {
    /// What tells most primitives apart: nothing where they have to touch, which is decided as fast.
    type Ahead: LookAhead;
    /// In the bodies' unit, not negative.
    fn value(self) -> f64;
    /// Bounds all coordinates where primitives are told apart so; else 0.
    fn reach(self) -> f64;
}

/// Primitives have to touch.
#[derive(Copy, Clone, Debug)]
pub(super) struct Touching;

impl Margin for Touching {
    type Ahead = ();

    #[inline(always)]
    fn value(self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn reach(self) -> f64 {
        0.0
    }
}

/// Bounds all coordinates of A where the pose places it, and of B.
#[inline(always)]
pub(super) fn reach<N: Lanes, P: Primitive, Q: Primitive>(
    a: &BvhRef<'_, N, P>,
    b: &BvhRef<'_, N, Q>,
    pose: &Pose,
) -> f64 {
    (4.0 * a.extent().max_coordinate + greatest(&pose.translation())) + b.extent().max_coordinate
}

/// They may be this far apart.
#[derive(Copy, Clone, Debug)]
pub(super) struct Within {
    margin: f64,
    reach: f64,
}

/// Margins below this share of the coordinates pay for roundings: the planes tell nearly all primitives apart that are not so near.
const ROUNDINGS: f64 = power_of_two(-30);

impl Within {
    pub(super) fn new<N: Lanes, P: Primitive, Q: Primitive>(
        margin: f64,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) -> Self {
        let reach = reach(a, b, pose);
        Self { margin, reach: if margin > ROUNDINGS * reach { reach } else { 0.0 } }
    }
}

impl Margin for Within {
    type Ahead = Ahead;

    #[inline(always)]
    fn value(self) -> f64 {
        self.margin
    }

    #[inline(always)]
    fn reach(self) -> f64 {
        self.reach
    }
}

/// Body a of a traversal, which is turned, and body b, which keeps its frame.
#[derive(Copy, Clone, Debug)]
pub(super) struct Placing<'t> {
    /// Moves the primitives of the query's A.
    pub(super) pose: &'t Pose,
    /// Which body of the query is turned.
    pub(super) turned: Side,
    /// Places it in the frame of the other: `pose`, or the way back.
    pub(super) to_b: &'t Pose,
    /// How far its volumes have to be moved out, in the bodies' unit: by the margin, and by what the way back pads.
    pub(super) outwards: f64,
}

impl Placing<'_> {
    /// Primitive of a as it is tested.
    #[inline(always)]
    pub(super) fn item_a<N: Lanes, P: Primitive>(&self, a: &BvhRef<'_, N, P>, index: u32) -> P::Item {
        self.place::<P>(a.primitive(index), Side::A)
    }

    /// Primitive of b as it is tested.
    #[inline(always)]
    pub(super) fn item_b<N: Lanes, Q: Primitive>(&self, b: &BvhRef<'_, N, Q>, index: u32) -> Q::Item {
        self.place::<Q>(b.primitive(index), Side::B)
    }

    /// A primitive of a or of b in the frame of the query's B: of these two it is the query's A that the pose moves.
    #[inline(always)]
    fn place<P: Primitive>(&self, item: P::Item, of: Side) -> P::Item {
        if self.turned == of { P::moved(&item, self.pose) } else { item }
    }
}

/// One body of a query.
pub(super) struct PlacedTree<'t, N: Lanes, P: Primitive> {
    pub(super) tree: &'t BvhRef<'t, N, P>,
    /// Moves its primitives, if it is the query's A.
    pub(super) pose: Option<&'t Pose>,
}

impl<N: Lanes, P: Primitive> PlacedTree<'_, N, P> {
    /// A primitive where it stands, for where no inner loop waits for it.
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    pub(super) fn item(&self, index: u32) -> P::Item {
        let item = self.tree.primitive(index);
        match self.pose {
            Some(pose) => P::moved(&item, pose),
            None => item,
        }
    }
}

/// Both bodies of a traversal.
pub(super) fn placed<'t, N: Lanes, P: Primitive, Q: Primitive>(
    (a, b): (&'t BvhRef<'t, N, P>, &'t BvhRef<'t, N, Q>),
    placing: &'t Placing<'_>,
) -> (PlacedTree<'t, N, P>, PlacedTree<'t, N, Q>) {
    let pose = |side: Side| (placing.turned == side).then_some(placing.pose);
    (PlacedTree { tree: a, pose: pose(Side::A) }, PlacedTree { tree: b, pose: pose(Side::B) })
}

/// The distance of some corner below volume a from some corner below b, rounded up.
#[cold]
#[inline(never)]
pub(super) fn corner_distance<N: Lanes, P: Primitive, Q: Primitive>(
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    placing: &Placing<'_>,
    (a, b): (Child, Child),
) -> f64 {
    let (of_a, of_b) = placed(trees, placing);
    let p = of_a.item(first_primitive(trees.0, a.link()));
    let q = of_b.item(first_primitive(trees.1, b.link()));
    let corner = |p: Option<Point>| p.map_or(glam::DVec3::ZERO, glam::DVec3::from_array);
    let d = corner(P::corners(&p).next()).distance(corner(Q::corners(&q).next()));
    d * (1.0 + 8.0 * f64::EPSILON)
}

/// Some primitive below a link.
pub(super) fn first_primitive<N: Lanes, P: Primitive>(tree: &BvhRef<'_, N, P>, mut link: Link) -> u32 {
    loop {
        match link {
            Link::Leaf { first, .. } => return first,
            // Links lead to later nodes, so this ends; a node without a used lane does not bound anything:
            // any primitive will do.
            Link::Inner(node) => {
                let children = tree.nodes()[node as usize].children();
                link = children.iter().map(|c| c.link()).find(|l| *l != Link::Empty).unwrap_or(Link::Empty);
            }
            Link::Empty => return 0,
        }
    }
}
