//! The command `simdop`: reads files, runs queries, prints tables or JSON.

extern crate alloc;

mod body;
mod build;
mod collide;
mod cover;
mod demo;
mod depth;
mod error;
mod info;
mod markup;
mod near;
mod output;
mod pack;
mod pair;
mod patches;
mod picture;
mod poses;
mod progress;
#[cfg(any(feature = "report", feature = "robot"))]
mod random;
#[cfg(feature = "report")]
mod report;
#[cfg(test)]
#[path = "../../tests/support/rng.rs"]
mod rng;
#[cfg(feature = "robot")]
mod robot;
#[cfg(feature = "selftest")]
mod selftest;
mod shape;
mod sphere_file;
mod verdicts;
mod volume;

use clap::{Args, Parser, Subcommand, ValueEnum};
use error::Error;
use serde::Serialize;
use simdop::construct::Magnification;
use simdop::isa::Isa;
use simdop::low_level::key::StorageKind;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exact collision queries between triangle meshes, with SIMD on hierarchies of k-DOPs.
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
    /// A and B are meshes (.obj, .off, .ply, .stl), trees made by `simdop build`, or exact shapes: box:X,Y,Z (side
    /// lengths), sphere:R, capsule:R,H, cylinder:R,H and cone:R,H, about the origin and along z, and plane:NX,NY,NZ,D
    /// (all points p with N . p <= D). The height of a capsule is the distance between the centres of its hemispheres.
    /// hull:FILE is the convex hull of the points of a mesh, tree or cloud (.ply, .xyz). Without bodies: two generated
    /// ones and a sweep of poses. If B alone is a shape, the inverse of the pose moves it. Exit code for a single pose:
    /// 0 if free, 1 if hit, 3 if the budget was exhausted first. For several poses it is 0. For errors it is 2.
    Collide(collide::Options),
    /// Builds the hierarchy of a mesh and writes it as a tree.
    ///
    /// The body is exactly the mesh. `simdop cover` makes a smaller one, within an error or a number of bytes or
    /// spheres.
    Build(build::Options),
    /// Describes a tree, or the tree of a mesh or a packing (.txt).
    Info(info::Options),
    /// Packs a closed mesh with disjoint spheres, always the largest that fits, and writes them as text.
    ///
    /// The table shows the share of the mesh's volume that the first spheres fill.
    Pack(pack::Options),
    /// Covers a mesh with spheres: a smaller body that is free only where the mesh is free.
    ///
    /// Every point of the mesh is in a sphere, and no point of a sphere is farther from the mesh than the error: "free"
    /// is certain, and "hit" means within the error. Only the surface is covered, so that a body inside it may be free;
    /// with --solid, and for trees of solids, the inside is covered, too. With --points, the input is a cloud of
    /// points.
    ///
    /// A cover pays while its tree is smaller than the exact tree of the triangles: for errors from about 1 % of the
    /// size.
    Cover(cover::Options),
    /// How much volume do two packings share, with A placed by a pose in B's frame?
    ///
    /// Also prints the direction that separates A from B. One row for each pose.
    Volume(volume::Options),
    /// How deeply do two solids overlap: how far must A, placed by a pose in B's frame, move to leave B?
    ///
    /// Prints bounds of the least translation that separates them, and a translation that does. One row for each pose.
    /// A and B are meshes (.obj, .off, .ply, .stl), which must be closed, or trees of solids made by `simdop build`.
    Depth(depth::Options),
    /// Which points of a cloud are near each other, or near a body?
    ///
    /// With a radius: the number of neighbours of the points, the time of the search, and the neighbours themselves.
    /// With a body, placed by a pose in the cloud's frame: whether any point is near it. Exit code for a single pose: 0
    /// if free, 1 if hit. For several poses it is 0, and for errors 2. Without files: the neighbours of built-in
    /// points.
    Near(near::Options),
    /// Which configurations of a robot are valid, which motions are free, and which of its links can meet?
    ///
    /// A free motion is free at all times, not only at samples, and a pair that never meets does not meet at any joint
    /// values. Meshes are .obj, .off, .ply or .stl. Without files: a built-in arm among boxes.
    #[cfg(feature = "robot")]
    Robot(robot::Options),
    /// Needs the feature `robot`: which configurations of a robot are valid, and which motions are free?
    #[cfg(not(feature = "robot"))]
    #[command(disable_help_flag = true)]
    Robot(Absent),
    /// Which tree is the fastest for a mesh, and what does it cost in bytes and in tightness?
    ///
    /// Builds the mesh with many settings, queries all trees at the same poses, and writes a self-contained page of
    /// plots with a recommendation, and a CSV file. A and B are meshes (.obj, .off, .ply, .stl), or trees, for the
    /// meshes that they were built from. With one mesh, it is tested against itself; without files, the bodies are
    /// generated. The settings are k, arity, leaf size, splitter, with or without normal slabs, and whether planes are
    /// stored as 16-bit fixed point or as half floats; all bodies are exactly their meshes. Packings of closed meshes
    /// are compared by their number of spheres.
    #[cfg(feature = "report")]
    Report(report::Options),
    /// Needs the feature `report`: which tree is the fastest for a mesh, and at what cost?
    #[cfg(not(feature = "report"))]
    #[command(disable_help_flag = true)]
    Report(Absent),
    /// Is every answer right on this machine? Compares hard cases with exact arithmetic on every available instruction
    /// set.
    ///
    /// The table has a row for each case: pairs, missed and false collisions, poses where the exact answer flips within
    /// one unit in the last place, and the time relative to that of a benign case. The exit code is 0 if everything is
    /// right, 2 for errors, and otherwise 1; then each wrong answer is printed with all that is needed to reproduce it.
    #[cfg(feature = "selftest")]
    Selftest(selftest::Options),
    /// Needs the feature `selftest`: is every answer right on this machine?
    #[cfg(not(feature = "selftest"))]
    #[command(disable_help_flag = true)]
    Selftest(Absent),
}

/// The arguments of a command that this build does not include.
#[cfg(not(all(feature = "report", feature = "robot", feature = "selftest")))]
#[derive(Args, Debug)]
struct Absent {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _arguments: Vec<std::ffi::OsString>,
}

/// Options for building a hierarchy from a mesh. Trees are used unchanged: if all bodies are trees, these options are
/// errors.
#[derive(Args, Clone, Default, Debug)]
struct TreeOptions {
    /// Planes of a volume: 6, 14, 18 or 26; those other than 18 need the feature `all-nodes`, which `report` and
    /// `selftest` include [default: 18, or that of a given tree].
    #[arg(short, long, value_parser = k)]
    k: Option<usize>,
    /// Children of a node: 16, or 4 with k = 18 and the feature `all-nodes` [default: 16, or that of a given tree].
    #[arg(short, long, value_parser = arity)]
    arity: Option<usize>,
    /// How planes are stored: half floats exist for k = 14, 18 and 26 at arity 16 [default: fixed, or that of a given
    /// tree].
    #[arg(long, value_enum)]
    storage: Option<StorageName>,
    /// Maximum number of triangles in a leaf: 1 to 16 [default: 1].
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..=16))]
    leaf_size: Option<u32>,
    /// How the triangles of a node are distributed to its children [default: mean-width].
    #[arg(short, long, value_enum)]
    splitter: Option<SplitterName>,
    /// Omit the normal slabs: saves 8 bytes per child, but smooth meshes that nearly touch take more visits.
    #[arg(long)]
    without_normal_slabs: bool,
    /// Treat the mesh as a solid, so that a body wholly inside it is a hit. It must be closed.
    #[arg(long)]
    solid: bool,
    /// Replace the mesh, or a cloud of points (.ply, .xyz), by the convex hull of its points, which is a solid unless
    /// all points are in one plane.
    #[arg(long, conflicts_with_all = ["solid", "cap"])]
    hull: bool,
    /// Treat the mesh as a solid, and cap its holes, none of which may be wider than this: the greatest distance
    /// between two corners of a hole's border, in the mesh's unit.
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    cap: Option<f64>,
    /// Accept a mesh file without triangles as an empty body, which meets nothing. Without this option it is an error.
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

    /// The first of these options that was given, if any: they do not apply to bodies that are already trees.
    fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--k", self.k.is_some()),
            ("--arity", self.arity.is_some()),
            ("--storage", self.storage.is_some()),
            ("--leaf-size", self.leaf_size.is_some()),
            ("--splitter", self.splitter.is_some()),
            ("--without-normal-slabs", self.without_normal_slabs),
            ("--solid", self.solid),
            ("--hull", self.hull),
            ("--cap", self.cap.is_some()),
            ("--allow-empty", self.allow_empty),
        ];
        given.iter().find(|(_, is_given)| *is_given).map(|(option, _)| *option)
    }
}

/// [`StorageKind`] in options and reports.
#[derive(ValueEnum, Serialize, Copy, Clone, PartialEq, Eq, Debug)]
#[serde(rename_all = "lowercase")]
enum StorageName {
    /// 16-bit fixed point: equally precise everywhere in the body.
    Fixed,
    /// Half floats: more precise near the centre of the body, and less precise far from it.
    Half,
}

impl From<StorageName> for StorageKind {
    fn from(storage: StorageName) -> Self {
        match storage {
            StorageName::Fixed => Self::Fixed,
            StorageName::Half => Self::Half,
        }
    }
}

impl From<StorageKind> for StorageName {
    fn from(storage: StorageKind) -> Self {
        match storage {
            StorageKind::Fixed => Self::Fixed,
            StorageKind::Half => Self::Half,
        }
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

fn length(text: &str) -> Result<f64, String> {
    let length = text.parse().ok().filter(|length| *length > 0.0);
    length.ok_or_else(|| "must be a length above 0".into())
}

fn isa(text: &str) -> Result<Isa, String> {
    if text == "auto" {
        return Ok(Isa::detect());
    }
    text.parse().map_err(|e: simdop::isa::IsaError| e.to_string())
}

/// clap does not check that a file exists: the reader's error messages are better.
type File = PathBuf;

/// Prints clap's output: help, version, or errors in the arguments. Failing to write the help is an error, as for all
/// output.
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
        Command::Depth(options) => depth::run(&options).map(|()| 0),
        Command::Near(options) => near::run(&options),
        #[cfg(feature = "robot")]
        Command::Robot(options) => robot::run(&options).map(|()| 0),
        #[cfg(not(feature = "robot"))]
        Command::Robot(_) => Err(Error::Feature("robot")),
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
        // The reader closed the pipe: not an error.
        Err(Error::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            // If standard error is closed too, only the exit code is left.
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
