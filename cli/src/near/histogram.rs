//! A histogram of the numbers of neighbours.

use serde::Serialize;
use std::io::Write;

/// Maximum number of rows.
const ROWS: u32 = 20;
/// Characters of the longest bar.
const BAR: usize = 50;

#[derive(Serialize)]
pub(super) struct Histogram {
    least: u32,
    /// For an even number of points, the lower of the two middle numbers.
    median: u32,
    mean: f64,
    greatest: u32,
    total: u64,
    rows: Vec<Row>,
}

/// The points whose number of neighbours is in `from ..= to`.
#[derive(Serialize, PartialEq, Eq, Debug)]
struct Row {
    from: u32,
    to: u32,
    points: usize,
}

impl Histogram {
    /// Requires at least one count.
    pub(super) fn of(mut counts: Vec<u32>) -> Self {
        counts.sort_unstable();
        let (least, greatest) = (counts[0], counts[counts.len() - 1]);
        let width = width(least, greatest);
        let mut rows = Vec::new();
        let mut rest = counts.as_slice();
        for row in least / width..=greatest / width {
            let (from, to) = (row * width, (row * width).saturating_add(width - 1));
            let (of_row, above) = rest.split_at(rest.partition_point(|count| *count <= to));
            rows.push(Row { from, to, points: of_row.len() });
            rest = above;
        }
        let total = counts.iter().copied().map(u64::from).sum();
        let median = counts[(counts.len() - 1) / 2];
        Self { least, median, mean: total as f64 / counts.len() as f64, greatest, total, rows }
    }

    pub(super) const fn total(&self) -> u64 {
        self.total
    }

    pub(super) fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let Self { least, median, mean, greatest, total, .. } = self;
        writeln!(
            out,
            "neighbours: {least} least, {mean:.2} mean, {median} median, {greatest} greatest, {total} in all"
        )?;
        writeln!(out, "\n           neighbours      points")?;
        let highest = self.rows.iter().map(|row| row.points).max().unwrap_or(1).max(1);
        for Row { from, to, points } in &self.rows {
            let range = if from == to { from.to_string() } else { format!("{from} to {to}") };
            let bar = "#".repeat((points * BAR).div_ceil(highest));
            writeln!(out, "{}", format!("{range:>21}  {points:10}  {bar}").trim_end())?;
        }
        Ok(())
    }
}

/// The smallest of 1, 2, 5, 10, 20 and so on that gives few enough rows.
fn width(least: u32, greatest: u32) -> u32 {
    let mut decade = 1;
    loop {
        for step in [1, 2, 5] {
            let width = step * decade;
            if greatest / width - least / width < ROWS {
                return width;
            }
        }
        decade *= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number is in exactly one row, rows adjoin, and there are neither too many nor needlessly few.
    #[test]
    fn every_count_is_in_one_row() {
        for counts in [
            vec![7],
            vec![0, 19, 3, 3],
            vec![1, 20, 21],
            vec![99, 1000, 101, 131_072],
            vec![0, u32::MAX],
            vec![u32::MAX - 1, u32::MAX],
        ] {
            let histogram = Histogram::of(counts.clone());
            let rows = &histogram.rows;
            assert!(rows.len() <= 20 && (rows.len() > 7 || rows[0].from == rows[0].to), "{rows:?}");
            for pair in rows.windows(2) {
                assert_eq!(pair[0].to + 1, pair[1].from);
                assert_eq!(pair[0].to - pair[0].from, rows[0].to - rows[0].from);
            }
            for row in rows {
                let inside = counts.iter().filter(|count| (row.from..=row.to).contains(count)).count();
                assert_eq!(row.points, inside, "{row:?}");
            }
            assert_eq!(rows.iter().map(|row| row.points).sum::<usize>(), counts.len());
        }
    }

    #[test]
    fn the_figures_are_those_of_the_counts() {
        let Histogram { least, median, mean, greatest, total, .. } = Histogram::of(vec![9, 1, 4, 2]);
        assert_eq!((least, median, mean, greatest, total), (1, 2, 4.0, 9, 16));
        assert_eq!(Histogram::of(vec![3, 1, 2]).median, 2);
    }
}
