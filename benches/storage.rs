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
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use std::hint::black_box;
use std::time::Instant;
use suites::{Approaching, DISTANCES, Method};

const LINES: usize = 200;
const PASSES: usize = 9;

fn main() {
    page::begin(
        "Fixed point and half floats",
        "Collision queries at k = 18 and arity 16: microseconds a query, median / mean / p99, with ratios of each, \
         half floats to fixed point. Triangle pairs and visits are means a query. Trees are equally large in both \
         storages. The verdicts of both are compared first.",
    );
    show!(
        "| A, B | distance | fixed | half | half / fixed | pairs, fixed | half | visits, fixed | half | bytes a \
         triangle |"
    );
    show!("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    let torus = shapes::wavy_torus(count(20_000, 1000) as u32);
    let mut pairs = vec![("torus", torus.clone(), torus)];
    if let Some(data) = directory() {
        pairs = SCENES
            .iter()
            .map(|scene| {
                let mut meshes = scene.meshes(&data);
                let b = meshes.pop().unwrap();
                (scene.name, meshes.pop().unwrap_or_else(|| b.clone()), b)
            })
            .collect();
    }
    let mut ratios = Vec::new();
    for (name, a, b) in &pairs[..count(pairs.len(), 1)] {
        ratios.extend(rows(name, a, b));
    }
    show!("");
    for (i, what) in ["medians", "means", "p99"].into_iter().enumerate() {
        let mut found: Vec<f64> = ratios.iter().map(|row| row[i]).collect();
        let mean = (found.iter().map(|x| x.ln()).sum::<f64>() / found.len() as f64).exp();
        found.sort_by(f64::total_cmp);
        show!(
            "* half / fixed, {what}: {:.3} to {:.3}, in the middle {:.3}, geometric mean {mean:.3}",
            found[0],
            found[found.len() - 1],
            found[found.len() / 2]
        );
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
    let lines: Vec<_> = Method::ALL
        .into_iter()
        .flat_map(|method| pair.poses(&DISTANCES, method, count(LINES, 8) / 2, 1))
        .collect();
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
        let figures = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            let mean = times.iter().sum::<f64>() / times.len() as f64;
            [times[times.len() / 2], mean, times[times.len() * 99 / 100]]
        });
        let cells =
            figures.each_ref().map(|[median, mean, p99]| format!("{median:.3} / {mean:.3} / {p99:.2}"));
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

/// Microseconds per call, averaged over enough calls to be measurable.
fn timed(ask: impl Fn() -> bool) -> f64 {
    let once = |calls: u32| {
        let start = Instant::now();
        for _ in 0..calls {
            black_box(ask());
        }
        start.elapsed().as_secs_f64() * 1e6 / f64::from(calls)
    };
    let first = once(1);
    once(((8.0 / first) as u32).clamp(1, 200))
}
