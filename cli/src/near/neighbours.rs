//! All neighbours of all points.

use super::cloud::{self, Points};
use super::histogram::Histogram;
use super::options::Options;
use super::timing::fastest;
use crate::error::Error;
use crate::output;
use core::fmt::Write as _;
use serde::Serialize;
use simdop::cloud::{CloudRef, List, Queries, Radii, RangeSearch, SearchError};
use std::io::Write;

/// The radius for the built-in points: a point far from the faces of the cube has about thirty neighbours.
const BUILT_IN_RADIUS: f32 = 0.038;

#[derive(Serialize)]
struct Report {
    version: &'static str,
    cloud: cloud::Report,
    isa: &'static str,
    radius: f32,
    repeat: u32,
    /// The neighbours of each point, itself included.
    neighbours: Histogram,
    /// The time to count the neighbours of all points.
    search_nanoseconds: u128,
    /// Calls of the kernel that tests sixteen boxes.
    boxes: u64,
    /// Calls of the kernel that tests the points of a bucket.
    buckets: u64,
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let radius = options.radius.unwrap_or(BUILT_IN_RADIUS);
    let points = Points::read(options)?;
    let (cloud, about) = points.build(options.repeat)?;
    let (cloud, search) = (cloud.view(), RangeSearch::new(options.isa));
    let failed = |error| Error::Search { name: about.name.clone(), error };

    let mut counts = vec![0; cloud.capacity()];
    let (work, time) = fastest(options.repeat, || {
        search.count(&cloud, &Queries::own(), Radii::Same(radius), &mut counts).map_err(failed)
    })?;
    let neighbours = Histogram::of(counts);
    if let Some(path) = &options.output {
        let lines = lists(&search, &cloud, radius, neighbours.total()).map_err(failed)?;
        output::replace([(path.as_path(), lines.as_bytes())])?;
    }
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        cloud: about,
        isa: options.isa.name(),
        radius,
        repeat: options.repeat,
        neighbours,
        search_nanoseconds: time.as_nanos(),
        boxes: work.boxes,
        buckets: work.buckets,
    };
    output::say(options.output.as_deref(), |out| print(&report, options.json, out))
}

/// The neighbours of each point on a line of its own.
fn lists(search: &RangeSearch, cloud: &CloudRef<'_>, radius: f32, total: u64) -> Result<String, SearchError> {
    // Offsets of lists have 32 bits.
    let Ok(room) = u32::try_from(total) else {
        return Err(SearchError::Buffer { have: u32::MAX as usize, need: total });
    };
    let mut lists = vec![List::default(); cloud.capacity()];
    let mut indices = vec![0; room as usize];
    search.fill(cloud, &Queries::own(), Radii::Same(radius), &mut lists, &mut indices)?;
    let mut lines = String::new();
    for list in lists {
        let neighbours = &mut indices[list.range()];
        // Sorted for human readers: the order of the tree means nothing to them.
        neighbours.sort_unstable();
        for (place, index) in neighbours.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(lines, "{}{index}", if place == 0 { "" } else { " " });
        }
        lines.push('\n');
    }
    Ok(lines)
}

fn print(report: &Report, json: bool, out: &mut dyn Write) -> std::io::Result<()> {
    if json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    report.cloud.print(out)?;
    let (radius, isa) = (report.radius, report.isa);
    let nanoseconds = report.search_nanoseconds as f64;
    writeln!(
        out,
        "within {radius} of each point: counted in {:.2} ms by {isa}, {:.3} us a point",
        nanoseconds / 1e6,
        nanoseconds / 1e3 / report.cloud.points as f64
    )?;
    report.neighbours.print(out)
}
