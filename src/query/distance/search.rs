//! The distance of two bodies: branch and bound over the same nodes.
//!
//! A **step** opens a node of one body and computes the lower bounds between all of its children and a volume of the
//! other body at once ([`super::bounds`]). It opens the node on the higher level, unless the other is much wider.
//! Children are visited nearest first. Pairs farther apart than a threshold are dropped: the distance of the best pair
//! of primitives so far, less the tolerance, or a margin.

use super::bounds::{Bounds, Kept, growths, no_turned};
use super::frontier::{Frontier, Opened, VolumeA, VolumeB};
use super::leaf::{LeafA, Threshold};
use super::steps;
use crate::hierarchy::BvhRef;
use crate::isa::Scalar;
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::primitive::{Primitive, Separation};
use crate::query::entry::{Completion, Found, PrimitivePair, Query, QueryStats};
use crate::query::lanes::{Entries, Entry, Lanes, PrimitiveGaps, least, weight};
use crate::query::setup::{ABOVE_ROOT, Ahead, Cutter, LookAhead, Side, first_primitive, is_near, reach};
use crate::range::Point;
use crate::realign::shrinkage;

/// The goal of a search.
#[derive(Copy, Clone, Debug)]
pub(super) enum Goal {
    /// The distance, until its bounds differ by `tolerance` relatively, or it is at least the cutoff.
    Distance { tolerance: f64, cutoff: f64 },
    /// Two primitives that are at most this far apart.
    Within { margin: f64 },
}

/// The best pair so far.
#[derive(Copy, Clone, Debug)]
pub(super) struct Best {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) found: Found,
    pub(super) points: [Point; 2],
}

/// The result of a search.
#[derive(Debug)]
pub(super) struct Outcome {
    pub(super) completion: Completion,
    /// The best pair. Its `lower` bounds the bodies' distance.
    pub(super) best: Best,
    /// Two primitives within the margin.
    pub(super) hit: Option<Found>,
    pub(super) stats: QueryStats,
}

#[derive(Debug)]
pub(super) struct Search<'t, N: Lanes, P: Primitive, Q: Primitive, E: Kernel> {
    kernel: E,
    pub(super) a: BvhRef<'t, N, P>,
    pub(super) b: BvhRef<'t, N, Q>,
    pub(super) pose: &'t Pose,
    pub(super) bounds: Bounds<'t, N>,
    budget: u64,
    pub(super) goal: Goal,
    /// Bounds all coordinates.
    reach: f64,
    pub(super) stats: QueryStats,
    best: Best,
    hit: Option<Found>,
    pub(super) threshold: Threshold,
    /// The primitive gaps of the last leaf that was pending against a node of the other tree.
    pub(super) primitive_gaps: Option<(Cutter, PrimitiveGaps)>,
    pub(super) leaf: LeafA<N, P>,
    /// A node whose lane 0 is the hull of B.
    whole_b: N,
    /// Converts the widths of A and of B to a common unit.
    pub(super) growths: [f32; 2],
}

/// Searches bodies that are not empty.
#[inline(never)]
pub(super) fn search<N: Lanes, P: PrimitivePair<Q>, Q: Primitive, E: Kernel>(
    kernel: E,
    a: BvhRef<'_, N, P>,
    b: BvhRef<'_, N, Q>,
    pose: &Pose,
    query: &Query,
    goal: Goal,
) -> Outcome {
    kernel.run(
        #[inline(always)]
        || {
            let mut kept = no_turned::<N>();
            let mut search = Search::new(kernel, a, b, pose, query, goal, &mut kept);
            let completion = search.run(query.hint.pair(a.len(), b.len()));
            let Search { best, hit, stats, .. } = search;
            Outcome { completion, best, hit, stats }
        },
    )
}

/// Primitive slabs are tested if children with at least this total weight are within the threshold ([`weight`]).
const WORTH_RAISING: usize = 16;
/// With a margin, primitive slabs are tested only from this visit on, since the first pair of primitives usually
/// decides earlier.
const FIRST_VISITS: u64 = 12;

impl<'t, N: Lanes, P: PrimitivePair<Q>, Q: Primitive, E: Kernel> Search<'t, N, P, Q, E> {
    #[inline(always)]
    fn new(
        kernel: E,
        a: BvhRef<'t, N, P>,
        b: BvhRef<'t, N, Q>,
        pose: &'t Pose,
        query: &Query,
        goal: Goal,
        kept: &'t mut Kept<N>,
    ) -> Self {
        let bounds = Bounds::new::<P>(pose, &a.extent(), &b.extent(), kept);
        let (Goal::Distance { cutoff: distance, .. } | Goal::Within { margin: distance }) = goal;
        let bound = bounds.of_distance(distance);
        Self {
            kernel,
            a,
            b,
            pose,
            bounds,
            budget: query.budget(),
            goal,
            reach: reach(&a, &b, pose),
            stats: QueryStats::default(),
            best: Best {
                lower: f64::INFINITY,
                upper: f64::INFINITY,
                found: Found { a: 0, b: 0 },
                points: [[0.0; 3]; 2],
            },
            hit: None,
            threshold: Threshold { distance, bound, ahead: Ahead::NOTHING },
            primitive_gaps: None,
            leaf: LeafA::none(),
            whole_b: b.nodes()[0].hull(),
            growths: growths(&a.extent(), &b.extent()),
        }
    }

    /// The pair of primitives to test before all others: the hint's. A distance search without a cutoff needs one.
    #[inline(always)]
    fn first(&self, hint: Option<Found>) -> Option<Found> {
        let first = match self.goal {
            Goal::Distance { cutoff: f64::INFINITY, .. } => Some(Found { a: 0, b: 0 }),
            _ => None,
        };
        hint.or(first)
    }

    /// Whether the search can end.
    const fn is_over(&self) -> bool {
        self.best.upper == 0.0 || self.hit.is_some()
    }

    /// Tests a pair of primitives.
    #[inline(always)]
    fn test(&mut self, found: Found, moved: &P::Item) {
        self.stats.primitive_pairs += 1;
        let still = self.b.primitive(found.b);
        if self.threshold.ahead.is_far::<P, Q>(moved, &still) {
            return;
        }
        let exact = &mut self.stats.exact_pairs;
        match self.goal {
            Goal::Distance { tolerance, cutoff } => {
                // The pair may be beyond the threshold. A pair beyond the cutoff is no better than the dropped pairs,
                // and must not raise the threshold.
                let limit = self.threshold.distance;
                let pair = P::nearer_on(self.kernel, moved, &still, limit, tolerance, exact);
                if let Some(pair) = pair.filter(|pair| pair.lower < cutoff) {
                    self.note(found, &pair, tolerance, cutoff);
                }
            }
            Goal::Within { margin } => {
                let ahead = &mut self.threshold.ahead;
                if is_near::<P, Q, _>(moved, &still, (margin, self.reach, ahead), exact) {
                    self.hit = Some(found);
                }
            }
        }
    }

    fn note(&mut self, found: Found, pair: &Separation, tolerance: f64, cutoff: f64) {
        let lower = self.best.lower.min(pair.lower);
        if pair.upper < self.best.upper {
            self.best = Best { lower, upper: pair.upper, found, points: [pair.a, pair.b] };
            let distance = (pair.upper / (1.0 + tolerance)).min(cutoff);
            (self.threshold.distance, self.threshold.bound) = (distance, self.bounds.of_distance(distance));
            self.threshold.look_along(self.best.points, self.reach);
        } else {
            self.best.lower = lower;
        }
    }

    /// Searches until nothing nearer can remain, or the budget is spent. Then [`Best::lower`] bounds the bodies'
    /// distance.
    #[inline(always)]
    fn run(&mut self, hint: Option<Found>) -> Completion {
        let mut stack = Frontier::new();
        // The root of A is opened first: no node holds its planes.
        let root_a =
            VolumeA { child: Child::ROOT, parent: Child::EMPTY, lane: 0, level: 0, width: f32::INFINITY };
        let width = self.whole_b.width(0, self.growths[1]);
        let root_b = VolumeB { child: Child::ROOT, parent: ABOVE_ROOT, lane: 0, level: 0, width };
        let least_bound = self.bounds.least();
        let mut roots = Some((root_a, root_b, least_bound));
        // As leaves, so that the test of two primitives is compiled once.
        let first = self.first(hint).map(|Found { a, b }| {
            let a = VolumeA { child: Child::leaf(a, 1), ..root_a };
            (a, VolumeB { child: Child::leaf(b, 1), ..root_b }, least_bound)
        });
        let mut next = first.or_else(|| roots.take());
        while let Some((a, b, bound)) = next {
            let is_leaf = |child: Child| matches!(child.link(), Link::Leaf { .. });
            if is_leaf(a.child) && is_leaf(b.child) {
                self.decide(a.child, b.child);
            } else {
                if self.stats.visits == self.budget {
                    self.give_up(stack.least().map_or(bound, |least| least.min(bound)), a.child, b.child);
                    return Completion::OutOfBudget;
                }
                self.stats.visits += 1;
                let body =
                    if is_leaf(b.child) || (!is_leaf(a.child) && a.is_next(&b)) { Side::A } else { Side::B };
                let entries = if body == Side::A { self.open_a(&a, &b) } else { self.open_b(&a, &b) };
                stack.push(Opened { entries, a, b, body });
                if self.growths[0] > 0.0
                    && let Some(step) = stack.top()
                {
                    self.raise(step);
                }
            }
            next = loop {
                let Some(step) = stack.top() else {
                    break roots.take().filter(|_| !self.is_over());
                };
                let entry = least(&step.entries);
                if entry == Entry::NONE || entry.bound() > self.threshold.bound || self.is_over() {
                    stack.pop();
                    continue;
                }
                let lane = entry.lane();
                step.entries[lane] = Entry::NONE;
                break Some(self.child(step, lane, entry.bound()));
            };
        }
        self.best.lower = self.certain();
        Completion::Complete
    }

    /// Lower bound of the distances of all pairs of primitives that were dropped or tested.
    fn certain(&self) -> f64 {
        self.best.lower.min(self.threshold.distance)
    }

    /// Ends the search with volumes pending, whose least bound is `pending`; `a` and `b` are among them.
    fn give_up(&mut self, pending: f32, a: Child, b: Child) {
        self.best.lower = self.bounds.distance(pending).min(self.certain());
        if let Goal::Within { .. } = self.goal {
            self.best.upper = distance_of_some((&self.a, &self.b), self.pose, (a, b));
        }
    }

    /// The pair of volumes of a lane of a step.
    #[inline(always)]
    fn child(&self, step: &Opened, lane: usize, bound: f32) -> (VolumeA, VolumeB, f32) {
        let (a, b) = (step.a, step.b);
        match (step.body, a.child.link(), b.child.link()) {
            (Side::A, Link::Inner(at), _) => {
                let node = &self.a.nodes()[at as usize];
                let (child, width) = (node.children()[lane], node.width(lane, self.growths[0]));
                (VolumeA { child, parent: a.child, lane: lane as u8, level: a.level + 1, width }, b, bound)
            }
            (Side::B, _, Link::Inner(node)) => {
                let holder = &self.b.nodes()[node as usize];
                let (child, width) = (holder.children()[lane], holder.width(lane, self.growths[1]));
                (a, VolumeB { child, parent: node, lane: lane as u8, level: b.level + 1, width }, bound)
            }
            _ => (a, b, bound),
        }
    }

    /// Lower bounds between the children of node `a` and volume `b`.
    #[inline(always)]
    fn open_a(&mut self, a: &VolumeA, b: &VolumeB) -> Entries {
        let Link::Inner(node) = a.child.link() else { return [Entry::NONE; 16] };
        self.stats.kernels += 1;
        let (node, lane) = (&self.a.nodes()[node as usize], usize::from(b.lane));
        let holder = if b.parent == ABOVE_ROOT { &self.whole_b } else { &self.b.nodes()[b.parent as usize] };
        match &mut self.bounds {
            Bounds::Near(near) => {
                let growth = near.growth;
                let rows = near.turn(self.kernel, &self.a, a.child, a.level, &mut self.stats);
                node.gaps_of_rows(rows, holder, lane, growth)
            }
            Bounds::Far(line) => {
                steps::gaps_along(self.kernel, node, &line.a, holder.reach_along(&line.b, lane))
            }
        }
    }

    /// Lower bounds between volume `a` and the children of node `b`.
    #[inline(always)]
    fn open_b(&mut self, a: &VolumeA, b: &VolumeB) -> Entries {
        let Link::Inner(node) = b.child.link() else { return [Entry::NONE; 16] };
        self.stats.kernels += 1;
        let (node, lane) = (&self.b.nodes()[node as usize], usize::from(a.lane));
        // A volume that is no leaf has a parent: the root of A is opened before anything of B.
        match (&mut self.bounds, a.child.link(), a.parent.link()) {
            (Bounds::Near(near), Link::Leaf { .. }, _) => {
                let planes = self.leaf.planes(&self.a, &near.frame, self.pose, a.child, self.reach);
                node.gaps_of_planes(planes, near.growth)
            }
            (Bounds::Near(near), ..) => {
                let growth = near.growth;
                let rows = near.turn(self.kernel, &self.a, a.parent, a.level - 1, &mut self.stats);
                node.gaps_of_planes(&N::planes_in(rows, lane), growth)
            }
            (Bounds::Far(line), Link::Inner(_), Link::Inner(parent)) => {
                let reach = self.a.nodes()[parent as usize].reach_along(&line.a, lane);
                steps::gaps_along(self.kernel, node, &line.b, reach)
            }
            (Bounds::Far(line), ..) => {
                let reach = self.leaf.reach(&self.a, &self.b.frame(), self.pose, a.child, line);
                steps::gaps_along(self.kernel, node, &line.b, reach)
            }
        }
    }

    /// Tests every primitive of one leaf against every primitive of the other.
    #[inline(always)]
    fn decide(&mut self, a: Child, b: Child) {
        let (Link::Leaf { first: i, count: m }, Link::Leaf { first: j, count: n }) = (a.link(), b.link())
        else {
            return;
        };
        for k in 0..m {
            let moved = self.leaf.items(&self.a, self.pose, a)[k as usize];
            for j in j..j + n {
                self.test(Found { a: i + k, b: j }, &moved);
                if self.hit.is_some() {
                    return;
                }
            }
        }
    }

    /// Raises the bounds of a step by primitive slabs if a pending leaf is wider than the node that was opened. Bodies
    /// of similar size, for which no widths are computed, have too few such steps for the test to pay.
    #[inline(always)]
    pub(super) fn raise(&mut self, step: &mut Opened) {
        let first_visits = if let Goal::Within { .. } = self.goal { FIRST_VISITS } else { 0 };
        if self.stats.visits < first_visits {
            return;
        }
        let (leaf, node, widths) = match (step.a.child.link(), step.b.child.link()) {
            (Link::Leaf { first, count: 1 }, Link::Inner(node)) => {
                (Cutter::A(first), &self.b.nodes()[node as usize], (step.a.width, step.b.width))
            }
            (Link::Inner(node), Link::Leaf { first, count: 1 }) => {
                (Cutter::B(first), &self.a.nodes()[node as usize], (step.b.width, step.a.width))
            }
            _ => return,
        };
        if widths.0 < widths.1 || weight(&step.entries, self.threshold.bound, node.children()) < WORTH_RAISING
        {
            return;
        }
        let gaps = match self.primitive_gaps {
            Some((last, gaps)) if last == leaf => gaps,
            _ => {
                let Bounds::Near(near) = &self.bounds else { return };
                let gaps = match leaf {
                    Cutter::A(_) => {
                        let others = self.b.extent();
                        let item = &self.leaf.items(&self.a, self.pose, step.a.child)[0];
                        let slabs = N::primitive_slabs::<P>(item, 0.0, &others, None);
                        PrimitiveGaps::new::<P>(item, slabs, near.growth_in(&others.frame))
                    }
                    Cutter::B(index) => {
                        let others = self.a.extent();
                        let (item, margin) = (&self.b.primitive(index), shrinkage::<P>(self.pose, &others));
                        let growth = near.growth_in(&others.frame);
                        let slabs = N::primitive_slabs::<Q>(item, margin, &others, Some(self.pose));
                        PrimitiveGaps::new::<Q>(item, slabs, growth)
                    }
                };
                self.primitive_gaps = Some((leaf, gaps));
                gaps
            }
        };
        steps::raise(self.kernel, node, &mut step.entries, &gaps);
    }
}

/// Upper bound of the distance of a primitive below volume `a` and one below `b`.
#[cold]
#[inline(never)]
fn distance_of_some<N: Lanes, P: PrimitivePair<Q>, Q: Primitive>(
    trees: (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    pose: &Pose,
    (a, b): (Child, Child),
) -> f64 {
    let moved = P::moved(&trees.0.primitive(first_primitive(trees.0, a.link())), pose);
    let still = trees.1.primitive(first_primitive(trees.1, b.link()));
    let pair = P::nearer_on(Scalar::new(), &moved, &still, f64::INFINITY, 1.0, &mut 0);
    pair.map_or(f64::INFINITY, |pair| pair.upper)
}
