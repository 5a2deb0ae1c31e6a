//! How many slabs separate two DOPs: figure 12 of the SIMDop paper, from the kernel calls of real queries.
//!
//! A scalar test of one pair ends at the slab that separates it. A kernel that tests sixteen pairs at once can exit
//! when all of them are separated, as the paper's does, or not exit early, as the library's at k = 18.

use crate::data::MeshData;
use crate::page::show;
use crate::support::bodies::Scene;
use crate::support::record::{Arity, record};
use simdop::construct::{Builder, Mesh};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;

/// Prints the slabs per pair of DOPs, mean over the kernel calls of free poses.
pub(crate) fn report(mesh: &MeshData, poses: &[Pose]) {
    show!("| kernel | slabs | one pair after the other | till all 16 are separated |\n|---|---|---|---|");
    row::<Node16<18>>("1vs16", mesh, poses, |query, lane, node| {
        slabs(18, 16, |j, i| query[j][lane] > node.planes[j][i])
    });
    row::<Node4<18>>("4vs4", mesh, poses, |query, _, node| {
        slabs(18, 16, |j, i| query[j][i / 4] > node.planes[j][i % 4])
    });
    row::<Node16<32>>("1vs16", mesh, poses, |query, lane, node| {
        slabs(32, 16, |j, i| query[j][lane] > node.planes[j][i])
    });
    row::<Node4<32>>("4vs4", mesh, poses, |query, _, node| {
        slabs(32, 16, |j, i| query[j][i / 4] > node.planes[j][i % 4])
    });
    show!("");
}

/// The slabs that the scalar tests of a call's pairs need, and the slabs that each pair gets if all are tested until
/// the last is separated.
fn slabs(k: usize, pairs: usize, beyond: impl Fn(usize, usize) -> bool) -> [usize; 2] {
    let of = |pair: usize| {
        let first = (0..k / 2).find(|s| beyond(2 * s, pair) || beyond(2 * s + 1, pair));
        first.map_or(k / 2, |slab| slab + 1)
    };
    let (sum, most) = (0..pairs).map(of).fold((0, 0), |(sum, most), n| (sum + n, most.max(n)));
    [sum, pairs * most]
}

fn row<N: Arity>(
    name: &str,
    mesh: &MeshData,
    poses: &[Pose],
    slabs: impl Fn(&N::Bodies, usize, &N) -> [usize; 2],
) {
    let tree =
        Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let recording = record(&[Scene { tree, poses: poses.to_vec() }]);
    let pairs = 16.0 * recording.calls.len() as f64;
    let mut sums = [0; 2];
    for call in &recording.calls {
        let (query, node) = (&recording.queries[call.query as usize], &recording.nodes[call.node as usize]);
        let [one, all] = slabs(query, call.lane.into(), node);
        sums = [sums[0] + one, sums[1] + all];
    }
    let [one, all] = sums.map(|sum| sum as f64 / pairs);
    show!("| {name} | {} | {one:.2} | {all:.2} |", N::K / 2);
}
