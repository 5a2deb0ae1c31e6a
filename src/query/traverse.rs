//! The simultaneous traversal: both trees descend together, sixteen pairs a step.
//!
//! A **visit** takes two nodes, or a node and a leaf. A's children are turned into B's frame (one
//! re-alignment), the kernel gives a row of bits for each of them, pairs of leaves among the bits are decided
//! at once, and what is left goes on the stack.
//!
//! **Unlike sizes.** Two nodes are opened both at once only if their volumes are of like width. Else a small
//! body would be walked down to its leaves while the other is still at nodes that are larger than all of it:
//! every pair of such leaves and nodes overlaps. So the wider node is opened alone, its children against the
//! narrower volume as a whole, until the two are alike. The widths are in the links ([`Width`]).
//!
//! **Which body is turned.** The one whose planes get less loose by it ([`Header::rotation_growth`]). In a traversal `a` is
//! that body and `b` the one that keeps its frame, whichever of the query's A and B they are: volumes of a are turned by
//! the pose, or by the way back ([`InversePose`]). Only primitives are not alike, since the query is about those of A as the
//! pose moves them: [`Placing`] says which body has to be moved.

use super::ahead::LookAhead;
use super::cut::{Cutter, used_lanes};
use super::hint::Found;
use super::normal_slabs::{LONG, NormalSlabs};
use super::placing::{Margin, Placing, corner_distance};
use super::stack::{ABOVE_ROOT, Descent, FEW, MANY, NOT_VISITED, Next, Rows, Stack, Visited, Volumes};
use super::turned::TurnedChildren;
use super::{Lanes, PrimitivePair, QueryStats};
use crate::hierarchy::BvhRef;
#[cfg(doc)]
use crate::hierarchy::Header;
use crate::kernel::Kernel;
#[cfg(doc)]
use crate::node::Width;
use crate::node::{Child, Link};
use crate::primitive::{Lattice, Primitive};
#[cfg(doc)]
use crate::realign::InversePose;
use crate::realign::PrimitiveSlabs;
use core::ops::{ControlFlow, Range};

/// Why a traversal ended early.
#[derive(Copy, Clone, Debug)]
pub(crate) enum Stop {
    /// The visitor said so.
    Visitor,
    /// The budget is spent. `upper`: the distance of two corners that are still to be looked at.
    Budget { upper: f64 },
}

pub(super) type Flow = ControlFlow<Stop>;

/// What is handed the pairs that meet. Few are, of all that are looked at: a call costs less than a traversal
/// that is compiled once more for each visitor.
pub(super) type Visitor<'v> = &'v mut dyn FnMut(Found) -> ControlFlow<()>;

/// When a traversal ends, and what counts as meeting.
#[derive(Copy, Clone, Debug)]
pub(super) struct Limits<M> {
    pub(super) budget: u64,
    pub(super) margin: M,
}

/// One query under way.
pub(crate) struct Traversal<'t, N: Lanes, P: Primitive, Q: Primitive, E, M: Margin> {
    pub(super) kernel: E,
    pub(super) a: &'t BvhRef<'t, N, P>,
    pub(super) b: &'t BvhRef<'t, N, Q>,
    pub(super) placing: &'t Placing<'t>,
    /// Of the frames that the traversal is in.
    pub(super) map: &'t mut N::Map,
    budget: u64,
    pub(super) margin: M,
    pub(super) stats: &'t mut QueryStats,
    pub(super) visit: Visitor<'t>,
    /// Of the node of A that was turned last. Siblings in B follow each other, so it is often the next one too.
    pub(super) turned: TurnedChildren<N::Turned>,
    /// The leaf or node of A whose volume is descending B's tree, if one did, and its planes.
    pub(super) aimed: Option<(Child, N::Aimed)>,
    /// The leaf that was cutting the other tree's nodes last, and the slabs of its primitive.
    pub(super) cutter: Option<(Cutter, PrimitiveSlabs)>,
    pub(super) thin: NormalSlabs<'t>,
    /// What tells primitives apart that are farther from each other than the margin.
    pub(super) ahead: M::Ahead,
    /// What triangles are tested on, if the kernel says so: none if there is none, once it was asked for.
    pub(super) lattice: Option<Option<Lattice>>,
    /// How many powers of two the unit of A's frame is larger than that of B's.
    pub(super) units: i32,
}

/// A node is opened alone if it is wider than the other by this many powers of two, that is by a factor of 4
/// to 16: below, bodies of like size would be opened in turns, which costs them more visits.
const MUCH_WIDER: i32 = 3;

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
        (a, b): (&'t BvhRef<'t, N, P>, &'t BvhRef<'t, N, Q>),
        placing: &'t Placing<'t>,
        map: &'t mut N::Map,
        Limits { budget, margin }: Limits<M>,
        stats: &'t mut QueryStats,
        visit: Visitor<'t>,
    ) -> Self {
        Self {
            kernel,
            a,
            b,
            placing,
            map,
            budget,
            margin,
            stats,
            visit,
            turned: TurnedChildren { planes: N::UNTURNED, node: Child::EMPTY, whole: 0 },
            aimed: None,
            cutter: None,
            thin: NormalSlabs::default(),
            ahead: M::Ahead::NOTHING,
            lattice: None,
            units: b.frame().exponent - a.frame().exponent,
        }
    }

    /// Visits every pair of primitives that meet.
    // Memory for what waits is got where it is needed: many queries end at the roots, and few get far down.
    #[inline(always)]
    pub(super) fn run(&mut self) -> Flow {
        if self.a.is_empty() || self.b.is_empty() {
            return Flow::Continue(());
        }
        let (a, b) = (self.a.header().root, self.b.header().root);
        let roots = Volumes { a, b, holder_b: ABOVE_ROOT, lane_b: 0 };
        let mut memory = [NOT_VISITED];
        if self.descend(Some(roots), &mut Stack::new(&mut memory, 0))? {
            self.go_on(&memory[0])
        } else {
            Flow::Continue(())
        }
    }

    /// Visits what is below an entry.
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

    /// [`Self::go_on`], with as much memory as trees that were validated can take.
    #[cold]
    #[inline(never)]
    fn go_deep(&mut self, entry: &Visited) -> Flow {
        let mut memory = [NOT_VISITED; MANY];
        memory[0] = *entry;
        let is_full = self.descend(None, &mut Stack::new(&mut memory, 1))?;
        assert!(!is_full, "the trees are deeper than they may be");
        Flow::Continue(())
    }

    /// Visits two volumes, if any, and what waits in the stack, until there is nothing left, or the stack is full: then this is true.
    // One function, whatever the memory, and the gate. One loop with one call of each kernel, so that each is inlined.
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
                        self.look_again(stack);
                    }
                    let Some(bit) = stack.next() else { return ControlFlow::Continue(false) };
                    next = Some(self.below(bit));
                }
            },
        )
    }

    /// The children that a bit on the stack stands for.
    #[inline(always)]
    fn below(&self, Next { volumes, opened, row, bit }: Next) -> Volumes {
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

    /// Whose children are next.
    #[inline(always)]
    fn opened(&self, a: Child, b: Child) -> Descent {
        match (a.link(), b.link()) {
            (Link::Inner(_), Link::Inner(_)) => {
                let excess = a.width().excess(b.width(), -self.units);
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

    pub(super) fn child_a(&self, node: u32, lane: usize) -> Child {
        self.a.nodes()[node as usize].children()[lane]
    }

    pub(super) fn child_b(&self, node: u32, lane: usize) -> Child {
        self.b.nodes()[node as usize].children()[lane]
    }

    /// Visits a pair of which at least one is a node, and says what is still to be visited below.
    #[inline(always)]
    fn step(&mut self, volumes: &Volumes) -> ControlFlow<Stop, Option<Visited>> {
        let Volumes { a, b, holder_b, lane_b } = *volumes;
        if self.stats.visits == self.budget {
            return ControlFlow::Break(Stop::Budget {
                upper: corner_distance((self.a, self.b), self.placing, (a, b)),
            });
        }
        self.stats.visits += 1;
        let is_b_root = holder_b == ABOVE_ROOT;
        let cuts_alone = self.cuts_alone(volumes);
        match a.link() {
            Link::Inner(_) if E::TURNS_BY_PLANES || cuts_alone => {}
            Link::Inner(node) => self.turn(a, node),
            _ => self.aim(a),
        }
        let mut rows = Rows::default();
        let mut wanted = u16::MAX;
        // The children of A that overlap b: only their rows can have a bit.
        if let Link::Inner(node) = a.link() {
            let kernels;
            (wanted, kernels) = if cuts_alone {
                (used_lanes(self.a.nodes()[node as usize].children()), 0)
            } else if E::TURNS_BY_PLANES {
                self.turn_over(a, node, if is_b_root { (root(b), None) } else { (holder_b, Some(lane_b)) })
            } else if is_b_root {
                self.b.nodes()[root(b) as usize].overlap_hull(self.kernel, &self.turned.planes)
            } else {
                let holder = &self.b.nodes()[holder_b as usize];
                (holder.overlap_column(self.kernel, &self.turned.planes, lane_b.into()), 1)
            };
            self.stats.kernels += kernels;
            // Half of the visits end here.
            if wanted == 0 {
                return ControlFlow::Continue(None);
            }
        }
        let opened = self.opened(a, b);
        match (opened, b.link()) {
            (Descent::Both, Link::Inner(node)) => {
                let kernels;
                (rows, kernels) =
                    self.b.nodes()[node as usize].overlap_rows(self.kernel, &self.turned.planes, wanted);
                self.stats.kernels += kernels;
            }
            (Descent::B, Link::Inner(node)) => {
                if let Link::Inner(node) = a.link() {
                    self.enclose(a, node);
                }
                let Some((_, aimed)) = &self.aimed else { return ControlFlow::Continue(None) };
                rows.rows[0] = self.b.nodes()[node as usize].overlap_aimed(self.kernel, aimed);
                rows.pending = u32::from(rows.rows[0] != 0);
                self.stats.kernels += 1;
            }
            _ => {
                rows.rows[0] = wanted;
                rows.pending = 1;
            }
        }
        if cuts_alone || opened != Descent::Both && self.is_worth_cutting(a, b, rows.rows[0]) {
            let left = self.cut(a, b, rows.rows[0]);
            rows.set(0, left);
        }
        self.decide_leaves(a, b, opened, &mut rows)?;
        let entry = Visited { volumes: *volumes, opened, rows, looked_at: false };
        ControlFlow::Continue((rows.pending != 0).then_some(entry))
    }
}

/// The node that a link to a root leads to.
#[inline(always)]
fn root(link: Child) -> u32 {
    if let Link::Inner(node) = link.link() { node } else { 0 }
}

/// The primitives of a leaf.
#[inline(always)]
pub(super) fn primitives(leaf: Link) -> Range<u32> {
    match leaf {
        Link::Leaf { first, count } => first..first + count,
        _ => 0..0,
    }
}

/// The indices of the set bits, ascending.
#[inline(always)]
pub(super) fn bits_of(mut bits: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        bit
    })
}
