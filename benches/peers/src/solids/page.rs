//! The results as a page of Markdown, and its rows.

use super::cases::placements;
use super::ours::OURS;
use super::{AGREE, PASSES};
use crate::Options;
use crate::cpu::cpu;
use crate::measure::{BLOCK, quantile};
use core::fmt::Write as _;
use serde::Serialize;

/// The project's targets for our median time relative to the fastest peer's: in the median row, and in any.
const MEDIAN_BAR: f64 = 1.0 / 3.0;
const ANY_BAR: f64 = 1.5;

/// A line of the CSV file: a library on a suite.
#[derive(Clone, Serialize)]
pub(super) struct Row {
    pub(super) run: u32,
    pub(super) a: String,
    pub(super) b: String,
    pub(super) placement: String,
    pub(super) cases: usize,
    /// Cases in which the solids meet.
    pub(super) hits: usize,
    /// Cases without a known verdict.
    pub(super) open: usize,
    pub(super) library: String,
    pub(super) version: String,
    pub(super) verdict_median_ns: f64,
    pub(super) verdict_p99_ns: f64,
    /// The mean time of a verdict, without reading the clock at each call.
    pub(super) verdict_mean_ns: f64,
    /// Answers "free" where the solids meet.
    pub(super) missed: usize,
    /// Answers "hit" where they do not.
    pub(super) invented: usize,
    pub(super) distance_median_ns: Option<f64>,
    pub(super) distance_p99_ns: Option<f64>,
    pub(super) distance_mean_ns: Option<f64>,
    pub(super) distance_wrong: Option<usize>,
    /// Wrong witnesses of right distances.
    pub(super) witness_wrong: Option<usize>,
}

/// One of the two queries.
struct Measure {
    title: &'static str,
    median: fn(&Row) -> Option<f64>,
    p99: fn(&Row) -> Option<f64>,
    wrong: fn(&Row) -> [usize; 2],
}

const MEASURES: [Measure; 2] = [
    Measure {
        title: "Verdicts",
        median: |row| Some(row.verdict_median_ns),
        p99: |row| Some(row.verdict_p99_ns),
        wrong: |row| [row.missed, row.invented],
    },
    Measure {
        title: "Distances",
        median: |row| row.distance_median_ns,
        p99: |row| row.distance_p99_ns,
        wrong: |row| [row.distance_wrong.unwrap_or(0), row.witness_wrong.unwrap_or(0)],
    },
];

/// The page.
pub(super) fn page(rows: &[Row], options: &Options) -> String {
    let libraries = distinct(rows.iter().map(|row| &*row.library));
    let mut page = String::new();
    head(&mut page, rows, &libraries, options);
    ratios(&mut page, rows, &libraries);
    wrong(&mut page, rows, &libraries);
    for measure in &MEASURES {
        for (placement, _) in placements() {
            let of: Vec<Row> = rows.iter().filter(|row| row.placement == placement).cloned().collect();
            if !of.is_empty() {
                let _ = write!(page, "\n## {}, {placement}\n\n", measure.title);
                table(&mut page, &of, &libraries, measure);
            }
        }
    }
    page
}

fn head(page: &mut String, rows: &[Row], libraries: &[&str], options: &Options) {
    let version = |library: &&str| {
        let row = rows.iter().find(|row| row.library == *library);
        format!("{library} {}", row.map_or("", |row| &row.version))
    };
    let versions: Vec<String> = libraries.iter().map(version).collect();
    let _ = write!(
        page,
        "# Pairs of convex shapes\n\n\
        {}. {}, one thread.\n\
        \n\
        {} run(s), {} poses per row, of ten pairs of sizes: lengths are between 1/4 and 1. A, rotated at random,\n\
        comes from a random direction such that a random point of it moves towards one of B, up to a distance\n\
        relative to the smaller body's diagonal; \"0 %\" is a gap of 2e-5, as in RESULTS.md. The half-space is\n\
        fixed.\n\
        \n\
        * *nested*: A, at a tenth of its size, is inside B.\n\
        * *thin*: the radius of capsules and one length of the others, but spheres, is 1e-6. *Tiny*: the sizes\n\
        are 1e-6 of those above. *1:1000*: one body is that much smaller. The distances take turns.\n\
        * *far*: the distance is 1e6.\n\
        * *touching*, *2^-36 apart*: at right angles, with numbers so short that nothing is rounded. These are\n\
        knife edges.\n\
        \n\
        Versions: {}.\n\
        \n\
        Coal is compiled as in its package. \"FCL native\" has its templates compiled here with -O3\n\
        -march=native; its package has assertions that end the process where shapes almost touch. All compute in\n\
        f64 with their default tolerances. A verdict is computed without contacts, Coal's by its functor for a\n\
        pair of shapes, with break_distance 0. A distance comes with the closest points; where the bodies meet,\n\
        no depth is computed. FCL has no distance from a half-space. \"simdop meshes (before)\" has trees of\n\
        triangles instead of shapes: cylinders and cones within 1e-3 of their radius, spheres and capsules as\n\
        points and segments with a margin, and a large cube as half-space; each a solid.\n\
        \n\
        Poses are converted to each library's type beforehand. A time is the mean of up to {} passes over a\n\
        block of {BLOCK} poses without those that were interrupted, less that of reading the clock; the\n\
        libraries take turns. With several runs, a figure is their median.\n",
        options.stamp,
        cpu(),
        options.runs,
        options.poses(),
        versions.join(", "),
        PASSES - 1
    );
}

/// Our median times relative to the fastest peer's.
fn ratios(page: &mut String, rows: &[Row], libraries: &[&str]) {
    let _ = write!(
        page,
        "\n## {OURS} / fastest peer\n\n\
        Of the median times of a row. The bars: at most {MEDIAN_BAR:.2} in the median row, never above {ANY_BAR}. \
        *Exact*: of the peers without a wrong answer in the row.\n\n\
        | query | rows | median row | worst row | | rows above {ANY_BAR} |\n| --- | --: | --: | --: | --- | --: |\n"
    );
    for (measure, is_exact) in MEASURES.iter().flat_map(|measure| [(measure, false), (measure, true)]) {
        let title = format!("{}{}", measure.title, if is_exact { ", exact" } else { "" });
        let mut all: Vec<(f64, String)> = groups(rows)
            .iter()
            .filter_map(|group| {
                let first = group[0];
                let what = format!("{}, {}, {}", first.a, first.b, first.placement);
                Some((ratio(group, libraries, measure, is_exact)?, what))
            })
            .collect();
        all.sort_by(|x, y| x.0.total_cmp(&y.0));
        let Some((worst, what)) = all.last() else {
            let _ = writeln!(page, "| {title} | 0 | - | - | | - |");
            continue;
        };
        let sorted: Vec<f64> = all.iter().map(|(ratio, _)| *ratio).collect();
        let above = sorted.iter().filter(|ratio| **ratio > ANY_BAR).count();
        let _ = writeln!(
            page,
            "| {title} | {} | {:.2} | {worst:.2} | {what} | {above} |",
            all.len(),
            quantile(&sorted, 0.5)
        );
    }
}

fn wrong(page: &mut String, rows: &[Row], libraries: &[&str]) {
    for (measure, about) in MEASURES.iter().zip([
        "Missed (\"free\" where the bodies meet) + invented (\"hit\" where they do not), over all pairs. Open: \
         the truth is not known.",
        &format!(
            "Distances that are off by more than {AGREE:e} of the distance and the smaller body's diagonal together + \
             closest points that are off by as much, from the bodies or as a distance."
        ),
    ]) {
        let _ = write!(
            page,
            "\n## Wrong {}\n\n{}\n\n| | answers | open | {} |\n| --- | --: | --: |{}\n",
            measure.title.to_lowercase(),
            about.split_inclusive(' ').fold(String::new(), wrapped),
            libraries.join(" | "),
            " --: |".repeat(libraries.len())
        );
        for (placement, _) in placements() {
            let of = |library: &&str| {
                rows.iter()
                    .filter(|row| row.run == 1 && row.placement == placement && row.library == *library)
                    .collect::<Vec<_>>()
            };
            let all = of(&libraries[0]);
            if all.is_empty() {
                continue;
            }
            let cells: Vec<String> = libraries
                .iter()
                .map(|library| {
                    let sum = |i: usize| of(library).iter().map(|row| (measure.wrong)(row)[i]).sum::<usize>();
                    format!("{} + {}", sum(0), sum(1))
                })
                .collect();
            let sum = |of: fn(&Row) -> usize| all.iter().map(|row| of(row)).sum::<usize>();
            let (cases, open) = (sum(|row| row.cases), sum(|row| row.open));
            let _ = writeln!(page, "| {placement} | {cases} | {open} | {} |", cells.join(" | "));
        }
    }
}

/// Appends a word, on a new line if it does not fit.
fn wrapped(mut text: String, word: &str) -> String {
    let line = text.rsplit('\n').next().unwrap_or_default().len();
    if line + word.trim_end().len() > 110 {
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text + word
}

fn table(page: &mut String, rows: &[Row], libraries: &[&str], measure: &Measure) {
    let _ = write!(
        page,
        "Median / 99th percentile, ns; in brackets wrong answers.\n\n\
        | A | B | {} | {OURS} / fastest |\n| --- | --- |{} --: |\n",
        libraries.join(" | "),
        " --: |".repeat(libraries.len())
    );
    for group in groups(rows) {
        let cell = |library: &&str| {
            let of: Vec<&Row> = group.iter().copied().filter(|row| row.library == *library).collect();
            let (Some(median), Some(p99)) = (over_runs(&of, measure.median), over_runs(&of, measure.p99))
            else {
                return "-".to_owned();
            };
            let [x, y] = (measure.wrong)(of[0]);
            let wrong = if x + y == 0 { String::new() } else { format!(" ({x} + {y})") };
            format!("{median:.0} / {p99:.0}{wrong}")
        };
        let cells: Vec<String> = libraries.iter().map(cell).collect();
        let ratio =
            ratio(&group, libraries, measure, false).map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
        let _ = writeln!(page, "| {} | {} | {} | {ratio} |", group[0].a, group[0].b, cells.join(" | "));
    }
}

/// The rows of each pair and placement.
fn groups(rows: &[Row]) -> Vec<Vec<&Row>> {
    let key = |row: &Row| (row.a.clone(), row.b.clone(), row.placement.clone());
    let of = |wanted| rows.iter().filter(|row| key(row) == wanted).collect();
    distinct(rows.iter().map(key)).into_iter().map(of).collect()
}

fn over_runs(rows: &[&Row], of: fn(&Row) -> Option<f64>) -> Option<f64> {
    let mut values: Vec<f64> = rows.iter().filter_map(|row| of(row)).collect();
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| quantile(&values, 0.5))
}

/// Our median time relative to that of the fastest peer, if `is_exact` of those without a wrong answer.
fn ratio(group: &[&Row], libraries: &[&str], measure: &Measure, is_exact: bool) -> Option<f64> {
    let of =
        |library: &str| -> Vec<&Row> { group.iter().copied().filter(|row| row.library == library).collect() };
    let time = |rows: &[&Row]| over_runs(rows, measure.median);
    let is_right = |rows: &[&Row]| !is_exact || rows.iter().all(|row| (measure.wrong)(row) == [0, 0]);
    let peers = libraries.iter().filter(|library| !library.starts_with(OURS)).map(|library| of(library));
    let fastest =
        peers.filter(|rows| is_right(rows)).filter_map(|rows| time(&rows)).min_by(f64::total_cmp)?;
    Some(time(&of(OURS))? / fastest)
}

/// The distinct items, in the order of first appearance.
fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    items.fold(Vec::new(), |mut all, item| {
        if !all.contains(&item) {
            all.push(item);
        }
        all
    })
}
