//! The thin slabs of a tree whose planes are known.

use super::parallel;
use crate::frame::Frame;
use crate::node::{Link, Node, ThinSlab};
use crate::range::Point;
use alloc::vec::Vec;

/// The thin slab of every lane, `ARITY` a node: along the mean normal of what is below. `normal` gives a
/// primitive's, as long as it weighs.
pub(super) fn thin_slabs<N: Node, R: AsRef<[u32]> + Sync>(
    nodes: &[N],
    frame: &Frame,
    vertices: &[Point],
    records: &[R],
    normal: impl FnMut(&R) -> Point,
) -> Vec<ThinSlab> {
    let normals = mean_normals(nodes, records, normal);
    let points = Points::new(nodes, frame, vertices, records);
    let mut slabs = alloc::vec![ThinSlab::EVERYWHERE; nodes.len() * N::ARITY];
    parallel::for_each_chunk(&mut slabs, NODES_PER_TASK * N::ARITY, |task, slabs| {
        for (index, slab) in (task * NODES_PER_TASK * N::ARITY..).zip(slabs) {
            let (node, lane) = (index / N::ARITY, index % N::ARITY);
            let extent = |n| match nodes[node].children()[lane].link() {
                Link::Empty => (f64::INFINITY, f64::NEG_INFINITY),
                Link::Inner(below) => extent(points.below(below), n),
                Link::Leaf { first, count } => {
                    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
                    for record in &records[first as usize..][..count as usize] {
                        for &vertex in record.as_ref() {
                            ends = reach(ends, &n, &relative(&vertices[vertex as usize], frame));
                        }
                    }
                    ends
                }
            };
            *slab = ThinSlab::new(normals[index], |n| {
                let (low, high) = extent(n);
                (low * frame.scale(), high * frame.scale())
            });
        }
    });
    slabs
}

const NODES_PER_TASK: usize = 64;

/// The sum of the normals below each lane.
fn mean_normals<N: Node, R>(nodes: &[N], records: &[R], mut normal: impl FnMut(&R) -> Point) -> Vec<Point> {
    let add = |sum: &mut Point, n: &Point| (0..3).for_each(|i| sum[i] += n[i]);
    let mut normals = alloc::vec![[0.0; 3]; nodes.len() * N::ARITY];
    // Children come after their parents.
    for node in (0..nodes.len()).rev() {
        for (lane, child) in nodes[node].children().iter().enumerate() {
            let mut sum = [0.0; 3];
            match child.link() {
                Link::Empty => {}
                Link::Leaf { first, count } => {
                    for record in &records[first as usize..][..count as usize] {
                        add(&mut sum, &normal(record));
                    }
                }
                Link::Inner(below) => {
                    for lane in &normals[below as usize * N::ARITY..][..N::ARITY] {
                        add(&mut sum, lane);
                    }
                }
            }
            normals[node * N::ARITY + lane] = sum;
        }
    }
    normals
}

/// The corners below each node, relative to the frame's centre, those below one node in one run: a corner
/// counts once for each node that has a leaf which uses it.
struct Points {
    points: Vec<Point>,
    /// Where the run of each node begins and ends.
    runs: Vec<(usize, usize)>,
}

impl Points {
    fn new<N: Node, R: AsRef<[u32]>>(nodes: &[N], frame: &Frame, vertices: &[Point], records: &[R]) -> Self {
        // The corners of each node's own leaves, node by node.
        let mut own = Vec::with_capacity(vertices.len());
        let mut own_ends = Vec::with_capacity(nodes.len());
        let mut last_used_by = alloc::vec![usize::MAX; vertices.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in node.children() {
                let Link::Leaf { first, count } = child.link() else { continue };
                for &vertex in records[first as usize..][..count as usize].iter().flat_map(|r| r.as_ref()) {
                    if last_used_by[vertex as usize] != index {
                        last_used_by[vertex as usize] = index;
                        own.push(vertex);
                    }
                }
            }
            own_ends.push(own.len());
        }
        // How many corners are below each node. Children come after their parents.
        let own_of =
            |node: usize| if node == 0 { 0..own_ends[0] } else { own_ends[node - 1]..own_ends[node] };
        let mut counts = alloc::vec![0; nodes.len()];
        for node in (0..nodes.len()).rev() {
            let inner = inner_links(&nodes[node]);
            counts[node] = own_of(node).len() + inner.map(|below| counts[below]).sum::<usize>();
        }
        // A node's own corners, then its children's.
        let mut points = alloc::vec![[0.0; 3]; own.len()];
        let mut runs = alloc::vec![(0, own.len()); nodes.len()];
        for node in 0..nodes.len() {
            let mut next = runs[node].0;
            for &vertex in &own[own_of(node)] {
                points[next] = relative(&vertices[vertex as usize], frame);
                next += 1;
            }
            for below in inner_links(&nodes[node]) {
                runs[below] = (next, next + counts[below]);
                next += counts[below];
            }
        }
        Self { points, runs }
    }

    fn below(&self, node: u32) -> &[Point] {
        let (start, end) = self.runs[node as usize];
        &self.points[start..end]
    }
}

fn inner_links<N: Node>(node: &N) -> impl Iterator<Item = usize> {
    node.children().iter().filter_map(|child| match child.link() {
        Link::Inner(below) => Some(below as usize),
        _ => None,
    })
}

fn relative(p: &Point, frame: &Frame) -> Point {
    core::array::from_fn(|i| p[i] - frame.centre[i])
}

/// The least and the greatest support along n. Two at a time, so that they do not wait for each other.
fn extent(points: &[Point], n: Point) -> (f64, f64) {
    let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    let (pairs, rest) = points.as_chunks::<2>();
    for pair in pairs {
        ends = [reach(ends[0], &n, &pair[0]), reach(ends[1], &n, &pair[1])];
    }
    for p in rest {
        ends[0] = reach(ends[0], &n, p);
    }
    let [(low, high), (other_low, other_high)] = ends;
    (if other_low < low { other_low } else { low }, if other_high > high { other_high } else { high })
}

/// The least and the greatest support, of p too.
#[inline(always)]
fn reach((low, high): (f64, f64), n: &Point, p: &Point) -> (f64, f64) {
    // Five roundings with that of p, each 2^-53 of at most 2047 * 2^7 units.
    let x = (n[0] * p[0] + n[1] * p[1]) + n[2] * p[2];
    (if x < low { x } else { low }, if x > high { x } else { high })
}
