//! The gain from a coarser body: `cargo bench --bench cover` prints a table. Three minutes.
//!
//! A mesh against itself at the poses of `support/suites.rs`, compared with trees of spheres that cover it within
//! several errors relative to its diagonal: against each other, and against the mesh; as surfaces, and as solids if it
//! is closed. All are queried in turns, [`PASSES`] times; the minimum time of each query counts. First checks that the
//! meshes are free wherever the spheres are, and that no hit is farther than the error.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/meshes.rs"]
mod meshes;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "../tests/support/shapes.rs"]
mod shapes;
#[path = "support/short.rs"]
mod short;
#[path = "support/suites.rs"]
mod suites;

use data::{MeshData, directory};
use meshes::SCENES;
use page::show;
use short::count;
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::query::Query;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::Instant;
use suites::{Approaching, DISTANCES, Method};

type Node = Node16<18>;

const LINES: usize = 100;
const PASSES: usize = 7;
const ERRORS: [f64; 3] = [0.02, 0.01, 0.005];

fn main() {
    page::begin(
        "Covers",
        "Medians, in microseconds a query: the mesh against itself / the spheres that cover it against themselves \
         / the spheres against the mesh. Errors are shares of the diagonal.",
    );
    show!("| mesh | as | error | spheres | cover, s | bytes, of the mesh's | 1 % deep | 0 % | 1 % | 5 % |");
    show!("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut meshes = vec![("torus".to_owned(), shapes::wavy_torus(count(20_000, 1000) as u32))];
    if let Some(data) = directory() {
        for scene in &SCENES {
            if let [mesh] = &scene.meshes(&data)[..] {
                meshes.push((scene.name.to_owned(), mesh.clone()));
            }
        }
    }
    for (name, mesh) in &meshes[..count(meshes.len(), 1)] {
        for is_solid in [false, true] {
            for &error in &ERRORS[..count(ERRORS.len(), 1)] {
                row(name, mesh, error, is_solid);
            }
        }
    }
    page::write();
}

fn row(name: &str, data: &MeshData, share: f64, is_solid: bool) {
    let mesh = Mesh { vertices: &data.vertices, triangles: &data.triangles };
    let builder = if is_solid { Builder::new().solid() } else { Builder::new() };
    let exact: Bvh<Node> = match builder.build_as(&mesh) {
        Err(BuildError::Open { .. }) => return,
        built => built.unwrap(),
    };
    let error = share * data.diagonal();
    let start = Instant::now();
    let spheres = if is_solid { mesh.cover_solid(error) } else { mesh.cover(error) }.unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let coarse: Bvh<Node, Spheres> = Builder::balanced()
        .without_balls()
        .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let rough = Builder::new().build_as::<Node>(&mesh).unwrap();
    let pair = Approaching { a: data, b: data, tree_a: rough.view(), tree_b: rough.view() };
    let lines: Vec<_> = Method::ALL
        .into_iter()
        .flat_map(|method| pair.poses(&DISTANCES, method, count(LINES, 8) / 2, 1))
        .collect();
    let query = Query::new(Isa::detect());
    let mut cells = Vec::new();
    for distance in 0..DISTANCES.len() {
        let poses: Vec<Pose> = lines.iter().map(|line| Pose::from_rows(line[distance]).unwrap()).collect();
        let mut times = vec![[f64::INFINITY; 3]; poses.len()];
        for pose in &poses {
            let [own, both, one] = [
                query.collide(&exact, &exact, pose).is_free(),
                query.collide(&coarse, &coarse, pose).is_free(),
                query.collide(&coarse, &exact, pose).is_free(),
            ];
            assert!(own || !both && !one, "the spheres are free, and the mesh is not");
            let near =
                |reach: f64| !query.within(&exact, &exact, pose, reach * (1.0 + 1e-9)).unwrap().is_free();
            assert!((both || near(2.0 * error)) && (one || near(error)), "a hit beyond the error");
        }
        for _ in 0..count(PASSES, 1) {
            for (pose, times) in poses.iter().zip(&mut times) {
                let mut time = |slot: usize, f: &dyn Fn() -> bool| {
                    let start = Instant::now();
                    black_box(f());
                    times[slot] = times[slot].min(start.elapsed().as_secs_f64() * 1e6);
                };
                time(0, &|| query.collide(&exact, &exact, pose).is_free());
                time(1, &|| query.collide(&coarse, &coarse, pose).is_free());
                time(2, &|| query.collide(&coarse, &exact, pose).is_free());
            }
        }
        let median = |slot: usize| {
            let mut sorted: Vec<f64> = times.iter().map(|times| times[slot]).collect();
            sorted.sort_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        cells.push(format!("{:.2} / {:.2} / {:.2}", median(0), median(1), median(2)));
    }
    show!(
        "| {name} | {} | {share} | {} | {seconds:.2} | {:.3} | {} |",
        if is_solid { "solid" } else { "surface" },
        spheres.len(),
        coarse.as_bytes().len() as f64 / exact.as_bytes().len() as f64,
        cells.join(" | ")
    );
}
