//! Compares simdop with other collision libraries: the same meshes, the same poses, one process, in turns.
//! `benches/peers/run` builds and starts it.

#![cfg_attr(feature = "simd", feature(portable_simd))]

mod builds;
#[path = "../../../tests/support/corners.rs"]
mod corners;
#[path = "../../support/cpu.rs"]
mod cpu;
#[path = "../../figures/plot.rs"]
mod curves;
#[path = "../../../tests/support/data.rs"]
mod data;
#[path = "../../figures/decimate.rs"]
mod decimate;
#[path = "../../../tests/support/digest.rs"]
mod digest;
mod distances;
mod driver;
#[path = "../../../tests/support/dyadic.rs"]
mod dyadic;
mod entrants;
#[path = "../../../tests/support/exact.rs"]
mod exact;
mod fineness;
mod measure;
#[path = "../../support/meshes.rs"]
mod meshes;
mod plot;
mod points;
mod poses;
mod record;
#[path = "../../../tests/support/rng.rs"]
mod rng;
#[path = "../../support/robots.rs"]
mod robots;
mod scenes;
#[path = "../../../tests/support/shape_oracle/mod.rs"]
mod shape_oracle;
#[path = "../../../tests/support/shapes.rs"]
mod shapes;
mod sizes;
mod solids;
#[path = "../../support/suites.rs"]
mod suites;
mod summary;
mod table;

use clap::Parser;
use meshes::{SCENES, Scene};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Time simdop beside other libraries
#[derive(Parser)]
struct Options {
    /// The data sets
    #[arg(long, env = "SIMDOP_DATA")]
    data: PathBuf,
    /// Folder of the peers' drivers
    #[arg(long)]
    drivers: PathBuf,
    /// Folder for poses and results
    #[arg(long, overrides_with = "out")]
    out: PathBuf,
    /// Meshes, separated by commas [default: all]; with --sizes: cow, armadillo, room, hand; with --points tables:
    /// growth, radii, scenes, particles, odd, single, any; with --shapes kinds: sphere, capsule, cuboid, cylinder,
    /// cone, half-space
    #[arg(long, value_delimiter = ',')]
    meshes: Vec<String>,
    /// Poses for each mesh and distance, half of each method; with --sizes, --fineness and --shapes, for each row
    /// [default: 200, with these 60, 60 and 1000]
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..))]
    poses: Option<u32>,
    /// Seed of the poses
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of runs
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Time only builds, against the number of polygons
    #[arg(long, group = "instead")]
    builds: bool,
    /// Keep what an interrupted run measured
    #[arg(long)]
    resume: bool,
    /// Measure distances instead of collisions, for the libraries that can; also with --sizes
    #[arg(long, conflicts_with_all = ["builds", "fineness", "points", "scenes", "shapes"])]
    distance: bool,
    /// Collide small bodies with large ones, near corners of the latter
    #[arg(long, group = "instead")]
    sizes: bool,
    /// Collide ever finer meshes of one surface that nearly touch
    #[arg(long, group = "instead")]
    fineness: bool,
    /// With --fineness: the numbers of triangles, separated by commas
    #[arg(long, value_delimiter = ',', default_values_t = fineness::TRIANGLES, requires = "fineness")]
    triangles: Vec<u32>,
    /// Search neighbours of points instead, compared with libraries for that
    #[arg(long, group = "instead")]
    points: bool,
    /// With --points: clouds of at most this many points
    #[arg(long, default_value_t = usize::MAX, hide_default_value = true, requires = "points")]
    most: usize,
    /// Check configurations of a robot among bodies instead, for the libraries that have scenes
    #[arg(long, group = "instead")]
    scenes: bool,
    /// With --scenes: one problem in this many
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..), requires = "scenes")]
    every: u32,
    /// Collide and measure pairs of convex shapes instead, for the libraries that have them
    #[arg(long, group = "instead")]
    shapes: bool,
    /// Date, version and command for the page
    #[arg(long, default_value = "")]
    stamp: String,
}

impl Options {
    fn poses(&self) -> usize {
        let default = match () {
            () if self.shapes => 1000,
            () if self.sizes || self.fineness => 60,
            () => 200,
        };
        self.poses.unwrap_or(default) as usize
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    let done = if options.builds {
        builds::run(&options.data, &options.drivers, &options.out)
    } else if options.sizes {
        sizes::run(&options)
    } else if options.fineness {
        fineness::run(&options)
    } else if options.points {
        points::run(&options)
    } else if options.scenes {
        scenes::run(&options)
    } else if options.shapes {
        solids::run(&options)
    } else {
        run(&options)
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let scenes = chosen(&options.meshes)?;
    if options.distance {
        return distances::run(options, &scenes);
    }
    let (poses, parts) = (options.out.join("poses"), options.out.join("parts"));
    if !options.resume && parts.exists() {
        std::fs::remove_dir_all(&parts).map_err(|e| format!("{}: {e}", parts.display()))?;
    }
    for directory in [&poses, &parts] {
        std::fs::create_dir_all(directory).map_err(|e| format!("{}: {e}", directory.display()))?;
    }
    let mut rows = Vec::new();
    for run in 1..=options.runs {
        for scene in &scenes {
            let part = parts.join(format!("{}_{}_{}_{run}.csv", scene.name, options.poses(), options.seed));
            if !part.exists() {
                let meshes = scene.meshes(&options.data);
                eprintln!("run {run}, {}: poses", scene.name);
                let suites = poses::suites(scene.name, &poses, &meshes, options.poses(), options.seed)?;
                eprintln!("run {run}, {}: queries", scene.name);
                let entrants = entrants::entrants(&meshes, &options.drivers);
                let occasion = measure::Occasion { run, mesh: scene.name };
                record::write(&part, &measure::measure(&occasion, &meshes, &entrants, &suites))?;
            }
            rows.extend(record::read(&part)?);
        }
    }
    report(options, &rows)
}

fn report(options: &Options, rows: &[record::Row]) -> Result<(), String> {
    record::write(&options.out.join("results.csv"), rows)?;
    let plot = options.out.join("results.svg");
    plot::draw(&plot, &summary::Summary::new(rows)).map_err(|e| format!("{}: {e}", plot.display()))?;
    save(&options.out.join("RESULTS.md"), &table::page(rows, &options.stamp))
}

/// Writes a page of results and prints its path.
fn save(path: &Path, page: &str) -> Result<(), String> {
    std::fs::write(path, page).map_err(|e| format!("{}: {e}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}

fn chosen(names: &[String]) -> Result<Vec<&'static Scene>, String> {
    let known = || SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        SCENES
            .iter()
            .find(|scene| scene.name == name)
            .ok_or_else(|| format!("no mesh {name}: there are {}", known()))
    };
    if names.is_empty() { Ok(SCENES.iter().collect()) } else { names.iter().map(find).collect() }
}
