//! The planes of a tree, and the widths in its links.

use crate::frame::Frame;
use crate::key::Key;
use crate::node::{Child, Dop, Link, Width};
use crate::parallel;
use crate::primitive::{Primitive, Sphere};
use alloc::vec::Vec;

/// Sets the planes of every lane to the supports of the corners below it, radii included. Rounding up is monotone, so
/// the maximum of the rounded supports is the rounded maximum: the hierarchy is the same whether each lane is reduced
/// from corners or from the lanes below. Each vertex is therefore rounded only once, though about six triangles and all
/// their ancestors use it.
pub(super) fn wrap<N: Dop, P: Primitive<Record: AsRef<[u32]>>>(
    nodes: &mut [N],
    frame: &Frame,
    vertices: &[P::Double],
    records: &[P::Record],
) {
    let keys = supports::<N, P>(frame, vertices);
    let keys_of = |vertex: u32| &keys[vertex as usize * N::K..][..N::K];
    parallel::for_each_chunk(nodes, NODES_PER_TASK, |_, nodes| {
        for node in nodes {
            for lane in 0..N::ARITY {
                let Link::Leaf { first, count } = node.children()[lane].link() else { continue };
                let records = &records[first as usize..][..count as usize];
                for vertex in records.iter().flat_map(|record| record.as_ref()) {
                    for (j, key) in keys_of(*vertex).iter().enumerate() {
                        node.raise_plane(j, lane, *key);
                    }
                }
            }
        }
    });
    for index in (0..nodes.len()).rev() {
        for lane in 0..N::ARITY {
            let Link::Inner(target) = nodes[index].children()[lane].link() else { continue };
            let below = nodes[target as usize];
            for j in 0..N::K {
                // Unused lanes have the lowest code, and a node has at least one used lane.
                let code = (0..N::ARITY).map(|lane| below.plane(j, lane)).fold(i16::MIN, i16::max);
                if let Some(key) = Key::<N::Storage>::from_code(code) {
                    nodes[index].raise_plane(j, lane, key);
                }
            }
            let width = Width::of_lane(&nodes[index], lane);
            nodes[index].set_child(lane, Child::inner(target, width));
        }
    }
}

const NODES_PER_TASK: usize = 512;
const VERTICES_PER_TASK: usize = 2048;

/// The key of each direction's support of each vertex, `K` per vertex.
fn supports<N: Dop, P: Primitive>(frame: &Frame, vertices: &[P::Double]) -> Vec<Key<N::Storage>> {
    let mut keys = alloc::vec![Key::<N::Storage>::LOWEST; vertices.len() * N::K];
    parallel::for_each_chunk(&mut keys, VERTICES_PER_TASK * N::K, |task, keys| {
        let vertices = &vertices[task * VERTICES_PER_TASK..];
        for (keys, vertex) in keys.chunks_exact_mut(N::K).zip(vertices) {
            for Sphere { centre, radius } in P::balls(vertex) {
                frame.raise_supports(N::DIRECTIONS, centre, radius, keys);
            }
        }
    });
    keys
}
