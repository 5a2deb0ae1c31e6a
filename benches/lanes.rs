//! Configurations decided by bounds, sixteen at a time, against the scene and against spheres: `cargo bench --bench
//! lanes --features planning`. Three minutes.
//!
//! The Panda and the UR5 on some problems of MotionBenchMaker, at random configurations, on one core. *Scene* decides
//! each with the scene; *bounds* is the same call after `use_bounds`, with the verdicts compared; *bounds alone* leaves
//! open what the bounds do not decide. *VAMP-like* uses VAMP's sphere models of the robots, against the same obstacles
//! as shapes (`lanes/sphere_checker.rs`). All run in turns, nine rounds for each 256 configurations; the least time of
//! the rounds counts, and medians of these are shown.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "support/planning_scenes.rs"]
mod planning_scenes;
#[path = "lanes/plot.rs"]
mod plot;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/robots.rs"]
mod robots;
#[path = "support/short.rs"]
mod short;
#[path = "lanes/sphere_checker.rs"]
mod sphere_checker;

use data::directory;
use page::show;
use planning_scenes::{load, scene_of};
use plot::Mark;
use rng::Rng;
use robots::{SETTINGS, Setting};
use short::count;
use simdop::planning::PlanningScene;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::scene::Body;
use sphere_checker::{SphereRobot, SphereWorld};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Width of a cell, in metres.
const CELL: f64 = 0.02;
/// Rounds of a full run.
const ROUNDS: usize = 9;
/// Configurations of a problem in a full run.
const MANY: usize = 2048;
/// Configurations of a measurement, which takes less than a time slice of the system.
const RUN: usize = 256;
/// The checkers, in the order of [`Figures::times`].
const NAMES: [&str; 4] = ["scene", "bounds", "bounds alone", "VAMP-like"];

/// The measurements of a robot.
#[derive(Default)]
struct Figures {
    name: &'static str,
    spheres: usize,
    dropped: usize,
    times: [Vec<f64>; 4],
    /// Seconds for all bounds of the first problem, for those of another, and after an object was moved.
    first: f64,
    builds: Vec<f64>,
    updates: Vec<f64>,
    bytes: usize,
    all: usize,
    /// Configurations, by whether bounds decide, and by whether they are free.
    shares: [[usize; 2]; 2],
    /// Wrong verdicts of the spheres: free configurations called hits, and hits called free.
    wrong: [usize; 2],
    /// Pairs of bodies that meet where bounds leave a configuration open.
    open: BTreeMap<String, usize>,
}

fn main() {
    page::begin(
        "Configurations in lanes",
        "Microseconds a configuration, for random configurations among the obstacles of MotionBenchMaker, on one \
         core, kinematics included: the median over runs of 256 configurations, each the least of nine rounds. \
         *Scene*: `PlanningScene::free`. *Bounds*: the same after `use_bounds` with cells of 2 cm; no verdict \
         differs. *Bounds alone*: what the bounds do not decide stays open. *VAMP-like*: VAMP's sphere models of \
         the robots, sixteen configurations at a time in `f32`, against the same boxes and cylinders, until all \
         sixteen are hits; without the pairs of links whose spheres meet in all of 4,096 configurations.",
    );
    let Some(folder) = directory() else { return };
    // A short run takes the Panda: the UR5's bounds take twice as long to compute.
    let settings = SETTINGS.iter().filter(|setting| !setting.is_drawn).take(count(SETTINGS.len(), 1));
    let mut all: Vec<Figures> = settings.map(|setting| measure(&folder, setting)).collect();
    let marks = print(&mut all);
    if page::is_wanted() {
        plot::plot(&page::folder().join("lanes.svg"), &marks);
    }
    page::write();
}

fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64(), result)
}

fn measure(folder: &Path, setting: &Setting) -> Figures {
    let at = folder.join("robots").join(setting.robot);
    let model = Arc::new(load(setting, folder));
    let mut spheres = SphereRobot::read(&at, setting.robot, &model.robot().variables);
    let mut rng = Rng::new(3);
    let mut random = |scene: &PlanningScene, count: usize| -> Vec<f64> {
        (0..count).flat_map(|_| scene.random(|| rng.range(0.0, 1.0))).collect()
    };
    let empty = PlanningScene::new(Arc::clone(&model)).unwrap();
    let dropped = spheres.drop_pairs_that_always_meet(&random(&empty, 4096));
    let mut found = Figures { name: setting.name, spheres: spheres.spheres(), dropped, ..Figures::default() };
    for problem in &setting.problems(folder, &setting.robot(folder), count(70, 350)) {
        let (scene, world) = (scene_of(&model, problem), SphereWorld::new(&problem.obstacles));
        let mut bounded = scene.clone();
        let (time, ()) = timed(|| bounded.use_bounds(CELL).unwrap());
        if found.first == 0.0 {
            found.first = time;
            println!("{}: all bounds made in {time:.2} s", setting.name);
        } else {
            found.builds.push(time);
        }
        let values = random(&scene, count(MANY, 128));
        for values in values.chunks(RUN * scene.variables()) {
            // The least of some rounds, since other programs may use the core.
            let mut least = [f64::INFINITY; 4];
            for round in 0..count(ROUNDS, 1) {
                let (exact_time, exact) = timed(|| scene.free(values).unwrap());
                let (bounds_time, by_bounds) = timed(|| bounded.free(values).unwrap());
                let (alone_time, decided) = timed(|| bounded.free_by_bounds(values).unwrap());
                let (spheres_time, by_spheres) = timed(|| spheres.free(&world, values));
                let times = [exact_time, bounds_time, alone_time, spheres_time];
                for (least, time) in least.iter_mut().zip(times) {
                    *least = least.min(time * 1e6 / exact.len() as f64);
                }
                assert!(exact == by_bounds, "verdicts differ");
                if round == 0 {
                    found.compare(&scene, values, &exact, &decided, &by_spheres);
                }
            }
            for (all, least) in found.times.iter_mut().zip(least) {
                all.push(least);
            }
        }
        found.bytes = found.bytes.max(bounded.bound_bytes().unwrap_or(0));
        let cup = Body::new(Shape::cylinder(0.04, 0.12).unwrap()).fixed();
        let place =
            |x: f64| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.5]]);
        let cup = bounded.insert("cup", cup, &place(0.5).unwrap()).unwrap();
        found.updates.push(timed(|| bounded.place(cup, &place(0.4).unwrap()).unwrap()).0);
    }
    found
}

impl Figures {
    fn compare(
        &mut self,
        scene: &PlanningScene,
        values: &[f64],
        exact: &[bool],
        decided: &[Option<bool>],
        by_spheres: &[bool],
    ) {
        let mut workspace = scene.workspace();
        self.all += exact.len();
        for (i, values) in values.chunks(scene.variables()).enumerate() {
            assert!(decided[i].is_none_or(|decided| decided == exact[i]), "a bound is wrong");
            self.shares[usize::from(decided[i].is_some())][usize::from(exact[i])] += 1;
            if exact[i] != by_spheres[i] {
                self.wrong[usize::from(by_spheres[i])] += 1;
            }
            if decided[i].is_none() {
                for hit in scene.hits(&mut workspace, values, 0.0).unwrap() {
                    let name = format!("{} {}", scene.name(hit.a), scene.name(hit.b));
                    *self.open.entry(name).or_insert(0) += 1;
                }
            }
        }
    }

    fn percent(&self, count: usize) -> f64 {
        100.0 * count as f64 / self.all as f64
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Shows the tables. Returns the marks of the plot.
fn print(all: &mut [Figures]) -> Vec<Mark> {
    let mut marks = Vec::new();
    show!(
        "| robot | {} | spheres | wrong by spheres, % | free ones called hits, % | hits called free, % |",
        NAMES.join(" | ")
    );
    show!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (robot, of) in all.iter_mut().enumerate() {
        let times = of.times.each_mut().map(|times| median(times));
        let [hits, free] = of.wrong.map(|count| of.percent(count));
        show!(
            "| {} | {:.3} | {:.3} | {:.3} | {:.3} | {} | {:.2} | {hits:.2} | {free:.2} |",
            of.name,
            times[0],
            times[1],
            times[2],
            times[3],
            of.spheres,
            hits + free
        );
        for (i, wrong) in [(0, 0.0), (1, 0.0), (3, hits + free)] {
            marks.push(Mark { robot, text: format!("{}, {}", of.name, NAMES[i]), time: times[i], wrong });
        }
    }
    show!("\n![time against wrong verdicts](lanes.svg)\n");
    show!("How configurations are decided, in percent, and the time and memory of the bounds:\n");
    show!(
        "| robot | free by bounds | free by the scene | hit by bounds | hit by the scene | first bounds, s | bounds \
         of another world, ms | one object moved, ms | bytes | pairs of links without spheres' test |"
    );
    show!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for of in all.iter_mut() {
        let [[open_hits, open_free], [hits, free]] =
            of.shares.map(|of_two| of_two.map(|count| of.percent(count)));
        show!(
            "| {} | {free:.1} | {open_free:.1} | {hits:.1} | {open_hits:.1} | {:.1} | {:.1} | {:.1} | {} | {} |",
            of.name,
            of.first,
            1e3 * median(&mut of.builds),
            1e3 * median(&mut of.updates),
            of.bytes,
            of.dropped,
        );
        let mut open: Vec<_> = of.open.iter().collect();
        open.sort_by_key(|(_, count)| core::cmp::Reverse(**count));
        println!("  meet where bounds do not say so: {:?}", &open[..open.len().min(40)]);
    }
    marks
}
