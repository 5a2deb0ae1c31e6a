//! Files of spheres, such as packings and covers, and the output of `simdop info` for them.

use super::body;
use super::error::Error;
use serde::Serialize;
use simdop::hierarchy::{Bvh, MAGIC};
use simdop::mesh_io::FileError;
use simdop::node::Node16;
use simdop::packing::text;
use simdop::primitive::{Sphere, Spheres};
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Whether a file holds spheres: by its name, or as a tree of spheres.
pub(super) fn is_of_spheres(path: &Path) -> bool {
    let is_tree = |bytes: Vec<u8>| bytes.starts_with(&MAGIC) && SphereTree::from_bytes(&bytes).is_ok();
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("txt"))
        || std::fs::read(path).is_ok_and(is_tree)
}

type SphereTree = Bvh<Node16<18>, Spheres>;

/// The spheres of a file, and their tree, which is read or built.
pub(super) fn read(path: &Path) -> Result<(Vec<Sphere>, SphereTree), Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    if bytes.starts_with(&MAGIC) {
        let tree =
            SphereTree::from_bytes(&bytes).map_err(|error| Error::Tree { path: path.into(), error })?;
        let spheres = (0..tree.view().len() as u32).map(|i| tree.view().primitive(i)).collect();
        return Ok((spheres, tree));
    }
    let spheres = text::read(&String::from_utf8_lossy(&bytes)).map_err(|error| {
        let advice = "a packing is a sphere a line, x y z r, as `simdop pack` makes it of a mesh";
        Error::content(path)(FileError::file(format!("{error}; {advice}")))
    })?;
    let tree = body::of_spheres(&path.display().to_string(), &spheres)?;
    Ok((spheres, tree))
}

/// The sum of the volumes of all spheres: overlaps count twice.
pub(super) fn volume(spheres: &[Sphere]) -> f64 {
    spheres.iter().map(Sphere::volume).sum()
}

#[derive(Serialize)]
struct Report {
    spheres: usize,
    volume: f64,
    least_radius: f64,
    median_radius: f64,
    greatest_radius: f64,
    k: u16,
    arity: u16,
    depth: usize,
    nodes: usize,
    bytes_per_sphere_planes_and_links: f64,
    bytes_per_sphere_balls: f64,
    bytes_per_sphere_total: f64,
    total_bytes: usize,
    build_milliseconds: f64,
    verified: Option<bool>,
}

/// Describes a packing and the tree built from it.
pub(super) fn info(path: &Path, verify: bool, json: bool) -> Result<(), Error> {
    let start = Instant::now();
    let (spheres, tree) = read(path)?;
    let build = start.elapsed();
    let view = tree.view();
    if verify {
        view.verify().map_err(|error| Error::Verify { path: path.into(), error })?;
    }
    let mut radii: Vec<f64> = spheres.iter().map(|sphere| sphere.radius).collect();
    radii.sort_by(f64::total_cmp);
    let (header, stats) = (view.header(), view.stats());
    let share = |bytes: usize| bytes as f64 / spheres.len() as f64;
    let report = Report {
        spheres: spheres.len(),
        volume: volume(&spheres),
        least_radius: radii[0],
        median_radius: radii[radii.len() / 2],
        greatest_radius: radii[radii.len() - 1],
        k: header.k,
        arity: header.arity,
        depth: stats.depth,
        nodes: stats.nodes,
        bytes_per_sphere_planes_and_links: share(stats.node_bytes),
        bytes_per_sphere_balls: share(stats.ball_bytes),
        bytes_per_sphere_total: share(stats.total_bytes),
        total_bytes: stats.total_bytes,
        build_milliseconds: build.as_secs_f64() * 1e3,
        verified: verify.then_some(true),
    };
    print(&report, json).map_err(Error::Output)
}

fn print(report: &Report, json: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    let Report { spheres, volume, least_radius, median_radius, greatest_radius, .. } = report;
    writeln!(out, "spheres           {spheres:>12}   volume {volume:.6e}")?;
    writeln!(out, "radii             {least_radius:>12.5e}   least")?;
    writeln!(out, "                  {median_radius:>12.5e}   median")?;
    writeln!(out, "                  {greatest_radius:>12.5e}   greatest")?;
    writeln!(
        out,
        "nodes             {:>12}   of k {}, arity {}, depth {}",
        report.nodes, report.k, report.arity, report.depth
    )?;
    let of_nodes = report.bytes_per_sphere_planes_and_links;
    writeln!(out, "bytes per sphere  {of_nodes:>12.1}   planes and links")?;
    writeln!(out, "                  {:>12.1}   balls", report.bytes_per_sphere_balls)?;
    writeln!(out, "                  {:>12.1}   in all", report.bytes_per_sphere_total)?;
    writeln!(out, "bytes             {:>12}", report.total_bytes)?;
    writeln!(out, "read and built in {:>12.1} ms", report.build_milliseconds)?;
    if report.verified.is_some() {
        writeln!(out, "verified: every plane and every ball bounds the spheres below it")?;
    }
    Ok(())
}
