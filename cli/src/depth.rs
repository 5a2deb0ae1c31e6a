//! `simdop depth`.

use super::body::{self, Body, BodyFile};
use super::error::Error;
use super::{File, TreeOptions, isa, output, poses, sphere_file};
use clap::Args;
use serde::Serialize;
use simdop::hierarchy::{AnyBvhRef, Bvh};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::query::{Completion, DepthInterval, Packings, Query};
use std::io::{BufWriter, Write};
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The body that the poses move: a mesh, which is built as a solid, or the tree of a solid.
    a: File,
    /// The body that stands still.
    b: File,
    #[command(flatten)]
    poses: poses::Options,
    /// Packings of A and of B, as `simdop pack` makes them, to find lower bounds sooner.
    #[arg(long, num_args = 2, value_names = ["A", "B"])]
    packings: Vec<File>,
    /// Stop after this many visits.
    #[arg(long, value_name = "VISITS")]
    budget: Option<u64>,
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

#[derive(Serialize)]
struct Report {
    version: &'static str,
    a: String,
    b: String,
    isa: &'static str,
    /// Rows, in the order of the file.
    poses: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    /// No shorter translation of A separates the two, in the bodies' unit.
    lower: f64,
    /// The length of the translation. Null if the budget was spent before a translation was found.
    upper: Option<f64>,
    /// A is free after this translation, in B's frame.
    translation: [f64; 3],
    complete: bool,
    visits: u64,
    nanoseconds: u128,
}

type SphereTree = Bvh<Node16<18>, Spheres>;

pub(super) fn run(options: &Options) -> Result<(), Error> {
    // Read the poses first, so that an error in them shows before the trees are built.
    let poses = options.poses.read()?;
    let [a, b] = [&options.a, &options.b].map(|path| BodyFile { path: path.clone(), is_hull: false });
    let [a, b] = body::solids([&a, &b], &options.tree, options.json)?;
    let packings = match options.packings.as_slice() {
        [of_a, of_b] => Some([sphere_file::read(of_a)?.1, sphere_file::read(of_b)?.1]),
        _ => None,
    };
    let query = body::query(options.isa, options.budget);
    let rows = poses.iter().map(|pose| row(&query, [&a, &b], packings.as_ref(), pose));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        a: a.name,
        b: b.name,
        isa: options.isa.name(),
        poses: rows,
    };
    print(&report, options, &mut BufWriter::new(std::io::stdout().lock())).map_err(Error::Output)
}

fn row(
    query: &Query,
    [a, b]: [&Body; 2],
    packings: Option<&[SphereTree; 2]>,
    pose: &Pose,
) -> Result<Row, Error> {
    let start = Instant::now();
    let found = match (packings, a.tree.view(), b.tree.view()) {
        (None, a, b) => query.depth_any(&a, &b, pose).expect(body::SAME),
        (Some([of_a, of_b]), AnyBvhRef::Arity16K18(a), AnyBvhRef::Arity16K18(b)) => {
            query.depth(&a, &b, pose, Some(&Packings { a: of_a.view(), b: of_b.view() }))
        }
        (Some(_), a, _) => {
            let problem = format!("packings need bodies of the default node type, not {}", a.node_type());
            return Err(Error::Option { option: "--packings", problem });
        }
    };
    let nanoseconds = start.elapsed().as_nanos();
    let DepthInterval { lower, upper, translation, completion, stats } = found;
    let complete = completion == Completion::Complete;
    let upper = upper.is_finite().then_some(upper);
    Ok(Row { lower, upper, translation, complete, visits: stats.visits, nanoseconds })
}

fn print(report: &Report, options: &Options, out: &mut impl Write) -> std::io::Result<()> {
    if options.json {
        writeln!(out, "{}", serde_json::to_string_pretty(report)?)?;
        return out.flush();
    }
    writeln!(out, "A: {}\nB: {}", report.a, report.b)?;
    writeln!(
        out,
        "\n  pose      at least       at most  translation of A                             visits          us"
    )?;
    for (index, row) in report.poses.iter().enumerate().take(options.rows) {
        let Row { lower, translation: [x, y, z], visits, nanoseconds, .. } = row;
        let (upper, time) = (row.upper.unwrap_or(f64::INFINITY), *nanoseconds as f64 / 1e3);
        writeln!(
            out,
            "{index:6}  {lower:12.5e}  {upper:12.5e}  {x:13.5e} {y:13.5e} {z:13.5e}  {visits:9}  {time:10.2}"
        )?;
    }
    output::rest(out, report.poses.len(), options.rows)?;
    out.flush()
}
