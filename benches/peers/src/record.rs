//! The records of a measurement: a row for each run, scene, distance and library.

use serde::{Deserialize, Serialize};
use std::path::Path;

/// A line of the CSV file. Times are of single queries, each the minimum of several at its pose.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) run: u32,
    pub(crate) mesh: String,
    pub(crate) triangles_a: usize,
    pub(crate) triangles_b: usize,
    pub(crate) distance: String,
    pub(crate) poses: usize,
    /// Poses at which the bodies meet, by the exact oracle.
    pub(crate) hits: usize,
    pub(crate) library: String,
    pub(crate) version: String,
    pub(crate) build_ms: f64,
    pub(crate) bytes_per_triangle: Option<f64>,
    pub(crate) median_us: f64,
    pub(crate) mean_us: f64,
    pub(crate) p99_us: f64,
    pub(crate) max_us: f64,
    /// Answers "free" where the bodies meet.
    pub(crate) missed: usize,
    /// Answers "hit" where they do not.
    pub(crate) invented: usize,
    pub(crate) visits: Option<f64>,
    pub(crate) kernels: Option<f64>,
    pub(crate) realignments: Option<f64>,
    pub(crate) primitive_pairs: Option<f64>,
    pub(crate) exact_pairs: Option<f64>,
}

impl Row {
    pub(crate) fn wrong(&self) -> usize {
        self.missed + self.invented
    }
}

pub(crate) fn write(path: &Path, rows: &[impl Serialize]) -> Result<(), String> {
    let write = || -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_path(path)?;
        for row in rows {
            writer.serialize(row)?;
        }
        Ok(writer.flush()?)
    };
    write().map_err(|e| format!("{}: {e}", path.display()))
}

pub(crate) fn read(path: &Path) -> Result<Vec<Row>, String> {
    let read = || csv::Reader::from_path(path)?.deserialize().collect::<Result<_, csv::Error>>();
    read().map_err(|e| format!("{}: {e}", path.display()))
}
