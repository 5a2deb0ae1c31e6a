//! The simultaneous traversal: both trees descend together, sixteen pairs a step.

use super::stack::{SingleStack, Stack};
use super::{Counters, Lanes, Pair};
use crate::frame::Point;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::{Child, Link, MAX_LEAF_SIZE};
use crate::pose::Pose;
use crate::triangle::{self, Triangle};
use core::ops::ControlFlow;

/// Why a traversal ended early.
#[derive(Copy, Clone, Debug)]
pub(crate) enum Stop {
    /// The visitor said so.
    Visitor,
    /// The budget is spent. `upper`: the distance of two corners that are still to be looked at.
    Budget { upper: f64 },
}

type Flow = ControlFlow<Stop>;

/// A range of triangles.
#[derive(Copy, Clone, Debug)]
struct Leaf {
    first: u32,
    count: u32,
}

/// One query under way.
#[derive(Debug)]
pub(crate) struct Traversal<'t, N: Lanes, E, V> {
    kernel: E,
    a: BvhRef<'t, N>,
    b: BvhRef<'t, N>,
    pose: &'t Pose,
    map: N::Map,
    budget: u64,
    pub(crate) counters: Counters,
    visit: V,
}

impl<'t, N: Lanes, E: Kernel, V: FnMut(Pair) -> ControlFlow<()>> Traversal<'t, N, E, V> {
    pub(crate) fn new(
        kernel: E,
        a: BvhRef<'t, N>,
        b: BvhRef<'t, N>,
        pose: &'t Pose,
        budget: u64,
        visit: V,
    ) -> Self {
        let map = N::map(pose, a.header(), &b.frame());
        Self { kernel, a, b, pose, map, budget, counters: Counters::default(), visit }
    }

    /// Visits every pair of triangles that meet.
    #[inline(always)]
    pub(crate) fn run(&mut self) -> Flow {
        if self.a.is_empty() || self.b.is_empty() {
            return Flow::Continue(());
        }
        let mut stack = Stack::new();
        self.expand(&mut stack, 0, 0)?;
        while let Some([(node_a, lane_a), (node_b, lane_b)]) = stack.next() {
            let child_a = self.a.nodes()[node_a as usize].children()[lane_a];
            let child_b = self.b.nodes()[node_b as usize].children()[lane_b];
            match (child_a.link(), child_b.link()) {
                (Link::Inner(a), Link::Inner(b)) => self.expand(&mut stack, a, b)?,
                (Link::Leaf { first, count }, Link::Inner(b)) => self.descend_b(Leaf { first, count }, b)?,
                (Link::Inner(a), Link::Leaf { first, count }) => {
                    self.descend_a(a, (node_b, lane_b), Leaf { first, count })?;
                }
                (Link::Leaf { first: a, count: n }, Link::Leaf { first: b, count: m }) => {
                    self.leaves(Leaf { first: a, count: n }, Leaf { first: b, count: m })?;
                }
                // No kernel reports an unused lane, and unused lanes of A are masked.
                (Link::Empty, _) | (_, Link::Empty) => {}
            }
        }
        Flow::Continue(())
    }

    /// All children of node `a` against all children of node `b`.
    #[inline(always)]
    fn expand(&mut self, stack: &mut Stack, a: u32, b: u32) -> Flow {
        self.spend(Link::Inner(a), Link::Inner(b))?;
        let node_a = &self.a.nodes()[a as usize];
        let node_b = &self.b.nodes()[b as usize];
        let query = node_a.realign(self.kernel, &self.map);
        let (rows, kernels) = node_b.overlap_all(self.kernel, &query, used_lanes(node_a));
        self.counters.realignments += 1;
        self.counters.kernels += kernels;
        stack.push(a, b, rows);
        Flow::Continue(())
    }

    /// A leaf of A against the subtree of node `b`.
    #[inline(always)]
    fn descend_b(&mut self, leaf: Leaf, b: u32) -> Flow {
        let (corners, count) = self.moved_corners(leaf);
        let query = N::query_of_corners(&self.b.frame(), &corners[..count]);
        let mut stack = SingleStack::new();
        self.step_b(&mut stack, leaf, &query, b)?;
        while let Some((node, lane)) = stack.next() {
            match self.b.nodes()[node as usize].children()[lane].link() {
                Link::Inner(next) => self.step_b(&mut stack, leaf, &query, next)?,
                Link::Leaf { first, count } => self.leaves(leaf, Leaf { first, count })?,
                Link::Empty => {}
            }
        }
        Flow::Continue(())
    }

    #[inline(always)]
    fn step_b(&mut self, stack: &mut SingleStack, leaf: Leaf, query: &N::Query, node: u32) -> Flow {
        self.spend(Link::Leaf { first: leaf.first, count: leaf.count }, Link::Inner(node))?;
        self.counters.kernels += 1;
        let mask = self.b.nodes()[node as usize].overlap_first(self.kernel, query);
        stack.push(node, mask);
        Flow::Continue(())
    }

    /// The subtree of node `a` against a leaf of B, which is lane `at.1` of node `at.0`.
    #[inline(always)]
    fn descend_a(&mut self, a: u32, at: (u32, usize), leaf: Leaf) -> Flow {
        // The leaf is the query now, and A's turned children are the node: the compare is the same from both sides.
        let query = self.b.nodes()[at.0 as usize].query_of_lane(at.1);
        let mut stack = SingleStack::new();
        self.step_a(&mut stack, a, &query, leaf)?;
        while let Some((node, lane)) = stack.next() {
            match self.a.nodes()[node as usize].children()[lane].link() {
                Link::Inner(next) => self.step_a(&mut stack, next, &query, leaf)?,
                Link::Leaf { first, count } => self.leaves(Leaf { first, count }, leaf)?,
                Link::Empty => {}
            }
        }
        Flow::Continue(())
    }

    #[inline(always)]
    fn step_a(&mut self, stack: &mut SingleStack, node: u32, query: &N::Query, leaf: Leaf) -> Flow {
        self.spend(Link::Inner(node), Link::Leaf { first: leaf.first, count: leaf.count })?;
        let node_a = &self.a.nodes()[node as usize];
        let turned = N::node_of_query(&node_a.realign(self.kernel, &self.map));
        self.counters.realignments += 1;
        self.counters.kernels += 1;
        stack.push(node, turned.overlap_first(self.kernel, query) & used_lanes(node_a));
        Flow::Continue(())
    }

    /// Every triangle of one leaf against every triangle of the other.
    #[inline(never)]
    fn leaves(&mut self, a: Leaf, b: Leaf) -> Flow {
        for i in a.first..a.first + a.count {
            let moved = self.moved(i);
            for j in b.first..b.first + b.count {
                self.counters.triangle_pairs += 1;
                if triangle::overlap(&moved, &self.b.triangle(j), &mut self.counters.exact_pairs) {
                    let pair = Pair { a: self.a.source(i), b: self.b.source(j) };
                    if (self.visit)(pair).is_break() {
                        return Flow::Break(Stop::Visitor);
                    }
                }
            }
        }
        Flow::Continue(())
    }

    fn moved(&self, index: u32) -> Triangle {
        self.a.triangle(index).map(|p| self.pose.apply(p))
    }

    fn moved_corners(&self, leaf: Leaf) -> ([Point; 3 * MAX_LEAF_SIZE as usize], usize) {
        let mut corners = [[0.0; 3]; 3 * MAX_LEAF_SIZE as usize];
        for (slot, index) in corners.chunks_exact_mut(3).zip(leaf.first..leaf.first + leaf.count) {
            slot.copy_from_slice(&self.moved(index));
        }
        (corners, 3 * leaf.count as usize)
    }

    /// One visit of the pair `(a, b)`, if the budget has it.
    #[inline(always)]
    fn spend(&mut self, a: Link, b: Link) -> Flow {
        if self.counters.visits == self.budget {
            return Flow::Break(Stop::Budget { upper: self.corner_distance(a, b) });
        }
        self.counters.visits += 1;
        Flow::Continue(())
    }

    /// The distance of some corner below `a` from some corner below `b`, rounded up.
    #[cold]
    fn corner_distance(&self, a: Link, b: Link) -> f64 {
        let p = self.moved(first_triangle(&self.a, a))[0];
        let q = self.b.triangle(first_triangle(&self.b, b))[0];
        let d = glam::DVec3::from_array(p).distance(glam::DVec3::from_array(q));
        d * (1.0 + 8.0 * f64::EPSILON)
    }
}

/// Bit i: lane i leads somewhere.
#[inline(always)]
fn used_lanes<N: Lanes>(node: &N) -> u16 {
    let lanes = node.children().iter().enumerate();
    lanes.fold(0, |mask, (i, child)| mask | u16::from(*child != Child::EMPTY) << i)
}

/// Some triangle below a link.
fn first_triangle<N: Lanes>(tree: &BvhRef<'_, N>, mut link: Link) -> u32 {
    loop {
        match link {
            Link::Leaf { first, .. } => return first,
            // Links lead to later nodes, so this ends; a node without a used lane does not bound anything: any triangle will do.
            Link::Inner(node) => {
                let children = tree.nodes()[node as usize].children();
                link = children.iter().map(|c| c.link()).find(|l| *l != Link::Empty).unwrap_or(Link::Empty);
            }
            Link::Empty => return 0,
        }
    }
}
