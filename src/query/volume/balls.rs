//! Traverses two trees of spheres with the bounding balls of their lanes, to find all pairs of spheres that meet: depth
//! first, or best first by the bound of the shared volume.

use super::lens::{LensSums, expected};
use super::queue::{BallPair, LaneAt, PairQueue, Waiting};
use crate::hierarchy::{BvhRef, MAX_DEPTH};
use crate::kernel::Kernel;
use crate::node::{Ball16, BoundingBall, Link, Node};
use crate::pose::Pose;
use crate::primitive::sphere::against_sphere;
use crate::primitive::{Primitive, Sphere, Spheres};
use crate::query::entry::QueryStats;
use crate::query::lanes::{Descent, Rows, bits_of};
use crate::realign::BallMap;
use core::ops::ControlFlow;

/// The children tested in a visit, with a bit for each pair that meets: if both nodes were opened, row i holds the bits
/// for child i of A; otherwise row 0 holds all bits.
#[derive(Copy, Clone, Debug)]
struct OpenedBalls {
    volumes: BallPair,
    /// The nodes, if they were opened.
    nodes: (u32, u32),
    by: Descent,
    rows: Rows,
}

const NOTHING: OpenedBalls = OpenedBalls {
    volumes: BallPair::ROOTS,
    nodes: (0, 0),
    by: Descent::Both,
    rows: Rows { rows: [0; 16], pending: 0 },
};

impl OpenedBalls {
    /// The pair of volumes of a bit.
    const fn below(&self, row: usize, bit: usize) -> BallPair {
        let BallPair { a, b } = self.volumes;
        match self.by {
            Descent::Both => {
                BallPair { a: LaneAt::lane(self.nodes.0, row), b: LaneAt::lane(self.nodes.1, bit) }
            }
            Descent::A => BallPair { a: LaneAt::lane(self.nodes.0, bit), b },
            Descent::B => BallPair { a, b: LaneAt::lane(self.nodes.1, bit) },
        }
    }
}

/// The result when the budget is spent.
#[derive(Copy, Clone, Debug)]
pub(super) struct Rest {
    /// The volume found before the visit that ran out of budget.
    pub(super) known: f64,
    /// Upper bound of the remaining shared volume, in the unit of B's frame. Assumes that the spheres of a body do not
    /// overlap.
    pub(super) bound: f64,
    /// Estimate of the remaining shared volume, in the same unit.
    pub(super) expected: f64,
}

/// The state of a search.
pub(super) struct BallSearch<'t, N, E> {
    kernel: E,
    a: BvhRef<'t, N, Spheres>,
    b: BvhRef<'t, N, Spheres>,
    pose: &'t Pose,
    map: &'t BallMap,
    budget: u64,
    stats: &'t mut QueryStats,
    sums: &'t mut LensSums,
    /// The node of A whose balls were moved last, and the moved balls.
    turned: (u32, Ball16),
    /// The lane of A whose ball was last moved alone, with that ball in lane 0.
    aimed: (LaneAt, Ball16),
    /// The unit of A's frame divided by that of B's.
    ratio: f32,
}

/// Only the larger of two balls is opened if its radius is more than this many times the other's.
const MUCH_LARGER: f32 = 4.0;

const NO_NODE: u32 = u32::MAX;

impl<'t, N: Node, E: Kernel> BallSearch<'t, N, E> {
    #[inline(always)]
    pub(super) fn new(
        kernel: E,
        (a, b): (BvhRef<'t, N, Spheres>, BvhRef<'t, N, Spheres>),
        pose: &'t Pose,
        map: &'t BallMap,
        budget: u64,
        (stats, sums): (&'t mut QueryStats, &'t mut LensSums),
    ) -> Self {
        let ratio = crate::exact::power_of_two((b.frame().exponent - a.frame().exponent).clamp(-100, 100));
        let (turned, aimed) = ((NO_NODE, Ball16::EMPTY), (LaneAt::ROOT, Ball16::EMPTY));
        Self { kernel, a, b, pose, map, budget, stats, sums, turned, aimed, ratio: ratio as f32 }
    }

    /// Finds all pairs, depth first. Breaks when the budget is spent.
    #[inline(always)]
    pub(super) fn all(&mut self) -> ControlFlow<()> {
        self.depth_first(BallPair::ROOTS)
    }

    /// Finds pairs, largest bound of the shared volume first, until the budget is spent.
    #[inline(always)]
    pub(super) fn best_first(&mut self) -> ControlFlow<Rest> {
        let mut queue = PairQueue::new();
        queue.push(Waiting { bound: f32::MAX, volumes: BallPair::ROOTS });
        while let Some(next) = queue.pop() {
            let known = self.sums.volume();
            let flow = if queue.has_room() {
                self.expand(&next, &mut queue)
            } else {
                self.depth_first(next.volumes)
            };
            if flow.is_break() {
                queue.push(next);
                let expected = queue.iter().map(|waiting| self.expected(waiting)).sum();
                let volume_of_a = |at| Self::volume_at(&self.a, at) * self.map.volume_growth();
                let of_a = queue.capped(|volumes| volumes.a, volume_of_a);
                let of_b = queue.capped(|volumes| volumes.b, |at| Self::volume_at(&self.b, at));
                return ControlFlow::Break(Rest { known, bound: f64::min(of_a, of_b), expected });
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits a pair of volumes and queues the pairs below it.
    #[inline(always)]
    fn expand(&mut self, next: &Waiting, queue: &mut PairQueue) -> ControlFlow<()> {
        let opened = self.visit(next.volumes)?;
        for row in bits_of(opened.rows.pending as u16) {
            let mut shared = [0.0; 16];
            match opened.by {
                Descent::Both => {
                    let one = self.turned.1.lane(row);
                    self.kernel.balls_share(&one, &self.b.balls()[opened.nodes.1 as usize], &mut shared);
                }
                Descent::B => {
                    let one = self.aimed.1.lane(0);
                    self.kernel.balls_share(&one, &self.b.balls()[opened.nodes.1 as usize], &mut shared);
                }
                Descent::A => {
                    let one = Self::ball_at(&self.b, opened.volumes.b);
                    self.kernel.balls_share(&one, &self.turned.1, &mut shared);
                }
            }
            for bit in bits_of(opened.rows.rows[row]) {
                // At most the volume that the parents share.
                let bound = if shared[bit] < next.bound { shared[bit] } else { next.bound };
                queue.push(Waiting { bound, volumes: opened.below(row, bit) });
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits everything below a pair of volumes.
    #[inline(always)]
    fn depth_first(&mut self, from: BallPair) -> ControlFlow<()> {
        // Each entry is at least a level deeper than the one before it, in one tree or in both.
        let mut stack = [NOTHING; 2 * MAX_DEPTH];
        let mut len = 0;
        let mut volumes = from;
        loop {
            let opened = self.visit(volumes)?;
            if opened.rows.pending != 0 {
                stack[len] = opened;
                len += 1;
            }
            let Some(top) = len.checked_sub(1).and_then(|last| stack.get_mut(last)) else {
                return ControlFlow::Continue(());
            };
            let row = (top.rows.pending.trailing_zeros() & 15) as usize;
            let bits = top.rows.rows[row];
            volumes = top.below(row, (bits.trailing_zeros() & 15) as usize);
            top.rows.set(row, bits & bits.wrapping_sub(1));
            if top.rows.pending == 0 {
                len -= 1;
            }
        }
    }

    /// Opens one volume or both, and tests the pairs of leaves among the children.
    #[inline(always)]
    fn visit(&mut self, volumes: BallPair) -> ControlFlow<(), OpenedBalls> {
        if self.stats.visits == self.budget {
            return ControlFlow::Break(());
        }
        self.stats.visits += 1;
        let (a, b) = (Self::link_at(&self.a, volumes.a), Self::link_at(&self.b, volumes.b));
        let by = match (a, b) {
            (Link::Inner(_), Link::Inner(_)) => self.opened(volumes),
            (Link::Inner(_), _) => Descent::A,
            _ => Descent::B,
        };
        let node = |link: Link| if let Link::Inner(node) = link { node } else { 0 };
        let mut opened = OpenedBalls { volumes, nodes: (node(a), node(b)), by, rows: Rows::default() };
        let rows = &mut opened.rows;
        if by == Descent::B {
            self.aim(volumes.a);
            let balls = &self.b.balls()[opened.nodes.1 as usize];
            self.kernel.balls_meet(&self.aimed.1, 1, balls, &mut rows.rows);
            self.stats.kernels += 1;
            rows.pending = u32::from(rows.rows[0] != 0);
        } else {
            self.turn(opened.nodes.0);
            let wanted = self.against(volumes.b);
            if by == Descent::A {
                rows.rows[0] = wanted;
                rows.pending = u32::from(wanted != 0);
            } else {
                let balls = &self.b.balls()[opened.nodes.1 as usize];
                self.kernel.balls_meet(&self.turned.1, wanted, balls, &mut rows.rows);
                self.stats.kernels += u64::from(wanted.count_ones());
                for (row, bits) in rows.rows.iter().enumerate() {
                    rows.pending |= u32::from(*bits != 0) << row;
                }
            }
        }
        self.decide_leaves(&mut opened);
        ControlFlow::Continue(opened)
    }

    /// The moved balls that meet the ball of B's lane; for the root, all used ones.
    #[inline(always)]
    fn against(&mut self, b: LaneAt) -> u16 {
        if b == LaneAt::ROOT {
            let [x, ..] = &self.turned.1.centre;
            return (0..16).filter(|&lane| !x[lane].is_nan()).fold(0, |used, lane| used | 1 << lane);
        }
        let (node, lane) = b.node_and_lane();
        let mut rows = [0; 16];
        self.kernel.balls_meet(&self.b.balls()[node as usize], 1 << lane, &self.turned.1, &mut rows);
        self.stats.kernels += 1;
        rows[lane]
    }

    /// Which of two nodes to open.
    #[inline(always)]
    fn opened(&self, BallPair { a, b }: BallPair) -> Descent {
        if a == LaneAt::ROOT || b == LaneAt::ROOT {
            return Descent::Both;
        }
        let of_a = Self::ball_at(&self.a, a).radius * self.ratio;
        let of_b = Self::ball_at(&self.b, b).radius;
        if of_a > MUCH_LARGER * of_b {
            Descent::A
        } else if of_b > MUCH_LARGER * of_a {
            Descent::B
        } else {
            Descent::Both
        }
    }

    fn link_at(tree: &BvhRef<'_, N, Spheres>, at: LaneAt) -> Link {
        if at == LaneAt::ROOT {
            return Link::Inner(0);
        }
        let (node, lane) = at.node_and_lane();
        tree.nodes()[node as usize].children()[lane].link()
    }

    fn ball_at(tree: &BvhRef<'_, N, Spheres>, at: LaneAt) -> BoundingBall {
        let (node, lane) = at.node_and_lane();
        tree.balls()[node as usize].lane(lane)
    }

    /// The volume of the spheres below a lane; unbounded for the root.
    fn volume_at(tree: &BvhRef<'_, N, Spheres>, at: LaneAt) -> f32 {
        if at == LaneAt::ROOT { f32::MAX } else { Self::ball_at(tree, at).volume }
    }

    /// Estimate of the volume that a pending pair shares. For the roots, which have no balls, nothing is known.
    #[inline(never)]
    fn expected(&self, Waiting { bound, volumes: BallPair { a, b } }: &Waiting) -> f64 {
        if *a == LaneAt::ROOT {
            return 0.0;
        }
        let (a, b) = (self.map.turned(&Self::ball_at(&self.a, *a)), Self::ball_at(&self.b, *b));
        // `min` also returns the bound where the estimate is NaN: for balls of radius zero.
        f64::min(expected(&a, &b), f64::from(*bound))
    }

    /// Moves the balls of node `a` into B's frame.
    #[inline(always)]
    fn turn(&mut self, a: u32) {
        if self.turned.0 != a {
            self.stats.realignments += 1;
            self.turned.0 = a;
            self.map.turn(&self.a.balls()[a as usize], &mut self.turned.1);
        }
    }

    /// Moves the ball of one lane.
    #[inline(always)]
    fn aim(&mut self, a: LaneAt) {
        if self.aimed.0 != a {
            self.aimed.0 = a;
            self.aimed.1.set(0, &self.map.turned(&Self::ball_at(&self.a, a)));
        }
    }

    /// Tests the pairs of leaves among the bits, and clears them.
    #[inline(always)]
    fn decide_leaves(&mut self, opened: &mut OpenedBalls) {
        for row in bits_of(opened.rows.pending as u16) {
            let mut inner = opened.rows.rows[row];
            // If A was opened, each bit has a different leaf of A; otherwise a row shares one leaf.
            let mut moved = (NO_NODE, Sphere::default());
            for bit in bits_of(inner) {
                let BallPair { a, b } = opened.below(row, bit);
                let (a, b) = (Self::link_at(&self.a, a), Self::link_at(&self.b, b));
                let is_pair = matches!((a, b), (Link::Leaf { .. }, Link::Leaf { .. }));
                if is_pair {
                    inner &= !(1 << bit);
                    for i in a.primitives() {
                        if moved.0 != i {
                            moved = (i, Spheres::moved(&self.a.primitive(i), self.pose));
                        }
                        for j in b.primitives() {
                            let still = self.b.primitive(j);
                            self.stats.primitive_pairs += 1;
                            if against_sphere::is_within(&moved.1, &still, 0.0, &mut self.stats.exact_pairs) {
                                self.sums.add(&moved.1, &still);
                            }
                        }
                    }
                }
            }
            opened.rows.set(row, inner);
        }
    }
}
