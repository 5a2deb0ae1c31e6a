//! Whole queries on planes in fixed point and in half floats: `cargo bench --bench storage` prints a table. A minute.
//!
//! The pairs are those of `benches/peers`, with poses found in the same way; without its files, a torus. At each pose
//! both storages are queried in turns, [`PASSES`] times; the minimum time of each counts. Verdicts are compared first.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/meshes.rs"]
mod meshes;
#[path = "support/page.rs"]
mod page;
#[path = "support/pairs.rs"]
mod pairs;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "../tests/support/shapes.rs"]
mod shapes;
#[path = "support/short.rs"]
mod short;
#[path = "support/suites.rs"]
mod suites;
#[path = "support/timing.rs"]
mod timing;

use data::MeshData;
use page::show;
use pairs::{lines, pairs, spread};
use short::count;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use std::hint::black_box;
use suites::{Approaching, DISTANCES};
use timing::{cell, figures, timed};

const PASSES: usize = 9;

fn main() {
    page::begin(
        "Fixed point and half floats",
        "Collision queries at k = 18 and arity 16: microseconds a query, median / mean / p99, with ratios of each, \
         half floats to fixed point. Triangle pairs and visits are means per query. Trees are equally large in \
         both storages. The verdicts of both are compared first.",
    );
    show!(
        "| A, B | distance | fixed | half | half / fixed | pairs, fixed | half | visits, fixed | half | bytes a \
         triangle |"
    );
    show!("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut ratios = Vec::new();
    for (name, a, b) in &pairs() {
        ratios.extend(rows(name, a, b));
    }
    show!("");
    for (i, what) in ["medians", "means", "p99"].into_iter().enumerate() {
        let found = ratios.iter().map(|row| row[i]).collect();
        show!("* half / fixed, {what}: {}", spread(found));
    }
    page::write();
}

/// The trees of a pair of meshes in one storage.
struct Pair<S: Storage>
where
    Node16<18, S>: simdop::query::Lanes,
{
    a: Bvh<Node16<18, S>>,
    b: Bvh<Node16<18, S>>,
}

impl<S: Storage> Pair<S>
where
    Node16<18, S>: simdop::query::Lanes,
{
    fn new(a: &MeshData, b: &MeshData) -> Self {
        let build = |parts: &MeshData| {
            let mesh = Mesh { vertices: &parts.vertices, triangles: &parts.triangles };
            Builder::new().build_as(&mesh).unwrap()
        };
        Self { a: build(a), b: build(b) }
    }

    fn is_free(&self, query: &Query, pose: &Pose) -> bool {
        query.collide(&self.a, &self.b, pose).is_free()
    }

    /// Means of the pairs of triangles tested, and of visits.
    fn work(&self, query: &Query, poses: &[Pose]) -> [f64; 2] {
        let stats: Vec<_> = poses.iter().map(|pose| query.collide(&self.a, &self.b, pose).stats).collect();
        let mean = |sum: u64| sum as f64 / poses.len() as f64;
        [
            mean(stats.iter().map(|stats| stats.primitive_pairs).sum()),
            mean(stats.iter().map(|stats| stats.visits).sum()),
        ]
    }

    fn bytes(&self) -> usize {
        self.a.as_bytes().len() + self.b.as_bytes().len()
    }
}

/// Ratios of median, mean and 99th percentile, half to fixed, by distance.
fn rows(name: &str, a: &MeshData, b: &MeshData) -> Vec<[f64; 3]> {
    let (fixed, half) = (Pair::<Fixed>::new(a, b), Pair::<Half>::new(a, b));
    assert_eq!(fixed.bytes(), half.bytes(), "sizes of {name} differ");
    let bytes = fixed.bytes() as f64 / (a.triangles.len() + b.triangles.len()) as f64;
    let pair = Approaching { a, b, tree_a: fixed.a.view(), tree_b: fixed.b.view() };
    let lines = lines(&pair);
    let query = Query::new(Isa::detect());
    let mut found = Vec::new();
    for (i, (distance, _)) in DISTANCES.iter().enumerate() {
        let poses: Vec<Pose> = lines.iter().map(|line| Pose::from_rows(line[i]).unwrap()).collect();
        for pose in &poses {
            assert_eq!(fixed.is_free(&query, pose), half.is_free(&query, pose), "verdicts differ: {pose:?}");
        }
        let mut times = [vec![f64::INFINITY; poses.len()], vec![f64::INFINITY; poses.len()]];
        for pass in 0..count(PASSES, 1) {
            for (i, pose) in poses.iter().enumerate() {
                // Which one is first alternates.
                for which in [pass % 2, 1 - pass % 2] {
                    let time = if which == 0 {
                        timed(|| fixed.is_free(&query, black_box(pose)))
                    } else {
                        timed(|| half.is_free(&query, black_box(pose)))
                    };
                    times[which][i] = times[which][i].min(time);
                }
            }
        }
        let figures = times.map(|mut times| figures(&mut times));
        let cells = figures.each_ref().map(cell);
        let ratio: [f64; 3] = core::array::from_fn(|j| figures[1][j] / figures[0][j]);
        let [of_fixed, of_half] = [fixed.work(&query, &poses), half.work(&query, &poses)];
        show!(
            "| {name} | {distance} | {} | {:.3} / {:.3} / {:.3} | {:.1} | {:.1} | {:.1} | {:.1} | {bytes:.1} |",
            cells.join(" | "),
            ratio[0],
            ratio[1],
            ratio[2],
            of_fixed[0],
            of_half[0],
            of_fixed[1],
            of_half[1],
        );
        found.push(ratio);
    }
    found
}
