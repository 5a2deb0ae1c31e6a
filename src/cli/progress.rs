//! Progress on long work: on a terminal only, on standard error.

use core::time::Duration;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::IsTerminal;

/// A spinner with a text, for a step of unknown length. It is gone when it is dropped.
pub(super) fn step(text: String, quiet: bool) -> ProgressBar {
    let bar = visible(ProgressBar::new_spinner(), quiet);
    if bar.is_hidden() {
        return bar;
    }
    bar.set_message(text);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// A bar over `count` poses. It is gone when it is dropped.
pub(super) fn bar(count: usize, quiet: bool) -> ProgressBar {
    let bar = visible(ProgressBar::new(count as u64), quiet);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} poses, {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn visible(bar: ProgressBar, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    bar.with_finish(ProgressFinish::AndClear)
}
