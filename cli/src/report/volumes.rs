//! How far the volumes of a tree say more than its triangles: counted and measured, not timed.
//!
//! **False positives**, at a pose: the pairs of a leaf of A and a leaf of B whose k-DOPs meet although no triangle
//! of the one meets one of the other. A's k-DOPs are turned into B's frame as a query turns them
//! ([`simdop::realign`]), so that both are k-DOPs of the same directions; triangles are decided exactly. All pairs
//! of leaves are meant, not those alone that a query comes to before its first hit. What else a query tells pairs
//! apart by, such as normal slabs, is not asked: that shows in its counters.
//!
//! **Overestimate**, of a leaf in a unit direction u, a length: what re-alignment takes for the leaf's support
//! along u, the sum of weights times three of its planes, less the support of its triangles. So far does the
//! volume stick out when it is turned until u is a direction of the other body. Mean and greatest are over all
//! leaves and [`directions`] that prefer no k. It is never negative, and holds what storing planes in 16 bits adds.

use simdop::hierarchy::{AnyBvh, BvhRef, Lane};
use simdop::low_level::directions::Directions;
use simdop::low_level::frame::{BodyBounds, Frame};
use simdop::low_level::key::decode;
use simdop::low_level::realign::Realignment;
use simdop::node::{Dop, Link};
use simdop::pose::Pose;
use simdop::primitive::triangle::{Triangle, overlap};
use simdop::with_bvh;

/// The k-DOPs of a tree, its lanes in use, out of their nodes.
pub(super) struct Volumes {
    k: usize,
    extent: BodyBounds,
    /// Of each node the first of its lanes, and at the end their number.
    starts: Vec<usize>,
    links: Vec<Link>,
    /// Codes, `k` for each lane.
    planes: Vec<i16>,
    triangles: Vec<Triangle>,
}

/// Pairs of leaves at a pose.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub(super) struct Meetings {
    /// Those whose volumes meet.
    pub(super) volumes: u64,
    /// Of these, those whose triangles meet.
    pub(super) triangles: u64,
}

impl Meetings {
    pub(super) const fn false_positives(self) -> u64 {
        self.volumes - self.triangles
    }
}

/// Lengths in the mesh's unit.
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub(super) struct Overestimate {
    sum: f64,
    count: usize,
    pub(super) greatest: f64,
}

impl Overestimate {
    pub(super) fn mean(&self) -> f64 {
        if self.count > 0 { self.sum / self.count as f64 } else { 0.0 }
    }
}

/// One side of a pair that is still to be opened.
#[derive(Copy, Clone, Debug)]
enum Side {
    Node(usize),
    /// A lane that is a leaf.
    Leaf(usize),
}

impl Volumes {
    pub(super) fn of(tree: &AnyBvh) -> Self {
        with_bvh!(tree.view(), tree => Self::of_nodes(&tree))
    }

    fn of_nodes<N: Dop>(tree: &BvhRef<'_, N>) -> Self {
        let mut lanes: Vec<Lane> = tree.walk().collect();
        // Depth first otherwise.
        lanes.sort_by_key(|lane| (lane.node, lane.lane));
        let mut starts = vec![0; tree.nodes().len() + 1];
        for lane in &lanes {
            starts[lane.node as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let nodes = tree.nodes();
        let codes = |lane: &Lane| {
            let (node, number) = (lane.node as usize, lane.lane);
            (0..N::K).map(move |j| nodes[node].plane(j, number))
        };
        Self {
            k: N::K,
            extent: tree.extent(),
            starts,
            links: lanes.iter().map(|lane| lane.child.link()).collect(),
            planes: lanes.iter().flat_map(codes).collect(),
            triangles: (0..tree.len() as u32).map(|index| tree.primitive(index)).collect(),
        }
    }

    /// Of a tree without a triangle there is none.
    fn root(&self) -> Option<Side> {
        (self.starts.len() > 1).then_some(Side::Node(0))
    }

    fn lanes(&self, side: Side) -> core::ops::Range<usize> {
        match side {
            Side::Node(node) => self.starts[node]..self.starts[node + 1],
            Side::Leaf(lane) => lane..lane + 1,
        }
    }

    fn below(&self, lane: usize) -> Side {
        match self.links[lane] {
            Link::Inner(node) => Side::Node(node as usize),
            _ => Side::Leaf(lane),
        }
    }

    fn planes(&self, lane: usize) -> &[i16] {
        &self.planes[lane * self.k..(lane + 1) * self.k]
    }

    fn triangles(&self, lane: usize) -> &[Triangle] {
        match self.links[lane] {
            Link::Leaf { first, count } => &self.triangles[first as usize..(first + count) as usize],
            _ => &[],
        }
    }

    /// Adds what its leaves overestimate.
    pub(super) fn measure(&self, overestimate: &mut Overestimate) {
        let Frame { centre, exponent } = self.extent.frame;
        let directions = directions();
        let weights: Vec<_> = directions.iter().map(|direction| weights(self.k, *direction)).collect();
        for lane in 0..self.links.len() {
            let Link::Leaf { .. } = self.links[lane] else { continue };
            let planes = self.planes(lane);
            for (direction, weights) in directions.iter().zip(&weights) {
                let support = |corner: &[f64; 3]| {
                    let [x, y, z]: [f64; 3] =
                        core::array::from_fn(|i| direction[i] * (corner[i] - centre[i]));
                    x + y + z
                };
                let exact = self.triangles(lane).iter().flatten().map(support).fold(f64::MIN, f64::max);
                let bound = weights.iter().map(|(plane, weight)| weight * f64::from(decode(planes[*plane])));
                // A rounding below zero is none.
                let excess = (bound.sum::<f64>() * 2_f64.powi(-exponent) - exact).max(0.0);
                overestimate.sum += excess;
                overestimate.count += 1;
                overestimate.greatest = overestimate.greatest.max(excess);
            }
        }
    }
}

/// Unit vectors through the middles of four by four squares on each side of a cube.
fn directions() -> Vec<[f64; 3]> {
    let steps = [-0.75, -0.25, 0.25, 0.75];
    let mut all = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        for (u, v) in steps.into_iter().flat_map(|u| steps.map(|v| (u, v))) {
            let length = f64::sqrt(1.0 + u * u + v * v);
            let mut direction = [0.0; 3];
            direction[axis] = sign / length;
            direction[(axis + 1) % 3] = u / length;
            direction[(axis + 2) % 3] = v / length;
            all.push(direction);
        }
    }
    all
}

/// The planes that bound a support along a direction, with their weights.
fn weights(k: usize, direction: [f64; 3]) -> [(usize, f64); 3] {
    let found = match k {
        6 => Directions::<6>::decompose(direction),
        14 => Directions::<14>::decompose(direction),
        18 => Directions::<18>::decompose(direction),
        26 => Directions::<26>::decompose(direction),
        _ => Directions::<32>::decompose(direction),
    };
    core::array::from_fn(|l| (usize::from(found.directions[l]), found.weights[l]))
}

/// Turns the planes of one volume: to the complement of the opposite plane in the other frame, ready for the
/// compare.
type Turn = Box<dyn Fn(&[i16], &mut [i16])>;

fn turn<const K: usize>(pose: &Pose, a: &BodyBounds, b: &Frame) -> Turn {
    let map = Realignment::<K>::new(pose, a, b);
    Box::new(move |planes, turned| {
        for (j, turned) in turned.iter_mut().enumerate() {
            *turned = !map.plane(j ^ 1, |source| planes[source]).code();
        }
    })
}

fn turn_of(k: usize, pose: &Pose, a: &BodyBounds, b: &Frame) -> Turn {
    match k {
        6 => turn::<6>(pose, a, b),
        14 => turn::<14>(pose, a, b),
        18 => turn::<18>(pose, a, b),
        26 => turn::<26>(pose, a, b),
        _ => turn::<32>(pose, a, b),
    }
}

/// Whether a turned volume meets one of the other body.
fn meet(turned: &[i16], planes: &[i16]) -> bool {
    turned.iter().zip(planes).all(|(turned, plane)| turned <= plane)
}

/// All pairs of leaves at a pose of `a` in the frame of `b`. Both have the same k.
pub(super) fn meetings(a: &Volumes, b: &Volumes, pose: &Pose) -> Meetings {
    let mut found = Meetings::default();
    let (Some(root_a), Some(root_b)) = (a.root(), b.root()) else { return found };
    let turn = turn_of(a.k, pose, &a.extent, &b.extent.frame);
    let mut turned = vec![0; a.planes.len()];
    let mut is_turned = vec![false; a.links.len()];
    let mut pairs = vec![(root_a, root_b)];
    while let Some((side_a, side_b)) = pairs.pop() {
        for lane_a in a.lanes(side_a) {
            let at = lane_a * a.k..(lane_a + 1) * a.k;
            if !is_turned[lane_a] {
                turn(a.planes(lane_a), &mut turned[at.clone()]);
                is_turned[lane_a] = true;
            }
            for lane_b in b.lanes(side_b).filter(|&lane_b| meet(&turned[at.clone()], b.planes(lane_b))) {
                match (a.below(lane_a), b.below(lane_b)) {
                    (Side::Leaf(_), Side::Leaf(_)) => {
                        found.volumes += 1;
                        found.triangles +=
                            u64::from(any_meet(a.triangles(lane_a), b.triangles(lane_b), pose));
                    }
                    below => pairs.push(below),
                }
            }
        }
    }
    found
}

fn any_meet(a: &[Triangle], b: &[Triangle], pose: &Pose) -> bool {
    let mut exact = 0;
    a.iter().any(|triangle| {
        let moved = triangle.map(|corner| pose.apply(corner));
        b.iter().any(|other| overlap(&moved, other, &mut exact))
    })
}

#[cfg(test)]
mod tests;
