//! `simdop report`: query time against error, bytes and build time, for many settings on one or two meshes.
//!
//! * `setting`: the settings compared; `approach`: the poses.
//! * `volumes`: **false positives** and **overestimates**, with their definitions; `clock`: times, measured in turns;
//!   `packings`: the same for packings; `covers`: for spheres that cover the meshes; `peers`: other libraries, from a
//!   file.
//! * `front`: the Pareto front and the recommendation; `results`: CSV, JSON and a digest of the reproducible results;
//!   `page`, `tables` and `plot`: the page.
//!
//! All trees are kept in memory, since they are queried in turns: for 100,000 triangles the default settings take about
//! 400 MB.

mod approach;
mod clock;
mod covers;
mod front;
mod html;
mod packings;
mod page;
mod peers;
mod plot;
mod results;
mod setting;
mod tables;
mod volumes;

use super::body::{self, Body, SAME};
use super::error::Error;
use super::{File, TreeOptions, demo, isa, output, progress};
use approach::{DISTANCES, PerDistance};
use clap::Args;
use clock::{ROUNDS, Times};
use front::{Budget, Cost};
use results::{Measured, MeasuredAt, Results, Subject};
use setting::{Setting, Sweep};
use simdop::hierarchy::AnyBvhRef;
use simdop::isa::Isa;
use simdop::mesh_io::MeshData;
use simdop::pose::Pose;
use simdop::query::Query;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use volumes::{Overestimate, Volumes, meetings};

#[derive(Args, Debug)]
pub(super) struct Options {
    /// The mesh that approaches, or a tree, for the mesh that it was built from. Without it: the built-in scene.
    a: Option<File>,
    /// The mesh that stands still. Without it: the same mesh.
    b: Option<File>,
    /// The page to write. Existing files are replaced atomically at the end.
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    output: File,
    /// The CSV file to write [default: beside the page, with its name and the extension .csv].
    #[arg(long, value_name = "FILE")]
    csv: Option<File>,
    /// Poses at each of the four distances.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 40,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    poses: u32,
    /// Seed of the poses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Recommend a setting whose k-DOPs overestimate by at most this, in the mesh's unit.
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    error: Option<f64>,
    /// Recommend a setting whose trees take at most this much flash.
    #[arg(long, value_name = "BYTES")]
    flash: Option<u64>,
    /// Combine every k, arity, storage, leaf size and splitter, with and without normal slabs: 384 settings instead of
    /// 45.
    #[arg(long)]
    full: bool,
    /// Maximum number of spheres of a packing; 0 for no packings.
    #[arg(long, value_name = "NUMBER", default_value_t = 1000)]
    spheres: u32,
    /// Include other libraries: the results.csv of `benches/peers/run`.
    #[arg(long, value_name = "FILE")]
    peers: Option<File>,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    isa: Isa,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

fn length(text: &str) -> Result<f64, String> {
    let length = text.parse().ok().filter(|length: &f64| *length >= 0.0 && length.is_finite());
    length.ok_or_else(|| "must be a length: a number, not negative".to_owned())
}

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let csv = targets(options)?;
    let meshes = meshes(options)?;
    let peers = peers_of(options, &meshes)?;
    let named: Vec<(&str, &MeshData)> = meshes.iter().map(|(name, mesh)| (name.as_str(), mesh)).collect();
    let pair = [named[0], named[named.len() - 1]];
    let poses = {
        let _spinner = progress::step("looking for poses".into(), options.json);
        approach::poses(pair, options.poses as usize, options.seed)?
    };
    let sweep = if options.full { Sweep::Full } else { Sweep::Cross };
    let built = build(&sweep.settings(), &named, options.json)?;
    let mut settings = measure(&built, &poses, options);
    drop(built);
    let covers = covers::measure(&named, &poses, options.isa, options.json)?;
    let packings = packings::measure(&named, options.spheres as usize, &poses, options.isa, options.json)?;

    let cost = |one: &Measured| Cost {
        time: one.geometric_mean_microseconds,
        overestimate: one.overestimate_greatest,
        bytes: one.bytes,
    };
    let costs: Vec<Cost> = settings.iter().map(cost).collect();
    for (one, is_on_front) in settings.iter_mut().zip(front::front(&costs)) {
        one.is_on_front = is_on_front;
    }
    let budget = Budget { error: options.error, flash: options.flash };
    let results = Results {
        subjects: named.iter().map(|(name, mesh)| subject(name, mesh)).collect(),
        isa: options.isa.name(),
        poses: options.poses as usize,
        seed: options.seed,
        budget,
        recommended: front::recommended(&costs, &budget),
        settings,
        covers,
        packings,
        peers,
    };
    let digest = results.digest();
    let page = page::html(&results, &digest, &command());
    output::replace([(&*options.output, page.as_bytes()), (&*csv, &results.csv())])?;
    let files = [&*options.output, &*csv];
    if files.into_iter().any(output::is_standard_output) {
        // The standard output must hold the file and nothing else.
        let _ = results.print(&digest, files, options.json, &mut std::io::stderr().lock());
        return Ok(());
    }
    results
        .print(&digest, files, options.json, &mut BufWriter::new(std::io::stdout().lock()))
        .map_err(Error::Output)
}

/// The command line for the page, with the program's name instead of its path.
fn command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    core::iter::once("simdop".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// The path of the CSV file. Reports targets that cannot be written before the work starts.
fn targets(options: &Options) -> Result<PathBuf, Error> {
    if options.csv.is_none() && output::is_standard_output(&options.output) {
        let problem = "needs a name where the page goes to the standard output".into();
        return Err(Error::Option { option: "--csv", problem });
    }
    let csv = options.csv.clone().unwrap_or_else(|| options.output.with_extension("csv"));
    let targets = [("--output", Some(&*options.output)), ("--csv", Some(&*csv))];
    for read in [&options.a, &options.b, &options.peers] {
        output::check_targets(read.as_deref(), targets)?;
    }
    for file in [&options.output, &csv] {
        std::fs::metadata(output::folder(file)).map_err(Error::io(file))?;
    }
    Ok(csv)
}

/// One mesh that is tested against itself, or two, with their names.
fn meshes(options: &Options) -> Result<Vec<(String, MeshData)>, Error> {
    let read = |path: &PathBuf| {
        let mesh = body::read(path, &TreeOptions::default(), options.json)?.into_mesh();
        let name = path.file_name().unwrap_or(path.as_os_str());
        Ok((name.to_string_lossy().into_owned(), mesh))
    };
    if options.a.is_none() {
        let built_in = [("torus knot (built in)", demo::knot()), ("gear ring (built in)", demo::gear())];
        return Ok(built_in.map(|(name, mesh)| (name.to_owned(), mesh)).into());
    }
    options.a.iter().chain(&options.b).map(read).collect()
}

fn peers_of(options: &Options, meshes: &[(String, MeshData)]) -> Result<Vec<peers::Peer>, Error> {
    let Some(path) = &options.peers else { return Ok(Vec::new()) };
    let [a, b] = [&meshes[0], &meshes[meshes.len() - 1]];
    let name = Path::new(&a.0).file_stem().unwrap_or_default().to_string_lossy();
    peers::read(path, &name, [a, b].map(|(_, mesh)| mesh.triangles.len()))
}

fn subject(name: &str, mesh: &MeshData) -> Subject {
    let diagonal = approach::diagonal(&approach::bounds(mesh));
    Subject { name: name.to_owned(), triangles: mesh.triangles.len(), diagonal }
}

/// The trees of a setting, one for each mesh.
struct Built {
    setting: Setting,
    trees: Vec<Body>,
    milliseconds: f64,
}

/// Builds shorter than this, in milliseconds, are repeated three times, in turns, and the median counts.
const LONG_BUILD: f64 = 100.0;

fn build(settings: &[Setting], meshes: &[(&str, &MeshData)], quiet: bool) -> Result<Vec<Built>, Error> {
    let bar = progress::bar(settings.len(), "settings built", quiet);
    let once = |setting: &Setting| -> Result<Built, Error> {
        let tree = |(name, mesh): &(&str, &MeshData)| {
            body::build((*name).to_owned(), mesh, &setting.options(), setting.node, true)
        };
        let trees = meshes.iter().map(tree).collect::<Result<Vec<Body>, Error>>()?;
        let time = trees.iter().filter_map(|body| body.build).map(|time| time.as_secs_f64()).sum::<f64>();
        Ok(Built { setting: *setting, trees, milliseconds: 1e3 * time })
    };
    let mut all = Vec::with_capacity(settings.len());
    for setting in settings {
        all.push(once(setting)?);
        bar.inc(1);
    }
    let short: Vec<usize> = (0..all.len()).filter(|&i| all[i].milliseconds < LONG_BUILD).collect();
    let mut times: Vec<Vec<f64>> = all.iter().map(|built| vec![built.milliseconds]).collect();
    for _ in 0..2 {
        for &i in &short {
            times[i].push(once(&all[i].setting)?.milliseconds);
        }
    }
    for (built, mut times) in all.iter_mut().zip(times) {
        times.sort_by(f64::total_cmp);
        built.milliseconds = times[times.len() / 2];
    }
    Ok(all)
}

fn measure(built: &[Built], poses: &PerDistance<Vec<Pose>>, options: &Options) -> Vec<Measured> {
    let bar = progress::bar(built.len(), "settings measured", options.json);
    let of_volumes = |built: &Built| {
        let one = of_volumes(built, poses);
        bar.inc(1);
        one
    };
    let mut settings: Vec<Measured> = built.iter().map(of_volumes).collect();
    let views: Vec<[AnyBvhRef<'_>; 2]> = built
        .iter()
        .map(|built| [&built.trees[0], &built.trees[built.trees.len() - 1]].map(|body| body.tree.view()))
        .collect();
    let query = Query::new(options.isa);
    let ask = |which: usize, pose: &Pose| {
        let [a, b] = &views[which];
        query.collide_any(a, b, pose).expect(SAME)
    };
    let bar = progress::bar(DISTANCES.len() * ROUNDS, "rounds of queries", options.json);
    for (distance, poses) in poses.iter().enumerate() {
        let times = clock::in_turns(built.len(), poses.len(), &bar, |which, pose| {
            let _ = core::hint::black_box(ask(which, &poses[pose]));
        });
        for (which, (one, Times { median, p99 })) in settings.iter_mut().zip(times).enumerate() {
            let answers: Vec<_> = poses.iter().map(|pose| ask(which, pose)).collect();
            let mean = |sum: u64| sum as f64 / poses.len() as f64;
            let at = &mut one.at[distance];
            at.hits = answers.iter().filter(|answer| !answer.is_free()).count();
            at.visits = mean(answers.iter().map(|answer| answer.stats.visits).sum());
            at.triangle_pairs = mean(answers.iter().map(|answer| answer.stats.primitive_pairs).sum());
            (at.median_microseconds, at.p99_microseconds) = (median, p99);
        }
    }
    for one in &mut settings {
        one.geometric_mean_microseconds = clock::geometric_mean(one.at.map(|at| at.median_microseconds));
    }
    settings
}

/// Everything that is counted or measured without a clock.
fn of_volumes(built: &Built, poses: &PerDistance<Vec<Pose>>) -> Measured {
    let volumes: Vec<Volumes> = built.trees.iter().map(|body| Volumes::of(&body.tree)).collect();
    let (a, b) = (&volumes[0], &volumes[volumes.len() - 1]);
    let mut overestimate = Overestimate::default();
    volumes.iter().for_each(|volumes| volumes.measure(&mut overestimate));
    let at = poses.each_ref().map(|poses| {
        let found: Vec<_> = poses.iter().map(|pose| meetings(a, b, pose)).collect();
        let mean = |sum: u64| sum as f64 / poses.len() as f64;
        MeasuredAt {
            false_positives: mean(found.iter().map(|one| one.false_positives()).sum()),
            leaf_pairs: mean(found.iter().map(|one| one.volumes).sum()),
            ..MeasuredAt::default()
        }
    });
    let bytes = built.trees.iter().map(|body| body.tree.as_bytes().len()).sum();
    let triangles: u32 = built.trees.iter().map(|body| body.tree.view().header().primitive_count).sum();
    Measured {
        setting: built.setting,
        bytes,
        bytes_per_triangle: bytes as f64 / f64::from(triangles),
        build_milliseconds: built.milliseconds,
        overestimate_mean: overestimate.mean(),
        overestimate_greatest: overestimate.greatest,
        at,
        geometric_mean_microseconds: 0.0,
        is_on_front: false,
    }
}
