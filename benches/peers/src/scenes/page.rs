//! The results as a page of Markdown, and its rows.

use super::entrants::OURS;
use crate::cpu::cpu;
use crate::table::short;
use core::fmt::Write as _;
use serde::Serialize;

/// A line of the CSV file: a library on a robot's configurations.
#[derive(Serialize)]
pub(super) struct Row {
    pub(super) robot: String,
    pub(super) links: usize,
    pub(super) triangles: usize,
    /// Pairs of links that are tested.
    pub(super) pairs: usize,
    pub(super) problems: usize,
    pub(super) obstacles: String,
    pub(super) configurations: usize,
    /// Free configurations, by the exact oracle.
    pub(super) free: usize,
    pub(super) library: String,
    pub(super) version: String,
    /// Mean over the configurations of the median over the rounds.
    pub(super) mean_us: f64,
    /// The same with the minimum over the rounds.
    pub(super) least_us: f64,
    pub(super) p50_us: f64,
    pub(super) p99_us: f64,
    /// Answers "free" that are wrong.
    pub(super) missed: usize,
    /// Answers "hit" that are wrong.
    pub(super) invented: usize,
}

const ABOUT: &str = "\
Is a configuration of the robot free? The links are at given poses, and are tested against the obstacles\n\
and against each other, up to the first hit. The SRDF excludes some pairs of links. Each problem of\n\
MotionBenchMaker has a start, a goal and ten random configurations.\n\
\n\
simdop uses a `Scene`. FCL and Coal use one `DynamicAABBTreeCollisionManager` for the links and one for\n\
the obstacles. The manager of the links is updated, tested against the other, and then against itself,\n\
with callbacks that stop at the first hit. Updating the links one by one takes longer, and testing them\n\
one by one is no faster; testing the links against each other first makes little difference. \"FCL\n\
native\" is compiled here with -O3 -march=native, the others as in their packages. Coal's break_distance\n\
is 0.\n\
\n\
Links are trees of triangles. Obstacles are boxes, and prisms of sixteen sides around cylinders.\n\
*Surfaces* are trees of their triangles for all libraries. *Solids*, in which a link inside is a hit,\n\
are solid trees for simdop, and Box and Convex for the peers (prisms as trees take them up to 8 % less,\n\
but are hollow). The truth is brute force in exact arithmetic, at every configuration. *Missed*:\n\
reported free where it is not; *invented*: reported hit where it is free.\n\
\n\
In a round, each library in turn decides every configuration once. For each configuration the median\n\
over the rounds counts: the table has mean, p50 and p99 of these; in brackets the mean of the minima.\n\
Reading the clock is included.\n";

/// The page.
pub(super) fn page(rows: &[Row], stamp: &str) -> String {
    let mut page = format!("# A robot among bodies\n\n{stamp}. {}, one thread.\n\n{ABOUT}", cpu());
    for group in rows.chunk_by(|a, b| (&a.robot, &a.obstacles) == (&b.robot, &b.obstacles)) {
        let first = &group[0];
        let _ = write!(
            page,
            "\n## {}, obstacles as {}\n\n{} links of {} triangles, {} pairs of links, {} problems; {} of {} \
             configurations are free.\n\n\
            | library | mean, µs | / {OURS} | p50 | p99 | missed + invented |\n| --- | --: | --: | --: | --: | --: |\n",
            first.robot,
            first.obstacles,
            first.links,
            first.triangles,
            first.pairs,
            first.problems,
            first.free,
            first.configurations
        );
        let ours = group.iter().find(|row| row.library == OURS).map_or(f64::NAN, |row| row.mean_us);
        for row in group {
            let _ = writeln!(
                page,
                "| {} {} | {} ({}) | {} | {} | {} | {} + {} |",
                row.library,
                row.version,
                short(row.mean_us),
                short(row.least_us),
                short(row.mean_us / ours),
                short(row.p50_us),
                short(row.p99_us),
                row.missed,
                row.invented
            );
        }
    }
    page
}
