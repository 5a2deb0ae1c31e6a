//! Figure 7 of the SIMDop paper with the peers: time of a build against the number of polygons, one thread, k = 18 and
//! arity 16.
//!
//! A build is everything a library does from arrays of coordinates and indices to a body that can be queried. Libraries
//! build in turns; the minimum of several times counts.

use crate::curves::{Curve, plot};
use crate::data::MeshData;
use crate::decimate::{MODELS, series};
use crate::entrants::{Build, builders};
use serde::Serialize;
use std::path::Path;

const RUNS: usize = 7;

/// A line of `builds.csv`.
#[derive(Clone, Serialize)]
struct Row {
    model: &'static str,
    polygons: usize,
    library: String,
    milliseconds: f64,
}

/// Writes `builds.csv` and a figure for each model.
pub(crate) fn run(data: &Path, drivers: &Path, out: &Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let builders = builders(drivers);
    let mut rows = Vec::new();
    for model in MODELS {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        for mesh in series(&mesh) {
            eprintln!("{model}: {} polygons", mesh.triangles.len());
            rows.extend(measure(model, &mesh, &builders));
        }
        let curves = builders.iter().map(|(name, _)| curve(&rows, model, name)).collect::<Vec<_>>();
        let title = format!("{model}, 1vs16, k = 18");
        plot(&out.join(format!("figure-7-peers-{model}.svg")), &title, "construction, milliseconds", &curves);
    }
    let file = out.join("builds.csv");
    write(&file, &rows).map_err(|e| format!("{}: {e}", file.display()))?;
    println!("{}", file.display());
    Ok(())
}

fn measure(model: &'static str, mesh: &MeshData, builders: &[(String, Build)]) -> Vec<Row> {
    let row = |(library, _): &(String, Build)| Row {
        model,
        polygons: mesh.triangles.len(),
        library: library.clone(),
        milliseconds: f64::INFINITY,
    };
    let mut rows: Vec<Row> = builders.iter().map(row).collect();
    for _ in 0..RUNS {
        for ((_, build), row) in builders.iter().zip(&mut rows) {
            row.milliseconds = row.milliseconds.min(build(mesh));
        }
    }
    rows
}

fn curve(rows: &[Row], model: &str, library: &str) -> Curve {
    let rows = rows.iter().filter(|row| row.model == model && row.library == library);
    Curve {
        name: library.to_owned(),
        points: rows.map(|row| (row.polygons as f64, row.milliseconds)).collect(),
    }
}

fn write(file: &Path, rows: &[Row]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(file)?;
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.flush()?)
}
