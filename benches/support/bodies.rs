//! Pairs of meshes at poses where they nearly touch.

use super::short::{count, is_short};
use crate::data::{MeshData, Suite, directory};
use crate::shapes::wavy_torus;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};

/// A mesh against itself.
pub(crate) struct Scene<N> {
    pub(crate) tree: Bvh<N>,
    /// The poses of the suites (`tests/support/data.rs`) at which it is free: 1e-2 to 1e-8 of the diagonal from
    /// contact.
    pub(crate) poses: Vec<Pose>,
}

/// Cow (5 804 triangles) and armadillo (52 000), if the data sets exist, otherwise a generated shape; in a short run a
/// small one.
pub(crate) fn scenes<N: Lanes>() -> Vec<Scene<N>> {
    let meshes = if is_short() {
        // The smaller one has many unused lanes for its size.
        vec![wavy_torus(3200), wavy_torus(32)]
    } else if let Some(data) = directory() {
        ["cow", "armadillo"].map(|name| MeshData::obj(&data.join(format!("meshes/{name}.obj")))).into()
    } else {
        eprintln!("*** GENERATED SHAPE: figures are not those of the documents ***");
        vec![wavy_torus(20_000)]
    };
    meshes.into_iter().map(scene).collect()
}

fn scene<N: Lanes>(mesh: MeshData) -> Scene<N> {
    let tree: Bvh<N> =
        Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let meets = |rows: &[[f64; 4]; 3]| {
        let pose = Pose::from_rows(*rows).unwrap();
        Query::new(Isa::detect()).collide(&tree.view(), &tree.view(), &pose).hit().is_some()
    };
    let suite = Suite { name: "bench", a: mesh.clone(), b: mesh };
    let free = suite.poses(count(1, 8), meets).into_iter().filter(|rows| !meets(rows));
    let poses = free.map(|rows| Pose::from_rows(rows).unwrap()).collect();
    Scene { tree, poses }
}
