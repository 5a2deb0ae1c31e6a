//! The BNG paper's two rivals of clustering, as shapes for the library's builder. Both select some spheres of a node
//! and assign each of the others to the one with the nearest centre. (The paper says "closest"; by the nearest surface
//! instead, big spheres would attract their whole surroundings, and trees inside meshes would get over 100 levels.)
//!
//! The paper has four lanes. For sixteen:
//!
//! * *biggest*: the sixteen biggest are selected;
//! * *extremes*: three axes have only six extremes, so the sixteen parts are made from four: each of the four parts is
//!   divided again, by its own extremes on its own two axes. A node is two levels of the tree of arity 4.
//!
//! Selecting the four biggest in each of four parts needed more visits than sixteen at once (two scenes of 2,000
//! spheres: 1.9 to 2.0 times those of Batch Neural Gas instead of 1.4). Sixteen extremes along eight directions needed
//! more than four in each of four parts (2.1 times instead of 1.7 to 1.8).

use simdop::construct::Assignment;
use simdop::hierarchy::MAX_DEPTH;
use simdop::primitive::Sphere;
use std::collections::VecDeque;
use std::ops::Range;

/// How the spheres of a node are divided.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Heuristic {
    /// By the biggest.
    Biggest,
    /// By the first and the last along each of the two axes with the largest extent.
    Extremes,
}

/// A shape, and how it was found.
pub(crate) struct Shape {
    pub(crate) assignment: Assignment,
    /// Nodes that were split into equal parts because the heuristic would have made the tree too deep.
    pub(crate) balanced: usize,
}

impl Heuristic {
    /// The shape of a tree with one sphere per leaf. A node with at most as many spheres as lanes has a lane for each.
    pub(crate) fn shape(self, spheres: &[Sphere], arity: usize) -> Shape {
        let mut order: Vec<u32> = (0..spheres.len() as u32).collect();
        let (mut ends, mut balanced) = (Vec::new(), 0);
        let mut waiting: VecDeque<(Range<usize>, usize)> = VecDeque::from([(0..spheres.len(), MAX_DEPTH)]);
        while let Some((range, levels_left)) = waiting.pop_front() {
            let items = &mut order[range.clone()];
            let parts = if items.len() <= arity {
                items.iter().map(|&item| vec![item]).collect()
            } else if levels_left <= levels_needed(items.len(), arity) {
                balanced += 1;
                equal_parts(spheres, items, arity)
            } else {
                self.divide(spheres, items, arity)
            };
            let mut start = range.start;
            for lane in 0..arity {
                let part = parts.get(lane).map_or(&[][..], |part| part);
                order[start..start + part.len()].copy_from_slice(part);
                if part.len() > 1 {
                    waiting.push_back((start..start + part.len(), levels_left - 1));
                }
                start += part.len();
                ends.push(start as u32);
            }
        }
        Shape { assignment: Assignment { order, ends }, balanced }
    }

    /// Divides more spheres than lanes into at least two and at most `arity` nonempty parts.
    fn divide(self, spheres: &[Sphere], items: &[u32], arity: usize) -> Vec<Vec<u32>> {
        match self {
            Self::Biggest => nearest(spheres, items, &biggest(spheres, items, arity)),
            Self::Extremes => {
                let mut parts = vec![items.to_vec()];
                while parts.len() * 4 <= arity {
                    let quarters = |part: &Vec<u32>| nearest(spheres, part, &extremes(spheres, part));
                    parts = parts.iter().flat_map(quarters).collect();
                }
                parts
            }
        }
    }
}

/// Levels of a balanced tree.
fn levels_needed(count: usize, arity: usize) -> usize {
    let (mut levels, mut room) = (0, 1);
    while room < count {
        (levels, room) = (levels + 1, room * arity);
    }
    levels
}

fn biggest(spheres: &[Sphere], items: &[u32], count: usize) -> Vec<u32> {
    let mut by_size = items.to_vec();
    by_size.sort_by(|&a, &b| {
        let radius = |i: u32| spheres[i as usize].radius;
        radius(b).total_cmp(&radius(a)).then(a.cmp(&b))
    });
    by_size.truncate(count);
    by_size
}

/// Four extremes, or fewer if one is extreme on both axes.
fn extremes(spheres: &[Sphere], items: &[u32]) -> Vec<u32> {
    let mut axes = [0, 1, 2].map(|axis| (extent(spheres, items, axis), axis));
    axes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<u32> = axes[..2].iter().flat_map(|&(_, axis)| ends(spheres, items, axis)).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// First and last along an axis.
fn ends(spheres: &[Sphere], items: &[u32], axis: usize) -> [u32; 2] {
    let along = |&a: &u32, &b: &u32| compare(spheres, axis, a, b);
    let end = |found: Option<u32>| found.expect("a node has spheres");
    [end(items.iter().copied().min_by(along)), end(items.iter().copied().max_by(along))]
}

fn extent(spheres: &[Sphere], items: &[u32], axis: usize) -> f64 {
    let [first, last] = ends(spheres, items, axis).map(|i| spheres[i as usize].centre[axis]);
    last - first
}

fn compare(spheres: &[Sphere], axis: usize, a: u32, b: u32) -> std::cmp::Ordering {
    let place = |i: u32| spheres[i as usize].centre[axis];
    place(a).total_cmp(&place(b)).then(a.cmp(&b))
}

/// A part for each of the `chosen` spheres, with the others nearest to it; the first one wins ties.
fn nearest(spheres: &[Sphere], items: &[u32], chosen: &[u32]) -> Vec<Vec<u32>> {
    let centre = |item: u32| spheres[item as usize].centre;
    let mut parts: Vec<Vec<u32>> = chosen.iter().map(|&c| vec![c]).collect();
    for &item in items.iter().filter(|item| !chosen.contains(item)) {
        let distance = |&part: &usize| square_distance(centre(item), centre(chosen[part]));
        let part = (0..chosen.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        parts[part.expect("one is chosen")].push(item);
    }
    parts
}

fn square_distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| (p[i] - q[i]) * (p[i] - q[i]));
    (x + y) + z
}

/// Equal parts along the longest axis.
fn equal_parts(spheres: &[Sphere], items: &[u32], arity: usize) -> Vec<Vec<u32>> {
    let longest = (0..3).max_by(|&a, &b| extent(spheres, items, a).total_cmp(&extent(spheres, items, b)));
    let mut sorted = items.to_vec();
    sorted.sort_by(|&a, &b| compare(spheres, longest.expect("there are three axes"), a, b));
    sorted.chunks(items.len().div_ceil(arity)).map(<[u32]>::to_vec).collect()
}
