//! The command `simdop`: reads files, runs queries, prints tables or JSON.

extern crate alloc;

mod body;
mod build;
mod collide;
mod cover;
mod demo;
mod error;
mod info;
mod mesh;
mod near;
mod output;
mod pack;
mod picture;
mod poses;
mod progress;
mod random;
#[cfg(feature = "report")]
mod report;
#[cfg(test)]
#[path = "../../tests/support/rng.rs"]
mod rng;
mod robot;
#[cfg(feature = "selftest")]
mod selftest;
mod sphere_file;
mod verdicts;
mod volume;

use clap::{Args, Parser, Subcommand, ValueEnum};
use error::Error;
use simdop::construct::Magnification;
use simdop::isa::Isa;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exact collision queries between triangle meshes, by SIMD on hierarchies of k-DOPs.
#[derive(Parser, Debug)]
#[command(version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Does A, placed by a pose in B's frame, meet B?
    ///
    /// A and B are meshes (.obj, .off, .ply, .stl) or trees made by `simdop build`. Without files: two
    /// generated bodies and a sweep of poses. For one pose the exit code is the verdict: 0 free, 1 hit;
    /// for several it is 0. It is 2 for errors, and 3 if the budget was spent before the only verdict was
    /// known.
    Collide(collide::Options),
    /// Builds the hierarchy of a mesh and writes it as a tree.
    ///
    /// The body is as exact as the mesh. A smaller one, within an error, or of so many bytes or spheres, is made by `simdop cover`.
    Build(build::Options),
    /// Describes a tree, or the tree that a mesh or a packing (.txt) becomes.
    Info(info::Options),
    /// Fills a closed mesh with disjoint spheres, the largest that fits first, and writes them as text.
    ///
    /// The table says what share of the mesh's volume the first spheres cover.
    Pack(pack::Options),
    /// Covers a mesh with spheres: a smaller body that is free only where the mesh is.
    ///
    /// Every point of the mesh is in a sphere, and no point of a sphere is farther from the mesh than the error: "free" is certain, and
    /// "hit" means within the error. It is the surface that is covered, so that what is inside of it may be free; with --solid, and of
    /// trees of solids, the inside is covered, too. With --points it is a cloud of points.
    Cover(cover::Options),
    /// How much of their volume do two packings share, A placed by a pose in B's frame?
    ///
    /// With the direction in which A is pushed, and as many rows as there are poses.
    Volume(volume::Options),
    /// Which points of a cloud are near each other, or near a body?
    ///
    /// With a radius: how many neighbours the points have, how long it takes, and the neighbours themselves.
    /// With a body, placed by a pose in the cloud's frame: whether any point is near it. For one pose the exit
    /// code is the verdict: 0 free, 1 hit; for several it is 0. It is 2 for errors. Without files: the
    /// neighbours of points that are built in.
    Near(near::Options),
    /// A robot and its joints: where may it stand among obstacles, which ways are free, which of its links can
    /// meet?
    ///
    /// A free way is free at all times, not at samples of it, and a pair that never meets does so at no values
    /// of the joints. Meshes are .obj, .off, .ply or .stl. Without files: an arm that is built in, among boxes.
    Robot(robot::Options),
    /// Which tree is the fastest for a mesh, at what cost in bytes and in how far its volumes stick out?
    ///
    /// Builds the mesh by many settings, asks them all at the same poses, and writes a page of plots that stands
    /// alone, with a recommendation, and a CSV file. A and B are meshes (.obj, .off, .ply, .stl), or trees, for the
    /// meshes that they were built from; one mesh meets itself, and without files it is two generated bodies. The
    /// settings are k, arity, leaf size, splitter, and with or without normal slabs; planes are 16-bit keys, and
    /// bodies are as exact as their meshes. Packings of closed meshes are compared by their number of spheres.
    #[cfg(feature = "report")]
    Report(report::Options),
    /// Needs the feature `report`: which tree is the fastest for a mesh, at what cost?
    #[cfg(not(feature = "report"))]
    #[command(disable_help_flag = true)]
    Report(Absent),
    /// Is every answer right on this machine? Generated bodies in hard cases, beside exact arithmetic, on every
    /// instruction set that there is.
    ///
    /// The table has a row for each case: pairs, collisions missed and invented, poses where the exact answer flips
    /// within one unit in the last place, and the time beside that of a benign case. The exit code is 0 if everything
    /// is right and 1 if not; then what was wrong is printed, so that it can be repeated. It is 2 for errors.
    #[cfg(feature = "selftest")]
    Selftest(selftest::Options),
    /// Needs the feature `selftest`: is every answer right on this machine?
    #[cfg(not(feature = "selftest"))]
    #[command(disable_help_flag = true)]
    Selftest(Absent),
}

/// The arguments of a command that this program was built without.
#[cfg(not(all(feature = "report", feature = "selftest")))]
#[derive(Args, Debug)]
struct Absent {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _arguments: Vec<std::ffi::OsString>,
}

/// What hierarchy a mesh becomes. A tree is what it is: where there are only trees, these are errors.
#[derive(Args, Clone, Default, Debug)]
struct TreeOptions {
    /// Planes of a volume: 6, 14, 18 or 26 [default: 18, or that of a given tree].
    #[arg(short, long, value_parser = k)]
    k: Option<usize>,
    /// Children of a node: 16, or 4 with k = 18 [default: 16, or that of a given tree].
    #[arg(short, long, value_parser = arity)]
    arity: Option<usize>,
    /// Triangles in a leaf, at most: 1 to 16 [default: 1].
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..=16))]
    leaf_size: Option<u32>,
    /// How triangles are assigned to the children of a node [default: mean-width].
    #[arg(short, long, value_enum)]
    splitter: Option<SplitterName>,
    /// Leave out the normal slabs: 8 bytes a child fewer, and more visits of smooth meshes that nearly touch.
    #[arg(long)]
    without_normal_slabs: bool,
    /// The mesh bounds a solid: what is wholly inside of it is a hit. It must be closed.
    #[arg(long)]
    solid: bool,
    /// Take a mesh file without a triangle for an empty body, which meets nothing. Without this it is an
    /// error.
    #[arg(long)]
    allow_empty: bool,
}

impl TreeOptions {
    fn leaf_size(&self) -> u32 {
        self.leaf_size.unwrap_or(1)
    }

    fn splitter(&self) -> SplitterName {
        self.splitter.unwrap_or(SplitterName::MeanWidth)
    }

    /// One of these that was given, if any was: for bodies that are trees already, on which they do nothing.
    fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--k", self.k.is_some()),
            ("--arity", self.arity.is_some()),
            ("--leaf-size", self.leaf_size.is_some()),
            ("--splitter", self.splitter.is_some()),
            ("--without-normal-slabs", self.without_normal_slabs),
            ("--solid", self.solid),
            ("--allow-empty", self.allow_empty),
        ];
        given.iter().find(|(_, is_given)| *is_given).map(|(option, _)| *option)
    }
}

#[derive(ValueEnum, Copy, Clone, PartialEq, Eq, Debug)]
enum SplitterName {
    LongestAxis,
    ExtendedLongestAxis,
    SurfaceArea,
    MeanWidth,
    NeuralGas,
    NeuralGasByArea,
}

impl From<SplitterName> for simdop::construct::Splitter {
    fn from(splitter: SplitterName) -> Self {
        match splitter {
            SplitterName::LongestAxis => Self::LongestAxis,
            SplitterName::ExtendedLongestAxis => Self::ExtendedLongestAxis,
            SplitterName::SurfaceArea => Self::SurfaceArea,
            SplitterName::MeanWidth => Self::MeanWidth,
            SplitterName::NeuralGas => Self::BatchNeuralGas { magnification: Magnification::None, seed: 0 },
            SplitterName::NeuralGasByArea => {
                Self::BatchNeuralGas { magnification: Magnification::Area, seed: 0 }
            }
        }
    }
}

fn one_of(text: &str, allowed: &[usize]) -> Result<usize, String> {
    let number = text.parse().ok().filter(|n| allowed.contains(n));
    number.ok_or_else(|| format!("must be one of {allowed:?}"))
}

fn k(text: &str) -> Result<usize, String> {
    one_of(text, &[6, 14, 18, 26])
}

fn arity(text: &str) -> Result<usize, String> {
    one_of(text, &[4, 16])
}

fn isa(text: &str) -> Result<Isa, String> {
    if text == "auto" {
        return Ok(Isa::detect());
    }
    text.parse().map_err(|e: simdop::isa::IsaError| e.to_string())
}

/// A file that exists is not required here: the reader names what is wrong.
type File = PathBuf;

/// Prints what clap has to say: help, the version, or what is wrong with the arguments. Help that cannot be written is an error, as
/// all output is.
fn answered(answer: &clap::Error) -> ExitCode {
    match answer.print().and_then(|()| std::io::stdout().flush()) {
        Ok(()) => ExitCode::from(u8::from(answer.use_stderr()) * 2),
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "simdop: {}", Error::Output(error));
            ExitCode::from(2)
        }
    }
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(answer) => return answered(&answer),
    };
    let outcome = match cli.command {
        Command::Collide(options) => collide::run(&options),
        Command::Build(options) => build::run(&options).map(|()| 0),
        Command::Info(options) => info::run(&options).map(|()| 0),
        Command::Pack(options) => pack::run(&options).map(|()| 0),
        Command::Cover(options) => cover::run(&options).map(|()| 0),
        Command::Volume(options) => volume::run(&options).map(|()| 0),
        Command::Near(options) => near::run(&options),
        Command::Robot(options) => robot::run(&options).map(|()| 0),
        #[cfg(feature = "report")]
        Command::Report(options) => report::run(&options).map(|()| 0),
        #[cfg(not(feature = "report"))]
        Command::Report(_) => Err(Error::Feature("report")),
        #[cfg(feature = "selftest")]
        Command::Selftest(options) => selftest::run(&options),
        #[cfg(not(feature = "selftest"))]
        Command::Selftest(_) => Err(Error::Feature("selftest")),
    };
    match outcome {
        Ok(code) => ExitCode::from(code),
        // The reader of our output has seen enough: nothing is wrong.
        Err(Error::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            // If the standard error is gone too, the exit code is all there is to say.
            let _ = writeln!(std::io::stderr(), "simdop: {error}");
            ExitCode::from(2)
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }
}
