//! The distance of two bodies: branch and bound over the same nodes.
//!
//! A **step** takes one volume of one body and a node of the other: the lower bounds of all its children at once ([`super::gaps`]). The
//! bodies take turns, the one with the larger volumes next. Children are followed nearest first; whatever is farther than the best pair of triangles
//! so far is dropped, by a threshold that allows for the tolerance.

use super::frontier::{ABOVE_ROOT, Body, Frame, Stack, VolumeA, VolumeB};
use super::gaps::{Entries, Entry, least};
use super::traverse::moved;
use super::{Completion, Counters, Lanes, Pair};
use crate::exact::round_up_f32;
use crate::frame::Point;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::triangle::Triangle;
use crate::triangle::distance::{Separation, TIGHT, nearer};

/// Nodes of A whose turned planes are kept: the last on each level, levels counted modulo this.
const KEPT: usize = 4;

/// The best pair so far.
#[derive(Copy, Clone, Debug)]
pub(super) struct Best {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) pair: Pair,
    pub(super) points: [Point; 2],
}

#[derive(Debug)]
pub(super) struct Search<'t, N: Lanes, E> {
    kernel: E,
    a: BvhRef<'t, N>,
    b: BvhRef<'t, N>,
    pose: &'t Pose,
    map: N::Map,
    budget: u64,
    tolerance: f64,
    pub(super) counters: Counters,
    pub(super) best: Best,
    /// From the best pair's point of B to that of A: near it, most other pairs are farther apart along this axis.
    axis: Point,
    /// No pair farther apart than this matters, in the bodies' unit and in B's frame.
    threshold: (f64, f32),
    turned: [(Child, N::Query); KEPT],
    /// The leaf of A that was compared last, and its planes from its corners.
    aimed: (Child, N::Query),
    /// Lane 0: all of B.
    whole_b: N,
}

impl<'t, N: Lanes, E: Kernel> Search<'t, N, E> {
    /// For bodies that are not empty.
    pub(super) fn new(
        kernel: E,
        a: BvhRef<'t, N>,
        b: BvhRef<'t, N>,
        pose: &'t Pose,
        budget: u64,
        tolerance: f64,
    ) -> Self {
        let nowhere = Best {
            lower: f64::INFINITY,
            upper: f64::INFINITY,
            pair: Pair { a: 0, b: 0 },
            points: [[0.0; 3]; 2],
        };
        let mut search = Self {
            kernel,
            a,
            b,
            pose,
            map: N::map(pose, a.header(), &b.frame()),
            budget,
            tolerance: if tolerance > TIGHT { tolerance } else { TIGHT },
            counters: Counters::default(),
            best: nowhere,
            axis: [0.0; 3],
            threshold: (f64::INFINITY, f32::INFINITY),
            turned: [(Child::EMPTY, N::NO_QUERY); KEPT],
            aimed: (Child::EMPTY, N::NO_QUERY),
            whole_b: b.nodes()[0].hull(),
        };
        search.start_with_corners();
        search
    }

    /// Two corners make the first upper bound.
    fn start_with_corners(&mut self) {
        let (p, q) = (self.moved(0)[0], self.b.triangle(0)[0]);
        let distance = glam::DVec3::from_array(p).distance(glam::DVec3::from_array(q));
        let points = [p, q];
        let pair = Pair { a: self.a.source(0), b: self.b.source(0) };
        // Two corners that coincide meet, and nothing else has this distance.
        self.improve(Best {
            lower: f64::INFINITY,
            upper: distance * (1.0 + 8.0 * f64::EPSILON),
            pair,
            points,
        });
    }

    fn improve(&mut self, best: Best) {
        let lower = self.best.lower.min(best.lower);
        self.best = Best { lower, ..best };
        let [p, q] = best.points;
        self.axis = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let threshold = best.upper / (1.0 + self.tolerance);
        self.threshold = (threshold, { let t = threshold * self.b.frame().scale(); round_up_f32(t * t * (1.0 + 1e-15)) });
    }

    /// Searches until nothing is left that could be nearer, or the budget is spent. Then [`Best::lower`] bounds the bodies' distance.
    #[inline(always)]
    pub(super) fn run(&mut self) -> Completion {
        let mut stack = Stack::new();
        let root_a = VolumeA { child: Child::ROOT, parent: Child::EMPTY, lane: 0, level: 0 };
        let root_b = VolumeB { child: Child::ROOT, parent: ABOVE_ROOT, lane: 0, level: 0 };
        let mut next = Some((root_a, root_b, 0.0));
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
                let opened = if is_leaf(b.child) || (!is_leaf(a.child) && a.level <= b.level) {
                    Body::A
                } else {
                    Body::B
                };
                let entries = if opened == Body::A { self.open_a(&a, &b) } else { self.open_b(&a, &b) };
                stack.push(Frame { entries, a, b, opened });
            }
            next = loop {
                let Some(frame) = stack.top() else { break None };
                let entry = least(&frame.entries);
                if entry == Entry::NONE || entry.bound() > self.threshold.1 || self.best.upper == 0.0 {
                    stack.pop();
                    continue;
                }
                let lane = entry.lane();
                frame.entries[lane] = Entry::NONE;
                break Some(self.child(frame, lane, entry.bound()));
            };
        }
        self.best.lower = self.certain();
        Completion::Complete
    }

    /// Every pair of triangles that was dropped or seen is at least this far apart.
    fn certain(&self) -> f64 {
        self.best.lower.min(self.threshold.0)
    }

    /// A bound in B's frame, in the bodies' unit.
    fn in_unit(&self, bound: f32) -> f64 {
        libm::sqrt(f64::from(bound)) / self.b.frame().scale()
    }

    /// The volumes that a lane of a frame stands for.
    #[inline(always)]
    fn child(&self, frame: &Frame, lane: usize, bound: f32) -> (VolumeA, VolumeB, f32) {
        let (a, b) = (frame.a, frame.b);
        match (frame.opened, a.child.link(), b.child.link()) {
            (Body::A, Link::Inner(node), _) => {
                let child = self.a.nodes()[node as usize].children()[lane];
                (VolumeA { child, parent: a.child, lane: lane as u8, level: a.level + 1 }, b, bound)
            }
            (Body::B, _, Link::Inner(node)) => {
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
        let (query, lane) = if let Link::Leaf { first, count } = a.child.link() {
            self.aim(a.child, first, count);
            (&self.aimed.1, 0)
        } else {
            // The volume has a parent: the root of A is opened before anything of B.
            let slot = self.turn(a.parent, a.level - 1);
            (&self.turned[slot].1, a.lane.into())
        };
        self.counters.kernels += 1;
        self.b.nodes()[node as usize].gaps_of_node(query, lane)
    }

    /// Where the planes of the children of node `a` are, turned into B's frame.
    #[inline(always)]
    fn turn(&mut self, a: Child, level: u8) -> usize {
        let slot = usize::from(level) % KEPT;
        if self.turned[slot].0 != a
            && let Link::Inner(node) = a.link()
        {
            self.counters.realignments += 1;
            self.turned[slot] = (a, self.a.nodes()[node as usize].realign(self.kernel, &self.map));
        }
        slot
    }

    #[inline(always)]
    fn aim(&mut self, leaf: Child, first: u32, count: u32) {
        if self.aimed.0 != leaf {
            let (body, pose) = (&self.a, self.pose);
            let triangles = (first..first + count).map(|index| moved(body, pose, index));
            N::aim(&mut self.aimed.1, &self.b.frame(), triangles, 0.0);
            self.aimed.0 = leaf;
        }
    }

    /// Every triangle of one leaf against every triangle of the other.
    #[inline(always)]
    fn decide(&mut self, a: Child, b: Child) {
        let (Link::Leaf { first: i, count: m }, Link::Leaf { first: j, count: n }) = (a.link(), b.link())
        else {
            return;
        };
        for i in i..i + m {
            let moved = self.moved(i);
            for j in j..j + n {
                self.counters.triangle_pairs += 1;
                let still = self.b.triangle(j);
                if let Some(found) = nearer(
                    &moved,
                    &still,
                    &self.axis,
                    self.threshold.0,
                    self.tolerance,
                    &mut self.counters.exact_pairs,
                ) {
                    self.note(i, j, &found);
                }
            }
        }
    }

    #[inline(always)]
    fn note(&mut self, i: u32, j: u32, found: &Separation) {
        if found.upper < self.best.upper {
            let pair = Pair { a: self.a.source(i), b: self.b.source(j) };
            self.improve(Best { lower: found.lower, upper: found.upper, pair, points: [found.a, found.b] });
        } else {
            self.best.lower = self.best.lower.min(found.lower);
        }
    }

    #[inline(always)]
    fn moved(&self, index: u32) -> Triangle {
        moved(&self.a, self.pose, index)
    }
}
