//! Pairs of leaves: tested as soon as a kernel reports that they overlap.

use super::bodies::Bodies;
use super::flow::{Flow, Stop, Visitor};
use super::lattice::{TestLattice, decide_on_lattice};
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::primitive::Primitive;
use crate::query::entry::{Found, PrimitivePair, QueryStats};
use crate::query::lanes::{Descent, Lanes, Rows, bits_of};
use crate::query::setup::{LookAhead, Margin, Side, is_near};
use core::ops::ControlFlow;

/// The children of a node that are leaves.
#[derive(Copy, Clone)]
pub(super) struct Leaves<'t> {
    children: &'t [Child],
    lanes: u16,
}

impl<'t> Leaves<'t> {
    /// The leaves among `bits`.
    #[inline(always)]
    fn among(children: &'t [Child], bits: u16) -> Self {
        let mut lanes = 0;
        for lane in bits_of(bits) {
            lanes |= u16::from(matches!(children[lane].link(), Link::Leaf { .. })) << lane;
        }
        Self { children, lanes }
    }
}

impl Iterator for Leaves<'_> {
    type Item = Child;

    #[inline(always)]
    fn next(&mut self) -> Option<Child> {
        let leaf = self.children.get(self.lanes.trailing_zeros() as usize)?;
        self.lanes &= self.lanes.wrapping_sub(1);
        Some(*leaf)
    }
}

/// The state of the tests of pairs of leaves.
pub(super) struct LeafPairs<'t, M: Margin> {
    margin: M,
    /// Culls primitives that are farther from each other than the margin.
    ahead: M::Ahead,
    visit: Visitor<'t>,
}

/// Whether pairs are first tested on an integer lattice.
#[inline(always)]
fn is_on_lattice<P: Primitive, Q: Primitive, E: Kernel>(margin: f64) -> bool {
    // The margin is the constant 0 if bodies have to touch.
    E::ON_LATTICE && P::IS_ON_LATTICE && Q::IS_ON_LATTICE && margin == 0.0
}

impl<'t, M: Margin> LeafPairs<'t, M> {
    #[inline(always)]
    pub(super) const fn new(margin: M, visit: Visitor<'t>) -> Self {
        Self { margin, ahead: M::Ahead::NOTHING, visit }
    }

    #[inline(always)]
    pub(super) const fn margin(&self) -> M {
        self.margin
    }

    /// Tests the pairs of leaves among the bits, and clears them.
    #[inline(always)]
    pub(super) fn decide<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        lattice: &mut TestLattice,
        stats: &mut QueryStats,
        (a, b, opened): (Child, Child, Descent),
        rows: &mut Rows,
    ) -> Flow {
        match (opened, b.link()) {
            (Descent::Both | Descent::B, Link::Inner(node_b)) => {
                for row in bits_of(rows.pending as u16) {
                    let child = match (opened, a.link()) {
                        (Descent::Both, Link::Inner(node_a)) => bodies.child_a(node_a, row),
                        _ => a,
                    };
                    if let Link::Leaf { .. } = child.link() {
                        let bits = rows.rows[row];
                        let leaves = Leaves::among(bodies.b.nodes()[node_b as usize].children(), bits);
                        self.decide_a(kernel, bodies, lattice, stats, child, leaves)?;
                        rows.set(row, bits & !leaves.lanes);
                    }
                }
            }
            (_, Link::Leaf { .. }) => {
                if let Link::Inner(node_a) = a.link() {
                    let bits = rows.rows[0];
                    let leaves = Leaves::among(bodies.a.nodes()[node_a as usize].children(), bits);
                    self.decide_b(kernel, bodies, lattice, stats, b, leaves)?;
                    rows.set(0, bits & !leaves.lanes);
                }
            }
            // A node of a that was opened alone has no child of b to test its leaves against.
            _ => {}
        }
        Flow::Continue(())
    }

    /// Tests every primitive of a leaf of a against every primitive of some leaves of b.
    #[inline(always)]
    fn decide_a<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        lattice: &mut TestLattice,
        stats: &mut QueryStats,
        one: Child,
        leaves: Leaves<'_>,
    ) -> Flow {
        let Bodies { a, b, placing, .. } = *bodies;
        if is_on_lattice::<P, Q, E>(self.margin.value()) {
            let lattice = lattice.get((a, b), placing);
            let (of_a, of_b) = bodies.placed();
            for i in one.link().primitives() {
                let mut visit = |j| (self.visit)(Found { a: i, b: j });
                decide_on_lattice(lattice, (&of_a, i), &of_b, leaves, stats, &mut visit)?;
            }
            return Flow::Continue(());
        }
        for i in one.link().primitives() {
            let item = placing.item_a(a, i);
            // Closures without `inline` became calls outside the gate.
            decide_one::<P, Q, E, M>(
                kernel,
                (self.margin, &mut self.ahead),
                stats,
                (&item, placing.turned == Side::A),
                leaves,
                #[inline(always)]
                |j| placing.item_b(b, j),
                #[inline(always)]
                |j| (self.visit)(Found { a: i, b: j }),
            )?;
        }
        Flow::Continue(())
    }

    /// Tests every primitive of a leaf of b against every primitive of some leaves of a.
    #[inline(always)]
    fn decide_b<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'_, N, P, Q>,
        lattice: &mut TestLattice,
        stats: &mut QueryStats,
        one: Child,
        leaves: Leaves<'_>,
    ) -> Flow {
        let Bodies { a, b, placing, .. } = *bodies;
        if is_on_lattice::<P, Q, E>(self.margin.value()) {
            let lattice = lattice.get((a, b), placing);
            let (of_a, of_b) = bodies.placed();
            for j in one.link().primitives() {
                let mut visit = |i| (self.visit)(Found { a: i, b: j });
                decide_on_lattice(lattice, (&of_b, j), &of_a, leaves, stats, &mut visit)?;
            }
            return Flow::Continue(());
        }
        for j in one.link().primitives() {
            let item = placing.item_b(b, j);
            decide_one::<Q, P, E, M>(
                kernel,
                (self.margin, &mut self.ahead),
                stats,
                (&item, placing.turned == Side::B),
                leaves,
                #[inline(always)]
                |i| placing.item_a(a, i),
                #[inline(always)]
                |i| (self.visit)(Found { a: i, b: j }),
            )?;
        }
        Flow::Continue(())
    }
}

/// Tests one primitive, of the query's A or B, against the primitives of some leaves, filtered four at a time. With a
/// margin, an axis culls far primitives first.
#[inline(always)]
fn decide_one<One: PrimitivePair<Other>, Other: PrimitivePair<One>, E: Kernel, M: Margin>(
    kernel: E,
    (margin, ahead): (M, &mut M::Ahead),
    stats: &mut QueryStats,
    (item, is_of_a): (&One::Item, bool),
    mut leaves: Leaves<'_>,
    other_at: impl Fn(u32) -> Other::Item,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> Flow {
    let (margin, reach) = (margin.value(), margin.reach());
    let looks = reach > 0.0;
    let probe = One::probe(item, margin);
    let is_far = |ahead: &M::Ahead, other: &Other::Item| match (looks, is_of_a) {
        (false, _) => false,
        (true, true) => ahead.is_far::<One, Other>(item, other),
        (true, false) => ahead.is_far::<Other, One>(other, item),
    };
    let (mut indices, mut others) = ([0; 4], [Other::Item::default(); 4]);
    let mut range = 0..0;
    loop {
        let mut len = 0;
        while len < 4 {
            if let Some(index) = range.next() {
                let other = other_at(index);
                if is_far(ahead, &other) {
                    stats.primitive_pairs += 1;
                    continue;
                }
                indices[len & 3] = index;
                others[len & 3] = other;
                len += 1;
            } else if let Some(leaf) = leaves.next() {
                range = leaf.link().primitives();
            } else {
                break;
            }
        }
        // A single pair is tested as fast without the filter.
        let apart = if len > 1 { One::apart_4(kernel, &probe, &others) } else { 0 };
        for k in bits_of(!apart & ((1 << len) - 1)) {
            let (other, exact) = (&others[k & 3], &mut stats.exact_pairs);
            let meets = match (margin > 0.0, is_of_a) {
                (false, _) => One::meets(&probe, other, exact),
                // Culled by an axis that was found in the meantime.
                (true, _) if is_far(ahead, other) => false,
                (true, true) => is_near::<One, Other, _>(item, other, (margin, reach, ahead), exact),
                (true, false) => is_near::<Other, One, _>(other, item, (margin, reach, ahead), exact),
            };
            if meets && visit(indices[k & 3]).is_break() {
                stats.primitive_pairs += k as u64 + 1;
                return Flow::Break(Stop::Visitor);
            }
        }
        stats.primitive_pairs += len as u64;
        if len < 4 {
            return Flow::Continue(());
        }
    }
}
