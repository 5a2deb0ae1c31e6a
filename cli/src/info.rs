//! `simdop info`.

use super::body::{self, CapsReport, Source};
use super::error::Error;
use super::{File, StorageName, TreeOptions, sphere_file};
use clap::Args;
use serde::Serialize;
use simdop::low_level::key::StorageKind;
use std::io::Write;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// A tree, or a mesh or a packing (.txt), whose tree is built first.
    tree: File,
    /// Verify in exact arithmetic that every plane bounds the primitives below it.
    #[arg(long)]
    verify: bool,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    build: TreeOptions,
}

#[derive(Serialize)]
struct Report {
    k: u16,
    arity: u16,
    storage: StorageName,
    leaf_size: u16,
    depth: usize,
    triangles: usize,
    degenerate_triangles: u32,
    solid: bool,
    caps: Option<CapsReport>,
    /// Number of spheres of the packing in the tree.
    spheres: usize,
    parts: u32,
    vertices: u32,
    vertex_format: &'static str,
    nodes: usize,
    lanes_used_per_node: f64,
    expected_visits: f64,
    area_ratio: f64,
    overlap: f64,
    mean_depth: f64,
    bytes_per_triangle_planes_and_links: f64,
    bytes_per_triangle_thin_slabs: f64,
    bytes_per_triangle_total: f64,
    total_bytes: usize,
    centre: [f64; 3],
    scale_exponent: i32,
    build_milliseconds: Option<f64>,
    verified: Option<bool>,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    if sphere_file::is_of_spheres(&options.tree) {
        return match options.build.first_given() {
            Some(option) => Err(Error::idle(option, &options.tree.display())),
            None => sphere_file::info(&options.tree, options.verify, options.json),
        };
    }
    let (tree, build) = match body::read(&options.tree, &options.build, options.json)? {
        Source::Tree(tree) => match options.build.first_given() {
            Some(option) => return Err(Error::idle(option, &options.tree.display())),
            None => (*tree, None),
        },
        Source::Mesh(mesh) => {
            let name = options.tree.display().to_string();
            let node = body::node_type(&options.build, None);
            let body = body::build(name, &mesh, &options.build, node, options.json)?;
            (body.tree, body.build)
        }
    };
    let view = tree.view();
    if options.verify {
        view.verify().map_err(|error| Error::Verify { path: options.tree.clone(), error })?;
    }
    let (header, stats, quality) = (view.header(), view.stats(), view.tree_stats());
    let share = |bytes: usize| bytes as f64 / stats.primitives.max(1) as f64;
    let report = Report {
        k: header.k,
        arity: header.arity,
        storage: view.node_type().storage.into(),
        leaf_size: header.leaf_size,
        depth: stats.depth,
        triangles: stats.primitives,
        degenerate_triangles: header.degenerate_count,
        solid: header.is_solid != 0,
        caps: CapsReport::of(view.cap_stats()),
        spheres: body::packed_spheres(&view),
        parts: stats.parts as u32,
        vertices: header.vertex_count,
        vertex_format: body::vertex_format(header),
        nodes: stats.nodes,
        lanes_used_per_node: stats.lanes_used as f64 / stats.nodes.max(1) as f64,
        expected_visits: quality.expected_visits,
        area_ratio: quality.area_ratio,
        overlap: quality.overlap,
        mean_depth: quality.mean_depth,
        bytes_per_triangle_planes_and_links: share(stats.node_bytes),
        bytes_per_triangle_thin_slabs: share(stats.normal_slab_bytes),
        bytes_per_triangle_total: share(stats.total_bytes),
        total_bytes: stats.total_bytes,
        centre: header.centre,
        scale_exponent: header.exponent,
        build_milliseconds: build.map(|time| time.as_secs_f64() * 1e3),
        verified: options.verify.then_some(true),
    };
    print(&report, options.json).map_err(Error::Output)
}

fn print(report: &Report, json: bool) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    if json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    let Report { k, arity, leaf_size, depth, triangles, vertices, nodes, .. } = report;
    let storage = StorageKind::from(report.storage);
    writeln!(out, "k {k}, arity {arity}, {storage}, leaf size {leaf_size}, depth {depth}")?;
    writeln!(out, "triangles           {triangles:>12}   without area {}", report.degenerate_triangles)?;
    let is = if report.solid { "of a solid" } else { "of a surface" };
    writeln!(out, "parts               {:>12}   {is}", report.parts)?;
    if let Some(CapsReport { holes, triangles, width }) = report.caps {
        writeln!(
            out,
            "holes               {holes:>12}   capped by {triangles} triangles, at most {} wide",
            body::rounded_up(width)
        )?;
    }
    if report.spheres > 0 {
        writeln!(out, "spheres inside      {:>12}", report.spheres)?;
    }
    writeln!(out, "vertices            {vertices:>12}   stored as {}", report.vertex_format)?;
    writeln!(out, "nodes               {nodes:>12}")?;
    writeln!(out, "lanes used per node {:>12.2}   of {arity}", report.lanes_used_per_node)?;
    writeln!(out, "mean depth          {:>12.2}", report.mean_depth)?;
    writeln!(
        out,
        "expected visits     {:>12.1}   of a query against itself, placed at random",
        report.expected_visits
    )?;
    writeln!(
        out,
        "area ratio          {:>12.3}   of a node's lanes together to the node",
        report.area_ratio
    )?;
    writeln!(out, "overlap             {:>12.3}   of the lanes' volume", report.overlap)?;
    let per_triangle = report.bytes_per_triangle_planes_and_links;
    writeln!(out, "bytes per triangle  {per_triangle:>12.1}   planes and links")?;
    writeln!(out, "                    {:>12.1}   normal slabs", report.bytes_per_triangle_thin_slabs)?;
    writeln!(out, "                    {:>12.1}   in all", report.bytes_per_triangle_total)?;
    writeln!(out, "bytes               {:>12}", report.total_bytes)?;
    if let Some(milliseconds) = report.build_milliseconds {
        writeln!(out, "built in            {milliseconds:>12.1} ms")?;
    }
    if report.verified.is_some() {
        writeln!(out, "verified: every plane bounds the triangles below it")?;
    }
    Ok(())
}
