//! The simultaneous traversal, generic over the form of nodes, so that the systems differ only in their nodes and in
//! the tests of these.
//!
//! It follows the library's step by step (`src/query/collide/traverse.rs`): it caches the last realigned node of A,
//! decides pairs of leaves when their bits appear, descends with a leaf of A by the planes of its moved corners, keeps
//! masks instead of pairs on the stack, and ends at the first hit. The predicate is the library's, too. Binary trees
//! differ in one respect: all four pairs of children are tested at once, without first testing which rows can have a
//! bit.

use super::tree::{Dop, K, Tree};
use core::ops::ControlFlow;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::realign::Realignment;
use simdop::node::{Child, Link};
use simdop::pose::Pose;
use simdop::primitive::triangle::{Probe, Triangle};

/// The work of a query.
#[derive(Copy, Clone, Default, Debug)]
pub(crate) struct Work {
    pub(crate) visits: u64,
    /// Pairs of DOPs tested.
    pub(crate) tests: u64,
    /// Slabs tested in all of them: the orientations in figure 12 of the SIMDop paper.
    pub(crate) slabs: u64,
    pub(crate) primitive_pairs: u64,
}

impl Work {
    /// Adds this many pairs of DOPs, each tested in all slabs.
    #[inline(always)]
    pub(crate) fn in_all_slabs(&mut self, tests: u64) {
        self.tests += tests;
        self.slabs += tests * (K / 2) as u64;
    }
}

/// A form of nodes with `W` children, and an instruction set to test them with. Planes of bodies in B's frame are upper
/// bounds.
pub(crate) trait System<const W: usize>: Copy {
    type Node;
    /// Realignment at a pose, prepared.
    type Map;
    /// The children of a node of A in B's frame.
    type Turned<'n>;
    /// A triangle of A in B's frame.
    type Leaf;
    type Isa: Kernel;
    /// Test first which children of A overlap the lane that leads to the node of B, before they are tested against all
    /// of its children.
    const COLUMN_FIRST: bool;

    fn node(dops: &[Dop; W], children: &[Child; W]) -> Self::Node;
    fn child(node: &Self::Node, lane: usize) -> Child;
    /// The instruction set that the traversal is compiled for.
    fn isa(self) -> Self::Isa;
    fn map(self, turn: &Realignment<K>) -> Self::Map;
    fn turn<'n>(self, map: &Self::Map, node: &'n Self::Node) -> Self::Turned<'n>;
    fn leaf(self, planes: &[f64; K]) -> Self::Leaf;
    /// For each of the `wanted` children of A, which children of `node` it overlaps.
    fn rows(
        self,
        map: &Self::Map,
        a: &Self::Turned<'_>,
        node: &Self::Node,
        wanted: u16,
        work: &mut Work,
    ) -> Rows<W>;
    /// Which children of A child `lane` of `node` overlaps.
    fn column(
        self,
        map: &Self::Map,
        a: &Self::Turned<'_>,
        node: &Self::Node,
        lane: usize,
        work: &mut Work,
    ) -> u16;
    /// Which children of `node` the triangle overlaps.
    fn row(self, a: &Self::Leaf, node: &Self::Node, work: &mut Work) -> u16;
}

/// Which pairs of children overlap.
#[derive(Copy, Clone)]
pub(crate) struct Rows<const W: usize> {
    /// For each child of A, or in row 0 for a body that is not split: bits of the children of B, or of A if B is not
    /// split.
    rows: [u16; W],
    /// Bit i: row i has a bit.
    pending: u16,
}

impl<const W: usize> Rows<W> {
    pub(crate) const NONE: Self = Self { rows: [0; W], pending: 0 };

    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, bits: u16) {
        self.rows[row % W] = bits;
        self.pending = self.pending & !(1 << row) | u16::from(bits != 0) << row;
    }
}

/// A visited pair, and the pairs still to descend into.
#[derive(Copy, Clone)]
pub(crate) struct Frame<const W: usize> {
    a: Child,
    b: Child,
    left: Rows<W>,
}

/// Whether A at the pose meets B.
pub(crate) fn collide<const W: usize, S: System<W>>(
    system: S,
    [a, b]: [&Tree<W, S>; 2],
    pose: &Pose,
    stack: &mut Vec<Frame<W>>,
) -> (bool, Work) {
    stack.clear();
    system.isa().run(
        #[inline(always)]
        || {
            let map = system.map(&Realignment::new(pose, &a.header.extent(), &b.frame));
            let target = (&b.above, 0);
            let work = Work::default();
            let mut descent = Descent {
                system,
                a,
                b,
                pose,
                map,
                turned: None,
                aimed: None,
                target,
                others: [[[0.0; 3]; 3]; 4],
                work,
            };
            let hit = descent.run(stack).is_break();
            (hit, descent.work)
        },
    )
}

struct Descent<'t, const W: usize, S: System<W>> {
    system: S,
    a: &'t Tree<W, S>,
    b: &'t Tree<W, S>,
    pose: &'t Pose,
    map: S::Map,
    turned: Option<(Child, S::Turned<'t>)>,
    aimed: Option<(Child, S::Leaf)>,
    /// Node and lane in B that A descends against.
    target: (&'t S::Node, usize),
    /// Triangles that are tested together.
    others: [Triangle; 4],
    work: Work,
}

impl<'t, const W: usize, S: System<W>> Descent<'t, W, S> {
    #[inline(always)]
    fn run(&mut self, stack: &mut Vec<Frame<W>>) -> ControlFlow<()> {
        let (mut a, mut b) = (Child::ROOT, Child::ROOT);
        loop {
            let left = self.step(a, b)?;
            if left.pending != 0 {
                stack.push(Frame { a, b, left });
            }
            let Some(top) = stack.last_mut() else { return ControlFlow::Continue(()) };
            let row = top.left.pending.trailing_zeros() as usize % W;
            let bits = top.left.rows[row];
            let bit = bits.trailing_zeros() as usize % W;
            top.left.set(row, bits & bits.wrapping_sub(1));
            let (from_a, from_b) = (top.a, top.b);
            if top.left.pending == 0 {
                stack.pop();
            }
            (a, b) = match (from_a.link(), from_b.link()) {
                (Link::Inner(node_a), Link::Inner(node_b)) => {
                    self.target = (&self.b.nodes[node_b as usize], bit);
                    (self.child_a(node_a, row), S::child(self.target.0, bit))
                }
                (Link::Inner(node_a), _) => (self.child_a(node_a, bit), from_b),
                (_, Link::Inner(node_b)) => (from_a, S::child(&self.b.nodes[node_b as usize], bit)),
                _ => unreachable!("pairs of leaves do not wait"),
            };
        }
    }

    fn child_a(&self, node: u32, lane: usize) -> Child {
        S::child(&self.a.nodes[node as usize], lane)
    }

    /// Visits a pair of which at least one is a node. Returns the pairs to descend into.
    #[inline(always)]
    fn step(&mut self, a: Child, b: Child) -> ControlFlow<(), Rows<W>> {
        self.work.visits += 1;
        match (a.link(), b.link()) {
            (Link::Inner(node_a), Link::Inner(node_b)) => {
                let node_b = &self.b.nodes[node_b as usize];
                let wanted = if S::COLUMN_FIRST { self.column(a, node_a) } else { u16::MAX };
                if wanted == 0 {
                    return ControlFlow::Continue(Rows::NONE);
                }
                self.turn(a, node_a);
                let (map, work) = (&self.map, &mut self.work);
                let mut rows = match &self.turned {
                    Some((_, turned)) => self.system.rows(map, turned, node_b, wanted, work),
                    None => Rows::NONE,
                };
                for row in bits_of(rows.pending) {
                    let child = self.child_a(node_a, row);
                    if is_leaf(child) {
                        rows.set(row, self.decide_row(child, node_b, rows.rows[row % W])?);
                    }
                }
                ControlFlow::Continue(rows)
            }
            (Link::Inner(node_a), _) => {
                let overlapping = self.column(a, node_a);
                let node = &self.a.nodes[node_a as usize];
                let leaves = leaves_among::<W, S>(node, overlapping);
                let (tree, pose, still) = (self.a, self.pose, self.b.triangle(b));
                self.decide(&still, leaves, |lane| moved(tree, pose, S::child(node, lane)))?;
                let inner = overlapping & !leaves;
                let mut rows = Rows::NONE;
                rows.set(0, inner);
                ControlFlow::Continue(rows)
            }
            (_, Link::Inner(node_b)) => {
                let node_b = &self.b.nodes[node_b as usize];
                self.aim(a);
                let bits = match &self.aimed {
                    Some((_, leaf)) => self.system.row(leaf, node_b, &mut self.work),
                    None => 0,
                };
                let mut rows = Rows::NONE;
                rows.set(0, self.decide_row(a, node_b, bits)?);
                ControlFlow::Continue(rows)
            }
            _ => unreachable!("pairs of leaves do not wait"),
        }
    }

    #[inline(always)]
    fn turn(&mut self, a: Child, node: u32) {
        if !matches!(&self.turned, Some((last, _)) if *last == a) {
            self.turned = Some((a, self.system.turn(&self.map, &self.a.nodes[node as usize])));
        }
    }

    /// The children of A that overlap the current target in B.
    #[inline(always)]
    fn column(&mut self, a: Child, node: u32) -> u16 {
        self.turn(a, node);
        let (node, lane) = self.target;
        match &self.turned {
            Some((_, turned)) => self.system.column(&self.map, turned, node, lane, &mut self.work),
            None => 0,
        }
    }

    #[inline(always)]
    fn aim(&mut self, a: Child) {
        if !matches!(&self.aimed, Some((last, _)) if *last == a) {
            let planes = self.b.planes_of(&moved(self.a, self.pose, a));
            self.aimed = Some((a, self.system.leaf(&planes)));
        }
    }

    /// Tests leaf `a` against the leaves among the children of `b` that `bits` selects. Returns the bits of the others.
    #[inline(always)]
    fn decide_row(&mut self, a: Child, b: &S::Node, bits: u16) -> ControlFlow<(), u16> {
        let leaves = leaves_among::<W, S>(b, bits);
        if leaves != 0 {
            let tree = self.b;
            let triangle = moved(self.a, self.pose, a);
            self.decide(&triangle, leaves, |lane| tree.triangle(S::child(b, lane)))?;
        }
        ControlFlow::Continue(bits & !leaves)
    }

    /// Tests one triangle against those of the other body in the lanes `leaves`. As in the library, four at a time go
    /// through the filter by planes; a single one does not, nor do the two that a binary node has at most.
    #[inline(always)]
    fn decide(&mut self, one: &Triangle, leaves: u16, other: impl Fn(usize) -> Triangle) -> ControlFlow<()> {
        let probe = Probe::new(one);
        let mut lanes = bits_of(leaves);
        if W < 4 {
            for lane in lanes {
                self.work.primitive_pairs += 1;
                if probe.overlaps(&other(lane), &mut 0) {
                    return ControlFlow::Break(());
                }
            }
            return ControlFlow::Continue(());
        }
        loop {
            let mut len = 0;
            while len < 4
                && let Some(lane) = lanes.next()
            {
                self.others[len] = other(lane);
                len += 1;
            }
            self.work.primitive_pairs += len as u64;
            let apart = if len > 1 { self.system.isa().apart_4(&probe, &self.others) } else { 0 };
            for k in bits_of(!apart & ((1 << len) - 1)) {
                if probe.overlaps(&self.others[k & 3], &mut 0) {
                    return ControlFlow::Break(());
                }
            }
            if len < 4 {
                return ControlFlow::Continue(());
            }
        }
    }
}

/// The triangle of a leaf of A at the pose.
#[inline(always)]
fn moved<const W: usize, S: System<W>>(tree: &Tree<W, S>, pose: &Pose, leaf: Child) -> Triangle {
    let [p, q, r] = tree.triangle(leaf);
    [pose.apply(p), pose.apply(q), pose.apply(r)]
}

/// Which of the selected children are leaves.
#[inline(always)]
fn leaves_among<const W: usize, S: System<W>>(node: &S::Node, bits: u16) -> u16 {
    bits_of(bits).filter(|&lane| is_leaf(S::child(node, lane))).fold(0, |leaves, lane| leaves | 1 << lane)
}

fn is_leaf(child: Child) -> bool {
    matches!(child.link(), Link::Leaf { .. })
}

/// The indices of the set bits, ascending.
#[inline(always)]
fn bits_of(mut bits: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        bit
    })
}
