//! Timing of queries.

use crate::data::MeshData;
use crate::entrants::Entrant;
use crate::poses::{Judged, Named};
use crate::record::Row;
use std::time::{Duration, Instant};

/// Poses that a library gets in a row before the next library's turn. With a single pose, the caches would hold the
/// other libraries' data at each query; a planner queries one library many times. A pose is repeated only after the
/// others of the block, so that no branch predictor learns a query.
pub(crate) const BLOCK: usize = 10;

/// Passes over a block; the minimum time of each pose counts.
pub(crate) const PASSES: usize = 5;

/// No further pass over a block that took this long in total.
pub(crate) const ENOUGH: Duration = Duration::from_millis(100);

/// The context of a measurement.
pub(crate) struct Occasion<'s> {
    pub(crate) run: u32,
    pub(crate) mesh: &'s str,
}

/// Times of one library on one suite, and its answers.
#[derive(Clone)]
struct Results {
    best: Vec<Duration>,
    hits: Vec<bool>,
}

/// All libraries on all suites, in turns.
pub(crate) fn measure(
    occasion: &Occasion<'_>,
    meshes: &[MeshData],
    entrants: &[Entrant],
    suites: &[Named],
) -> Vec<Row> {
    let mut rows = Vec::new();
    let clock = clock_cost();
    for (distance, suite) in suites {
        let results = in_turns(entrants, suite, clock);
        for (entrant, results) in entrants.iter().zip(results) {
            rows.push(row(occasion, meshes, distance, entrant, suite, &results));
        }
    }
    rows
}

/// The minimum time between two consecutive readings of the clock: this much of a time is not the query's.
fn clock_cost() -> Duration {
    (0..10_000).map(|_| Instant::now().elapsed()).min().unwrap_or_default()
}

fn in_turns(entrants: &[Entrant], suite: &[Judged], clock: Duration) -> Vec<Results> {
    let blank = Results { best: vec![Duration::MAX; suite.len()], hits: vec![false; suite.len()] };
    let mut results = vec![blank; entrants.len()];
    for (turn, first) in (0..suite.len()).step_by(BLOCK).enumerate() {
        let block = first..suite.len().min(first + BLOCK);
        for i in 0..entrants.len() {
            let which = (turn + i) % entrants.len();
            let (entrant, results) = (&entrants[which], &mut results[which]);
            let start = Instant::now();
            for _ in 0..PASSES {
                for pose in block.clone() {
                    let start = Instant::now();
                    let hit = (entrant.collide)(&suite[pose].rows);
                    results.best[pose] = results.best[pose].min(start.elapsed().saturating_sub(clock));
                    results.hits[pose] = hit;
                }
                if start.elapsed() > ENOUGH {
                    break;
                }
            }
        }
    }
    results
}

fn row(
    occasion: &Occasion<'_>,
    meshes: &[MeshData],
    distance: &str,
    entrant: &Entrant,
    suite: &[Judged],
    results: &Results,
) -> Row {
    let mut times: Vec<f64> = results.best.iter().map(|time| time.as_secs_f64() * 1e6).collect();
    times.sort_by(f64::total_cmp);
    let differ = |meets| {
        let pairs = suite.iter().zip(&results.hits);
        pairs.filter(|(pose, hit)| pose.meets == meets && **hit != meets).count()
    };
    let counters =
        entrant.count.as_ref().map(|count| suite.iter().map(|pose| count(&pose.rows)).collect::<Vec<_>>());
    let mean = |of: fn(&simdop::query::QueryStats) -> u64| {
        counters.as_ref().map(|all| all.iter().map(of).sum::<u64>() as f64 / all.len() as f64)
    };
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    Row {
        run: occasion.run,
        mesh: occasion.mesh.to_owned(),
        triangles_a: meshes[0].triangles.len(),
        triangles_b: meshes[meshes.len() - 1].triangles.len(),
        distance: distance.to_owned(),
        poses: suite.len(),
        hits: suite.iter().filter(|pose| pose.meets).count(),
        library: entrant.name.clone(),
        version: entrant.version.clone(),
        build_ms: entrant.build_ms,
        bytes_per_triangle: entrant.bytes.map(|bytes| bytes as f64 / triangles as f64),
        median_us: quantile(&times, 0.5),
        mean_us: times.iter().sum::<f64>() / times.len() as f64,
        p99_us: quantile(&times, 0.99),
        max_us: quantile(&times, 1.0),
        missed: differ(true),
        invented: differ(false),
        visits: mean(|c| c.visits),
        kernels: mean(|c| c.kernels),
        realignments: mean(|c| c.realignments),
        primitive_pairs: mean(|c| c.primitive_pairs),
        exact_pairs: mean(|c| c.exact_pairs),
    }
}

/// Nearest rank: the smallest value that is not below the given share of all values.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}
