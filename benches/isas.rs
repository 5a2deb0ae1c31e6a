//! Whole queries on each instruction set of this machine: `cargo bench --bench isas` prints a table. A minute.
//!
//! The pairs are those of `benches/peers`, with poses found in the same way; without its files, a torus. Each query
//! runs on every instruction set in turns, [`PASSES`] times; the minimum time of each counts. Verdicts and query
//! statistics are compared first.

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
use simdop::isa::Isa;
use simdop::low_level::key::{Half, Storage, StorageKind};
use simdop::node::{Dop, Node, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};
use std::hint::black_box;
use suites::{Approaching, DISTANCES};
use timing::{cell, figures, timed};

const PASSES: usize = 9;

fn main() {
    let isas: Vec<Isa> = Isa::available().collect();
    let columns: Vec<&str> = isas.iter().map(|isa| isa.name()).collect();
    let ratios: Vec<String> = isas.windows(2).map(|two| format!("{} / {}", two[1], two[0])).collect();
    page::begin(
        "Instruction sets",
        "Microseconds a query, median / mean / p99, with ratios of medians and means. Verdicts and query \
         statistics are compared first.",
    );
    show!("| A, B | k | planes | distance | {} | {} |", columns.join(" | "), ratios.join(" | "));
    show!("|---|--:|---|---|{}", "--:|".repeat(columns.len() + ratios.len()));
    let (mut fixed, mut half) = (Vec::new(), Vec::new());
    for (name, a, b) in &pairs() {
        fixed.extend(rows::<Node16<18>>(&isas, name, a, b));
        half.extend(rows::<Node16<18, Half>>(&isas, name, a, b));
        if std::env::args().any(|arg| arg == "--all") {
            fixed.extend(rows::<Node16<26>>(&isas, name, a, b));
            fixed.extend(rows::<Node16<32>>(&isas, name, a, b));
        }
    }
    show!("");
    summary(&ratios, StorageKind::Fixed, &fixed);
    summary(&ratios, StorageKind::Half, &half);
    page::write();
}

/// The ratios of consecutive instruction sets over all rows.
fn summary(ratios: &[String], storage: StorageKind, all: &[Vec<[f64; 3]>]) {
    for (i, ratio) in ratios.iter().enumerate() {
        for (j, what) in ["medians", "means", "p99"].into_iter().enumerate() {
            let found = all.iter().map(|row| row[i + 1][j] / row[i][j]).collect();
            show!("* {storage}, {ratio}, {what}: {}", spread(found));
        }
    }
}

/// Median, mean and 99th percentile of each instruction set, by distance.
fn rows<N: Dop + Lanes>(isas: &[Isa], name: &str, a: &MeshData, b: &MeshData) -> Vec<Vec<[f64; 3]>> {
    let mesh = |parts: &MeshData| {
        let mesh = Mesh { vertices: &parts.vertices, triangles: &parts.triangles };
        (Builder::new().build_as::<N>(&mesh).unwrap(), Builder::new().build_as(&mesh).unwrap())
    };
    let ((tree_a, rough_a), (tree_b, rough_b)) = (mesh(a), mesh(b));
    let pair = Approaching { a, b, tree_a: rough_a.view(), tree_b: rough_b.view() };
    let lines = lines(&pair);
    let queries: Vec<Query> = isas.iter().map(|&isa| Query::new(isa)).collect();
    let mut found = Vec::new();
    for (i, (distance, _)) in DISTANCES.iter().enumerate() {
        let poses: Vec<Pose> = lines.iter().map(|line| Pose::from_rows(line[i]).unwrap()).collect();
        let ask = |query: &Query, pose: &Pose| query.collide(&tree_a, &tree_b, pose);
        for pose in &poses {
            let answers: Vec<_> = queries.iter().map(|query| ask(query, pose)).collect();
            assert!(answers.windows(2).all(|two| two[0] == two[1]), "answers of instruction sets differ");
        }
        let mut times = vec![vec![f64::INFINITY; poses.len()]; isas.len()];
        for _ in 0..count(PASSES, 1) {
            for (i, pose) in poses.iter().enumerate() {
                for (query, times) in queries.iter().zip(&mut times) {
                    times[i] = times[i].min(timed(|| ask(query, black_box(pose)).is_free()));
                }
            }
        }
        let figures: Vec<[f64; 3]> = times.iter_mut().map(|times| figures(times)).collect();
        let cells: Vec<String> = figures.iter().map(cell).collect();
        let ratios: Vec<String> = figures
            .windows(2)
            .map(|two| format!("{:.2}, {:.2}", two[1][0] / two[0][0], two[1][1] / two[0][1]))
            .collect();
        show!(
            "| {name} | {} | {} | {distance} | {} | {} |",
            N::K,
            <N as Node>::Storage::KIND,
            cells.join(" | "),
            ratios.join(" | ")
        );
        found.push(figures);
    }
    found
}
