//! Progress of work that takes minutes: lines in a log, if standard error is no terminal.

use crate::progress;
use core::time::Duration;
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::time::Instant;

/// Time between two lines of a log.
const EVERY: Duration = Duration::from_secs(10);

/// A bar over `count` items on a terminal, and a line every ten seconds in a log.
pub(super) struct Logged {
    bar: ProgressBar,
    unit: &'static str,
    is_log: bool,
    start: Instant,
    last: Instant,
}

impl Logged {
    pub(super) fn new(count: usize, unit: &'static str, quiet: bool) -> Self {
        let now = Instant::now();
        let is_log = !quiet && !std::io::stderr().is_terminal();
        Self { bar: progress::bar(count, unit, quiet), unit, is_log, start: now, last: now }
    }

    /// Called after each item.
    pub(super) fn inc(&mut self) {
        self.bar.inc(1);
        if self.is_log && self.last.elapsed() >= EVERY {
            self.last = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
            eprintln!("{}", line(done, all, self.unit, self.start.elapsed()));
        }
    }
}

/// A line of a log. `done` is at least 1.
fn line(done: u64, all: u64, unit: &str, passed: Duration) -> String {
    let left = passed.as_secs_f64() * all.saturating_sub(done) as f64 / done as f64;
    format!("{done}/{all} {unit}, {left:.0} s left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_log_say_what_is_left() {
        assert_eq!(line(30, 120, "pairs", Duration::from_secs(20)), "30/120 pairs, 60 s left");
        assert_eq!(line(120, 120, "pairs", Duration::from_secs(20)), "120/120 pairs, 0 s left");
    }
}
