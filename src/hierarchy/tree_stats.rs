//! Predicts the cost of queries from the shape of a tree alone.

use super::{BvhRef, Lane, MAX_DEPTH};
use crate::node::{Dop, Link};
use crate::primitive::Primitive;

/// Quality of a tree, by the boxes of its lanes (the first three slabs, which every k has). All numbers are ratios,
/// without unit.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct TreeStats {
    /// Expected number of visits of a query against a copy of the tree that finds no hit, at a uniformly random motion
    /// for which the two root boxes meet.
    ///
    /// Given that the root boxes r meet, boxes a and b meet with probability mu(a, b) / mu(r, r), where by Blaschke's
    /// kinematic formula
    ///
    /// ```text
    /// mu(a, b) = 4 (V_a + V_b) + S_a m_b + S_b m_a          (times 2 pi^2)
    /// ```
    ///
    /// with the volume V, the area S and the sum m of the three edges of a box. The result sums this probability over
    /// all pairs that a query can visit: pairs of nodes of the same level, and pairs of a node with a leaf of the same
    /// or a higher level of the other tree, counted twice since either tree may have the leaf. It is 1 for a single
    /// node. If the root has no area, every pair counts as meeting.
    pub expected_visits: f64,
    /// Sum of the areas of a node's lanes divided by the area of the node; mean over the nodes with nonzero area.
    pub area_ratio: f64,
    /// Volume that two lanes of a node share, summed over pairs of lanes, divided by the sum of the lanes' volumes;
    /// mean over the nodes whose lanes have volume.
    pub overlap: f64,
    /// Fraction of the lanes that are used.
    pub lanes_used: f64,
    /// Levels of nodes above a primitive; mean over the primitives.
    pub mean_depth: f64,
}

/// Low and high end along each axis, in the tree's frame.
type LaneBox = [[f64; 2]; 3];

const NOTHING: LaneBox = [[f64::INFINITY, f64::NEG_INFINITY]; 3];

/// Number of boxes, and the sums of their volumes, areas and edges.
#[derive(Copy, Clone, Default, Debug)]
struct Size {
    count: f64,
    volume: f64,
    area: f64,
    edges: f64,
}

impl Size {
    fn of(lane: &LaneBox) -> Self {
        let [x, y, z] = lane.map(|[low, high]| (high - low).max(0.0));
        Self { count: 1.0, volume: x * y * z, area: 2.0 * (x * y + y * z + z * x), edges: x + y + z }
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.volume += other.volume;
        self.area += other.area;
        self.edges += other.edges;
    }

    /// The measure of the motions for which two boxes meet, divided by `2 pi^2`, summed over every box of one set with
    /// every box of the other.
    fn meeting(&self, other: &Self) -> f64 {
        let volumes = 4.0 * (self.volume * other.count + other.volume * self.count);
        volumes + self.area * other.edges + other.area * self.edges
    }
}

/// Sums of values and their number.
#[derive(Copy, Clone, Default, Debug)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    /// Adds a ratio, if the denominator is positive.
    fn add(&mut self, part: f64, whole: f64) {
        if whole > 0.0 {
            self.sum += part / whole;
            self.count += 1.0;
        }
    }

    fn value(&self) -> f64 {
        if self.count > 0.0 { self.sum / self.count } else { 0.0 }
    }
}

#[derive(Default, Debug)]
struct LevelSums {
    /// Sizes of nodes and of leaves by level; the root's node has level 0.
    nodes: [Size; MAX_DEPTH + 1],
    leaves: [Size; MAX_DEPTH + 1],
    area_ratio: Mean,
    overlap: Mean,
    depth: Mean,
}

impl<N: Dop, P: Primitive> BvhRef<'_, N, P> {
    /// Predicts the cost of queries. Linear in the number of nodes. Zeros for an empty tree.
    #[must_use]
    pub fn tree_stats(&self) -> TreeStats {
        let sums = self.sums();
        let stats = self.stats();
        TreeStats {
            expected_visits: sums.expected_visits(),
            area_ratio: sums.area_ratio.value(),
            overlap: sums.overlap.value(),
            lanes_used: stats.lanes_used as f64 / (stats.nodes * N::ARITY).max(1) as f64,
            mean_depth: sums.depth.value(),
        }
    }

    fn sums(&self) -> LevelSums {
        let mut sums = LevelSums::default();
        if self.nodes().is_empty() {
            return sums;
        }
        sums.nodes[0] = self.add_node(0, &mut sums);
        for Lane { node, lane, level, child } in self.walk() {
            match child.link() {
                Link::Empty => {}
                Link::Leaf { count, .. } => {
                    sums.leaves[level].add(&Size::of(&self.lane_box(node, lane)));
                    sums.depth.sum += level as f64 * f64::from(count);
                    sums.depth.count += f64::from(count);
                }
                Link::Inner(below) => {
                    let size = self.add_node(below, &mut sums);
                    sums.nodes[level].add(&size);
                }
            }
        }
        sums
    }

    /// Adds the areas and overlaps of a node's lanes. Returns the size of the box around its lanes.
    fn add_node(&self, node: u32, sums: &mut LevelSums) -> Size {
        let used = |lane: &usize| self.nodes()[node as usize].children()[*lane].link() != Link::Empty;
        let lanes = || (0..N::ARITY).filter(used).map(|lane| self.lane_box(node, lane));
        let (mut whole, mut parts, mut shared) = (NOTHING, Size::default(), 0.0);
        for (i, a) in lanes().enumerate() {
            whole = core::array::from_fn(|k| [whole[k][0].min(a[k][0]), whole[k][1].max(a[k][1])]);
            parts.add(&Size::of(&a));
            for b in lanes().skip(i + 1) {
                let both = core::array::from_fn(|k| [a[k][0].max(b[k][0]), a[k][1].min(b[k][1])]);
                shared += Size::of(&both).volume;
            }
        }
        let whole = Size::of(&whole);
        sums.area_ratio.add(parts.area, whole.area);
        sums.overlap.add(shared, parts.volume);
        whole
    }

    fn lane_box(&self, node: u32, lane: usize) -> LaneBox {
        // Use the codes. They are half a step below the planes, about as much as rounding up adds on average.
        let plane = |j: usize| f64::from(self.nodes()[node as usize].plane(j, lane));
        core::array::from_fn(|axis| [-plane(2 * axis + 1), plane(2 * axis)])
    }
}

impl LevelSums {
    fn expected_visits(&self) -> f64 {
        let whole = self.nodes[0].meeting(&self.nodes[0]);
        let chance = |a: &Size, b: &Size| {
            if whole > 0.0 { a.meeting(b) / whole } else { a.count * b.count }
        };
        let (mut visits, mut leaves) = (0.0, Size::default());
        for (nodes, more) in self.nodes.iter().zip(&self.leaves) {
            leaves.add(more);
            visits += chance(nodes, nodes) + 2.0 * chance(&leaves, nodes);
        }
        visits
    }
}
