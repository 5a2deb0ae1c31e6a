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
    /// By the exact oracle.
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
May the robot stand here? The links are placed, at poses that are given, and asked against the obstacles and against \
each other, all pairs but those that the\n\
SRDF rules out, until the first hit. Problems of MotionBenchMaker: of each the start, a goal and ten random \
configurations. simdop: a `Scene`. FCL and Coal: a\n\
`DynamicAABBTreeCollisionManager` for the links and one for the obstacles. The links' manager is updated, asked \
against the other, and then against itself, by callbacks\n\
that stop at the first hit. Updating links one by one takes longer, asking one by one no less, itself first more or \
less. \"FCL native\" is compiled here with\n\
-O3 -march=native, the others as their packages are. Coal's break_distance is 0.\n\n\
Links are trees of triangles. Obstacles are boxes, and prisms of sixteen sides around cylinders. *Surfaces* are trees \
of their triangles for all libraries.\n\
*Solids*, in which a link is a hit too, are solid trees for simdop, Box and Convex for the peers (prisms as trees take \
them up to 8 % less, but are hollow).\n\
The truth is brute force in exact arithmetic, at every configuration. *Missed*: said free where it is not; *invented*: \
said hit where it is free.\n\n\
A round is every configuration once by one library, and the libraries take turns. Of each configuration the median of \
its rounds counts: their mean, p50 and\n\
p99; in brackets the mean of the least. Reading the clock is in all of them.\n";

/// The page.
pub(super) fn page(rows: &[Row], stamp: &str) -> String {
    let mut page = format!("# A robot among bodies\n\n{stamp}. {}, one thread.\n\n{ABOUT}", cpu());
    for group in rows.chunk_by(|a, b| (&a.robot, &a.obstacles) == (&b.robot, &b.obstacles)) {
        let first = &group[0];
        let _ = write!(
            page,
            "\n## {}, obstacles as {}\n\n{} links of {} triangles, {} pairs of them, {} problems; {} of {} \
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
