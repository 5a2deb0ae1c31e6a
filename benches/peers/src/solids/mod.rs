//! Convex shapes of a formula, pair by pair, compared with the libraries that have such.

mod bodies;
mod cases;
mod entrants;
mod gjk;
mod ours;
mod page;
mod truth;

use crate::measure::{BLOCK, PASSES, clock_cost, quantile};
use crate::{Options, record, save};
use cases::{Case, Suite};
use entrants::{Distance, Entrant};
use page::Row;
use simdop::pose::Pose;
use simdop::primitive::shape::{Core, Shape};
use std::hint::black_box;
use std::time::Instant;

/// A distance is wrong if its error is more than this share of the distance and the smaller body's diagonal together:
/// the peers' default tolerances are 1e-6 of the distance or in the unit of the data. A witness is wrong by as much.
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

/// The times of a function in ns, by case, and their mean without reading the clock each time.
struct Times {
    best: Vec<f64>,
    mean: f64,
}

struct Results {
    verdicts: Times,
    hits: Vec<bool>,
    distances: Option<Times>,
    /// `None`: the library failed.
    found: Vec<Option<Distance>>,
}

/// All libraries on all cases, block by block, as in [`crate::measure`]. Verdicts first.
fn in_turns(entrants: &[Entrant], count: usize) -> Vec<Results> {
    let clock = clock_cost().as_secs_f64() * 1e9;
    let times = || Times { best: vec![f64::INFINITY; count], mean: 0.0 };
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
            results
                .verdicts
                .of_block(block.clone(), count, clock, |case| results.hits[case] = (entrant.collide)(case));
            if let (Some(measure), Some(times)) = (&entrant.distance, &mut results.distances) {
                times.of_block(block.clone(), count, clock, |case| results.found[case] = measure(case));
            }
        }
    }
    results
}

impl Times {
    fn of_block(
        &mut self,
        block: std::ops::Range<usize>,
        count: usize,
        clock: f64,
        mut call: impl FnMut(usize),
    ) {
        let nanos = |start: Instant| start.elapsed().as_secs_f64() * 1e9;
        let mut all = f64::INFINITY;
        for _ in 0..PASSES {
            for case in block.clone() {
                let start = Instant::now();
                call(black_box(case));
                self.best[case] = self.best[case].min((nanos(start) - clock).max(0.0));
            }
            let start = Instant::now();
            for case in block.clone() {
                call(black_box(case));
            }
            all = all.min((nanos(start) - clock).max(0.0));
        }
        self.mean += all / count as f64;
    }

    /// Median, 99th percentile and mean.
    fn figures(&self) -> [f64; 3] {
        let mut sorted = self.best.clone();
        sorted.sort_by(f64::total_cmp);
        [quantile(&sorted, 0.5), quantile(&sorted, 0.99), self.mean]
    }
}

/// What is wrong with an answer.
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
