//! Motions of robots among obstacles: certified with and without bounds, and sampled: `cargo bench --bench motions
//! --features planning`.
//!
//! The Panda and the UR5 on some problems of MotionBenchMaker: motions from the start towards random configurations,
//! between random configurations, and from the start to the goal. The Talos in a street scanned by a lidar: the same,
//! from free configurations near the middle of its limits. *Samples*: the scene at as many times as VAMP uses, 32 per
//! unit of length in the joints. *Scene*: `PlanningScene::check_motion`. *Bounds*: `is_motion_free` after `use_bounds`.
//! All run in turns, and the least of some rounds counts.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "support/planning_scenes.rs"]
mod planning_scenes;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/robots.rs"]
mod robots;
#[path = "support/short.rs"]
mod short;
#[path = "support/street.rs"]
mod street;

use core::num::NonZeroU32;
use data::directory;
use page::show;
use planning_scenes::{load, scene_of, values};
use rng::Rng;
use robots::{SETTINGS, Setting};
use short::count;
use simdop::planning::{PlanningScene, Workspace};
use simdop::scene::{MotionAnswer, MotionVerdict};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Samples per unit of length in the joints, as in VAMP.
const RESOLUTION: f64 = 32.0;
/// Width of a cell, in metres.
const CELL: f64 = 0.02;
const ROUNDS: usize = 5;
/// Motions of each kind for a problem.
const MOTIONS: usize = 8;
const KINDS: [&str; 4] = ["0.3 from the start", "1 from the start", "random", "start to goal"];

/// Motions of one kind: microseconds by samples, by the scene, and with bounds.
#[derive(Default)]
struct Row {
    hits: Vec<[f64; 4]>,
    free: Vec<[f64; 4]>,
    unresolved: usize,
    missed: usize,
}

fn main() {
    page::begin(
        "Motions",
        "Microseconds a motion, means unless said otherwise, one core, kinematics included, the least of five rounds. \
         *Samples*: `PlanningScene::check_motion_discrete` at 32 samples per unit of length in the joints. *Scene*: \
         `PlanningScene::check_motion`. *Bounds*: `PlanningScene::is_motion_free` after `use_bounds` with cells of \
         2 cm. *Pair*: `check_motion` after `use_bounds`, which also names two bodies that meet. No verdict differs. \
         *Missed*: hits that no sample finds. The Talos is without the \
         pairs of links that its published SRDF file disables because they meet at its default configuration.",
    );
    let Some(folder) = directory() else { return };
    show!(
        "| robot | motions | verdict | count | missed | samples | scene | bounds, pair | bounds | scene over samples | \
         bounds over samples | scene, median / p99 | bounds, median / p99 |"
    );
    show!("|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let settings = SETTINGS.iter().filter(|setting| !setting.is_drawn).take(count(SETTINGS.len(), 1));
    for setting in settings {
        print_all(setting.name, measure(&folder, setting));
    }
    if !short::is_short() {
        print_all("Talos in a scan", measure_street(&folder));
    }
    page::write();
}

fn print_all(robot: &str, mut rows: [Row; 4]) {
    for (kind, row) in KINDS.iter().zip(&mut rows) {
        print(robot, kind, row);
    }
    let [mut hits, mut free] = [Vec::new(), Vec::new()];
    for row in &rows {
        hits.extend_from_slice(&row.hits);
        free.extend_from_slice(&row.free);
    }
    let missed = rows.iter().map(|row| row.missed).sum();
    let unresolved = rows.iter().map(|row| row.unresolved).sum();
    print(robot, "all", &mut Row { hits, free, unresolved, missed });
}

fn measure(folder: &Path, setting: &Setting) -> [Row; 4] {
    let model = Arc::new(load(setting, folder));
    let mut rows: [Row; 4] = core::array::from_fn(|_| Row::default());
    let mut rng = Rng::new(5);
    for problem in &setting.problems(folder, &setting.robot(folder), count(35, 350)) {
        let scene = scene_of(&model, problem);
        let mut bounded = scene.clone();
        bounded.use_bounds(CELL).unwrap();
        let mut workspaces = [scene.workspace(), bounded.workspace()];
        let [start, goal] = problem.ends.each_ref().map(|end| values(&model, end));
        for _ in 0..count(MOTIONS, 2) {
            let random = [(); 2].map(|()| scene.random(|| rng.range(0.0, 1.0)));
            let length = scene.distance(&start, &random[0]).unwrap();
            for (row, reach) in rows.iter_mut().zip([0.3, 1.0]) {
                let to = scene.between(&start, &random[0], (reach / length).min(1.0)).unwrap();
                row.ask([&scene, &bounded], &mut workspaces, [&start, &to]);
            }
            rows[2].ask([&scene, &bounded], &mut workspaces, [&random[0], &random[1]]);
        }
        rows[3].ask([&scene, &bounded], &mut workspaces, [&start, &goal]);
    }
    rows
}

/// Motions of the Talos from ten free configurations.
fn measure_street(folder: &Path) -> [Row; 4] {
    let scene = street::scene(folder);
    let mut bounded = scene.clone();
    let start = Instant::now();
    bounded.use_bounds(CELL).unwrap();
    println!(
        "bounds of the Talos and the scan: {:.1} s, {:?} bytes",
        start.elapsed().as_secs_f64(),
        bounded.bound_bytes()
    );
    let mut workspaces = [scene.workspace(), bounded.workspace()];
    let mut rows: [Row; 4] = core::array::from_fn(|_| Row::default());
    let mut rng = Rng::new(6);
    let mut starts = 0;
    for _ in 0..100_000 {
        if starts == 10 {
            break;
        }
        let start = scene.random(|| rng.range(0.4, 0.6));
        if !scene.is_free(&mut workspaces[0], &start).unwrap() {
            continue;
        }
        starts += 1;
        for _ in 0..MOTIONS {
            let random = [(); 2].map(|()| scene.random(|| rng.range(0.35, 0.65)));
            let length = scene.distance(&start, &random[0]).unwrap();
            for (row, reach) in rows.iter_mut().zip([0.3, 1.0]) {
                let to = scene.between(&start, &random[0], (reach / length).min(1.0)).unwrap();
                row.ask([&scene, &bounded], &mut workspaces, [&start, &to]);
            }
            rows[2].ask([&scene, &bounded], &mut workspaces, [&random[0], &random[1]]);
        }
    }
    rows
}

impl Row {
    fn ask(&mut self, scenes: [&PlanningScene; 2], workspaces: &mut [Workspace; 2], ends: [&[f64]; 2]) {
        let length = scenes[0].distance(ends[0], ends[1]).unwrap();
        let parts = NonZeroU32::new((RESOLUTION * length).ceil().max(1.0) as u32).unwrap();
        let mut least = [f64::INFINITY; 4];
        let mut answers: [Option<MotionAnswer>; 3] = [None; 3];
        let mut is_free = false;
        for _ in 0..count(ROUNDS, 1) {
            for i in 0..4 {
                let (scene, workspace) = (scenes[i / 2], &mut workspaces[i / 2]);
                let start = Instant::now();
                let answer = match i {
                    0 => Some(scene.check_motion_discrete(workspace, ends, parts).unwrap()),
                    1 | 2 => Some(scene.check_motion(workspace, ends).unwrap()),
                    _ => {
                        is_free = scene.is_motion_free(workspace, ends).unwrap();
                        None
                    }
                };
                least[i] = least[i].min(start.elapsed().as_secs_f64() * 1e6);
                if let Some(answer) = answer {
                    answers[i] = Some(answer);
                }
            }
        }
        let [sampled, exact, bounded] = answers.map(|answer| answer.unwrap().verdict);
        assert!(is_free == matches!(exact, MotionVerdict::Free), "verdicts differ");
        let is_missed = matches!(sampled, MotionVerdict::Unresolved { .. });
        match (exact, bounded) {
            (MotionVerdict::Free, MotionVerdict::Free) => {
                assert!(is_missed, "certified free, and a sample is a hit");
                self.free.push(least);
            }
            (MotionVerdict::Hit { .. }, MotionVerdict::Hit { .. }) => {
                self.hits.push(least);
                self.missed += usize::from(is_missed);
            }
            (MotionVerdict::Unresolved { .. }, MotionVerdict::Unresolved { .. }) => self.unresolved += 1,
            verdicts => panic!("verdicts differ: {verdicts:?}"),
        }
    }
}

fn print(robot: &str, kind: &str, row: &mut Row) {
    let Row { hits, free, unresolved, missed } = row;
    for (name, times, missed) in [("hit", hits, *missed), ("free", free, 0)] {
        if times.is_empty() {
            continue;
        }
        let mean = |i: usize| times.iter().map(|of| of[i]).sum::<f64>() / times.len() as f64;
        let ordered = |i: usize| {
            let mut of: Vec<f64> = times.iter().map(|of| of[i]).collect();
            of.sort_by(f64::total_cmp);
            (of[of.len() / 2], of[(of.len() * 99 / 100).min(of.len() - 1)])
        };
        let [samples, scene, bounds, is_free] = [0, 1, 2, 3].map(mean);
        let [of_scene, of_bounds] = [1, 3].map(ordered);
        show!(
            "| {robot} | {kind} | {name} | {} | {missed} | {samples:.1} | {scene:.1} | {bounds:.1} | {is_free:.1} | \
             {:.2} | {:.2} | {:.1} / {:.1} | {:.1} / {:.1} |",
            times.len(),
            scene / samples,
            is_free / samples,
            of_scene.0,
            of_scene.1,
            of_bounds.0,
            of_bounds.1,
        );
    }
    if *unresolved > 0 {
        show!("| {robot} | {kind} | unresolved | {unresolved} | | | | | | | | | |");
    }
}
