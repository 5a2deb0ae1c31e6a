//! The normal slabs of a tree.

use super::corners_below::CornersBelow;
use crate::construct::input::{Geometry, Record, corners_of};
use crate::frame::Frame;
use crate::node::{Link, Node, NormalSlab};
use crate::parallel;
use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use crate::vector::length;
use alloc::vec::Vec;

/// The normal slab of every lane, `ARITY` per node: along the mean normal of the primitives below.
pub(super) fn normal_slabs<N: Node, G: Geometry>(
    nodes: &[N],
    frame: &Frame,
    vertices: &[<G::Primitive as Primitive>::Double],
    records: &[Record<G>],
) -> Vec<NormalSlab> {
    let mut corners = Vec::new();
    let normals = mean_normals(nodes, records, |record| {
        corners_of::<G::Primitive>(vertices, record, &mut corners);
        G::normal(&corners)
    });
    let corners = CornersBelow::<G::Primitive>::new(nodes, vertices, records);
    let mut slabs = alloc::vec![NormalSlab::EVERYWHERE; nodes.len() * N::ARITY];
    parallel::for_each_chunk(&mut slabs, NODES_PER_TASK * N::ARITY, |task, slabs| {
        for (index, slab) in (task * NODES_PER_TASK * N::ARITY..).zip(slabs) {
            let (node, lane) = (index / N::ARITY, index % N::ARITY);
            let along = |n| {
                let length = if G::Primitive::IS_ROUND { length(&n) } else { 0.0 };
                let mut along = Stretch { n, length, centre: frame.centre, ends: NONE };
                match nodes[node].children()[lane].link() {
                    Link::Empty => {}
                    Link::Inner(below) => along.extend::<G::Primitive>(corners.below(below)),
                    Link::Leaf { first, count } => {
                        for record in &records[first as usize..][..count as usize] {
                            for &vertex in record.as_ref() {
                                along.add::<G::Primitive>(&vertices[vertex as usize]);
                            }
                        }
                    }
                }
                let (low, high) = along.ends;
                (low * frame.scale(), high * frame.scale())
            };
            *slab = NormalSlab::new(normals[index], along);
        }
    });
    slabs
}

const NODES_PER_TASK: usize = 64;

/// The sum of the normals of the primitives below each lane.
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

/// The least and the greatest support of an empty set.
const NONE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// The least and the greatest support along n, relative to a centre.
#[derive(Copy, Clone)]
struct Stretch {
    n: Point,
    length: f64,
    centre: Point,
    ends: (f64, f64),
}

impl Stretch {
    /// Includes corners. Two accumulators, so that their latencies overlap.
    fn extend<P: Primitive>(&mut self, corners: &[P::Double]) {
        let mut other = Self { ends: NONE, ..*self };
        let (pairs, rest) = corners.as_chunks::<2>();
        for [p, q] in pairs {
            self.add::<P>(p);
            other.add::<P>(q);
        }
        for p in rest {
            self.add::<P>(p);
        }
        self.join(other.ends);
    }

    /// Includes a corner.
    #[inline(always)]
    fn add<P: Primitive>(&mut self, corner: &P::Double) {
        for Sphere { centre: p, radius } in P::balls(corner) {
            let (n, c) = (&self.n, &self.centre);
            // A few roundings, each 2^-53 of at most 2047 * 2^15 units.
            let x = (n[0] * (p[0] - c[0]) + n[1] * (p[1] - c[1])) + n[2] * (p[2] - c[2]);
            let reach = self.length * radius;
            self.join(if P::IS_ROUND { (x - reach, x + reach) } else { (x, x) });
        }
    }

    #[inline(always)]
    fn join(&mut self, (low, high): (f64, f64)) {
        self.ends = (
            if low < self.ends.0 { low } else { self.ends.0 },
            if high > self.ends.1 { high } else { self.ends.1 },
        );
    }
}
