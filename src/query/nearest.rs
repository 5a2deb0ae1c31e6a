//! The distance of two bodies: branch and bound over the same nodes.
//!
//! A **step** takes one volume of one body and a node of the other: the lower bounds of all its children at
//! once ([`super::gaps`]). The bodies take turns, the one with the larger volumes next. Children are followed
//! nearest first; whatever is farther than the best pair of primitives so far is dropped, by a threshold that
//! allows for the tolerance.

use super::frontier::{ABOVE_ROOT, Frontier, Opened, Side, VolumeA, VolumeB};
use super::gaps::{Entries, Entry, least};
use super::hint::Found;
use super::leaf::{Ahead, LeafA};
use super::{Completion, Counters, Lanes, Pairwise, Query};
use crate::exact::round_up_f32;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::primitive::{Primitive, Separation};
use crate::range::Point;

/// Nodes of A whose turned planes are kept: the last on each level, levels counted modulo this.
const KEPT: usize = 4;

/// The best pair so far.
#[derive(Copy, Clone, Debug)]
pub(super) struct Best {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) found: Found,
    pub(super) points: [Point; 2],
}

/// No pair farther apart than this matters.
#[derive(Copy, Clone, Debug)]
struct Threshold {
    /// In the bodies' unit.
    distance: f64,
    /// In B's frame, squared, rounded up: as the bounds of volumes are.
    square: f32,
    ahead: Ahead,
}

#[derive(Debug)]
pub(super) struct Search<'t, N: Lanes, P: Primitive, Q: Primitive, E> {
    kernel: E,
    pub(super) a: BvhRef<'t, N, P>,
    pub(super) b: BvhRef<'t, N, Q>,
    pose: &'t Pose,
    map: N::Map,
    budget: u64,
    tolerance: f64,
    /// Bounds all coordinates.
    reach: f64,
    pub(super) counters: Counters,
    pub(super) best: Best,
    threshold: Threshold,
    turned: [(Child, N::Turned); KEPT],
    leaf: LeafA<N, P>,
    /// Lane 0: all of B.
    whole_b: N,
}

impl<'t, N: Lanes, P: Pairwise<Q>, Q: Primitive, E: Kernel> Search<'t, N, P, Q, E> {
    /// For bodies that are not empty.
    pub(super) fn new(
        kernel: E,
        a: BvhRef<'t, N, P>,
        b: BvhRef<'t, N, Q>,
        pose: &'t Pose,
        query: &Query,
        tolerance: f64,
    ) -> Self {
        let Found { a: i, b: j } = query.hint.pair(a.len(), b.len()).unwrap_or(Found { a: 0, b: 0 });
        let mut counters = Counters { primitive_pairs: 1, ..Counters::default() };
        let (moved, still) = (P::moved(&a.primitive(i), pose), b.primitive(j));
        let first = P::nearer(&moved, &still, f64::INFINITY, tolerance, &mut counters.exact_pairs);
        let mut search = Self {
            kernel,
            a,
            b,
            pose,
            map: N::map(pose, &a.extent(), &b.frame()),
            budget: query.budget,
            tolerance,
            reach: (4.0 * a.extent().max_coordinate + greatest(&pose.translation()))
                + b.extent().max_coordinate,
            counters,
            best: Best {
                lower: f64::INFINITY,
                upper: f64::INFINITY,
                found: Found { a: i, b: j },
                points: [[0.0; 3]; 2],
            },
            threshold: Threshold { distance: f64::INFINITY, square: f32::INFINITY, ahead: Ahead::NOTHING },
            turned: [(Child::EMPTY, N::NO_TURNED); KEPT],
            leaf: LeafA::none(),
            whole_b: b.nodes()[0].hull(),
        };
        if let Some(first) = first {
            search.note(Found { a: i, b: j }, &first);
        }
        search
    }

    fn note(&mut self, found: Found, pair: &Separation) {
        let lower = self.best.lower.min(pair.lower);
        if pair.upper < self.best.upper {
            self.best = Best { lower, upper: pair.upper, found, points: [pair.a, pair.b] };
            let distance = pair.upper / (1.0 + self.tolerance);
            let scaled = distance * self.b.frame().scale();
            let [p, q] = self.best.points;
            let axis = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
            self.threshold = Threshold {
                distance,
                square: round_up_f32(scaled * scaled * (1.0 + 8.0 * f64::EPSILON)),
                ahead: Ahead::new(axis, distance, self.reach),
            };
        } else {
            self.best.lower = lower;
        }
    }

    /// Searches until nothing is left that could be nearer, or the budget is spent. Then [`Best::lower`]
    /// bounds the bodies' distance.
    #[inline(always)]
    pub(super) fn run(&mut self) -> Completion {
        let mut stack = Frontier::new();
        let root_a = VolumeA { child: Child::ROOT, parent: Child::EMPTY, lane: 0, level: 0 };
        let root_b = VolumeB { child: Child::ROOT, parent: ABOVE_ROOT, lane: 0, level: 0 };
        let mut next = (self.best.upper > 0.0).then_some((root_a, root_b, 0.0));
        while let Some((a, b, bound)) = next {
            let is_leaf = |child: Child| matches!(child.link(), Link::Leaf { .. });
            if is_leaf(a.child) && is_leaf(b.child) {
                self.decide(a.child, b.child);
            } else {
                if self.counters.visits == self.budget {
                    let pending = stack.least().map_or(bound, |least| least.min(bound));
                    self.best.lower = self.in_unit(pending).min(self.certain());
                    return Completion::OutOfBudget;
                }
                self.counters.visits += 1;
                // A leaf can only wait for the other; of two nodes the one on the higher level is opened.
                let body = if is_leaf(b.child) || (!is_leaf(a.child) && a.level <= b.level) {
                    Side::A
                } else {
                    Side::B
                };
                let entries = if body == Side::A { self.open_a(&a, &b) } else { self.open_b(&a, &b) };
                stack.push(Opened { entries, a, b, body });
            }
            next = loop {
                let Some(step) = stack.top() else { break None };
                let entry = least(&step.entries);
                if entry == Entry::NONE || entry.square() > self.threshold.square || self.best.upper == 0.0 {
                    stack.pop();
                    continue;
                }
                let lane = entry.lane();
                step.entries[lane] = Entry::NONE;
                break Some(self.child(step, lane, entry.square()));
            };
        }
        self.best.lower = self.certain();
        Completion::Complete
    }

    /// Every pair of primitives that was dropped or seen is at least this far apart.
    fn certain(&self) -> f64 {
        self.best.lower.min(self.threshold.distance)
    }

    /// A bound in the bodies' unit.
    fn in_unit(&self, square: f32) -> f64 {
        libm::sqrt(f64::from(square)) / self.b.frame().scale()
    }

    /// The volumes that a lane of a step stands for.
    #[inline(always)]
    fn child(&self, step: &Opened, lane: usize, bound: f32) -> (VolumeA, VolumeB, f32) {
        let (a, b) = (step.a, step.b);
        match (step.body, a.child.link(), b.child.link()) {
            (Side::A, Link::Inner(node), _) => {
                let child = self.a.nodes()[node as usize].children()[lane];
                (VolumeA { child, parent: a.child, lane: lane as u8, level: a.level + 1 }, b, bound)
            }
            (Side::B, _, Link::Inner(node)) => {
                let child = self.b.nodes()[node as usize].children()[lane];
                (a, VolumeB { child, parent: node, lane: lane as u8, level: b.level + 1 }, bound)
            }
            _ => (a, b, bound),
        }
    }

    /// The children of node `a` against volume `b`.
    #[inline(always)]
    fn open_a(&mut self, a: &VolumeA, b: &VolumeB) -> Entries {
        let slot = self.turn(a.child, a.level);
        let Link::Inner(node) = a.child.link() else { return [Entry::NONE; 16] };
        self.counters.kernels += 1;
        let holder = if b.parent == ABOVE_ROOT { &self.whole_b } else { &self.b.nodes()[b.parent as usize] };
        self.a.nodes()[node as usize].gaps_of_query(&self.turned[slot].1, holder, b.lane.into())
    }

    /// Volume `a` against the children of node `b`.
    #[inline(always)]
    fn open_b(&mut self, a: &VolumeA, b: &VolumeB) -> Entries {
        let Link::Inner(node) = b.child.link() else { return [Entry::NONE; 16] };
        self.counters.kernels += 1;
        if let Link::Leaf { .. } = a.child.link() {
            let lows = self.leaf.lows(&self.a, &self.b.frame(), self.pose, a.child, self.reach);
            return self.b.nodes()[node as usize].gaps_of_lows(lows);
        }
        // The volume has a parent: the root of A is opened before anything of B.
        let slot = self.turn(a.parent, a.level - 1);
        self.b.nodes()[node as usize].gaps_of_node(&self.turned[slot].1, a.lane.into())
    }

    /// Where the planes of the children of node `a` are, turned into B's frame.
    #[inline(always)]
    fn turn(&mut self, a: Child, level: u8) -> usize {
        let slot = usize::from(level) % KEPT;
        if self.turned[slot].0 != a
            && let Link::Inner(node) = a.link()
        {
            self.counters.realignments += 1;
            self.turned[slot].0 = a;
            self.a.nodes()[node as usize].realign(self.kernel, &self.map, &mut self.turned[slot].1);
        }
        slot
    }

    /// Every primitive of one leaf against every primitive of the other.
    #[inline(always)]
    fn decide(&mut self, a: Child, b: Child) {
        let (Link::Leaf { first: i, count: m }, Link::Leaf { first: j, count: n }) = (a.link(), b.link())
        else {
            return;
        };
        for k in 0..m {
            let moved = self.leaf.items(&self.a, self.pose, a)[k as usize];
            for j in j..j + n {
                self.counters.primitive_pairs += 1;
                let still = self.b.primitive(j);
                if self.threshold.ahead.is_far::<P, Q>(&moved, &still) {
                    continue;
                }
                let exact = &mut self.counters.exact_pairs;
                if let Some(pair) = P::nearer(&moved, &still, self.threshold.distance, self.tolerance, exact)
                {
                    self.note(Found { a: i + k, b: j }, &pair);
                }
            }
        }
    }
}

/// The greatest magnitude of a coordinate.
fn greatest(p: &Point) -> f64 {
    p[0].abs().max(p[1].abs()).max(p[2].abs())
}
