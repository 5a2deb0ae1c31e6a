//! The cloud: read or generated, and its tree.

use super::options::Options;
use super::timing::fastest;
use crate::error::Error;
use crate::{demo, progress};
use core::mem::size_of_val;
use serde::Serialize;
use simdop::cloud::PointCloud;
use simdop::mesh_io;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Files smaller than this are read instantly, in a user's eyes.
const LONG_READ: usize = 4 << 20;

/// Points in the form that the library takes.
pub(super) struct Points {
    name: String,
    points: Vec<[f32; 3]>,
    /// Maximum difference between a coordinate of the file and its `f32`.
    rounding: f64,
    read_nanoseconds: Option<u128>,
}

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) name: String,
    pub(super) points: usize,
    /// Maximum difference between a coordinate of the file and its `f32`.
    rounding: f64,
    /// Bytes of the tree, which contains the points.
    bytes: usize,
    bytes_per_point: f64,
    /// Null for built-in points.
    read_nanoseconds: Option<u128>,
    build_nanoseconds: u128,
}

impl Points {
    pub(super) fn read(options: &Options) -> Result<Self, Error> {
        match &options.cloud {
            Some(path) => Self::of_file(path, options.json),
            None => Ok(Self {
                name: "uniform cube (built in)".into(),
                points: demo::cube(),
                rounding: 0.0,
                read_nanoseconds: None,
            }),
        }
    }

    fn of_file(path: &Path, quiet: bool) -> Result<Self, Error> {
        let start = Instant::now();
        let bytes = std::fs::read(path).map_err(Error::io(path))?;
        let spinner = progress::step(format!("reading {}", path.display()), quiet || bytes.len() < LONG_READ);
        let exact = mesh_io::points(path, &bytes).map_err(Error::content(path))?;
        drop(spinner);
        let read_nanoseconds = Some(start.elapsed().as_nanos());
        let points: Vec<[f32; 3]> = exact.iter().map(|point| point.map(|x| x as f32)).collect();
        let pairs = exact.as_flattened().iter().zip(points.as_flattened());
        let rounding = pairs.map(|(x, single)| (x - f64::from(*single)).abs()).fold(0.0, f64::max);
        Ok(Self { name: path.display().to_string(), points, rounding, read_nanoseconds })
    }

    /// Builds the tree `repeat` times and reports the fastest build.
    pub(super) fn build(&self, repeat: u32) -> Result<(PointCloud, Report), Error> {
        let build = || {
            PointCloud::new(&self.points)
                .map_err(|error| Error::PointCloud { name: self.name.clone(), error })
        };
        let (cloud, time) = fastest(repeat, build)?;
        let view = cloud.view();
        // The owner also stores the place of each index, one number each.
        let bytes =
            size_of_val(view.nodes()) + size_of_val(view.buckets()) + view.capacity() * size_of::<u32>();
        let report = Report {
            name: self.name.clone(),
            points: view.len(),
            rounding: self.rounding,
            bytes,
            bytes_per_point: bytes as f64 / view.len() as f64,
            read_nanoseconds: self.read_nanoseconds,
            build_nanoseconds: time.as_nanos(),
        };
        Ok((cloud, report))
    }
}

impl Report {
    pub(super) fn print(&self, out: &mut dyn Write) -> std::io::Result<()> {
        write!(out, "{}: {} points", self.name, self.points)?;
        if let Some(nanoseconds) = self.read_nanoseconds {
            write!(out, ", read in {:.1} ms", nanoseconds as f64 / 1e6)?;
        }
        let milliseconds = self.build_nanoseconds as f64 / 1e6;
        writeln!(
            out,
            ", built in {milliseconds:.2} ms: {} bytes, {:.1} a point",
            self.bytes, self.bytes_per_point
        )?;
        if self.rounding > 0.0 {
            writeln!(out, "coordinates are rounded to f32, by {:e} at most", self.rounding)?;
        }
        Ok(())
    }
}
