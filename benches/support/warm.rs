//! Brings GPUs to full clock speed.

use crate::short::is_short;
use std::time::{Duration, Instant};

/// Calls `work` repeatedly for a while: an idle GPU lowers its clock, to a third on an H200, and takes some tenths of a
/// second of work to recover.
pub(crate) fn warm_up<T>(mut work: impl FnMut() -> T) {
    let start = Instant::now();
    let _ = work();
    while !is_short() && start.elapsed() < Duration::from_millis(700) {
        let _ = work();
    }
}
