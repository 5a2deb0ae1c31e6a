//! Hierarchies over spheres: Batch Neural Gas, with and without the spheres' volumes as weights, beside the
//! two heuristics that the BNG paper measures it against (Weller, Mainzer, Srinivas, Teschner & Zachmann
//! 2014, section 4). `cargo bench --bench spheres` prints a table, the same on every machine.
//!
//! Arity 4, as in the paper. Nodes are wrapped: a node's ball encloses the spheres below it, not the balls of
//! its children. Compared are, in a query for penetration volume, which meets every pair of spheres that
//! overlap, the visits of two nodes, which are what SIMD code pays for, and the tests of two balls: means
//! over [`POSES`] poses of a packing against itself, and in brackets their ratio to the first row's. Every
//! tree must find the pairs that brute force finds.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
mod spheres {
    pub(crate) mod heuristics;
    pub(crate) mod packing;
    pub(crate) mod tree;
}

use data::{MeshData, directory};
use rng::Rng;
use short::{count, some};
use simdop::construct::{Magnification, Splitter};
use spheres::packing::{self, Sphere};
use spheres::tree::{Moved, Node, by_heuristic, by_splitter, pairs_by_brute_force};
use spheres::{heuristics, tree};

const POSES: usize = 200;
/// Of a packing.
const SPHERES: usize = 4000;
/// Batch Neural Gas is built so often, from other starts; its figures are means.
const SEEDS: usize = 5;

fn number() -> usize {
    count(SPHERES, 200)
}

fn main() {
    println!("| spheres | hierarchy | visits | tests | children's volume | depth |");
    println!("|---|---|---|---|---|---|");
    for (exponent, name) in [(0.0, "alike"), (1.0, "1 : 10"), (2.0, "1 : 100")] {
        compare(name, &packing::in_a_ball(number(), 10_f64.powf(-exponent), &mut Rng::new(1)));
    }
    let Some(data) = directory() else { return };
    for model in some(&["cow", "hand", "camel", "armadillo"]) {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        compare(model, &packing::inside(&mesh, number()));
    }
}

/// The hierarchies of a row, each as several trees if there is chance in it.
fn hierarchies(spheres: &[Sphere]) -> Vec<(&'static str, Vec<Node>)> {
    let gas = |magnification| -> Vec<Node> {
        let build = |seed| by_splitter(spheres, Splitter::BatchNeuralGas { magnification, seed });
        (0..count(SEEDS, 1) as u32).map(build).collect()
    };
    vec![
        ("neural gas, by volume", gas(Magnification::Area)),
        ("neural gas", gas(Magnification::None)),
        ("four biggest", vec![by_heuristic(spheres, heuristics::biggest)]),
        ("extremes on two axes", vec![by_heuristic(spheres, heuristics::extremes)]),
        ("extended longest axis", vec![by_splitter(spheres, Splitter::ExtendedLongestAxis)]),
        ("mean width", vec![by_splitter(spheres, Splitter::MeanWidth)]),
    ]
}

fn compare(name: &str, spheres: &[Sphere]) {
    let hierarchies = hierarchies(spheres);
    let poses = poses(&hierarchies[0].1[0]);
    let queries = |tree: &Node| -> Vec<tree::Count> {
        poses.iter().map(|pose| tree::overlaps(&Moved { tree, pose }, tree)).collect()
    };
    let mut pairs: Vec<u64> = queries(&hierarchies[0].1[0]).iter().map(|count| count.pairs).collect();
    for (pose, pairs) in poses.iter().zip(&mut pairs).take(5) {
        assert_eq!(*pairs, pairs_by_brute_force(spheres, pose), "{name}");
    }
    let mut first = None;
    for (hierarchy, trees) in &hierarchies {
        let mean = |of: &dyn Fn(&Node) -> f64| trees.iter().map(of).sum::<f64>() / trees.len() as f64;
        let count = |of: fn(&tree::Count) -> u64| {
            mean(&|tree| {
                let counts = queries(tree);
                let same = counts.iter().zip(&pairs).all(|(count, pairs)| count.pairs == *pairs);
                assert!(same, "{name}, {hierarchy}: other pairs than by brute force");
                counts.iter().map(of).sum::<u64>() as f64 / counts.len() as f64
            })
        };
        let (visits, tests) = (count(|c| c.visits), count(|c| c.tests));
        let (first_visits, first_tests) = *first.get_or_insert((visits, tests));
        let (over_visits, over_tests) = (visits / first_visits, tests / first_tests);
        let (volume, depth) = (mean(&Node::volume_ratio), mean(&|tree| tree.depth() as f64));
        println!(
            "| {name} ({}) | {hierarchy} | {visits:.0} ({over_visits:.2}) | {tests:.0} ({over_tests:.2}) | {volume:.2} | {depth:.0} |",
            spheres.len()
        );
    }
}

/// Random rotations about the middle, with the middles up to the root's radius apart.
fn poses(root: &Node) -> Vec<tree::Pose> {
    let mut rng = Rng::new(2);
    let Sphere { centre, radius } = root.ball;
    let pose = |_| {
        let rotation = rng.rotation();
        let (direction, distance) = (rng.rotation()[0], rng.unit() * radius);
        let rotated = rotation.map(|row| (row[0] * centre[0] + row[1] * centre[1]) + row[2] * centre[2]);
        let shift = core::array::from_fn(|i| centre[i] - rotated[i] + distance * direction[i]);
        tree::Pose { rotation, shift }
    };
    (0..count(POSES, 8)).map(pose).collect()
}
