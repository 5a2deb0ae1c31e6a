//! The thin slabs of a tree whose planes are known.

use super::geometry::balls;
use super::parallel;
use crate::frame::Frame;
use crate::node::{Link, Node, ThinSlab};
use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use alloc::vec::Vec;

/// The thin slab of every lane, `ARITY` a node: along the mean normal of what is below. `normal` gives a
/// primitive's, as long as it weighs.
pub(super) fn thin_slabs<N: Node, P: Primitive<Record: AsRef<[u32]>>>(
    nodes: &[N],
    frame: &Frame,
    vertices: &[P::Double],
    records: &[P::Record],
    normal: impl FnMut(&P::Record) -> Point,
) -> Vec<ThinSlab> {
    let normals = mean_normals(nodes, records, normal);
    let mut slabs = alloc::vec![ThinSlab::EVERYWHERE; nodes.len() * N::ARITY];
    parallel::for_each_chunk(&mut slabs, NODES_PER_TASK * N::ARITY, |task, slabs| {
        let mut pending = Vec::new();
        for (index, slab) in (task * NODES_PER_TASK * N::ARITY..).zip(slabs) {
            let (node, lane) = (index / N::ARITY, index % N::ARITY);
            let link = nodes[node].children()[lane].link();
            *slab = ThinSlab::new(normals[index], |n| {
                pending.push(link);
                extent::<N, P>(nodes, frame, vertices, records, &mut pending, n)
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

/// The least and the greatest support along n of what is below the pending links, in the frame.
fn extent<N: Node, P: Primitive<Record: AsRef<[u32]>>>(
    nodes: &[N],
    frame: &Frame,
    vertices: &[P::Double],
    records: &[P::Record],
    pending: &mut Vec<Link>,
    n: Point,
) -> (f64, f64) {
    let (c, scale) = (frame.centre, frame.scale());
    let length = libm::sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2]);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    while let Some(link) = pending.pop() {
        match link {
            Link::Empty => {}
            Link::Inner(node) => pending.extend(nodes[node as usize].children().iter().map(|c| c.link())),
            Link::Leaf { first, count } => {
                for record in &records[first as usize..][..count as usize] {
                    for Sphere { centre: p, radius } in balls::<P>(vertices, record) {
                        // A few roundings, each 2^-53 of at most 2047 * 2^7.
                        let x = (n[0] * (p[0] - c[0]) + n[1] * (p[1] - c[1])) + n[2] * (p[2] - c[2]);
                        let reach = length * radius;
                        let (least, most) = (x - reach, x + reach);
                        (low, high) =
                            (if least < low { least } else { low }, if most > high { most } else { high });
                    }
                }
            }
        }
    }
    (low * scale, high * scale)
}
