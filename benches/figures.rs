//! Figures 6 and 7 of the SIMDop paper (Tan, Weller, Zachmann, IROS 2019) for this library's splitters: time of a query
//! and of a build against the number of polygons. `cargo bench --bench figures` writes `figures.csv` and the plots to
//! `target/figures/`, and prints after how many queries, touching and 1 % of the diagonal apart, a longer build pays
//! off.
//!
//! Figure 7 with other libraries' builds: `benches/peers/run --builds`.
//!
//! As in the paper k is 32, poses are at the distance zero (a millionth of the diagonal from contact, free), and the
//! polygon count varies by decimation: vertices that share a cell of a grid become one. A model is tested against
//! itself. Query times are means over the poses of the minimum over several interleaved runs; build times are the
//! minimum of several.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
mod figures {
    pub(crate) mod decimate;
    pub(crate) mod plot;
}
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;

use data::{GAPS, MeshData, Suite, directory};
use figures::decimate::{MODELS, series};
use figures::plot::{Curve, plot};
use page::show;
use short::{count, is_short, some};
use simdop::construct::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, QueryStats};
use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

/// The splitter of the fast preset.
const FAST: &str = "extended longest axis";
/// The splitters compared, one curve each.
const SPLITTERS: [(&str, Splitter); 6] = [
    ("longest axis", Splitter::LongestAxis),
    (FAST, Splitter::ExtendedLongestAxis),
    ("surface area", Splitter::SurfaceArea),
    ("mean width", Splitter::MeanWidth),
    ("neural gas", Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 0 }),
    ("neural gas by area", Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 }),
];
const RUNS: usize = 7;
/// Indices of the suites' gaps: practically zero, and 1 % of the diagonal.
const TOUCHING: usize = 4;
const APART: usize = 0;

/// A splitter's row in the table: one model at one size, one arity.
struct Row {
    model: &'static str,
    polygons: usize,
    arity: usize,
    splitter: &'static str,
    query_microseconds: f64,
    apart_microseconds: f64,
    visits: f64,
    kernels: f64,
    primitive_pairs: f64,
    build_milliseconds: f64,
    expected_visits: f64,
}

fn main() {
    let Some(data) = directory() else { return };
    page::begin(
        "Splitters: queries and builds",
        "Milliseconds a build, microseconds a query, k = 32, arity 16, a mesh against itself. *Pays after*: the \
         number of queries that save the additional build time over the fast preset.",
    );
    let mut rows = Vec::new();
    for &model in some(&MODELS) {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        let series = series(&mesh);
        // In a short run only the coarsest.
        for mesh in &series[..count(series.len(), 2)] {
            let poses = [TOUCHING, APART].map(|gap| poses(mesh, gap));
            eprintln!("{model}: {} polygons", mesh.triangles.len());
            measure::<Node4<32>>(model, mesh, &poses, &mut rows);
            measure::<Node16<32>>(model, mesh, &poses, &mut rows);
        }
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(if is_short() {
        "figures-short"
    } else {
        "figures"
    });
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("figures.csv"), csv(&rows)).unwrap();
    for &model in some(&MODELS) {
        for (arity, letter, kernel) in [(4, 'a', "4vs4"), (16, 'b', "1vs16")] {
            let curves = |value: fn(&Row) -> f64| curves(&rows, model, arity, value);
            let file = |figure: u32| folder.join(format!("figure-{figure}{letter}-{model}.svg"));
            let title = format!("{model}, {kernel}, k = 32");
            plot(&file(6), &title, "query, microseconds", &curves(|row| row.query_microseconds));
            plot(&file(7), &title, "construction, milliseconds", &curves(|row| row.build_milliseconds));
        }
    }
    println!("{}", folder.display());
    show!("{}", pay_offs(&rows).trim_end());
    page::write();
}

fn build<N: Lanes>(mesh: &MeshData, splitter: Splitter) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Builder::new().splitter(splitter).build_as(&mesh).unwrap()
}

fn poses(mesh: &MeshData, gap: usize) -> Vec<Pose> {
    let tree = build::<Node16<18>>(mesh, Splitter::default());
    let pose = |rows: &[[f64; 4]; 3]| Pose::from_rows(*rows).unwrap();
    let meets =
        |rows: &_| Query::new(Isa::detect()).collide(&tree.view(), &tree.view(), &pose(rows)).hit().is_some();
    let suite = Suite { name: "figures", a: mesh.clone(), b: mesh.clone() };
    suite.poses(count(1, 8), meets).chunks_exact(GAPS.len()).map(|at_gaps| pose(&at_gaps[gap])).collect()
}

/// Appends a row for each splitter, measured at touching poses and at poses apart.
fn measure<N: Lanes>(model: &'static str, mesh: &MeshData, poses: &[Vec<Pose>; 2], rows: &mut Vec<Row>) {
    let built = SPLITTERS.map(|(_, splitter)| {
        let time = || {
            let start = Instant::now();
            let tree = build::<N>(mesh, splitter);
            (start.elapsed().as_secs_f64(), tree)
        };
        (0..count(3, 1)).map(|_| time()).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    });
    let trees = built.each_ref().map(|(_, tree)| tree);
    let [touching, apart] = poses.each_ref().map(|poses| query_times(&trees, poses));
    for (i, ((build, tree), (splitter, _))) in built.iter().zip(SPLITTERS).enumerate() {
        let query = Query::new(Isa::detect());
        let answers: Vec<_> =
            poses[0].iter().map(|pose| query.collide(&tree.view(), &tree.view(), pose)).collect();
        assert!(answers.iter().all(|answer| answer.is_free()), "poses are free");
        let mean = |of: fn(&QueryStats) -> u64| {
            answers.iter().map(|a| of(&a.stats)).sum::<u64>() as f64 / answers.len() as f64
        };
        rows.push(Row {
            model,
            polygons: mesh.triangles.len(),
            arity: N::ARITY,
            splitter,
            query_microseconds: 1e6 * touching[i],
            apart_microseconds: 1e6 * apart[i],
            visits: mean(|c| c.visits),
            kernels: mean(|c| c.kernels),
            primitive_pairs: mean(|c| c.primitive_pairs),
            build_milliseconds: 1e3 * build,
            expected_visits: tree.view().tree_stats().expected_visits,
        });
    }
}

/// Seconds per query: mean over the poses of the minimum over several runs, in which the trees take turns.
fn query_times<N: Lanes>(trees: &[&Bvh<N>; SPLITTERS.len()], poses: &[Pose]) -> [f64; SPLITTERS.len()] {
    let query = Query::new(Isa::detect());
    let mut times = vec![[f64::INFINITY; SPLITTERS.len()]; poses.len()];
    for _ in 0..count(RUNS, 1) {
        for (pose, times) in poses.iter().zip(&mut times) {
            for (tree, time) in trees.iter().zip(times) {
                let start = Instant::now();
                let _ = black_box(query.collide(&tree.view(), &tree.view(), black_box(pose)));
                *time = time.min(start.elapsed().as_secs_f64());
            }
        }
    }
    core::array::from_fn(|i| times.iter().map(|times| times[i]).sum::<f64>() / poses.len() as f64)
}

fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "model,polygons,arity,splitter,query_microseconds,apart_microseconds,visits,kernels,primitive_pairs,\
         build_milliseconds,expected_visits\n",
    );
    for row in rows {
        let Row { model, polygons, arity, splitter, query_microseconds, visits, kernels, .. } = row;
        let Row { apart_microseconds, primitive_pairs, build_milliseconds, expected_visits, .. } = row;
        writeln!(
            text,
            "{model},{polygons},{arity},{splitter},{query_microseconds:.3},{apart_microseconds:.3},{visits:.1},\
             {kernels:.1},\
             {primitive_pairs:.1},{build_milliseconds:.3},{expected_visits:.1}"
        )
        .unwrap();
    }
    text
}

/// After how many queries the longer build of a splitter pays off, compared with the fast preset: both models at full
/// resolution, 1vs16.
fn pay_offs(rows: &[Row]) -> String {
    let mut text = String::from(
        "| model | splitter | build, ms | touching, us | pays after | 1 % apart, us | pays after \
         |\n|---|---|---|---|---|---|---|\n",
    );
    for model in MODELS {
        let wide = || rows.iter().filter(|row| row.model == model && row.arity == 16);
        let polygons = wide().map(|row| row.polygons).max();
        let full = || wide().filter(|row| Some(row.polygons) == polygons);
        let Some(fast) = full().find(|row| row.splitter == FAST) else { continue };
        for row in full() {
            let longer = 1e3 * (row.build_milliseconds - fast.build_milliseconds);
            let after = |of: fn(&Row) -> f64| {
                let saved = of(fast) - of(row);
                if saved > 0.0 && longer > 0.0 { format!("{:.0}", longer / saved) } else { "-".into() }
            };
            let Row { splitter, build_milliseconds: build, .. } = row;
            let (touching, apart) = (row.query_microseconds, row.apart_microseconds);
            let [paid, paid_apart] = [after(|r| r.query_microseconds), after(|r| r.apart_microseconds)];
            writeln!(
                text,
                "| {model} | {splitter} | {build:.1} | {touching:.2} | {paid} | {apart:.2} | {paid_apart} |"
            )
            .unwrap();
        }
    }
    text
}

fn curves(rows: &[Row], model: &str, arity: usize, value: fn(&Row) -> f64) -> Vec<Curve> {
    let curve = |(name, _): (&'static str, Splitter)| {
        let rows = rows.iter().filter(|r| r.model == model && r.arity == arity && r.splitter == name);
        Curve { name: name.to_owned(), points: rows.map(|row| (row.polygons as f64, value(row))).collect() }
    };
    SPLITTERS.map(curve).into()
}
