//! Devices at full speed.

use crate::short::is_short;
use std::time::{Duration, Instant};

/// Calls `work` again and again for a while: a device without work slows its clock down, to a third on an H200, and takes some tenths of
/// a second of work to come back.
pub(crate) fn warm_up<T>(mut work: impl FnMut() -> T) {
    let start = Instant::now();
    let _ = work();
    while !is_short() && start.elapsed() < Duration::from_millis(700) {
        let _ = work();
    }
}
