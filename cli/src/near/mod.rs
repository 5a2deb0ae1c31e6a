//! `simdop near`.

mod body;
mod cloud;
mod histogram;
mod neighbours;

use super::error::Error;
use super::{File, isa, output, poses};
use clap::{ArgGroup, Args};
use cloud::Points;
use core::time::Duration;
use simdop::isa::Isa;
use std::time::Instant;

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("asked").args(["radius", "a"])))]
pub(super) struct Options {
    /// The points: the vertices of a .ply, or an .xyz with one point per line, of which the first three numbers are
    /// read. Without it: built-in points, uniform in the unit cube.
    #[arg(requires = "asked")]
    cloud: Option<File>,
    /// Find the neighbours of every point within this distance; each point is its own neighbour, too [default for the
    /// built-in points: 0.038].
    // Without the conflicts, clap would silently accept options that require a body, although there is none.
    #[arg(
        short,
        long,
        value_name = "DISTANCE",
        value_parser = radius,
        allow_hyphen_values = true,
        conflicts_with_all = ["margin", "pose", "poses", "translate"]
    )]
    radius: Option<f32>,
    /// The file for the neighbours, one line for each point: indices from 0, in ascending order. An existing file is
    /// replaced atomically, once the list is complete.
    #[arg(short, long, value_name = "FILE", conflicts_with = "a")]
    output: Option<File>,
    /// Test at each pose whether any point is near this body, A: a packing (.txt), whose spheres are solid, a mesh,
    /// which is a surface, or a tree. The cloud is B.
    #[arg(id = "a", long = "body", value_name = "FILE")]
    body: Option<File>,
    /// Distance from the body that counts as near; 0 means touching it, or being inside a sphere.
    #[arg(
        long,
        value_name = "DISTANCE",
        default_value_t = 0.0,
        requires = "a",
        value_parser = margin,
        allow_hyphen_values = true
    )]
    margin: f64,
    #[command(flatten)]
    poses: poses::Options,
    /// Time each search this many times and report the fastest.
    #[arg(long, value_name = "TIMES", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    isa: Isa,
    /// Maximum number of rows in the table of poses.
    #[arg(long, default_value_t = 64)]
    rows: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

fn radius(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|x: &f32| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "must be a number that is not negative, and finite as f32".into())
}

fn margin(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "must be a number that is not negative, and finite".into())
}

pub(super) fn run(options: &Options) -> Result<u8, Error> {
    output::check_targets(
        options.cloud.as_deref(),
        [("--output", options.output.as_deref()), ("--output", None)],
    )?;
    match &options.body {
        Some(path) => body::run(path, options),
        None => neighbours::run(options).map(|()| 0),
    }
}

/// The result of a search, which is the same each time, and the shortest time it took.
fn fastest<R>(repeat: u32, mut search: impl FnMut() -> Result<R, Error>) -> Result<(R, Duration), Error> {
    let mut timed = || {
        let start = Instant::now();
        search().map(|result| (result, start.elapsed()))
    };
    let (result, mut least) = timed()?;
    for _ in 1..repeat {
        least = least.min(timed()?.1);
    }
    Ok((result, least))
}
