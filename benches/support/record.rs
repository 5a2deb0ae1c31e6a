//! The kernel calls of real queries, in their order.

use super::bodies::Scene;
use crate::rng::Rng;
use core::ops::Range;
use simdop::hierarchy::BvhRef;
use simdop::isa::Scalar;
use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::Storage;
use simdop::low_level::realign::Realignment;
use simdop::node::{Child, Link, Node4, Node16};
use simdop::query::Lanes;
use turned::{turned_4, turned_16};

#[path = "../../tests/support/turned.rs"]
#[expect(unreachable_pub, reason = "public for the fuzz targets, where it is part of a library")]
mod turned;

/// One call of an overlap kernel.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Call {
    pub(crate) query: u32,
    pub(crate) node: u32,
    /// Lane of the query; 4vs4 uses all.
    pub(crate) lane: u16,
    /// The expected answer, by the scalar kernel or by plain code.
    pub(crate) mask: u16,
}

/// Calls, and the bodies they refer to.
pub(crate) struct Recording<Q, N> {
    pub(crate) queries: Vec<Q>,
    pub(crate) nodes: Vec<N>,
    pub(crate) calls: Vec<Call>,
}

/// What the recorder needs from a node.
pub(crate) trait Arity: Lanes {
    type Bodies: Copy;
    type Turn;
    fn turn_of(scene: BvhRef<'_, Self>, pose: &simdop::pose::Pose) -> Self::Turn;
    fn turned(&self, turn: &Self::Turn) -> Self::Bodies;
    /// The planes of one child in all lanes: a leaf that descends alone.
    fn alone(planes: &Self::Bodies, lane: usize) -> Self::Bodies;
    /// Which bodies of the query child `lane` of `self` overlaps.
    fn column(&self, planes: &Self::Bodies, lane: usize) -> u16;
    /// Which children of A the root of B overlaps.
    fn against_hull(&self, planes: &Self::Bodies) -> u16;
    /// Calls the kernel for the `wanted` children of A, and `call(lane, answer)` with each result. Returns the rows of
    /// bits.
    fn rows(&self, planes: &Self::Bodies, wanted: u16, call: impl FnMut(usize, u16)) -> [u16; 16];
}

macro_rules! impl_arity {
    ($node:ident, $arity:literal, $turned:ident, $($item:item)*) => {
        impl<const K: usize, S: Storage> Arity for $node<K, S>
        where
            Self: Lanes,
        {
            type Bodies = Turned<$arity, K>;
            type Turn = Realignment<K, S>;
            fn turn_of(tree: BvhRef<'_, Self>, pose: &simdop::pose::Pose) -> Self::Turn {
                Realignment::new(pose, &tree.extent(), &tree.frame())
            }
            fn turned(&self, turn: &Self::Turn) -> Self::Bodies {
                $turned(Scalar::new(), turn, self)
            }
            fn alone(planes: &Self::Bodies, lane: usize) -> Self::Bodies {
                planes.map(|plane| [plane[lane]; $arity])
            }
            $($item)*
        }
    };
}

impl_arity! {
    Node16,
    16,
    turned_16,
    fn column(&self, planes: &Self::Bodies, lane: usize) -> u16 {
        Scalar::new().overlap_16v1(planes, self, lane)
    }

    fn against_hull(&self, planes: &Self::Bodies) -> u16 {
        Scalar::new().overlap_16v_hull(planes, self)
    }

    fn rows(&self, planes: &Self::Bodies, wanted: u16, mut call: impl FnMut(usize, u16)) -> [u16; 16] {
        let mut rows = [0; 16];
        for lane in (0..16).filter(|lane| wanted >> lane & 1 != 0) {
            rows[lane] = Scalar::new().overlap_1v16(planes, lane, self);
            call(lane, rows[lane]);
        }
        rows
    }
}

impl_arity! {
    Node4,
    4,
    turned_4,
    fn column(&self, planes: &Self::Bodies, lane: usize) -> u16 {
        let pairs = Scalar::new().overlap_4v4(planes, self) >> lane;
        (0..4).fold(0, |mask, i| mask | (pairs >> (4 * i) & 1) << i)
    }

    fn against_hull(&self, _: &Self::Bodies) -> u16 {
        u16::MAX
    }

    fn rows(&self, planes: &Self::Bodies, wanted: u16, mut call: impl FnMut(usize, u16)) -> [u16; 16] {
        let pairs = Scalar::new().overlap_4v4(planes, self);
        call(0, pairs);
        let row =
            |lane: usize| if lane < 4 && wanted >> lane & 1 != 0 { pairs >> (4 * lane) & 0xf } else { 0 };
        core::array::from_fn(row)
    }
}

/// The part of A that descends.
#[derive(Copy, Clone)]
enum Side {
    Node(u32),
    /// A leaf, as the index of the query with its planes.
    Leaf(u32),
}

/// The library's traversal for free poses, without leaf tests and stack.
struct Recorder<'t, N: Arity> {
    tree: BvhRef<'t, N>,
    turn: N::Turn,
    first_node: u32,
    turned: Option<(u32, u32)>,
    out: &'t mut Recording<N::Bodies, N>,
}

/// Records every scene at every pose.
pub(crate) fn record<N: Arity>(scenes: &[Scene<N>]) -> Recording<N::Bodies, N> {
    let mut out = Recording { queries: Vec::new(), nodes: Vec::new(), calls: Vec::new() };
    for scene in scenes {
        let tree = scene.tree.view();
        let first_node = out.nodes.len() as u32;
        out.nodes.extend_from_slice(tree.nodes());
        for pose in &scene.poses {
            let turn = N::turn_of(tree, pose);
            let mut recorder = Recorder { tree, turn, first_node, turned: None, out: &mut out };
            recorder.visit(Side::Node(0), Child::ROOT, None);
        }
    }
    out
}

impl<N: Arity> Recorder<'_, N> {
    /// `from`: the node and lane in B that lead to `b`.
    fn visit(&mut self, a: Side, b: Child, from: Option<(u32, usize)>) {
        let tree = self.tree;
        match (a, b.link()) {
            (Side::Node(node_a), link_b) => {
                let query = self.turn(node_a);
                let planes = self.out.queries[query as usize];
                let wanted = match from {
                    Some((node, lane)) => tree.nodes()[node as usize].column(&planes, lane),
                    None => tree.nodes()[0].against_hull(&planes),
                };
                let children = tree.nodes()[node_a as usize].children();
                if let Link::Inner(node_b) = link_b {
                    let rows = self.call(query, node_b, wanted);
                    for (lane, row) in rows.into_iter().enumerate() {
                        for bit in bits(row) {
                            let b = tree.nodes()[node_b as usize].children()[bit];
                            self.descend(children[lane], query, lane, b, Some((node_b, bit)));
                        }
                    }
                } else {
                    bits(wanted).for_each(|lane| self.descend(children[lane], query, lane, b, from));
                }
            }
            (Side::Leaf(query), Link::Inner(node_b)) => {
                let rows = self.call(query, node_b, 1);
                for bit in bits(rows[0]) {
                    self.visit(a, tree.nodes()[node_b as usize].children()[bit], None);
                }
            }
            _ => {}
        }
    }

    /// A child of A, in `lane` of the query, against `b`, unless both are leaves.
    fn descend(&mut self, child: Child, query: u32, lane: usize, b: Child, from: Option<(u32, usize)>) {
        match (child.link(), b.link()) {
            (Link::Inner(node), _) => self.visit(Side::Node(node), b, from),
            (Link::Leaf { .. }, Link::Inner(_)) => {
                let alone = N::alone(&self.out.queries[query as usize], lane);
                let query = self.query(alone);
                self.visit(Side::Leaf(query), b, None);
            }
            _ => {}
        }
    }

    fn call(&mut self, query: u32, node: u32, wanted: u16) -> [u16; 16] {
        let planes = self.out.queries[query as usize];
        let (calls, in_all) = (&mut self.out.calls, self.first_node + node);
        self.tree.nodes()[node as usize].rows(&planes, wanted, |lane, mask| {
            calls.push(Call { query, node: in_all, lane: lane as u16, mask });
        })
    }

    fn query(&mut self, planes: N::Bodies) -> u32 {
        self.out.queries.push(planes);
        self.out.queries.len() as u32 - 1
    }

    fn turn(&mut self, node: u32) -> u32 {
        if let Some((last, query)) = self.turned
            && last == node
        {
            return query;
        }
        let query = self.query(self.tree.nodes()[node as usize].turned(&self.turn));
        self.turned = Some((node, query));
        query
    }
}

fn bits(mask: u16) -> impl Iterator<Item = usize> {
    (0..16).filter(move |bit| mask >> bit & 1 != 0)
}

/// The memory that the bodies of the calls are loaded from.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Level {
    /// Windows of calls whose bodies fit into 24 KB, loaded before the clock starts.
    L1,
    /// The same with 256 KB.
    L2,
    /// A copy of the node for each call, in random order: larger than the last-level cache.
    Memory,
}

pub(crate) const LEVELS: [(Level, &str); 3] =
    [(Level::L1, "L1"), (Level::L2, "L2"), (Level::Memory, "memory")];

impl<Q, N: Clone> Recording<Q, N> {
    /// Consecutive calls whose bodies fit in the cache.
    pub(crate) fn windows(&self, level: Level) -> Vec<Range<usize>> {
        let limit = match level {
            Level::L1 => 24 << 10,
            Level::L2 => 256 << 10,
            Level::Memory => usize::MAX,
        };
        let (mut seen_queries, mut seen_nodes) = (vec![0; self.queries.len()], vec![0; self.nodes.len()]);
        let (mut windows, mut start, mut bytes) = (Vec::new(), 0, 0);
        for (i, call) in self.calls.iter().enumerate() {
            // A stamp of 0 marks no window: windows start at 1.
            let stamp = windows.len() + 1;
            let new =
                |seen: &mut usize, size| if core::mem::replace(seen, stamp) == stamp { 0 } else { size };
            bytes += new(&mut seen_queries[call.query as usize], size_of::<Q>())
                + new(&mut seen_nodes[call.node as usize], size_of::<N>());
            if bytes > limit {
                windows.push(start..i);
                (start, bytes) = (i, 0);
            }
        }
        windows.push(start..self.calls.len());
        windows
    }

    /// Gives each call a node of its own at a random place.
    pub(crate) fn scattered(&self, rng: &mut Rng) -> Self
    where
        Q: Clone,
    {
        let mut place: Vec<u32> = (0..self.calls.len() as u32).collect();
        for i in (1..place.len()).rev() {
            place.swap(i, rng.below(i as u64 + 1) as usize);
        }
        let mut nodes = vec![self.nodes[0].clone(); place.len()];
        let mut calls = self.calls.clone();
        for (call, place) in calls.iter_mut().zip(place) {
            nodes[place as usize] = self.nodes[call.node as usize].clone();
            call.node = place;
        }
        Self { queries: self.queries.clone(), nodes, calls }
    }

    /// The same calls with these answers, for planes that were rounded once more.
    pub(crate) fn answered(mut self, mask: impl Fn(&Q, usize, &N) -> u16) -> Self {
        for call in &mut self.calls {
            let (query, node) = (&self.queries[call.query as usize], &self.nodes[call.node as usize]);
            call.mask = mask(query, call.lane.into(), node);
        }
        self
    }

    /// The same calls on other forms of the bodies.
    pub(crate) fn map<P, M>(&self, query: impl Fn(&Q) -> P, node: impl Fn(&N) -> M) -> Recording<P, M> {
        Recording {
            queries: self.queries.iter().map(query).collect(),
            nodes: self.nodes.iter().map(node).collect(),
            calls: self.calls.clone(),
        }
    }
}
