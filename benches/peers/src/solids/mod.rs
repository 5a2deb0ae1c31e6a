//! Analytic convex shapes, pair by pair, compared with the libraries that have them.

mod bodies;
mod cases;
mod entrants;
mod gjk;
mod ours;
mod page;
mod truth;

use crate::measure::{BLOCK, quantile};
use crate::{Options, record, save};
use cases::{Case, Suite};
use entrants::{Distance, Entrant};
use page::Row;
use simdop::pose::Pose;
use simdop::primitive::shape::{Core, Shape};
use std::hint::black_box;
use std::ops::Range;
use std::time::Instant;

/// A distance is wrong if its error is more than this share of the distance and the smaller body's diagonal together:
/// the peers' default tolerances are 1e-6 of the distance or in the unit of the data. The same error makes a witness
/// wrong.
const AGREE: f64 = 1e-5;

pub(crate) fn run(options: &Options) -> Result<(), String> {
    let poses = options.out.join("poses");
    std::fs::create_dir_all(&poses).map_err(|e| format!("{}: {e}", poses.display()))?;
    let suites = cases::suites(options)?;
    let drivers = crate::entrants::loaded(&entrants::DRIVERS, &options.drivers);
    let mut rows: Vec<Row> = Vec::new();
    for run in 1..=options.runs {
        for suite in &suites {
            eprintln!("run {run}: {}, {}, {}", suite.kinds[0].name(), suite.kinds[1].name(), suite.placement);
            let entrants = entrants::entrants(suite, &drivers);
            let results = in_turns(&entrants, suite.cases.len());
            rows.extend(
                entrants.iter().zip(results).map(|(entrant, results)| row(run, suite, entrant, &results)),
            );
        }
    }
    record::write(&options.out.join("shapes.csv"), &rows)?;
    save(&options.out.join("SHAPES.md"), &page::page(&rows, options))
}

/// Passes over a block. The clock of some machines has steps of 10 ns, so that a time is a mean of many readings.
const PASSES: usize = 15;

/// The times of a function in ns: for each case, and their mean without reading the clock at each call.
struct Times {
    of: Vec<f64>,
    mean: f64,
}

struct Results {
    verdicts: Times,
    hits: Vec<bool>,
    distances: Option<Times>,
    /// `None`: the library failed.
    found: Vec<Option<Distance>>,
}

/// All libraries on all cases, block by block. Verdicts first.
fn in_turns(entrants: &[Entrant], count: usize) -> Vec<Results> {
    let clock = clock();
    let times = || Times { of: vec![0.0; count], mean: 0.0 };
    let blank = |entrant: &Entrant| Results {
        verdicts: times(),
        hits: vec![false; count],
        distances: entrant.distance.is_some().then(times),
        found: vec![None; count],
    };
    let mut results: Vec<Results> = entrants.iter().map(blank).collect();
    for (turn, first) in (0..count).step_by(BLOCK).enumerate() {
        let block = first..count.min(first + BLOCK);
        for i in 0..entrants.len() {
            let which = (turn + i) % entrants.len();
            let (entrant, results) = (&entrants[which], &mut results[which]);
            let hits = &mut results.hits;
            results.verdicts.add(block.clone(), clock, |case| hits[case] = (entrant.collide)(case));
            if let (Some(measure), Some(times)) = (&entrant.distance, &mut results.distances) {
                let found = &mut results.found;
                times.add(block.clone(), clock, |case| found[case] = measure(case));
            }
        }
    }
    results
}

/// The time that [`Times`] measures for a call that does nothing.
fn clock() -> f64 {
    let nothing: Box<dyn Fn(usize) -> bool> = Box::new(|case| case % 2 == 0);
    let mut times = Times { of: vec![0.0; 1000], mean: 0.0 };
    let mut answers = vec![false; 1000];
    for first in (0..1000).step_by(BLOCK) {
        times.add(first..first + BLOCK, 0.0, |case| answers[case] = nothing(case));
    }
    black_box(answers);
    times.figures()[0]
}

impl Times {
    fn add(&mut self, block: Range<usize>, clock: f64, mut call: impl FnMut(usize)) {
        let nanos = |start: Instant| start.elapsed().as_secs_f64() * 1e9;
        let count = self.of.len() as f64;
        let (mut single, mut together) = (vec![Vec::new(); block.len()], Vec::new());
        for _ in 0..PASSES {
            for (case, times) in block.clone().zip(&mut single) {
                let start = Instant::now();
                call(black_box(case));
                times.push(nanos(start));
            }
            let start = Instant::now();
            for case in block.clone() {
                call(black_box(case));
            }
            together.push(nanos(start));
        }
        for (case, times) in block.zip(single) {
            self.of[case] = (undisturbed(times) - clock).max(0.0);
        }
        self.mean += (undisturbed(together) - clock).max(0.0) / count;
    }

    /// Median, 99th percentile and mean.
    fn figures(&self) -> [f64; 3] {
        let mut sorted = self.of.clone();
        sorted.sort_by(f64::total_cmp);
        [quantile(&sorted, 0.5), quantile(&sorted, 0.99), self.mean]
    }
}

/// The mean without interruptions, and without the first pass, which fills the caches.
fn undisturbed(mut times: Vec<f64>) -> f64 {
    times.remove(0);
    times.sort_by(f64::total_cmp);
    let limit = 1.5 * times[times.len() / 4] + 20.0;
    times.retain(|time| *time <= limit);
    times.iter().sum::<f64>() / times.len() as f64
}

/// The fault of a wrong answer.
enum Fault {
    Distance,
    Witness,
}

fn row(run: u32, suite: &Suite, entrant: &Entrant, results: &Results) -> Row {
    let wrong = |meets: bool| {
        let answers = suite.cases.iter().zip(&results.hits);
        answers.filter(|(case, hit)| case.meets == Some(meets) && **hit != meets).count()
    };
    let faults = |of: fn(&Fault) -> bool| {
        let answers = suite.cases.iter().zip(&results.found);
        answers
            .filter(|(case, found)| fault(suite, case, found.as_ref()).is_some_and(|fault| of(&fault)))
            .count()
    };
    let [verdict_median_ns, verdict_p99_ns, verdict_mean_ns] = results.verdicts.figures();
    let figures = results.distances.as_ref().map(Times::figures);
    Row {
        run,
        a: suite.kinds[0].name().to_owned(),
        b: suite.kinds[1].name().to_owned(),
        placement: suite.placement.clone(),
        cases: suite.cases.len(),
        hits: suite.cases.iter().filter(|case| case.meets == Some(true)).count(),
        open: suite.cases.iter().filter(|case| case.meets.is_none()).count(),
        library: entrant.name.clone(),
        version: entrant.version.clone(),
        verdict_median_ns,
        verdict_p99_ns,
        verdict_mean_ns,
        missed: wrong(true),
        invented: wrong(false),
        distance_median_ns: figures.map(|[median, ..]| median),
        distance_p99_ns: figures.map(|[_, p99, _]| p99),
        distance_mean_ns: figures.map(|[.., mean]| mean),
        distance_wrong: figures.map(|_| faults(|fault| matches!(fault, Fault::Distance))),
        witness_wrong: figures.map(|_| faults(|fault| matches!(fault, Fault::Witness))),
    }
}

fn fault(suite: &Suite, case: &Case, found: Option<&Distance>) -> Option<Fault> {
    let solids = &suite.pairs[case.pair];
    let [low, high] = case.distance;
    let allowed = AGREE * (high + solids[0].diagonal().min(solids[1].diagonal()));
    let Some(Distance { distance, points: [p, q] }) = found else { return Some(Fault::Distance) };
    let distance = distance.max(0.0);
    if distance < low - allowed || distance > high + allowed {
        return Some(Fault::Distance);
    }
    if case.meets != Some(false) || distance == 0.0 {
        return None;
    }
    let pose = Pose::from_rows(case.rows).expect("the poses are rigid");
    let bodies = [solids[0].shape().moved(&pose), solids[1].shape()];
    let is_off = |point: &[f64; 3], body: &Shape| {
        let point = Shape::new(Core::Point(*point), 0.0);
        point.is_ok_and(|point| gjk::bounds(&point, body).lower > allowed)
    };
    let apart = gjk::length(&gjk::difference(p, q));
    let is_wrong = (apart - distance).abs() > allowed || is_off(p, &bodies[0]) || is_off(q, &bodies[1]);
    is_wrong.then_some(Fault::Witness)
}
