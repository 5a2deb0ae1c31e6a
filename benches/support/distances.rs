//! Poses of a mesh against itself at the suites' distances.

use crate::data::MeshData;
use crate::suites::{Approaching, DISTANCES, Method};
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use simdop::pose::Pose;

/// One value for each distance.
pub(crate) type PerDistance<T> = [T; DISTANCES.len()];

/// `count` poses at each distance, half of them by each method. They are found with the trees of one fixed splitter, so
/// that a change to another splitter is measured at the same poses.
pub(crate) fn poses(mesh: &MeshData, count: usize) -> PerDistance<Vec<Pose>> {
    let tree: Bvh<Node16<18>> = Builder::new()
        .splitter(Splitter::ExtendedLongestAxis)
        .build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles })
        .unwrap();
    let pair = Approaching { a: mesh, b: mesh, tree_a: tree.view(), tree_b: tree.view() };
    let mut poses: PerDistance<Vec<Pose>> = Default::default();
    for line in Method::ALL.into_iter().flat_map(|method| pair.poses(&DISTANCES, method, count / 2, 1)) {
        for (poses, rows) in poses.iter_mut().zip(line) {
            poses.push(Pose::from_rows(rows).unwrap());
        }
    }
    poses
}
