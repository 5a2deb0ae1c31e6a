//! simdop beside other collision libraries: the same meshes, the same poses, one process, in turns.
//! `benches/peers/run` builds and starts it.

mod builds;
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
mod entrants;
#[path = "../../../tests/support/exact.rs"]
mod exact;
mod measure;
mod meshes;
mod plot;
mod poses;
mod record;
#[path = "../../../tests/support/rng.rs"]
mod rng;
#[path = "../../support/suites.rs"]
mod suites;
mod summary;
mod table;

use clap::Parser;
use meshes::{SCENES, Scene};
use std::path::PathBuf;
use std::process::ExitCode;

/// Time simdop beside other libraries
#[derive(Parser)]
struct Options {
    /// The data sets
    #[arg(long, env = "SIMDOP_DATA")]
    data: PathBuf,
    /// Where the peers' drivers are
    #[arg(long)]
    drivers: PathBuf,
    /// Where poses and results go
    #[arg(long, overrides_with = "out")]
    out: PathBuf,
    /// Which meshes, separated by commas [default: all]
    #[arg(long, value_delimiter = ',')]
    meshes: Vec<String>,
    /// Poses for each mesh and distance, half of each method
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..))]
    poses: u32,
    /// Of the poses
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Repeat everything so often
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Time builds against the number of polygons, and nothing else
    #[arg(long)]
    builds: bool,
    /// Keep what an interrupted run measured
    #[arg(long)]
    resume: bool,
    /// Measure distances instead of collisions, by the libraries that can
    #[arg(long)]
    distance: bool,
    /// What to say of date, version and command
    #[arg(long, default_value = "")]
    stamp: String,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let done = if options.builds {
        builds::run(&options.data, &options.drivers, &options.out)
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
            let part = parts.join(format!("{}_{}_{}_{run}.csv", scene.name, options.poses, options.seed));
            if !part.exists() {
                let meshes = scene.meshes(&options.data);
                eprintln!("run {run}, {}: poses", scene.name);
                let suites =
                    poses::suites(scene.name, &poses, &meshes, options.poses as usize, options.seed)?;
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
    let page = options.out.join("RESULTS.md");
    std::fs::write(&page, table::page(rows, &options.stamp))
        .map_err(|e| format!("{}: {e}", page.display()))?;
    let plot = options.out.join("results.svg");
    plot::draw(&plot, &summary::Summary::new(rows)).map_err(|e| format!("{}: {e}", plot.display()))?;
    println!("{}", page.display());
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
