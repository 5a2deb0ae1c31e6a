//! `simdop volume`.

use super::error::Error;
use super::{File, isa, output, poses, sphere_file};
use clap::Args;
use serde::Serialize;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::query::{Penetration, Query};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The packing that the poses move, in the format of `simdop pack`: one sphere per line, x y z r.
    a: File,
    /// The packing that stands still.
    b: File,
    #[command(flatten)]
    poses: poses::Options,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    isa: Isa,
    /// Stop after this many visits, and bound the missing volume.
    #[arg(long, value_name = "VISITS")]
    budget: Option<u64>,
    /// Maximum number of rows in the table.
    #[arg(long, default_value_t = 64)]
    rows: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    a: Body,
    b: Body,
    isa: &'static str,
    /// Rows, in the order of the file.
    poses: Vec<Row>,
}

#[derive(Serialize)]
struct Body {
    name: String,
    spheres: usize,
    /// The sum of the volumes of all its spheres: overlaps count twice.
    volume: f64,
}

#[derive(Serialize)]
struct Row {
    /// Lower bound on the shared volume, in cubic units.
    volume: f64,
    /// Estimate of the shared volume: equal to the lower bound, unless the budget was exhausted.
    estimate: f64,
    /// Upper bound, provided that the spheres of a body do not overlap each other.
    upper: f64,
    /// The direction that pushes A out of B.
    direction: [f64; 3],
    /// The centroid of the shared volume, in B's frame. Null if the packings share nothing.
    point: Option<[f64; 3]>,
    pairs: u64,
    visits: u64,
    nanoseconds: u128,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    // Read the poses first, so that an error in them shows before the trees are built.
    let poses = options.poses.read()?;
    let [(a, tree_a), (b, tree_b)] = [read(&options.a)?, read(&options.b)?];
    let query = Query::new(options.isa).with_budget(options.budget.unwrap_or(u64::MAX));
    let row = |pose: &Pose| {
        let start = Instant::now();
        let found = query.penetration(&tree_a, &tree_b, pose);
        let nanoseconds = start.elapsed().as_nanos();
        let visits = found.stats.visits;
        let Penetration { volume, estimate, upper, direction, point, pairs, .. } = found;
        Row { volume, estimate, upper, direction, point, pairs, visits, nanoseconds }
    };
    let rows = poses.iter().map(row).collect();
    let report = Report { version: env!("CARGO_PKG_VERSION"), a, b, isa: options.isa.name(), poses: rows };
    print(&report, options, &mut BufWriter::new(std::io::stdout().lock())).map_err(Error::Output)
}

fn read(path: &Path) -> Result<(Body, Bvh<Node16<18>, Spheres>), Error> {
    let (spheres, tree) = sphere_file::read(path)?;
    let body = Body {
        name: path.display().to_string(),
        spheres: spheres.len(),
        volume: sphere_file::volume(&spheres),
    };
    Ok((body, tree))
}

fn print(report: &Report, options: &Options, out: &mut impl Write) -> std::io::Result<()> {
    if options.json {
        writeln!(out, "{}", serde_json::to_string_pretty(report)?)?;
        return out.flush();
    }
    for (which, Body { name, spheres, volume }) in [("A", &report.a), ("B", &report.b)] {
        writeln!(out, "{which}: {name}, number of spheres {spheres}, volume {volume:.6e}")?;
    }
    let smaller = f64::min(report.a.volume, report.b.volume);
    writeln!(
        out,
        "\n  pose        volume       at most  % of smaller     pairs  direction of A                   us"
    )?;
    for (index, row) in report.poses.iter().enumerate().take(options.rows) {
        let Row { volume, upper, direction: [x, y, z], pairs, nanoseconds, .. } = row;
        let (share, time) = (100.0 * volume / smaller, *nanoseconds as f64 / 1e3);
        writeln!(
            out,
            "{index:6}  {volume:12.5e}  {upper:12.5e}  {share:12.3}  {pairs:8}  {x:7.3} {y:7.3} {z:7.3}  {time:10.2}"
        )?;
    }
    output::rest(out, report.poses.len(), options.rows)?;
    out.flush()
}
