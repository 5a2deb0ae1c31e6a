//! The cost of a query in each splitter's trees, in counted work: `cargo bench --bench splitters` prints a table, the
//! same on every machine. Five minutes.
//!
//! Visits per query of a mesh against itself, mean over [`POSES`] poses at each of the four distances of
//! `support/suites.rs`: k = 18, arity 16, one triangle per leaf.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/distances.rs"]
mod distances;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/suites.rs"]
mod suites;

use data::{MeshData, directory};
use distances::{PerDistance, poses};
use page::show;
use short::{count, some};
use simdop::construct::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};
use suites::DISTANCES;

const MODELS: [&str; 6] = ["cow", "armadillo", "bunny75k", "camel", "hand", "fandisk_large"];

/// The splitters compared. The last is that of the best preset, and should need the fewest visits.
const SPLITTERS: [(&str, Splitter); 6] = [
    ("longest axis", Splitter::LongestAxis),
    ("extended longest axis", Splitter::ExtendedLongestAxis),
    ("surface area", Splitter::SurfaceArea),
    ("neural gas", Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 0 }),
    ("neural gas by area", Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 }),
    ("mean width", Splitter::MeanWidth),
];

/// Enough to resolve differences of 1 % between trees: with 100 poses, another seed changes the order of the best
/// three.
const POSES: usize = 1600;

fn main() {
    let Some(data) = directory() else { return };
    page::begin(
        "Visits by splitter",
        "Visits per query, means over the poses: a mesh against itself, k = 18, arity 16, one triangle a \
         leaf. The counts are the same on every machine.",
    );
    show!("| mesh | splitter | {} |", DISTANCES.map(|(name, _)| name).join(" | "));
    show!("|---|---|{}", "---|".repeat(DISTANCES.len()));
    let mut fewest = 0;
    for model in some(&MODELS) {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        let poses = poses(&mesh, count(POSES, 8));
        let visits = SPLITTERS.map(|(_, splitter)| visits(&build(&mesh, splitter), &poses));
        for ((splitter, _), visits) in SPLITTERS.iter().zip(&visits) {
            show!("| {model} | {splitter} | {} |", visits.map(|v| format!("{v:.2}")).join(" | "));
        }
        let [rivals @ .., best] = &visits;
        fewest += usize::from(rivals.iter().all(|rival| best.iter().zip(rival).all(|(best, r)| best <= r)));
    }
    show!(
        "\nThe last splitter needs the fewest visits at all distances on {fewest} of {} meshes.",
        some(&MODELS).len()
    );
    page::write();
}

fn build<N: Lanes>(mesh: &MeshData, splitter: Splitter) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Builder::new().splitter(splitter).build_as(&mesh).unwrap()
}

fn visits(tree: &Bvh<Node16<18>>, poses: &PerDistance<Vec<Pose>>) -> PerDistance<f64> {
    let query = Query::new(Isa::detect());
    let visits = |pose| query.collide(&tree.view(), &tree.view(), pose).stats.visits;
    poses.each_ref().map(|poses| poses.iter().map(visits).sum::<u64>() as f64 / poses.len() as f64)
}
