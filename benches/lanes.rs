//! Configurations decided by bounds, sixteen at a time, against the scene: `cargo bench --bench lanes --features
//! planning`. Two minutes.
//!
//! The Panda and the UR5 on some problems of MotionBenchMaker, at random configurations, on one core. *Scene* decides
//! each by the scene; *bounds* is the same call after `use_bounds`, with the verdicts compared; *bounds alone* leaves
//! open what the bounds do not decide. The three alternate; medians of nine rounds.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/robots.rs"]
mod robots;
#[path = "support/short.rs"]
mod short;

use data::directory;
use rng::Rng;
use robots::{SETTINGS, Setting};
use short::count;
use simdop::planning::{PlanningScene, RobotFiles};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::scene::Body;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Width of a cell, in metres.
const CELL: f64 = 0.02;
/// In the long form.
const ROUNDS: usize = 9;
/// Configurations of a problem, in the long form.
const MANY: usize = 2048;

fn main() {
    let Some(folder) = directory() else { return };
    for setting in SETTINGS.iter().filter(|setting| !setting.is_drawn) {
        run(&folder, setting);
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64(), result)
}

fn run(folder: &Path, setting: &Setting) {
    let at = folder.join("robots").join(setting.robot);
    let file = |extension: &str| at.join(format!("{}.{extension}", setting.robot));
    let model = Arc::new(RobotFiles::new(file("urdf")).srdf(file("srdf")).load().unwrap());
    let (rounds, many) = (count(ROUNDS, 1), count(MANY, 128));
    let mut rng = Rng::new(3);
    let mut times: [Vec<f64>; 3] = Default::default();
    let (mut shares, mut builds, mut updates, mut bytes) = ([0; 4], Vec::new(), Vec::new(), 0);
    let mut open = BTreeMap::new();
    let problems = setting.problems(folder, &setting.robot(folder), count(70, 350));
    for problem in &problems {
        let mut scene = PlanningScene::new(Arc::clone(&model)).unwrap();
        for obstacle in &problem.obstacles {
            let at = Pose::try_from(obstacle.at).unwrap();
            let _ = scene.insert("obstacle", Body::new(obstacle.shape.shape()).fixed(), &at).unwrap();
        }
        let mut bounded = scene.clone();
        let (time, ()) = timed(|| bounded.use_bounds(CELL).unwrap());
        if builds.is_empty() {
            println!("{}: spheres, tables and cells made in {time:.2} s", setting.name);
        }
        builds.push(time);
        let values: Vec<f64> = (0..many).flat_map(|_| scene.random(|| rng.range(0.0, 1.0))).collect();
        for _ in 0..rounds {
            let (time, exact) = timed(|| scene.free(&values).unwrap());
            times[0].push(time);
            let (time, found) = timed(|| bounded.free(&values).unwrap());
            times[1].push(time);
            let (time, decided) = timed(|| bounded.free_by_bounds(&values).unwrap());
            times[2].push(time);
            let wrong = exact.iter().zip(&found).filter(|(a, b)| a != b).count();
            assert_eq!(wrong, 0, "verdicts differ");
            if times[0].len().is_multiple_of(rounds) {
                let mut workspace = scene.workspace();
                for ((decided, exact), values) in
                    decided.iter().zip(&exact).zip(values.chunks(scene.variables()))
                {
                    assert!(decided.is_none_or(|decided| decided == *exact), "a bound is wrong");
                    shares[usize::from(decided.is_some()) + 2 * usize::from(*exact)] += 1;
                    if decided.is_none() {
                        for hit in scene.hits(&mut workspace, values, 0.0).unwrap() {
                            let name = format!("{} {}", scene.name(hit.a), scene.name(hit.b));
                            *open.entry(name).or_insert(0) += 1;
                        }
                    }
                }
            }
        }
        bytes = bytes.max(bounded.bound_bytes().unwrap_or(0));
        let cup = Body::new(Shape::cylinder(0.04, 0.12).unwrap()).fixed();
        let place =
            |x: f64| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.5]]);
        let cup = bounded.insert("cup", cup, &place(0.5).unwrap()).unwrap();
        updates.push(timed(|| bounded.place(cup, &place(0.4).unwrap()).unwrap()).0);
    }
    let median = |times: &mut Vec<f64>, unit: f64| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2] * unit
    };
    let per = 1e6 / many as f64;
    let of = |count: usize| 100.0 * count as f64 / (problems.len() * many) as f64;
    let [exact, bounds, alone] = times.each_mut().map(|times| median(times, per));
    println!(
        "{}: us a configuration, medians: scene {exact:.3}, bounds {bounds:.3}, bounds alone {alone:.3}",
        setting.name
    );
    let [open_hits, hits, open_free, free] = shares.map(of);
    println!(
        "  % of configurations: free by bounds {free:.1}, free by the scene {open_free:.1}, hit by bounds {hits:.1}, \
         hit by the scene {open_hits:.1}"
    );
    println!(
        "  all cells made in {:.1} ms, one object moved in {:.1} ms (medians); {bytes} bytes at most",
        median(&mut builds, 1e3),
        median(&mut updates, 1e3)
    );
    let mut open: Vec<_> = open.into_iter().collect();
    open.sort_by_key(|(_, count)| core::cmp::Reverse(*count));
    println!("  pairs of bodies that meet where bounds do not say so: {:?}", &open[..open.len().min(12)]);
}
