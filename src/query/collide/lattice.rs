//! Tests of leaves on cores without `f64` hardware: with corners on an integer lattice where the result is certain, and
//! otherwise as on all machines. The choice changes no verdict, no plane and no query statistics ([`LatticeProbe`]).

use super::flow::{Flow, Stop};
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::node::{Child, Link};
use crate::primitive::triangle::LatticeProbe;
use crate::primitive::{Lattice, LatticeCorners, Primitive};
use crate::query::entry::{PrimitivePair, QueryStats};
use crate::query::lanes::Lanes;
use crate::query::setup::{PlacedTree, Placing, Side};
use crate::realign::ALL;
use core::ops::ControlFlow;

/// The lattice of a query, made when first needed; the inner `None` if the bodies have none.
#[derive(Default, Debug)]
pub(super) struct TestLattice(Option<Option<Lattice>>);

impl TestLattice {
    pub(super) fn get<N: Lanes, P: Primitive, Q: Primitive>(
        &mut self,
        (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
        placing: &Placing<'_>,
    ) -> Option<&Lattice> {
        self.0
            .get_or_insert_with(|| {
                let (a, b) = (a.extent().max_coordinate, b.extent().max_coordinate);
                let (moved, still) = if placing.turned == Side::A { (a, b) } else { (b, a) };
                Lattice::new(placing.pose, moved, still)
            })
            .as_ref()
    }
}

#[inline(always)]
fn corners_of<N: Lanes, P: Primitive>(
    body: &PlacedTree<'_, N, P>,
    index: u32,
    lattice: &Lattice,
) -> Option<LatticeCorners> {
    P::on_lattice(body.tree.store(), index, lattice, body.pose.is_some())
}

/// Tests one primitive against those of some leaves.
#[inline(never)]
pub(super) fn decide_on_lattice<N: Lanes, One: PrimitivePair<Other>, Other: PrimitivePair<One>>(
    lattice: Option<&Lattice>,
    (one, index): (&PlacedTree<'_, N, One>, u32),
    other: &PlacedTree<'_, N, Other>,
    leaves: impl Iterator<Item = Child>,
    stats: &mut QueryStats,
    visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Flow {
    let corners = lattice.and_then(|lattice| corners_of(one, index, lattice));
    let probe = corners.as_ref().map(LatticeProbe::new);
    for leaf in leaves {
        for j in leaf.link().primitives() {
            stats.primitive_pairs += 1;
            let certain = match (&probe, lattice) {
                (Some(probe), Some(lattice)) => {
                    corners_of(other, j, lattice).and_then(|corners| probe.meets(&corners))
                }
                _ => None,
            };
            let meets = match certain {
                Some(meets) => meets,
                None => meet((one, index), (other, j), &mut stats.exact_pairs),
            };
            if meets && visit(j).is_break() {
                return Flow::Break(Stop::Visitor);
            }
        }
    }
    Flow::Continue(())
}

#[cold]
#[inline(never)]
fn meet<N: Lanes, One: PrimitivePair<Other>, Other: PrimitivePair<One>>(
    (one, i): (&PlacedTree<'_, N, One>, u32),
    (other, j): (&PlacedTree<'_, N, Other>, u32),
    exact: &mut u64,
) -> bool {
    One::meets(&One::probe(&one.item(i), 0.0), &other.item(j), exact)
}

/// The planes of leaf `a`, placed by `placing`, in a frame of b, where they are certain. Returns a bit for each other
/// plane.
#[inline(always)]
pub(super) fn aim_on_lattice<N: Lanes, P: Primitive, Q: Primitive>(
    lattice: &mut TestLattice,
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    leaf: Link,
    placing: &Placing<'_>,
    frame_b: &Frame,
    aimed: &mut N::Aimed,
) -> u32 {
    if placing.turned == Side::A {
        aim_by::<N, P>(lattice.get(trees, placing), (trees.0, leaf), placing.outwards, frame_b, aimed)
    } else {
        aim_back(trees, leaf, placing, frame_b, aimed)
    }
}

/// The inverse pose has a lattice of its own.
// Not inlined: it would enlarge the caller's stack frame.
#[cold]
#[inline(never)]
fn aim_back<N: Lanes, P: Primitive, Q: Primitive>(
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    leaf: Link,
    placing: &Placing<'_>,
    frame_b: &Frame,
    aimed: &mut N::Aimed,
) -> u32 {
    let mut lattice = TestLattice::default();
    let to_b = Placing { pose: placing.to_b, turned: Side::A, ..*placing };
    aim_by::<N, P>(lattice.get(trees, &to_b), (trees.0, leaf), placing.outwards, frame_b, aimed)
}

#[inline(never)]
fn aim_by<N: Lanes, P: Primitive>(
    lattice: Option<&Lattice>,
    (a, leaf): (&BvhRef<'_, N, P>, Link),
    outwards: f64,
    frame_b: &Frame,
    aimed: &mut N::Aimed,
) -> u32 {
    let Some(lattice) = lattice else { return ALL };
    let corners = leaf.primitives().map(|index| P::on_lattice(a.store(), index, lattice, true));
    N::aim_on_lattice(aimed, frame_b, corners, lattice.exponent, outwards)
}
