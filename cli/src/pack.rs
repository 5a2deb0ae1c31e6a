//! `simdop pack`.

use super::body::{self, CapsReport};
use super::error::Error;
use super::output;
use super::picture::{self, Format};
use super::{File, progress};
use clap::Args;
use core::ops::ControlFlow;
use serde::Serialize;
use simdop::construct::Mesh;
use simdop::hierarchy::CapStats;
use simdop::mesh_io::MeshData;
use simdop::packing::{Filling, Packer, Packing, text};
use std::io::Write;
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// A closed mesh, or a tree, for the mesh that it was built from. Without it: a built-in gear.
    mesh: Option<File>,
    /// Number of spheres.
    #[arg(
        short = 'n',
        long,
        value_name = "NUMBER",
        default_value_t = 1000,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    spheres: u32,
    /// Cap the holes of the mesh, none of which may be wider than this: the greatest distance between two corners of a
    /// hole's border, in the mesh's unit. Caps bound the packing like triangles.
    #[arg(long, value_name = "LENGTH", value_parser = crate::length)]
    cap: Option<f64>,
    /// The packing to write, one sphere per line: x y z r. An existing file is replaced atomically, once the packing is
    /// complete.
    #[arg(short, long)]
    output: File,
    /// An image to write, .svg or (with the feature `png`) .png by its extension: the spheres, each coloured by the
    /// child of their tree's root that contains it.
    #[arg(long, value_name = "FILE")]
    picture: Option<File>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    mesh: String,
    triangles: usize,
    caps: Option<CapsReport>,
    /// Volume of the mesh, in cubic units.
    volume: f64,
    spheres: usize,
    asked: u32,
    pack_nanoseconds: u128,
    /// Steps after 1, 2, 5, 10, 20 and so on spheres, and after all.
    steps: Vec<Step>,
}

/// The volume that the first spheres cover.
#[derive(Serialize)]
struct Step {
    spheres: usize,
    volume: f64,
    share: f64,
    /// Radius of the last of them.
    radius: f64,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let format = options.picture.as_deref().map(Format::of).transpose()?;
    let targets = [("--output", Some(options.output.as_path())), ("--picture", options.picture.as_deref())];
    output::check_targets(options.mesh.as_deref(), targets)?;
    let (name, source) = body::source_or_gear(options.mesh.as_deref(), options.json)?;
    let (width, mut mesh) = (options.cap.or(source.cap_width()), source.into_mesh());
    let triangles = mesh.triangles.len();
    let caps = width.map_or(Ok(CapStats::default()), |width| body::cap(&name, &mut mesh, width))?;
    let start = Instant::now();
    let packing = fill(&name, &mesh, options.spheres, options.json)?;
    let pack_nanoseconds = start.elapsed().as_nanos();
    let mut lines = String::new();
    // Writing to a string does not fail.
    let _ = text::write(&packing.spheres, &mut lines);
    let image = format.map(|format| paint(&name, &packing, format)).transpose()?;
    let packed = (options.output.as_path(), lines.as_bytes());
    output::replace([packed].into_iter().chain(options.picture.as_deref().zip(image.as_deref())))?;
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        mesh: name,
        triangles,
        caps: CapsReport::of(caps),
        volume: packing.volume,
        spheres: packing.spheres.len(),
        asked: options.spheres,
        pack_nanoseconds,
        steps: steps(&packing),
    };
    output::say(Some(&options.output), |out| print(&report, options.json, out))
}

/// Fills a closed mesh with at most this many spheres.
pub(super) fn fill(name: &str, mesh: &MeshData, spheres: u32, quiet: bool) -> Result<Packing, Error> {
    let bar = progress::bar(spheres as usize, "spheres", quiet);
    let mut observer = |filling: Filling| {
        bar.set_position(filling.placed as u64);
        ControlFlow::Continue(())
    };
    Packer::new()
        .spheres(spheres as usize)
        .pack_with(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }, &mut observer)
        .map_err(|error| Error::Pack { name: name.into(), error })
}

fn paint(name: &str, packing: &Packing, format: Format) -> Result<Vec<u8>, Error> {
    let tree = body::of_spheres(name, &packing.spheres)?;
    let title = format!("{name}, {} spheres", packing.spheres.len());
    Ok(picture::paint_spheres(&tree.view(), &title, format))
}

fn steps(packing: &Packing) -> Vec<Step> {
    let all = packing.spheres.len();
    let shares = packing.shares().zip(&packing.spheres).zip(1..);
    let rows = shares.filter(|(_, count)| *count == all || is_step(*count));
    let step = |((share, sphere), spheres): ((f64, &simdop::primitive::Sphere), usize)| Step {
        spheres,
        volume: share * packing.volume,
        share,
        radius: sphere.radius,
    };
    rows.map(step).collect()
}

/// Whether a number is 1, 2 or 5 times a power of ten.
const fn is_step(mut count: usize) -> bool {
    while count >= 10 && count.is_multiple_of(10) {
        count /= 10;
    }
    matches!(count, 1 | 2 | 5)
}

fn print(report: &Report, json: bool, out: &mut dyn Write) -> std::io::Result<()> {
    if json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    let Report { mesh, triangles, volume, spheres, asked, .. } = report;
    let seconds = report.pack_nanoseconds as f64 / 1e9;
    let caps = report.caps.map_or_else(String::new, |caps| format!(", {caps}"));
    writeln!(
        out,
        "{mesh}: {triangles} triangles{caps}, volume {volume:.6e}, {spheres} spheres in {seconds:.2} s"
    )?;
    if *spheres < *asked as usize {
        writeln!(out, "of {asked} spheres asked for, the rest would be too small")?;
    }
    writeln!(out, "\n   spheres  covered %        volume   last radius")?;
    for Step { spheres, volume, share, radius } in &report.steps {
        writeln!(out, "{spheres:10} {:10.2}  {volume:12.5e}  {radius:12.5e}", 100.0 * share)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::is_step;

    #[test]
    fn steps_are_1_2_5() {
        let steps: Vec<usize> = (1..=2000).filter(|count| is_step(*count)).collect();
        assert_eq!(steps, [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000]);
    }
}
