//! The simultaneous traversal of both trees, sixteen pairs of volumes a step.
//!
//! A **visit** takes two nodes, or a node and a leaf. It rotates a's children into b's frame (one re-alignment), and
//! the kernel returns a row of bits for each of them. The visit tests the pairs of leaves among the bits at once, and
//! pushes the other pairs on the stack.

use super::bodies::Bodies;
use super::flow::{Flow, Stop, Visitor};
use super::lattice::TestLattice;
use super::leaves::LeafPairs;
use super::normal_slabs::{LONG, NormalSlabs};
use super::primitive_slabs::{PrimitiveCut, is_worth_cutting};
use super::rotated::Rotated;
use super::stack::{FEW, MANY, NOT_VISITED, Stack, Visited, Volumes};
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::query::entry::{PrimitivePair, QueryStats};
use crate::query::lanes::{Descent, Lanes, Rows, used_lanes};
use crate::query::setup::{ABOVE_ROOT, Margin, corner_distance};
use core::ops::ControlFlow;

/// The budget of a traversal, and the distance up to which primitives count as meeting.
#[derive(Copy, Clone, Debug)]
pub(super) struct Limits<M> {
    pub(super) budget: u64,
    pub(super) margin: M,
}

/// The state of a query.
pub(super) struct Traversal<'t, N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>, E, M: Margin> {
    kernel: E,
    bodies: Bodies<'t, N, P, Q>,
    budget: u64,
    stats: &'t mut QueryStats,
    leaves: LeafPairs<'t, M>,
    rotated: Rotated<N>,
    primitive_cut: PrimitiveCut,
    normal_slabs: NormalSlabs<'t>,
    lattice: TestLattice,
}

impl<'t, N, P, Q, E, M> Traversal<'t, N, P, Q, E, M>
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    E: Kernel,
    M: Margin,
{
    #[inline(always)]
    pub(super) fn new(
        kernel: E,
        bodies: Bodies<'t, N, P, Q>,
        Limits { budget, margin }: Limits<M>,
        stats: &'t mut QueryStats,
        visit: Visitor<'t>,
    ) -> Self {
        Self {
            kernel,
            bodies,
            budget,
            stats,
            leaves: LeafPairs::new(margin, visit),
            rotated: Rotated::none(),
            primitive_cut: PrimitiveCut::default(),
            normal_slabs: NormalSlabs::default(),
            lattice: TestLattice::default(),
        }
    }

    /// Visits every pair of primitives that meet.
    // Each part of the stack belongs to its own function: many queries end at the roots, and few go deep.
    #[inline(always)]
    pub(super) fn run(&mut self) -> Flow {
        let (a, b) = (self.bodies.a, self.bodies.b);
        if a.is_empty() || b.is_empty() {
            return Flow::Continue(());
        }
        let roots = Volumes { a: a.header().root, b: b.header().root, holder_b: ABOVE_ROOT, lane_b: 0 };
        let mut memory = [NOT_VISITED];
        if self.descend(Some(roots), &mut Stack::new(&mut memory, 0))? {
            self.go_on(&memory[0])
        } else {
            Flow::Continue(())
        }
    }

    /// Visits everything below an entry.
    #[inline(never)]
    fn go_on(&mut self, entry: &Visited) -> Flow {
        let mut memory = [NOT_VISITED; FEW];
        memory[0] = *entry;
        let mut len = 1;
        while self.descend(None, &mut Stack::new(&mut memory, len))? {
            self.go_deep(&memory[FEW - 1])?;
            len = FEW - 1;
        }
        Flow::Continue(())
    }

    /// [`Self::go_on`], with as much memory as the deepest valid trees need.
    #[cold]
    #[inline(never)]
    fn go_deep(&mut self, entry: &Visited) -> Flow {
        let mut memory = [NOT_VISITED; MANY];
        memory[0] = *entry;
        let is_full = self.descend(None, &mut Stack::new(&mut memory, 1))?;
        assert!(!is_full, "the trees are deeper than they may be");
        Flow::Continue(())
    }

    /// Visits two volumes, if any, and then all pairs on the stack. Returns true if it stops early because the stack is
    /// full.
    // A single function for all sizes of memory, which contains the ISA gate. A loop with a single call of each kernel,
    // so that each is inlined.
    #[inline(never)]
    fn descend(&mut self, volumes: Option<Volumes>, stack: &mut Stack<'_>) -> ControlFlow<Stop, bool> {
        let kernel = self.kernel;
        kernel.run(
            #[inline(always)]
            || {
                let mut next = volumes;
                loop {
                    if let Some(volumes) = next
                        && let Some(entry) = self.step(&volumes)?
                        && stack.push(entry)
                    {
                        return ControlFlow::Continue(true);
                    }
                    if self.stats.visits >= LONG {
                        self.normal_slabs.cull(kernel, &self.bodies, self.leaves.margin(), stack);
                    }
                    let Some(bit) = stack.next() else { return ControlFlow::Continue(false) };
                    next = Some(self.bodies.below(bit));
                }
            },
        )
    }

    /// Visits a pair of which at least one is a node, and returns the pending pairs below it.
    #[inline(always)]
    fn step(&mut self, volumes: &Volumes) -> ControlFlow<Stop, Option<Visited>> {
        let Volumes { a, b, holder_b, lane_b } = *volumes;
        let (kernel, bodies) = (self.kernel, &self.bodies);
        if self.stats.visits == self.budget {
            return ControlFlow::Break(Stop::Budget {
                upper: corner_distance((bodies.a, bodies.b), bodies.placing, (a, b)),
            });
        }
        self.stats.visits += 1;
        let is_b_root = holder_b == ABOVE_ROOT;
        let cuts_alone = self.primitive_cut.cuts_alone(bodies, self.rotated.node(), volumes);
        match a.link() {
            Link::Inner(_) if E::TURNS_BY_PLANES || cuts_alone => {}
            Link::Inner(node) => self.rotated.rotate(kernel, bodies, a, node, self.stats),
            _ => self.rotated.aim::<P, Q, E>(bodies, a, &mut self.lattice),
        }
        let mut rows = Rows::default();
        let mut wanted = u16::MAX;
        // The children of a that overlap b: only their rows can have a bit.
        if let Link::Inner(node) = a.link() {
            let kernels;
            (wanted, kernels) = if cuts_alone {
                (used_lanes(bodies.a.nodes()[node as usize].children()), 0)
            } else if E::TURNS_BY_PLANES {
                let holder = if is_b_root { (root(b), None) } else { (holder_b, Some(lane_b)) };
                self.rotated.rotate_over(kernel, bodies, a, node, holder, self.stats)
            } else if is_b_root {
                bodies.b.nodes()[root(b) as usize].overlap_hull(kernel, &self.rotated.children.planes)
            } else {
                let holder = &bodies.b.nodes()[holder_b as usize];
                (holder.overlap_column(kernel, &self.rotated.children.planes, lane_b.into()), 1)
            };
            self.stats.kernels += kernels;
            // Half of the visits end here.
            if wanted == 0 {
                return ControlFlow::Continue(None);
            }
        }
        let opened = bodies.opened(a, b);
        match (opened, b.link()) {
            (Descent::Both, Link::Inner(node)) => {
                let kernels;
                (rows, kernels) = bodies.b.nodes()[node as usize].overlap_rows(
                    kernel,
                    &self.rotated.children.planes,
                    wanted,
                );
                self.stats.kernels += kernels;
            }
            (Descent::B, Link::Inner(node)) => {
                if let Link::Inner(node) = a.link() {
                    self.rotated.enclose(kernel, bodies, a, node);
                }
                let Some((_, aimed)) = &self.rotated.aimed else { return ControlFlow::Continue(None) };
                rows.rows[0] = bodies.b.nodes()[node as usize].overlap_aimed(kernel, aimed);
                rows.pending = u32::from(rows.rows[0] != 0);
                self.stats.kernels += 1;
            }
            _ => {
                rows.rows[0] = wanted;
                rows.pending = 1;
            }
        }
        if cuts_alone || opened != Descent::Both && is_worth_cutting(bodies, a, b, rows.rows[0]) {
            let left = self.primitive_cut.cut(kernel, bodies, self.leaves.margin(), (a, b), rows.rows[0]);
            rows.set(0, left);
        }
        self.leaves.decide(kernel, bodies, &mut self.lattice, self.stats, (a, b, opened), &mut rows)?;
        let entry = Visited { volumes: *volumes, opened, rows, looked_at: false };
        ControlFlow::Continue((rows.pending != 0).then_some(entry))
    }
}

/// The node of a link to a root.
#[inline(always)]
fn root(link: Child) -> u32 {
    if let Link::Inner(node) = link.link() { node } else { 0 }
}
