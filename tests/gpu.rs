//! Batch Neural Gas on a device: the scalar builder's bytes, and errors as values.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod support;

use core::ops::ControlFlow;
use simdop::build::gpu::{Gpu, Otherwise};
use simdop::build::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::node::{Node, Node4, Node16};
use support::data::MeshData;
use support::shapes;

fn device() -> Option<Gpu> {
    Some(Gpu::new().unwrap())
}

fn mesh_of(mesh: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }
}

fn compare<N: Node>(gpu: &Gpu, name: &str, mesh: &MeshData, builder: &Builder) {
    let start = std::time::Instant::now();
    let got: Bvh<N> =
        builder.build_on(gpu, Otherwise::Fail, &mesh_of(mesh), &mut |_| ControlFlow::Continue(())).unwrap();
    let on_gpu = start.elapsed();
    let want: Bvh<N> = builder.build(&mesh_of(mesh)).unwrap();
    println!("{name} {builder:?} {on_gpu:?} {:?}", start.elapsed() - on_gpu);
    assert!(got.as_bytes() == want.as_bytes(), "{name}, {builder:?}");
}

#[test]
fn smoke() {
    let Some(gpu) = device() else { return };
    println!("{:?} {}", gpu.info(), gpu.has_int64());
    for (a, b) in [(3, 3), (5, 4), (20, 10), (30, 20), (60, 40), (200, 100)] {
        let mesh = shapes::torus(a, b);
        for magnification in [Magnification::None, Magnification::Area] {
            let builder = Builder::new().splitter(Splitter::BatchNeuralGas { magnification, seed: 0 });
            compare::<Node16<6>>(&gpu, "torus", &mesh, &builder);
            compare::<Node4<6>>(&gpu, "torus", &mesh, &builder);
        }
    }
}
