//! Times of variants of a query, which run in turns.

use std::hint::black_box;
use std::time::Instant;

/// Microseconds per call, averaged over enough calls to be measurable.
pub(crate) fn timed(ask: impl Fn() -> bool) -> f64 {
    let once = |calls: u32| {
        let start = Instant::now();
        for _ in 0..calls {
            black_box(ask());
        }
        start.elapsed().as_secs_f64() * 1e6 / f64::from(calls)
    };
    let first = once(1);
    once(((8.0 / first) as u32).clamp(1, 200))
}

/// Median, mean and 99th percentile of times, which are sorted.
pub(crate) fn figures(times: &mut [f64]) -> [f64; 3] {
    times.sort_by(f64::total_cmp);
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    [times[times.len() / 2], mean, times[times.len() * 99 / 100]]
}

/// [`figures`] as a cell of a table.
pub(crate) fn cell([median, mean, p99]: &[f64; 3]) -> String {
    format!("{median:.3} / {mean:.3} / {p99:.2}")
}
