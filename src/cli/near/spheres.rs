//! A body of spheres at poses, and whether points lie in it.

use super::{Options, Points, cloud, fastest};
use crate::cli::error::{Error, Fault};
use crate::cli::report::Summary;
use crate::cli::{packing, progress};
use serde::Serialize;
use simdop::cloud::{CloudRef, RangeSearch};
use simdop::pose::Pose;
use simdop::primitive::Sphere;
use std::io::{BufWriter, Write};
use std::path::Path;

#[derive(Serialize)]
struct Report {
    version: &'static str,
    cloud: cloud::Report,
    spheres: Body,
    isa: &'static str,
    margin: f32,
    repeat: u32,
    summary: Summary,
    /// In the order of the file.
    poses: Vec<Row>,
}

#[derive(Serialize)]
struct Body {
    name: String,
    spheres: usize,
}

#[derive(Serialize)]
struct Row {
    verdict: &'static str,
    /// The first sphere that holds a point, by its index in the file from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    sphere: Option<usize>,
    /// The point nearest to its centre, by its index in the file from 0; of those equally near, the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    point: Option<u32>,
    nanoseconds: u64,
}

pub(super) fn run(path: &Path, options: &Options) -> Result<u8, Error> {
    // Poses and spheres first: a slip in them shows before the work of building.
    let poses = options.poses.read()?;
    let mut spheres = packing::spheres(path)?;
    let name = path.display().to_string();
    for (index, sphere) in spheres.iter_mut().enumerate() {
        sphere.radius += f64::from(options.margin);
        if !(sphere.radius as f32).is_finite() {
            let problem = format!("sphere {index}, from 0, has a radius beyond f32");
            return Err(Error::content(path, Fault::file(problem)));
        }
    }
    let (cloud, about) = Points::read(options)?.build(options.repeat)?;
    let (cloud, search) = (cloud.view(), RangeSearch::new(options.isa));

    let bar = progress::bar(poses.len(), options.json || poses.len() < 1000);
    let mut rows = Vec::with_capacity(poses.len());
    for (index, pose) in poses.iter().enumerate() {
        let beyond = |sphere| Error::Beyond { name: name.clone(), sphere, pose: index };
        let (sphere, time) =
            fastest(options.repeat, || first_hit(&search, &cloud, &spheres, pose).map_err(beyond))?;
        rows.push(Row {
            verdict: if sphere.is_some() { "hit" } else { "free" },
            sphere,
            point: sphere.and_then(|sphere| nearest(&search, &cloud, &spheres[sphere], pose)),
            nanoseconds: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
        });
        bar.inc(1);
    }
    drop(bar);
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        cloud: about,
        spheres: Body { name, spheres: spheres.len() },
        isa: options.isa.name(),
        margin: options.margin,
        repeat: options.repeat,
        summary: Summary::of(rows.iter().map(|row| (row.verdict, row.nanoseconds))),
        poses: rows,
    };
    let code = match report.poses.as_slice() {
        [only] if only.verdict == "hit" => 1,
        _ => 0,
    };
    match print(&report, options, &mut BufWriter::new(std::io::stdout().lock())) {
        // The reader of our output has seen enough. The verdict is what it is.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(code),
        printed => printed.map(|()| code).map_err(Error::Output),
    }
}

/// The first sphere of the body at a pose that holds a point. Fails with a sphere whose centre is no `f32` there.
fn first_hit(
    search: &RangeSearch,
    cloud: &CloudRef<'_>,
    spheres: &[Sphere],
    pose: &Pose,
) -> Result<Option<usize>, usize> {
    for (index, sphere) in spheres.iter().enumerate() {
        // Radii are finite, so it is the centre.
        if search.any_within(cloud, centre(sphere, pose), sphere.radius as f32).map_err(|_| index)? {
            return Ok(Some(index));
        }
    }
    Ok(None)
}

/// The point nearest to the centre of a sphere that holds some.
fn nearest(search: &RangeSearch, cloud: &CloudRef<'_>, sphere: &Sphere, pose: &Pose) -> Option<u32> {
    Some(search.nearest(cloud, centre(sphere, pose)).ok()??.index)
}

/// Where the centre of a sphere is at a pose.
fn centre(sphere: &Sphere, pose: &Pose) -> [f32; 3] {
    pose.apply(sphere.centre).map(|x| x as f32)
}

fn print(report: &Report, options: &Options, out: &mut impl Write) -> std::io::Result<()> {
    if options.json {
        writeln!(out, "{}", serde_json::to_string_pretty(report)?)?;
        return out.flush();
    }
    let Body { name, spheres } = &report.spheres;
    writeln!(out, "A  {name}: {spheres} spheres")?;
    write!(out, "B  ")?;
    report.cloud.print(out)?;
    writeln!(out, "\n  pose  verdict          us   sphere     point")?;
    for (index, Row { verdict, sphere, point, nanoseconds }) in
        report.poses.iter().enumerate().take(options.rows)
    {
        write!(out, "{index:6}  {verdict:<7}  {:10.2}", *nanoseconds as f64 / 1e3)?;
        if let (Some(sphere), Some(point)) = (sphere, point) {
            write!(out, " {sphere:8}  {point:8}")?;
        }
        writeln!(out)?;
    }
    if report.poses.len() > options.rows {
        writeln!(out, "   ... and {} more: --rows or --json shows them", report.poses.len() - options.rows)?;
    }
    if report.poses.len() > 1 {
        writeln!(out)?;
        report.summary.print(out)?;
    }
    out.flush()
}
