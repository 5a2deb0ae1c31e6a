//! RRT-Connect on certified motions, on the problems of MotionBenchMaker: `cargo bench --bench plans --features
//! planning`.
//!
//! The Panda and the UR5, all problems whose start and goal are free, on one core. The same planner runs with bounds
//! (`PlanningScene::use_bounds`), which are computed before, and with the scene alone. Both certify the same motions,
//! so their paths must be equal.

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

use data::directory;
use page::show;
use planning_scenes::{load, scene_of, values};
use robots::{SETTINGS, Setting};
use short::count;
use simdop::planning::{PlanSettings, PlanningScene};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Width of a cell, in metres.
const CELL: f64 = 0.02;

#[derive(Default)]
struct Figures {
    problems: usize,
    /// Problems whose start or goal is not free.
    impossible: usize,
    solved: usize,
    /// Milliseconds of plans with bounds, of plans without, and of the bounds of a world.
    times: [Vec<f64>; 3],
    motions: u64,
    length: f64,
}

fn main() {
    page::begin(
        "Plans",
        "Milliseconds a problem of MotionBenchMaker: RRT-Connect with 100 shortcuts, every motion certified at all \
         times, one core. *Bounds*: after `PlanningScene::use_bounds` with cells of 2 cm; the time for the bounds of \
         a problem's obstacles is listed separately. *Impossible*: the start or the goal is not free.",
    );
    let Some(folder) = directory() else { return };
    show!(
        "| robot | problems | impossible | solved | bounds, median | p95 | most | scene, median | p95 | most | bounds \
         of the obstacles, median | motions a plan | mean length |"
    );
    show!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let settings = SETTINGS.iter().filter(|setting| !setting.is_drawn).take(count(SETTINGS.len(), 1));
    for setting in settings {
        let Figures { problems, impossible, solved, mut times, motions, length } = measure(&folder, setting);
        let [bounds, scene, build] = times.each_mut().map(|times| {
            times.sort_by(f64::total_cmp);
            [0.5, 0.95, 1.0].map(|share| times[((times.len() - 1) as f64 * share) as usize])
        });
        show!(
            "| {} | {problems} | {impossible} | {solved} | {:.2} | {:.1} | {:.0} | {:.2} | {:.1} | {:.0} | {:.0} | \
             {:.0} | {:.2} |",
            setting.name,
            bounds[0],
            bounds[1],
            bounds[2],
            scene[0],
            scene[1],
            scene[2],
            build[0],
            motions as f64 / solved as f64,
            length / solved as f64,
        );
    }
    page::write();
}

fn measure(folder: &Path, setting: &Setting) -> Figures {
    let model = Arc::new(load(setting, folder));
    let mut found = Figures::default();
    let step = std::env::var("SIMDOP_STEP").map_or(1, |step| step.parse().unwrap());
    for (index, problem) in
        setting.problems(folder, &setting.robot(folder), count(step, 350)).iter().enumerate()
    {
        let scene = scene_of(&model, problem);
        let mut bounded = scene.clone();
        let start = Instant::now();
        bounded.use_bounds(CELL).unwrap();
        if index > 0 {
            // The first one includes what is computed once for the robot.
            found.times[2].push(start.elapsed().as_secs_f64() * 1e3);
        }
        let [start, goal] = problem.ends.each_ref().map(|end| values(&model, end));
        found.problems += 1;
        if scene.free(&[start.clone(), goal.clone()].concat()).unwrap() != [true, true] {
            found.impossible += 1;
            continue;
        }
        let mut plan = |which: usize, scene: &PlanningScene| {
            let mut workspace = scene.workspace();
            let begin = Instant::now();
            let plan = scene.plan(&mut workspace, &start, &[&goal], &PlanSettings::default()).unwrap();
            found.times[which].push(begin.elapsed().as_secs_f64() * 1e3);
            plan
        };
        let (by_bounds, by_scene) = (plan(0, &bounded), plan(1, &scene));
        if by_bounds.path != by_scene.path {
            println!("{}, problem {}: another path with bounds", setting.name, index * step);
        }
        if by_bounds.is_found() {
            let mut workspace = scene.workspace();
            for ends in by_bounds.path.windows(2) {
                assert!(scene.check_motion(&mut workspace, [&ends[0], &ends[1]]).unwrap().is_free());
            }
            found.solved += 1;
            found.motions += u64::from(by_bounds.motions);
            found.length += by_bounds.length;
        } else {
            println!("{}, problem {}: no path in {} motions", setting.name, index * step, by_bounds.motions);
        }
    }
    found
}
