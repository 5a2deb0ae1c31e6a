//! Measures the times of several entrants at the same poses in one run.

use super::approach::PerDistance;
use indicatif::ProgressBar;
use std::time::{Duration, Instant};

/// Every entrant runs each block of poses this many times; the minimum for each pose counts.
pub(super) const ROUNDS: usize = 5;

/// Number of poses that an entrant runs in a row before the next entrant's turn, as in `benches/peers`: a planner
/// queries one tree many times, and no pose is repeated before its block is over.
const BLOCK: usize = 10;

/// The resolution of clocks: shorter times count as this.
const LEAST: Duration = Duration::from_nanos(10);

/// The times of one entrant over all poses, in microseconds.
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub(super) struct Times {
    pub(super) median: f64,
    pub(super) p99: f64,
}

/// The geometric mean of the medians at the distances.
pub(super) fn geometric_mean(medians: PerDistance<f64>) -> f64 {
    (medians.iter().map(|median| median.ln()).sum::<f64>() / medians.len() as f64).exp()
}

/// Times `ask(entrant, pose)`. The bar has [`ROUNDS`] steps.
pub(super) fn in_turns(
    entrants: usize,
    poses: usize,
    bar: &ProgressBar,
    mut ask: impl FnMut(usize, usize),
) -> Vec<Times> {
    // The time to read the clock twice is not part of the query.
    let clock = (0..10_000).map(|_| Instant::now().elapsed()).min().unwrap_or_default();
    let mut least = vec![vec![Duration::MAX; poses]; entrants];
    for _ in 0..ROUNDS {
        for (turn, first) in (0..poses).step_by(BLOCK).enumerate() {
            for i in 0..entrants {
                let which = (turn + i) % entrants;
                let block = first..poses.min(first + BLOCK);
                for (pose, least) in block.clone().zip(&mut least[which][block]) {
                    let start = Instant::now();
                    ask(which, pose);
                    let time = start.elapsed().saturating_sub(clock).max(LEAST);
                    *least = time.min(*least);
                }
            }
        }
        bar.inc(1);
    }
    least.into_iter().map(Times::of).collect()
}

impl Times {
    fn of(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        // Nearest rank: the smallest time that is not below the given percentage of all times.
        let at = |percent: usize| {
            let rank = (times.len() * percent).div_ceil(100).saturating_sub(1);
            times.get(rank).map_or(0.0, |time| 1e6 * time.as_secs_f64())
        };
        Self { median: at(50), p99: at(99) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entrant_gets_every_pose_in_every_round() {
        let mut asked = vec![[0; 3]; 25];
        let times = in_turns(3, 25, &ProgressBar::hidden(), |entrant, pose| {
            asked[pose][entrant] += 1;
            if entrant == 1 {
                std::thread::sleep(Duration::from_micros(200));
            }
        });
        assert!(times.iter().all(|times| times.median >= 0.01), "{times:?}");
        assert!(asked.iter().flatten().all(|&count| count == ROUNDS));
        assert!(times[1].median >= 190.0 && times[1].median <= times[1].p99, "{times:?}");
        assert!(times[0].median < 100.0 && times[2].median < 100.0, "{times:?}");
    }

    #[test]
    fn percentiles_are_times_that_were_measured() {
        let times = Times::of((1..=200).rev().map(Duration::from_micros).collect());
        assert_eq!((times.median.round(), times.p99.round()), (100.0, 198.0));
    }
}
