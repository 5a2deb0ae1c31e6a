//! Validity checks of whole configurations of a robot among fixed bodies, compared with the managers of FCL and Coal.

mod entrants;
mod page;
mod truth;

use crate::measure::quantile;
use crate::robots::{Problem, Robot, SETTINGS, Setting};
use crate::suites::Rows;
use crate::{Options, record, save};
use entrants::{Entrant, OBSTACLES, Trees, entrants};
use glam::DAffine3;
use page::Row;
use std::time::Instant;

/// Rounds of each run: in each, every library decides every configuration, in turns.
const ROUNDS: u32 = 15;

/// A robot and its problems.
struct Task {
    robot: Robot,
    problems: Vec<Problem>,
    configurations: Vec<Configuration>,
}

struct Configuration {
    problem: usize,
    /// The pose of each link.
    places: Vec<Rows>,
}

/// The matrix by rows, in the form that all libraries take.
fn rows(at: &DAffine3) -> Rows {
    let (x, y, z, t) = (at.x_axis, at.y_axis, at.z_axis, at.translation);
    core::array::from_fn(|i| [x[i], y[i], z[i], t[i]])
}

impl Task {
    fn new(setting: &Setting, options: &Options) -> Self {
        let robot = setting.robot(&options.data);
        let problems = setting.problems(&options.data, &robot, options.every as usize);
        let of = |(problem, given): (usize, &Problem)| {
            let places = given.poses.iter().map(|links| links.iter().map(rows).collect());
            places.map(move |places| Configuration { problem, places }).collect::<Vec<_>>()
        };
        let configurations = problems.iter().enumerate().flat_map(of).collect();
        Self { robot, problems, configurations }
    }
}

pub(crate) fn run(options: &Options) -> Result<(), String> {
    let mut rows: Vec<Row> = Vec::new();
    for setting in &SETTINGS {
        eprintln!("{}: the truth", setting.name);
        let task = Task::new(setting, options);
        let truth = truth::free(&task);
        let trees = Trees::new(&task);
        for (obstacles, free) in OBSTACLES.into_iter().zip(&truth) {
            eprintln!("{}, obstacles as {}", setting.name, obstacles.name());
            let mut entrants = entrants(&task, &trees, obstacles, &options.drivers);
            let results = in_turns(&mut entrants, &task.configurations, ROUNDS * options.runs);
            rows.extend(entrants.iter().zip(&results).map(|(entrant, results)| Row {
                robot: setting.name.to_owned(),
                links: task.robot.links.len(),
                triangles: task.robot.links.iter().map(|link| link.mesh.triangles.len()).sum(),
                pairs: task.robot.pairs.len(),
                problems: task.problems.len(),
                obstacles: obstacles.name().to_owned(),
                configurations: free.len(),
                free: free.iter().filter(|free| **free).count(),
                library: entrant.name.clone(),
                version: entrant.version.clone(),
                mean_us: mean(&results.sorted(0.5)),
                least_us: mean(&results.sorted(0.0)),
                p50_us: quantile(&results.sorted(0.5), 0.5),
                p99_us: quantile(&results.sorted(0.5), 0.99),
                missed: results.wrong(free, true),
                invented: results.wrong(free, false),
            }));
        }
    }
    std::fs::create_dir_all(&options.out).map_err(|e| format!("{}: {e}", options.out.display()))?;
    record::write(&options.out.join("scenes.csv"), &rows)?;
    save(&options.out.join("SCENES.md"), &page::page(&rows, &options.stamp))
}

/// The verdicts and times of one library.
struct Results {
    free: Vec<bool>,
    /// Times by configuration and round, in µs.
    times: Vec<Vec<f64>>,
}

/// In a round, one library after the other decides every configuration once, problem by problem.
fn in_turns(entrants: &mut [Entrant<'_>], configurations: &[Configuration], rounds: u32) -> Vec<Results> {
    let blank = |_: &Entrant<'_>| Results {
        free: vec![false; configurations.len()],
        times: vec![Vec::new(); configurations.len()],
    };
    let mut results: Vec<Results> = entrants.iter().map(blank).collect();
    for round in 0..rounds as usize {
        for i in 0..entrants.len() {
            let which = (round + i) % entrants.len();
            let (entrant, results) = (&mut entrants[which], &mut results[which]);
            for (index, configuration) in configurations.iter().enumerate() {
                let start = Instant::now();
                results.free[index] = (entrant.is_free)(configuration.problem, &configuration.places);
                results.times[index].push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
    }
    results
}

fn mean(times: &[f64]) -> f64 {
    times.iter().sum::<f64>() / times.len() as f64
}

impl Results {
    /// For each configuration, this quantile of its rounds; in ascending order.
    fn sorted(&self, share: f64) -> Vec<f64> {
        let of = |rounds: &Vec<f64>| {
            let mut rounds = rounds.clone();
            rounds.sort_by(f64::total_cmp);
            quantile(&rounds, share)
        };
        let mut times: Vec<f64> = self.times.iter().map(of).collect();
        times.sort_by(f64::total_cmp);
        times
    }

    /// Configurations that were reported as free (or not) and are the opposite.
    fn wrong(&self, truth: &[bool], said: bool) -> usize {
        self.free.iter().zip(truth).filter(|(free, truth)| **free == said && **truth != said).count()
    }
}
