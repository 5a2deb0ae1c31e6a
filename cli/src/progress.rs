//! Progress of long work, on standard error: bars on a terminal, and for some work, lines in a log.

use core::time::Duration;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::IsTerminal;
use std::time::Instant;

/// A spinner with a text, for a step of unknown length. Disappears when dropped.
pub(super) fn step(text: String, quiet: bool) -> ProgressBar {
    let bar = visible(ProgressBar::new_spinner(), quiet);
    if bar.is_hidden() {
        return bar;
    }
    bar.set_message(text);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// A bar over `count` items, such as poses. Disappears when dropped.
pub(super) fn bar(count: usize, unit: &str, quiet: bool) -> ProgressBar {
    let bar = visible(ProgressBar::new(count as u64), quiet);
    let template = format!("{{wide_bar}} {{pos}}/{{len}} {unit}, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar
}

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

/// See [`Logged`].
pub(super) fn logged(count: usize, unit: &'static str, quiet: bool) -> Logged {
    let now = Instant::now();
    let is_log = !quiet && !std::io::stderr().is_terminal();
    Logged { bar: bar(count, unit, quiet), unit, is_log, start: now, last: now }
}

impl Logged {
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

/// A bar over a build, in levels of the tree: the first takes longest, and the others about equally long. Disappears
/// when dropped.
pub(super) fn build(name: &str, levels: u64, quiet: bool) -> ProgressBar {
    // One more step makes the nodes of all levels.
    let bar = visible(ProgressBar::new(levels + 1), quiet);
    if bar.is_hidden() {
        return bar;
    }
    if let Ok(style) = ProgressStyle::with_template("building {msg} {wide_bar} {percent} %, {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(name.to_owned());
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Levels of a tree with full nodes over this many triangles.
pub(super) fn levels(triangles: usize, leaf_size: usize, arity: usize) -> u64 {
    let (mut levels, mut room) = (1, leaf_size.saturating_mul(arity));
    while room < triangles {
        (levels, room) = (levels + 1, room.saturating_mul(arity));
    }
    levels
}

fn visible(bar: ProgressBar, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    bar.with_finish(ProgressFinish::AndClear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_log_say_what_is_left() {
        assert_eq!(line(30, 120, "pairs", Duration::from_secs(20)), "30/120 pairs, 60 s left");
        assert_eq!(line(120, 120, "pairs", Duration::from_secs(20)), "120/120 pairs, 0 s left");
    }

    #[test]
    fn full_trees_have_so_many_levels() {
        for (triangles, leaf_size, arity, want) in
            [(0, 1, 16, 1), (16, 1, 16, 1), (17, 1, 16, 2), (32, 2, 16, 1), (4096, 1, 16, 3), (65, 1, 4, 4)]
        {
            assert_eq!(levels(triangles, leaf_size, arity), want);
        }
    }
}
