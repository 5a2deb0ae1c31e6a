//! `simdop collide`.

use super::body;
use super::error::Error;
use super::pair::Bodies;
use super::shape::{self, Given};
use super::verdicts::{Pairs, PoseReport, Report, Summary};
use super::{TreeOptions, demo, isa, patches, poses, progress};
use clap::Args;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Answer, Query, QueryStats, Verdict};
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The body that the poses move. Without it: the built-in scene.
    #[arg(requires = "b", value_parser = shape::parser())]
    a: Option<Given>,
    /// The body that stands still.
    #[arg(value_parser = shape::parser())]
    b: Option<Given>,
    #[command(flatten)]
    poses: poses::Options,
    /// Time each query this many times and report the fastest.
    #[arg(long, value_name = "TIMES", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Stop after this many visits of node pairs.
    #[arg(long, value_name = "VISITS")]
    budget: Option<u64>,
    /// List every pair of triangles that meet, by their indices from 0, in the order in which they are found.
    #[arg(long)]
    all_pairs: bool,
    /// Describe the patches in which two meshes touch: the direction in which A leaves B, how far A must move in that
    /// direction, and up to four points that span the patch.
    #[arg(long)]
    contacts: bool,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    isa: Isa,
    /// Maximum number of rows in the table.
    #[arg(long, default_value_t = 64)]
    rows: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    tree: TreeOptions,
}

pub(super) fn run(options: &Options) -> Result<u8, Error> {
    let (bodies, poses) = scene_of(options)?;
    let query = body::query(options.isa, options.budget);
    if options.contacts && bodies.trees().is_none() {
        let problem = "shapes have no triangles that could touch".into();
        return Err(Error::Option { option: "--contacts", problem });
    }
    let reports = all(&bodies, query, &poses, options);
    let (node, [a, b]) = (bodies.node_type(), bodies.reports());
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        a,
        b,
        k: node.map(|node| node.k),
        arity: node.map(|node| node.arity),
        storage: node.map(|node| node.storage.into()),
        isa: options.isa.name(),
        budget: options.budget,
        repeat: options.repeat,
        summary: Summary::of(reports.iter().map(|pose| (pose.verdict, pose.nanoseconds))),
        poses: reports,
    };
    let printed = if options.json { report.print_json() } else { report.print_table(options.rows) };
    let code = match report.poses.as_slice() {
        [only] if only.verdict == "hit" => 1,
        [only] if only.verdict == "unknown" => 3,
        _ => 0,
    };
    match printed {
        // The reader closed the pipe. The verdict is valid all the same.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(code),
        printed => printed.map(|()| code).map_err(Error::Output),
    }
}

/// The bodies, and the poses for their queries.
fn scene_of(options: &Options) -> Result<(Bodies, Vec<Pose>), Error> {
    let (Some(a), Some(b)) = (&options.a, &options.b) else {
        return Ok((Bodies::built_in(&options.tree, options.json)?, demo::sweep()));
    };
    // Read the poses first, so that an error in them shows before the trees are built.
    let poses = options.poses.read()?;
    let bodies = Bodies::read([a, b], &options.tree, options.json)?;
    let places = bodies.places(poses)?;
    Ok((bodies, places))
}

fn all<'a>(bodies: &'a Bodies, query: Query, poses: &'a [Pose], options: &Options) -> Vec<PoseReport<'a>> {
    // Fewer poses finish instantly.
    let bar = progress::bar(poses.len(), "poses", options.json || poses.len() < 1000);
    let mut reports = Vec::with_capacity(poses.len());
    for pose in poses {
        reports.push(one(bodies, query, pose, options));
        bar.inc(1);
    }
    reports
}

fn one<'a>(bodies: &'a Bodies, query: Query, pose: &'a Pose, options: &Options) -> PoseReport<'a> {
    let (answer, nanoseconds) = fastest(bodies, query, pose, options.repeat);
    // A query without visits measures the set-up alone.
    let (_, set_up_nanoseconds) = fastest(bodies, query.with_budget(0), pose, options.repeat);
    let (verdict, pair, distance_bounds) = match answer.verdict {
        Verdict::Hit(pair) => ("hit", Some([pair.a, pair.b]), None),
        Verdict::Free => ("free", None, None),
        Verdict::Unknown { lower, upper } => ("unknown", None, Some([lower, upper])),
    };
    let (pairs, pairs_complete) = options.all_pairs.then(|| Pairs::new(bodies, query, pose)).unzip();
    let patches = bodies.trees().filter(|_| options.contacts).map(|trees| patches::find(&query, trees, pose));
    let QueryStats { visits, kernels, realignments, primitive_pairs, exact_pairs } = answer.stats;
    PoseReport {
        verdict,
        pair,
        pairs,
        pairs_complete,
        patches,
        distance_bounds,
        nanoseconds,
        set_up_nanoseconds,
        visits,
        kernels,
        realignments,
        primitive_pairs,
        exact_pairs,
    }
}

/// The answer, which is the same each time, and the shortest time it took.
fn fastest(bodies: &Bodies, query: Query, pose: &Pose, repeat: u32) -> (Answer, u64) {
    let timed = || {
        let start = Instant::now();
        let answer = bodies.collide(&query, pose);
        (answer, u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX))
    };
    let (answer, first) = timed();
    (answer, (1..repeat).map(|_| timed().1).fold(first, u64::min))
}
