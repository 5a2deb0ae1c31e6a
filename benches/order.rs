//! Whether the order of the bodies matters, and the cost of a far pair: `cargo bench --bench order` prints a table.
//! Half a minute.
//!
//! Each pair of bodies is queried at poses of `support/suites.rs` as given, and exchanged at the inverse poses, in
//! turns, [`PASSES`] times; the minimum time of each query counts. *Far* is a body's length beyond 5 %. The verdicts of
//! both orders are compared first: they may differ only where rounding of the inverse moves the body.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
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
#[path = "support/timing.rs"]
mod timing;

use data::{MeshData, directory};
use glam::{DAffine3, DMat3, DVec3};
use page::show;
use short::count;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::BvhRef;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;
use std::hint::black_box;
use suites::{Approaching, DISTANCES, Method, Rows};
use timing::{cell, figures, timed};

const LINES: usize = 200;
const PASSES: usize = 7;

type Tree<'t> = BvhRef<'t, Node16<18>>;

fn mesh(parts: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &parts.vertices, triangles: &parts.triangles }
}

fn main() {
    page::begin(
        "Order of the bodies, and far pairs",
        "Microseconds a query, median / mean / p99: the bodies as given, and exchanged at the inverse poses. \
         *Far*: two diagonals beyond 5 %.",
    );
    show!("| A | B | distance | as given | exchanged | ratio of means |");
    show!("|---|---|---|--:|--:|--:|");
    let room = shapes::room(count(20_000, 1000) as u32);
    let mut pairs =
        vec![("torus", "room", shapes::scaled(&shapes::wavy_torus(5000), 0.3, [0.0; 3]), room.clone())];
    if let Some(data) = directory() {
        let read = |file: &str| MeshData::obj(&data.join(file));
        let link = |n: u32| read(&format!("robots/panda/meshes/visual_link{n}.obj"));
        let cow = read("meshes/cow.obj");
        let size = 0.4 * room.diagonal() / cow.diagonal();
        pairs.extend([
            ("unc: robot", "room", read("planning/unc_rob.obj"), read("planning/unc_env.obj")),
            ("panda: one link", "another", link(6), link(5)),
            ("cow", "room", shapes::scaled(&cow, size, [0.0; 3]), room),
            ("cow", "cow", cow.clone(), cow),
        ]);
    }
    for (name_a, name_b, a, b) in &pairs[..count(pairs.len(), 2)] {
        let [tree_a, tree_b] = [a, b].map(|body| Builder::new().build(&mesh(body)).unwrap());
        let pair = Approaching { a, b, tree_a: tree_a.view(), tree_b: tree_b.view() };
        let lines: Vec<[Rows; 4]> = Method::ALL
            .into_iter()
            .flat_map(|method| pair.poses(&DISTANCES, method, count(LINES, 8) / 2, 1))
            .collect();
        for (i, (distance, _)) in DISTANCES.iter().enumerate() {
            let poses: Vec<Rows> = lines.iter().map(|line| line[i]).collect();
            row([name_a, name_b, distance], &tree_a.view(), &tree_b.view(), &poses);
        }
        let far = lines.iter().map(|line| beyond(line, a.diagonal() + b.diagonal())).collect::<Vec<_>>();
        row([name_a, name_b, "far"], &tree_a.view(), &tree_b.view(), &far);
    }
    page::write();
}

/// The pose further along the line, by this much.
fn beyond(line: &[Rows; 4], by: f64) -> Rows {
    let at = |rows: &Rows| DVec3::from_array(rows.map(|row| row[3]));
    let shift = (at(&line[3]) - at(&line[0])).normalize() * by;
    core::array::from_fn(|i| {
        let [x, y, z, t] = line[3][i];
        [x, y, z, t + shift[i]]
    })
}

fn pose(rows: &Rows) -> Pose {
    Pose::from_rows(*rows).unwrap()
}

fn inverse(rows: &Rows) -> Pose {
    let turn = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
    let there = DAffine3::from_mat3_translation(turn, DVec3::from_array(rows.map(|row| row[3])));
    Pose::try_from(DAffine3::from_mat3_translation(turn.transpose(), -(turn.transpose() * there.translation)))
        .unwrap()
}

fn row([name_a, name_b, distance]: [&str; 3], a: &Tree<'_>, b: &Tree<'_>, poses: &[Rows]) {
    let query = Query::new(Isa::detect());
    let (there, back): (Vec<_>, Vec<_>) = poses.iter().map(|rows| (pose(rows), inverse(rows))).unzip();
    let same = there
        .iter()
        .zip(&back)
        .filter(|(there, back)| query.collide(a, b, there).is_free() == query.collide(b, a, back).is_free());
    assert!(same.count() * 50 >= poses.len() * 49, "the orders disagree");
    let mut times = [vec![f64::INFINITY; poses.len()], vec![f64::INFINITY; poses.len()]];
    for _ in 0..count(PASSES, 1) {
        for i in 0..poses.len() {
            let given = timed(|| query.collide(black_box(a), black_box(b), black_box(&there[i])).is_free());
            let exchanged =
                timed(|| query.collide(black_box(b), black_box(a), black_box(&back[i])).is_free());
            times[0][i] = times[0][i].min(given);
            times[1][i] = times[1][i].min(exchanged);
        }
    }
    let [given, exchanged] = times.map(|mut times| figures(&mut times));
    show!(
        "| {name_a} | {name_b} | {distance} | {} | {} | {:.2} |",
        cell(&given),
        cell(&exchanged),
        exchanged[1] / given[1]
    );
}
