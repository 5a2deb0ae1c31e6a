//! Progress of long work: bars on standard error, if it is a terminal.

use core::time::Duration;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::io::IsTerminal;

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
    fn full_trees_have_so_many_levels() {
        for (triangles, leaf_size, arity, want) in
            [(0, 1, 16, 1), (16, 1, 16, 1), (17, 1, 16, 2), (32, 2, 16, 1), (4096, 1, 16, 3), (65, 1, 4, 4)]
        {
            assert_eq!(levels(triangles, leaf_size, arity), want);
        }
    }
}
