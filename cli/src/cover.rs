//! `simdop cover`.

use super::body::{self, CapsReport};
use super::error::Error;
use super::{File, output, progress};
use clap::Args;
use core::ops::ControlFlow;
use serde::Serialize;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, CapStats};
use simdop::mesh_io::{self, MeshData};
use simdop::node::Node16;
use simdop::packing::text;
use simdop::primitive::{Sphere, Spheres};
use std::io::Write;
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// A mesh, or a tree, for the mesh that it was built from. Without it: a built-in gear.
    mesh: Option<File>,
    #[command(flatten)]
    limit: Limit,
    /// Cover the inside of a closed mesh, too: a body wholly inside is a hit. Implied for the tree of a solid.
    #[arg(long, conflicts_with = "points")]
    solid: bool,
    /// Cap the holes of a mesh, and cover its inside, too. No hole may be wider than this: the greatest distance
    /// between two corners of its border, in the mesh's unit.
    #[arg(long, value_name = "LENGTH", value_parser = crate::length, conflicts_with = "points")]
    cap: Option<f64>,
    /// Cover the points of a cloud (.ply, .xyz), and ignore its faces.
    #[arg(long, requires = "mesh")]
    points: bool,
    /// The file to write: if its name ends in .txt, one sphere per line (x y z r); otherwise the tree of the spheres (k
    /// = 18, arity 16), for instance for firmware. An existing file is replaced atomically.
    #[arg(short, long)]
    output: File,
    /// Print one JSON object instead of a line.
    #[arg(long)]
    json: bool,
}

/// Limits the error or the size of the cover.
#[derive(Args, Copy, Clone, Debug)]
#[group(required = true, multiple = false)]
struct Limit {
    /// Maximum distance of any point of the spheres from the mesh, in its unit.
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    error: Option<f64>,
    /// Find the smallest error, up to a tenth, that needs at most this many spheres.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    spheres: Option<u32>,
    /// Find the smallest error, up to a tenth, whose tree needs at most this many bytes.
    #[arg(long, value_name = "BYTES")]
    bytes: Option<u64>,
}

/// The part of a mesh that the spheres cover.
#[derive(Copy, Clone, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum CoveredPart {
    Surface,
    Solid,
    Points,
}

/// The input of a cover.
pub(super) struct ToCover<'m> {
    pub(super) name: &'m str,
    pub(super) mesh: &'m MeshData,
    pub(super) part: CoveredPart,
}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    mesh: String,
    /// Number of triangles, or of points.
    triangles: usize,
    caps: Option<CapsReport>,
    part: CoveredPart,
    error: f64,
    spheres: usize,
    /// Bytes of the tree of the spheres.
    bytes: usize,
    /// Bytes of the tree of the triangles; none for points.
    mesh_bytes: Option<usize>,
    cover_nanoseconds: u128,
}

/// Spheres that cover a mesh, and their tree.
pub(super) struct Covered {
    error: f64,
    pub(super) spheres: Vec<Sphere>,
    pub(super) tree: Bvh<Node16<18>, Spheres>,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    output::check_targets(
        options.mesh.as_deref(),
        [("--output", Some(options.output.as_path())), ("", None)],
    )?;
    let (name, mut mesh, part, width) = read(options)?;
    let triangles = mesh.triangles.len();
    let caps = width.map_or(Ok(CapStats::default()), |width| body::cap(&name, &mut mesh, width))?;
    let spinner = progress::step(format!("covering {name}"), options.json);
    let start = Instant::now();
    let covered = within(&ToCover { name: &name, mesh: &mesh, part }, options.limit)?;
    let cover_nanoseconds = start.elapsed().as_nanos();
    drop(spinner);
    let mut lines = String::new();
    let contents = if options.output.extension().is_some_and(|ending| ending == "txt") {
        // Writing to a string does not fail.
        let _ = text::write(&covered.spheres, &mut lines);
        lines.as_bytes()
    } else {
        covered.tree.as_bytes()
    };
    output::replace([(options.output.as_path(), contents)])?;
    let mesh_bytes = if part == CoveredPart::Points { None } else { Some(bytes_of_triangles(&name, &mesh)?) };
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        mesh: name,
        triangles,
        caps: CapsReport::of(caps),
        part,
        error: covered.error,
        spheres: covered.spheres.len(),
        bytes: covered.tree.as_bytes().len(),
        mesh_bytes,
        cover_nanoseconds,
    };
    output::say(Some(&options.output), |out| print(&report, options.json, out))
}

/// Reads the mesh and determines the part of it to cover, and the width of holes to cap.
fn read(options: &Options) -> Result<(String, MeshData, CoveredPart, Option<f64>), Error> {
    if let (Some(path), true) = (options.mesh.as_deref(), options.points) {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(Error::io(path))?;
        let vertices = mesh_io::points(path, &bytes).map_err(Error::content(path))?;
        // Degenerate triangles, one for each point.
        let triangles = (0..vertices.len() as u32).map(|i| [i; 3]).collect();
        return Ok((name, MeshData { vertices, triangles }, CoveredPart::Points, None));
    }
    let (name, source) = body::source_or_gear(options.mesh.as_deref(), options.json)?;
    let width = options.cap.or(source.cap_width());
    // The tree of a solid is covered as a solid.
    let is_solid = options.solid || width.is_some() || source.is_solid();
    let part = if is_solid { CoveredPart::Solid } else { CoveredPart::Surface };
    Ok((name, source.into_mesh(), part, width))
}

/// The cover within an error, in the mesh's unit.
pub(super) fn cover(subject: &ToCover<'_>, error: f64) -> Result<Covered, Error> {
    let ToCover { name, mesh: MeshData { vertices, triangles }, part } = subject;
    let mesh = Mesh { vertices, triangles };
    let spheres = if *part == CoveredPart::Solid { mesh.cover_solid(error) } else { mesh.cover(error) };
    let spheres = spheres.map_err(|error| Error::Cover { name: (*name).into(), error })?;
    let tree = Builder::balanced()
        .without_balls()
        .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
        .map_err(|error| Error::Build { name: (*name).into(), error })?;
    Ok(Covered { error, spheres, tree })
}

/// Bytes of the exact tree, which a cover should not exceed.
fn bytes_of_triangles(name: &str, mesh: &MeshData) -> Result<usize, Error> {
    let tree: Bvh<Node16<18>> = Builder::balanced()
        .build_as(&mesh.as_mesh())
        .map_err(|error| Error::Build { name: name.into(), error })?;
    Ok(tree.as_bytes().len())
}

/// A cover within a limit.
fn within(subject: &ToCover<'_>, limit: Limit) -> Result<Covered, Error> {
    if let Some(error) = limit.error {
        return cover(subject, error);
    }
    let fits = |covered: &Covered| {
        limit.spheres.is_none_or(|most| covered.spheres.len() <= most as usize)
            && limit.bytes.is_none_or(|most| covered.tree.as_bytes().len() as u64 <= most)
    };
    let (low, high) = subject.mesh.vertices.iter().fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), p| {
        ([0, 1, 2].map(|i| low[i].min(p[i])), [0, 1, 2].map(|i| high[i].max(p[i])))
    });
    // An error that a single sphere meets.
    let widest = (0..3).map(|i| high[i] - low[i]).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut best = cover(subject, widest)?;
    if !fits(&best) {
        let problem = format!("one sphere takes {} bytes", best.tree.as_bytes().len());
        return Err(Error::Option { option: "--bytes", problem });
    }
    let mut step = 0.5;
    while step < 0.95 {
        match cover(subject, best.error * step) {
            // The size no longer changes: one sphere, or one per point.
            Ok(finer) if fits(&finer) && finer.error > 1e-6 * widest => best = finer,
            // An error too small to compute does not fit either.
            Ok(_) | Err(Error::Cover { .. }) => step = step.sqrt(),
            Err(other) => return Err(other),
        }
    }
    Ok(best)
}

fn print(report: &Report, json: bool, out: &mut dyn Write) -> std::io::Result<()> {
    if json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    let Report { mesh, triangles, part, error, spheres, bytes, mesh_bytes, cover_nanoseconds, .. } = report;
    let (what, from) = match part {
        CoveredPart::Surface => ("triangles", "them"),
        CoveredPart::Solid => ("triangles and what is inside", "the solid"),
        CoveredPart::Points => ("points", "them"),
    };
    let caps = report.caps.map_or_else(String::new, |caps| format!(" ({caps})"));
    writeln!(
        out,
        "{mesh}: {triangles} {what}{caps} within {spheres} spheres, none farther than {error:.6e} from {from}; {bytes} \
         bytes as a tree, {:.2} s",
        *cover_nanoseconds as f64 * 1e-9
    )?;
    if let Some(exact) = mesh_bytes.filter(|exact| exact < bytes) {
        writeln!(
            out,
            "The tree of the triangles is exact and smaller, {exact} bytes: choose a larger error."
        )?;
    }
    Ok(())
}
