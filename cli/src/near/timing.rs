//! Times of searches.

use crate::error::Error;
use core::time::Duration;
use std::time::Instant;

/// The result of some work, which is the same every time, and the shortest time it took.
pub(super) fn fastest<R>(
    repeat: u32,
    mut search: impl FnMut() -> Result<R, Error>,
) -> Result<(R, Duration), Error> {
    let mut timed = || {
        let start = Instant::now();
        search().map(|result| (result, start.elapsed()))
    };
    let (result, mut least) = timed()?;
    for _ in 1..repeat {
        least = least.min(timed()?.1);
    }
    Ok((result, least))
}
