//! How loosely the volumes of a tree bound its triangles, in counts and lengths, not times.
//!
//! **False positives**, at a pose: the pairs of a leaf of A and a leaf of B whose k-DOPs meet although no triangle of
//! one meets a triangle of the other. A's k-DOPs are realigned to B's frame as in a query ([`simdop::realign`]), so
//! that both have the same directions; triangle tests are exact. This covers all pairs of leaves, not only those that a
//! query visits before its first hit. Further tests of a query, such as normal slabs, are not included: the query
//! statistics show them.
//!
//! **Overestimate**, of a leaf in a unit direction u, a length: the leaf's support along u as bounded by realignment
//! (the sum of weights times three of its planes), minus the support of its triangles. This is the gap between volume
//! and triangles after a rotation that maps u to a direction of the other body. Mean and maximum are over all leaves
//! and over [`directions`] that favour no k. It is never negative, and includes the loss from 16-bit planes.

use simdop::hierarchy::{AnyBvh, BvhRef, Lane};
use simdop::low_level::directions::Directions;
use simdop::low_level::frame::{BodyBounds, Frame};
use simdop::low_level::key::{Fixed, Half, Storage, StorageKind};
use simdop::low_level::realign::Realignment;
use simdop::node::{Dop, Link};
use simdop::pose::Pose;
use simdop::primitive::triangle::{Triangle, overlap};
use simdop::with_bvh;

/// The k-DOPs of a tree: its used lanes, extracted from the nodes.
pub(super) struct Volumes {
    k: usize,
    storage: StorageKind,
    extent: BodyBounds,
    /// The first lane of each node, and at the end the number of lanes.
    starts: Vec<usize>,
    links: Vec<Link>,
    /// Keys, `k` for each lane.
    planes: Vec<i16>,
    triangles: Vec<Triangle>,
}

/// Numbers of pairs of leaves at a pose.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub(super) struct Meetings {
    /// Pairs whose k-DOPs meet.
    pub(super) volumes: u64,
    /// Of these, pairs whose triangles meet.
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

/// One side of a pair that is pending.
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
        // The lanes come in depth-first order otherwise.
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
            storage: N::Storage::KIND,
            extent: tree.extent(),
            starts,
            links: lanes.iter().map(|lane| lane.child.link()).collect(),
            planes: lanes.iter().flat_map(codes).collect(),
            triangles: (0..tree.len() as u32).map(|index| tree.primitive(index)).collect(),
        }
    }

    /// `None` for a tree without triangles.
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

    /// The value of a plane's key, in steps of the frame.
    fn value(&self, code: i16) -> f32 {
        match self.storage {
            StorageKind::Fixed => Fixed::value(code),
            StorageKind::Half => Half::value(code),
        }
    }

    fn triangles(&self, lane: usize) -> &[Triangle] {
        match self.links[lane] {
            Link::Leaf { first, count } => &self.triangles[first as usize..(first + count) as usize],
            _ => &[],
        }
    }

    /// Adds the overestimates of the leaves.
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
                let bound =
                    weights.iter().map(|(plane, weight)| weight * f64::from(self.value(planes[*plane])));
                // Rounding can make it slightly negative.
                let excess = (bound.sum::<f64>() * 2_f64.powi(-exponent) - exact).max(0.0);
                overestimate.sum += excess;
                overestimate.count += 1;
                overestimate.greatest = overestimate.greatest.max(excess);
            }
        }
    }
}

/// Unit vectors through the centres of four by four squares on each face of a cube.
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

/// The planes that bound the support along a direction, with their weights.
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

/// Realigns the planes of one k-DOP: to the complement of the opposite plane in the other frame, ready for comparison.
type Turn = Box<dyn Fn(&[i16], &mut [i16])>;

fn turn<const K: usize, S: Storage>(pose: &Pose, a: &BodyBounds, b: &Frame) -> Turn {
    let map = Realignment::<K, S>::new(pose, a, b);
    Box::new(move |planes, turned| {
        for (j, turned) in turned.iter_mut().enumerate() {
            *turned = !map.plane(j ^ 1, |source| planes[source]).code();
        }
    })
}

fn turn_of<S: Storage>(k: usize, pose: &Pose, a: &BodyBounds, b: &Frame) -> Turn {
    match k {
        6 => turn::<6, S>(pose, a, b),
        14 => turn::<14, S>(pose, a, b),
        18 => turn::<18, S>(pose, a, b),
        26 => turn::<26, S>(pose, a, b),
        _ => turn::<32, S>(pose, a, b),
    }
}

/// Whether a realigned k-DOP meets one of the other body.
fn meet(turned: &[i16], planes: &[i16]) -> bool {
    turned.iter().zip(planes).all(|(turned, plane)| turned <= plane)
}

/// All pairs of leaves at a pose of `a` in the frame of `b`. Both have the same k and storage.
pub(super) fn meetings(a: &Volumes, b: &Volumes, pose: &Pose) -> Meetings {
    let mut found = Meetings::default();
    let (Some(root_a), Some(root_b)) = (a.root(), b.root()) else { return found };
    let turn_of = match a.storage {
        StorageKind::Fixed => turn_of::<Fixed>,
        StorageKind::Half => turn_of::<Half>,
    };
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
