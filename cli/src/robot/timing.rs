//! Times of answers, and their averages.

use simdop::planning::PlanningError;
use std::time::Instant;

/// An answer, which is the same every time, and the shortest of three measured times, in microseconds.
pub(super) fn timed<R>(mut ask: impl FnMut() -> Result<R, PlanningError>) -> Result<(R, f64), PlanningError> {
    let mut once = || {
        let start = Instant::now();
        ask().map(|answer| (answer, start.elapsed().as_secs_f64() * 1e6))
    };
    let (answer, first) = once()?;
    Ok((answer, first.min(once()?.1).min(once()?.1)))
}

/// Zero if there are no values.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Zero if there are no values.
pub(super) fn median(values: Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

/// Zero if there are no values.
pub(super) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((share * values.len() as f64) as usize).copied().unwrap_or(0.0)
}
