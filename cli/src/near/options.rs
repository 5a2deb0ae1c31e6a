//! The options.

use crate::shape::{self, Given};
use crate::{File, isa, poses};
use clap::{ArgGroup, Args};
use simdop::isa::Isa;

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("asked").args(["radius", "a"])))]
pub(crate) struct Options {
    /// The points: the vertices of a .ply, or an .xyz with one point per line, whose first three numbers are read.
    /// Without it: built-in points, uniform in the unit cube.
    #[arg(requires = "asked")]
    pub(super) cloud: Option<File>,
    /// Find the neighbours of every point within this distance; each point is its own neighbour, too [default for the
    /// built-in points: 0.038].
    // Without the conflicts, clap would silently accept options that require a body without one.
    #[arg(
        short,
        long,
        value_name = "DISTANCE",
        value_parser = radius,
        allow_hyphen_values = true,
        conflicts_with_all = ["margin", "pose", "poses", "translate"]
    )]
    pub(super) radius: Option<f32>,
    /// The file for the neighbours, one line for each point: indices from 0, in ascending order. An existing file is
    /// replaced atomically, once the list is complete.
    #[arg(short, long, value_name = "FILE", conflicts_with = "a")]
    pub(super) output: Option<File>,
    /// Test at each pose whether any point is near this body, A: a packing (.txt), whose spheres are solid; a mesh,
    /// which is a surface; a tree; or a shape or hull as for `simdop collide`, such as box:0.1,0.2,0.3. The cloud is B.
    #[arg(id = "a", long = "body", value_name = "FILE", value_parser = shape::parser())]
    pub(super) body: Option<Given>,
    /// Distance from the body that counts as near; 0 means touching it, or being inside a sphere or shape.
    #[arg(
        long,
        value_name = "DISTANCE",
        default_value_t = 0.0,
        requires = "a",
        value_parser = margin,
        allow_hyphen_values = true
    )]
    pub(super) margin: f64,
    #[command(flatten)]
    pub(super) poses: poses::Options,
    /// Time each search this many times and report the fastest.
    #[arg(long, value_name = "TIMES", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) repeat: u32,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    pub(super) isa: Isa,
    /// Maximum number of rows in the table of poses.
    #[arg(long, default_value_t = 64)]
    pub(super) rows: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
}

fn radius(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|x: &f32| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "must be a number that is not negative, and finite as f32".into())
}

fn margin(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "must be a number that is not negative, and finite".into())
}
