//! Leaves on cores that have no `f64`: by corners on a lattice of integers where these are certain, else as everywhere. Which
//! of the two decides changes no verdict, no plane and no counter ([`LatticeProbe`]).

use super::frontier::Side;
use super::leaves::Leaves;
use super::placing::{PlacedTree, Placing};
use super::traverse::{Flow, Stop, primitives};
use super::{Lanes, PrimitivePair, QueryStats};
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::node::Link;
use crate::primitive::triangle::LatticeProbe;
use crate::primitive::{Lattice, LatticeCorners, Primitive};
use crate::realign::ALL;
use core::ops::ControlFlow;

impl<N: Lanes, P: Primitive> PlacedTree<'_, N, P> {
    #[inline(always)]
    fn corners(&self, index: u32, lattice: &Lattice) -> Option<LatticeCorners> {
        P::on_lattice(self.tree.store(), index, lattice, self.pose.is_some())
    }
}

/// The lattice of tests, made when it is first needed.
pub(super) fn lattice_of<'l, N: Lanes, P: Primitive, Q: Primitive>(
    made: &'l mut Option<Option<Lattice>>,
    (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    placing: &Placing<'_>,
) -> Option<&'l Lattice> {
    made.get_or_insert_with(|| {
        let (a, b) = (a.extent().max_coordinate, b.extent().max_coordinate);
        let (moved, still) = if placing.turned == Side::A { (a, b) } else { (b, a) };
        Lattice::new(placing.pose, moved, still)
    })
    .as_ref()
}

/// One primitive against those of some leaves.
#[inline(never)]
pub(super) fn decide_on_lattice<N: Lanes, One: PrimitivePair<Other>, Other: PrimitivePair<One>>(
    lattice: Option<&Lattice>,
    (one, index): (&PlacedTree<'_, N, One>, u32),
    other: &PlacedTree<'_, N, Other>,
    leaves: Leaves<'_>,
    stats: &mut QueryStats,
    visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Flow {
    let corners = lattice.and_then(|lattice| one.corners(index, lattice));
    let probe = corners.as_ref().map(LatticeProbe::new);
    for leaf in leaves {
        for j in primitives(leaf.link()) {
            stats.primitive_pairs += 1;
            let certain = match (&probe, lattice) {
                (Some(probe), Some(lattice)) => {
                    other.corners(j, lattice).and_then(|corners| probe.meets(&corners))
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

/// The planes of leaf `a`, which `placing` places in body b, in a frame of b, as far as they are certain: of the others a bit each.
#[inline(always)]
pub(super) fn aim_on_lattice<N: Lanes, P: Primitive, Q: Primitive>(
    made: &mut Option<Option<Lattice>>,
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    leaf: Link,
    placing: &Placing<'_>,
    frame_b: &Frame,
    aimed: &mut N::Aimed,
) -> u32 {
    if placing.turned == Side::A {
        aim_by::<N, P>(lattice_of(made, trees, placing), (trees.0, leaf), placing.outwards, frame_b, aimed)
    } else {
        aim_back(trees, leaf, placing, frame_b, aimed)
    }
}

/// The way back has a lattice of its own.
// Not a part of its caller, of whose stack it would take more.
#[cold]
#[inline(never)]
fn aim_back<N: Lanes, P: Primitive, Q: Primitive>(
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    leaf: Link,
    placing: &Placing<'_>,
    frame_b: &Frame,
    aimed: &mut N::Aimed,
) -> u32 {
    let mut made = None;
    let to_b = Placing { pose: placing.to_b, turned: Side::A, ..*placing };
    aim_by::<N, P>(lattice_of(&mut made, trees, &to_b), (trees.0, leaf), placing.outwards, frame_b, aimed)
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
    let corners = primitives(leaf).map(|index| P::on_lattice(a.store(), index, lattice, true));
    N::aim_on_lattice(aimed, frame_b, corners, lattice.exponent, outwards)
}
