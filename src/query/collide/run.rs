//! From a query to a traversal: which body is rotated, and the ISA gate of the set-up.

use super::bodies::Bodies;
use super::flow::{Stop, Visitor};
use super::traverse::{Limits, Traversal};
use crate::exact::power_of_two;
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::{BvhRef, Header};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::entry::{Found, PrimitivePair, Query, QueryStats};
use crate::query::lanes::Lanes;
use crate::query::setup::{Margin, Placing, Side};
use crate::realign::{InversePose, shrinkage};

impl Query {
    /// Visits pairs of primitives at most `margin` apart, by their indices in leaf order.
    pub(in crate::query) fn run<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
        pose: &Pose,
        margin: impl Margin,
        stats: &mut QueryStats,
        visit: Visitor<'_>,
    ) -> Option<Stop> {
        if is_b_turned(a.header(), b.header()) {
            return self.run_back((a, b), pose, margin, stats, visit);
        }
        let placing = Placing { pose, turned: Side::A, to_b: pose, outwards: margin.value() };
        self.traverse((a, b), &placing, margin, stats, visit)
    }

    /// [`Self::run`] if B is rotated.
    // Not inlined, so that the inverse pose takes no stack of other queries.
    #[inline(never)]
    fn run_back<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
        pose: &Pose,
        margin: impl Margin,
        stats: &mut QueryStats,
        visit: Visitor<'_>,
    ) -> Option<Stop> {
        let back = InversePose::new(pose, &a.extent(), &b.extent());
        let outwards = back.outwards::<Q>(margin.value(), &b.extent());
        let placing = Placing { pose, turned: Side::B, to_b: &back.pose, outwards };
        self.traverse((b, a), &placing, margin, stats, &mut |found: Found| {
            visit(Found { a: found.b, b: found.a })
        })
    }

    /// Traverses with body a rotated.
    #[inline(always)]
    fn traverse<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
        placing: &Placing<'_>,
        margin: impl Margin,
        stats: &mut QueryStats,
        visit: Visitor<'_>,
    ) -> Option<Stop> {
        on_isa!(self.isa(), token => self.traverse_on(token, trees, placing, margin, stats, visit))
    }

    /// A single function for both orders, which have the same type if both bodies have the same primitives. Not
    /// inlined: the stack frame of the scalar code would add to that of the selected instruction set.
    #[inline(never)]
    fn traverse_on<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>, E: Kernel>(
        &self,
        kernel: E,
        (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
        placing: &Placing<'_>,
        margin: impl Margin,
        stats: &mut QueryStats,
        visit: Visitor<'_>,
    ) -> Option<Stop> {
        // Inlined in the gate whatever its size, so that the set-up is compiled for the instruction set. The traversal
        // has a gate of its own.
        kernel.run(
            #[inline(always)]
            || {
                let mut map = N::UNMAPPED;
                set_up::<N, P>(&mut map, placing, &a.extent(), &b.frame());
                let bodies = Bodies::new((a, b), placing, &map);
                let limits = Limits { budget: self.budget(), margin };
                Traversal::new(kernel.narrow(), bodies, limits, stats, visit).run().break_value()
            },
        )
    }
}

/// The map that rotates volumes of body a into the frame of b.
// Inlined, so that it is compiled for the query's instruction set. Not on small machines, where it would take stack of
// the whole traversal.
#[cfg_attr(simdop_small, inline(never))]
#[cfg_attr(not(simdop_small), inline(always))]
fn set_up<N: Lanes, P: Primitive>(map: &mut N::Map, placing: &Placing<'_>, a: &BodyBounds, b: &Frame) {
    N::map(map, placing.to_b, a, b);
    let outwards = placing.outwards + shrinkage::<P>(placing.to_b, a);
    if outwards > 0.0 {
        N::widen(map, b, outwards);
    }
}

/// Whether rotation enlarges B's k-DOPs less than A's, by enough to pay for the inverse pose.
fn is_b_turned(a: &Header, b: &Header) -> bool {
    let loose = |h: &Header| f64::from(h.rotation_growth) * power_of_two(-h.exponent);
    WAY_BACK * loose(b) < loose(a)
}

/// The relative cost of rotating B: similar bodies keep their order.
const WAY_BACK: f64 = 1.02;
