//! A body at poses, and whether points are near it.

use super::cloud::{self, Points};
use super::options::Options;
use super::timing::fastest;
use crate::body;
use crate::error::Error;
use crate::shape::{Given, NamedShape};
use crate::verdicts::Summary;
use crate::{TreeOptions, output, progress, sphere_file};
use serde::Serialize;
use simdop::cloud::{CloudRef, Contact, RangeSearch, SearchError};
use simdop::hierarchy::{AnyBvh, Bvh};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::with_bvh;
use std::io::{BufWriter, Write};

#[derive(Serialize)]
struct Report {
    version: &'static str,
    body: BodyReport,
    cloud: cloud::Report,
    isa: &'static str,
    margin: f64,
    repeat: u32,
    summary: Summary,
    /// Rows, in the order of the file.
    poses: Vec<Row>,
}

#[derive(Serialize)]
struct BodyReport {
    name: String,
    /// The kind of its primitives: spheres, triangles, or one shape.
    kind: &'static str,
    primitives: usize,
}

#[derive(Serialize)]
struct Row {
    verdict: &'static str,
    /// The primitive found near a point, by its index from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    primitive: Option<u32>,
    /// The point, by its index from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    point: Option<u32>,
    nanoseconds: u64,
}

/// The kind of a body that is one shape.
const SHAPE: &str = "shape";

enum Body {
    Spheres(Bvh<Node16<18>, Spheres>),
    Mesh(Box<AnyBvh>),
    Shape(NamedShape),
}

pub(super) fn run(given: &Given, options: &Options) -> Result<u8, Error> {
    // Read the poses first, so that an error in them shows before the trees are built.
    let poses = options.poses.read()?;
    let body = Body::read(given, options.json)?;
    let (cloud, about) = Points::read(options)?.build(options.repeat)?;
    let (cloud, search) = (cloud.view(), RangeSearch::new(options.isa));

    // Fewer poses finish instantly.
    let bar = progress::bar(poses.len(), "poses", options.json || poses.len() < 1000);
    let mut rows = Vec::with_capacity(poses.len());
    for pose in &poses {
        let ask = || {
            body.near(&search, &cloud, pose, options.margin)
                .map_err(|error| Error::Search { name: about.name.clone(), error })
        };
        let (contact, time) = fastest(options.repeat, ask)?;
        let (primitive, point) = contact.map(|Contact { primitive, point }| (primitive, point)).unzip();
        rows.push(Row {
            verdict: if contact.is_some() { "hit" } else { "free" },
            primitive,
            point,
            nanoseconds: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
        });
        bar.inc(1);
    }
    drop(bar);
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        body: body.report(given),
        cloud: about,
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
        // The reader closed the pipe. The verdict is valid all the same.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(code),
        printed => printed.map(|()| code).map_err(Error::Output),
    }
}

impl Body {
    fn read(given: &Given, quiet: bool) -> Result<Self, Error> {
        match given {
            Given::Shape(named) => Ok(Self::Shape(named.clone())),
            Given::File(file) if !file.is_hull && sphere_file::is_of_spheres(&file.path) => {
                Ok(Self::Spheres(sphere_file::read(&file.path)?.1))
            }
            Given::File(file) => {
                Ok(Self::Mesh(Box::new(body::single(file, &TreeOptions::default(), quiet)?.tree)))
            }
        }
    }

    fn near(
        &self,
        search: &RangeSearch,
        cloud: &CloudRef<'_>,
        pose: &Pose,
        margin: f64,
    ) -> Result<Option<Contact>, SearchError> {
        match self {
            Self::Spheres(tree) => search.body_within(cloud, tree, pose, margin),
            Self::Mesh(tree) => {
                with_bvh!(tree.view(), tree => search.body_within(cloud, &tree, pose, margin))
            }
            Self::Shape(named) => search.shape_within(cloud, &named.shape, pose, margin),
        }
    }

    fn report(&self, given: &Given) -> BodyReport {
        let (kind, primitives) = match self {
            Self::Spheres(tree) => ("sphere", tree.view().len()),
            Self::Mesh(tree) => ("triangle", tree.view().stats().primitives),
            Self::Shape(_) => (SHAPE, 1),
        };
        let name = match given {
            Given::File(file) => file.name(),
            Given::Shape(named) => named.name.clone(),
        };
        BodyReport { name, kind, primitives }
    }
}

fn print(report: &Report, options: &Options, out: &mut impl Write) -> std::io::Result<()> {
    if options.json {
        writeln!(out, "{}", serde_json::to_string_pretty(report)?)?;
        return out.flush();
    }
    let BodyReport { name, kind, primitives } = &report.body;
    match *kind {
        SHAPE => writeln!(out, "A  {name}: a shape")?,
        _ => writeln!(out, "A  {name}: {primitives} {kind}s")?,
    }
    write!(out, "B  ")?;
    report.cloud.print(out)?;
    writeln!(out, "\n  pose  verdict          us")?;
    for (index, row) in report.poses.iter().enumerate().take(options.rows) {
        write!(out, "{index:6}  {:<7}  {:10.2}", row.verdict, row.nanoseconds as f64 / 1e3)?;
        if let (Some(primitive), Some(point)) = (row.primitive, row.point) {
            match *kind {
                SHAPE => write!(out, "  point {point} is near A")?,
                _ => write!(out, "  point {point} is near {kind} {primitive} of A")?,
            }
        }
        writeln!(out)?;
    }
    output::rest(out, report.poses.len(), options.rows)?;
    if report.poses.len() > 1 {
        writeln!(out)?;
        report.summary.print(out)?;
    }
    out.flush()
}
