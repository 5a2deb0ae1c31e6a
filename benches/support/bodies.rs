//! Pairs of meshes at poses where they nearly touch.

use super::short::{count, is_short};
use crate::data::{MeshData, Suite, directory};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};

/// A mesh against itself.
pub(crate) struct Scene<N> {
    pub(crate) tree: Bvh<N>,
    /// The poses of the suites (`tests/support/data.rs`) at which it is free: 1e-2 to 1e-8 of the diagonal
    /// from contact.
    pub(crate) poses: Vec<Pose>,
}

/// Cow (5 804 triangles) and armadillo (52 000), if the data sets are there, else a made-up shape; of a short
/// run a small one.
pub(crate) fn scenes<N: Lanes>() -> Vec<Scene<N>> {
    let meshes = if is_short() {
        // The smaller has many unused lanes for its size.
        vec![wavy_torus(40), wavy_torus(4)]
    } else if let Some(data) = directory() {
        ["cow", "armadillo"].map(|name| MeshData::obj(&data.join(format!("meshes/{name}.obj")))).into()
    } else {
        eprintln!("*** GENERATED SHAPE: figures are not those of the documents ***");
        vec![wavy_torus(100)]
    };
    meshes.into_iter().map(scene).collect()
}

fn scene<N: Lanes>(mesh: MeshData) -> Scene<N> {
    let tree: Bvh<N> =
        Builder::new().build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let meets = |rows: &[[f64; 4]; 3]| {
        let pose = Pose::from_rows(*rows).unwrap();
        Query::new(Isa::detect()).collide(&tree.view(), &tree.view(), &pose).hit().is_some()
    };
    let suite = Suite { name: "bench", a: mesh.clone(), b: mesh };
    let free = suite.poses(count(1, 8), meets).into_iter().filter(|rows| !meets(rows));
    let poses = free.map(|rows| Pose::from_rows(rows).unwrap()).collect();
    Scene { tree, poses }
}

pub(crate) fn wavy_torus(n: u32) -> MeshData {
    let angle = |i: u32| f64::from(i) / f64::from(n) * core::f64::consts::TAU;
    let grid = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let vertex = |(i, j)| {
        let ((s, c), (v, u)) = (angle(i).sin_cos(), angle(j).sin_cos());
        let r = 2.0 + (0.7 + 0.2 * (5.0 * angle(i)).cos()) * u;
        [r * c, r * s, 0.7 * v + 0.3 * (3.0 * angle(j)).sin()]
    };
    let at = |i: u32, j: u32| i % n * n + j % n;
    let cell =
        |(i, j)| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]];
    MeshData { vertices: grid().map(vertex).collect(), triangles: grid().flat_map(cell).collect() }
}
