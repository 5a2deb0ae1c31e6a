//! The gain from a hint along a motion: `cargo bench --bench hints` prints a table. A minute.
//!
//! A mesh moves against itself in [`STEPS`] small steps, from poses by both methods of `support/suites.rs`. *In
//! contact* it rotates about its centre by 2e-4 radians per step, from 1 % deep, and may become free on the way;
//! *apart* it does the same from a gap of 1 %; *approaching* it moves straight in from 5 % to 2e-5 of the diagonal.
//! Each sweep runs without hints and with the hint of the previous step, in turns, [`PASSES`] times; the minimum time
//! of each counts. First every verdict and distance with hints is compared with the one without.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/suites.rs"]
mod suites;

use data::{MeshData, directory};
use glam::{DMat3, DQuat, DVec3};
use page::show;
use rng::Rng;
use short::{count, some};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::BvhRef;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Hint, Query};
use std::hint::black_box;
use std::time::{Duration, Instant};
use suites::{Approaching, DISTANCES, Method, Rows};

const MODELS: [&str; 3] = ["cow", "armadillo", "bunny75k"];
const SWEEPS: usize = 16;
const STEPS: usize = 400;
const PASSES: usize = 3;

fn sweeps() -> usize {
    count(SWEEPS, 2)
}

fn steps() -> usize {
    count(STEPS, 20)
}

type Tree<'t> = BvhRef<'t, Node16<18>>;

fn main() {
    let Some(data) = directory() else { return };
    page::begin(
        "Hints",
        &format!(
            "Microseconds a query without hints, with the hint of the previous step, and the ratio: medians over {} \
             sweeps of {} steps.",
            sweeps(),
            steps()
        ),
    );
    show!("| mesh | sweep | steps in contact | collide | hinted | ratio | distance | hinted | ratio |");
    show!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    for model in some(&MODELS) {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        let baked = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        let (tree, rough) =
            (Builder::best().build(&baked).unwrap(), Builder::new().build_as(&baked).unwrap());
        let pair = Approaching { a: &mesh, b: &mesh, tree_a: rough.view(), tree_b: rough.view() };
        let places: Vec<_> = Method::ALL
            .into_iter()
            .flat_map(|method| pair.poses(&DISTANCES, method, sweeps() / 2, 1))
            .collect();
        let mut rng = Rng::new(2);
        let mut turning = |from: usize| -> Vec<Vec<Pose>> {
            places.iter().map(|at| turns(&at[from], mesh.centre(), &mut rng)).collect()
        };
        let sweeps = [
            ("in contact", turning(0)),
            ("apart", turning(2)),
            ("approaching", places.iter().map(|at| straight(&at[3], &at[1])).collect()),
        ];
        for (name, sweeps) in sweeps {
            row(model, name, &tree.view(), &sweeps);
        }
    }
    page::write();
}

fn row(model: &str, name: &str, tree: &Tree<'_>, sweeps: &[Vec<Pose>]) {
    let query = Query::new(Isa::detect());
    let collide = |hint: Hint, pose: &Pose| {
        let answer = query.with_hint(hint).collide(tree, tree, pose);
        (answer.hint, if answer.is_free() { 1.0 } else { 0.0 })
    };
    let distance = |hint: Hint, pose: &Pose| {
        let found = query.with_hint(hint).distance(tree, tree, pose, 0.0).unwrap();
        (found.hint, found.upper)
    };
    let hits = sweeps.iter().flatten().filter(|pose| query.collide(tree, tree, pose).hit().is_some()).count();
    show!(
        "| {model} | {name} | {:.0} % | {} | {} |",
        100.0 * hits as f64 / (sweeps.len() * steps()) as f64,
        compared(sweeps, collide),
        compared(sweeps, distance),
    );
}

/// Three cells of the table: without hints, with them, and the ratio.
fn compared(sweeps: &[Vec<Pose>], ask: impl Fn(Hint, &Pose) -> (Hint, f64)) -> String {
    let times: Vec<[f64; 2]> = sweeps.iter().map(|sweep| both(sweep, &ask)).collect();
    let median = |of: fn(&[f64; 2]) -> f64| {
        let mut all: Vec<f64> = times.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    format!("{:.2} | {:.2} | {:.2}", median(|t| t[0]), median(|t| t[1]), median(|t| t[0] / t[1]))
}

/// Microseconds per step, without hints and with them.
fn both(sweep: &[Pose], ask: &impl Fn(Hint, &Pose) -> (Hint, f64)) -> [f64; 2] {
    let pass = |hinted: bool| {
        let (start, mut hint) = (Instant::now(), Hint::NONE);
        for pose in sweep {
            let (next, answer) = ask(hint, pose);
            black_box(answer);
            if hinted {
                hint = next;
            }
        }
        start.elapsed()
    };
    let mut hint = Hint::NONE;
    for pose in sweep {
        let ((next, hinted), (_, plain)) = (ask(hint, pose), ask(Hint::NONE, pose));
        assert!((hinted - plain).abs() <= 1e-12 * plain, "a hint changes {plain} to {hinted}");
        hint = next;
    }
    let mut best = [Duration::MAX; 2];
    for _ in 0..PASSES {
        for (best, hinted) in best.iter_mut().zip([false, true]) {
            *best = pass(hinted).min(*best);
        }
    }
    best.map(|time| time.as_secs_f64() * 1e6 / sweep.len() as f64)
}

/// Rotations about the body's centre and one axis.
fn turns(from: &Rows, centre: [f64; 3], rng: &mut Rng) -> Vec<Pose> {
    let [x, y, z] = [0, 1, 2].map(|axis| DVec3::from_array(from.map(|row| row[axis])));
    let (start, translation) = (DMat3::from_cols(x, y, z), DVec3::from_array(from.map(|row| row[3])));
    let (centre, axis) = (DVec3::from_array(centre), DVec3::from_array(rng.rotation()[0]));
    let stays = start * centre + translation;
    let turned = |step: usize| {
        let rotation = DMat3::from_quat(DQuat::from_axis_angle(axis, 2e-4 * step as f64)) * start;
        Pose::new(rotation, stays - rotation * centre).unwrap()
    };
    (0..steps()).map(turned).collect()
}

/// Translation from one pose to another of the same rotation.
fn straight(from: &Rows, to: &Rows) -> Vec<Pose> {
    let at = |step: usize| {
        let share = step as f64 / (steps() - 1) as f64;
        let mut rows = *from;
        for (row, end) in rows.iter_mut().zip(to) {
            row[3] += share * (end[3] - row[3]);
        }
        Pose::from_rows(rows).unwrap()
    };
    (0..steps()).map(at).collect()
}
