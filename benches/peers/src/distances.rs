//! Distances instead of collisions, at the same poses: simdop's at tolerance 0, and those of the peers that have them.

use crate::data::MeshData;
use crate::entrants::{Entrant, OURS, measuring};
use crate::measure::{BLOCK, ENOUGH, PASSES, quantile};
use crate::meshes::Scene;
use crate::poses::{self, Judged};
use crate::{Options, save};
use core::fmt::Write as _;
use std::time::{Duration, Instant};

/// The project's target: FCL's median is at least this many times ours.
const BAR: f64 = 2.0;

/// A peer's answer is wrong if its relative difference from ours exceeds this. Ours are tested against exact arithmetic
/// (`tests/queries/distance.rs`).
const AGREE: f64 = 1e-9;

/// One library on one suite.
struct Results {
    library: String,
    /// The minimum of several for each pose, µs.
    times: Vec<f64>,
    distances: Vec<f64>,
}

/// The medians and 99th percentiles of one library on one suite, for each run, and its wrong answers.
struct Cell {
    library: String,
    medians: Vec<f64>,
    p99s: Vec<f64>,
    wrong: usize,
}

pub(crate) fn run(options: &Options, scenes: &[&Scene]) -> Result<(), String> {
    let directory = options.out.join("poses");
    std::fs::create_dir_all(&directory).map_err(|e| format!("{}: {e}", directory.display()))?;
    let mut page = Page::new(options, "Distances", "mesh and distance, as in RESULTS.md");
    for scene in scenes {
        let meshes = scene.meshes(&options.data);
        let suites = poses::suites(scene.name, &directory, &meshes, options.poses(), options.seed)?;
        page.add(options, scene.name, &meshes, &suites);
    }
    save(&options.out.join("DISTANCES.md"), &page.text)
}

/// The page of results, with a row for each suite.
pub(crate) struct Page {
    pub(crate) text: String,
    has_head: bool,
}

impl Page {
    /// A page for this many poses of each `what`.
    pub(crate) fn new(options: &Options, title: &str, what: &str) -> Self {
        let text = format!(
            "# {title}\n\n{}. {}, one thread. {} run(s), {} poses for each {what}.\n\
            \n\
            simdop: k 18, tolerance 0, with both points. FCL and Coal: OBBRSS, no tolerance, FCL with the nearest\n\
            points. \"FCL native\" is compiled here (RESULTS.md); the ratio is to the faster FCL. If the bodies meet,\n\
            each library stops in its own way.\n\
            \n\
            Median / 99th percentile, µs. With several runs, a figure is their median. An answer is wrong if its\n\
            relative difference from ours exceeds {AGREE:e}, or if only one of the two says that the bodies meet.\n\n",
            options.stamp,
            crate::cpu::cpu(),
            options.runs,
            options.poses()
        );
        Self { text, has_head: false }
    }

    /// Measures two meshes, or one against itself, at the poses of each suite.
    pub(crate) fn add(
        &mut self,
        options: &Options,
        mesh: &str,
        meshes: &[MeshData],
        suites: &[(String, Vec<Judged>)],
    ) {
        let entrants = measuring(meshes, &options.drivers);
        if !self.has_head {
            self.has_head = true;
            head(&mut self.text, &entrants);
        }
        for (distance, suite) in suites {
            eprintln!("{mesh}, {distance}");
            let runs: Vec<_> = (0..options.runs).map(|_| in_turns(&entrants, suite)).collect();
            row(&mut self.text, mesh, distance, &cells(&runs, suite));
        }
    }
}

fn in_turns(entrants: &[Entrant], suite: &[Judged]) -> Vec<Results> {
    let blank = |entrant: &Entrant| Results {
        library: entrant.name.clone(),
        times: vec![f64::INFINITY; suite.len()],
        distances: vec![f64::NAN; suite.len()],
    };
    let mut results: Vec<Results> = entrants.iter().map(blank).collect();
    for (turn, first) in (0..suite.len()).step_by(BLOCK).enumerate() {
        let block = first..suite.len().min(first + BLOCK);
        for i in 0..entrants.len() {
            let which = (turn + i) % entrants.len();
            let (Some(measure), results) = (&entrants[which].distance, &mut results[which]) else { continue };
            let begun = Instant::now();
            for _ in 0..PASSES {
                for pose in block.clone() {
                    let start = Instant::now();
                    results.distances[pose] = measure(&suite[pose].rows);
                    results.times[pose] = results.times[pose].min(micros(start.elapsed()));
                }
                if begun.elapsed() > ENOUGH {
                    break;
                }
            }
        }
    }
    results
}

fn micros(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

fn cells(runs: &[Vec<Results>], suite: &[Judged]) -> Vec<Cell> {
    let ours = &runs[0][0].distances;
    let cell = |i: usize| {
        let of_runs = |share: f64| {
            let quantile_of = |results: &Vec<Results>| {
                let mut times = results[i].times.clone();
                times.sort_by(f64::total_cmp);
                quantile(&times, share)
            };
            runs.iter().map(quantile_of).collect::<Vec<_>>()
        };
        let wrong = |pose: &usize| {
            let (theirs, ours) = (runs[0][i].distances[*pose], ours[*pose]);
            (theirs <= 0.0) != suite[*pose].meets || (theirs.max(0.0) - ours).abs() > AGREE * ours
        };
        Cell {
            library: runs[0][i].library.clone(),
            medians: of_runs(0.5),
            p99s: of_runs(0.99),
            wrong: (0..suite.len()).filter(wrong).count(),
        }
    };
    (0..runs[0].len()).map(cell).collect()
}

fn head(page: &mut String, entrants: &[Entrant]) {
    let names: Vec<String> =
        entrants.iter().map(|entrant| format!("{} ({})", entrant.name, entrant.version)).collect();
    let _ = writeln!(page, "| mesh | distance | {} | FCL / ours, bar {BAR} | wrong |", names.join(" | "));
    let _ = writeln!(page, "| --- | --- | {}--: | --- |", "--: | ".repeat(names.len()));
}

fn row(page: &mut String, mesh: &str, distance: &str, cells: &[Cell]) {
    let median = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, 0.5)
    };
    let figures: Vec<String> = cells
        .iter()
        .map(|cell| format!("{:.1} / {:.1}", median(&cell.medians), median(&cell.p99s)))
        .collect();
    let of = |start: &str| {
        let named = cells.iter().filter(|cell| cell.library.starts_with(start));
        named.min_by(|x, y| median(&x.medians).total_cmp(&median(&y.medians)))
    };
    let ratio = match (of(OURS), of("FCL")) {
        (Some(ours), Some(fcl)) => {
            let ratios: Vec<f64> = fcl.medians.iter().zip(&ours.medians).map(|(f, o)| f / o).collect();
            let kept = ratios.iter().filter(|ratio| **ratio >= BAR).count();
            format!("{:.1} ({kept}/{})", median(&ratios), ratios.len())
        }
        _ => "-".to_owned(),
    };
    let wrong: Vec<String> = cells.iter().map(|cell| cell.wrong.to_string()).collect();
    let _ =
        writeln!(page, "| {mesh} | {distance} | {} | {ratio} | {} |", figures.join(" | "), wrong.join(", "));
}
