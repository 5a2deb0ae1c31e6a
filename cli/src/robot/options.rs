//! The options.

use crate::{File, isa};
use clap::{Args, ValueEnum};
use simdop::isa::Isa;
use simdop::robot::LinkShapes;

#[derive(Args, Debug)]
pub(crate) struct Options {
    /// The robot. Without it: a built-in arm, with problems and pairs.
    pub(super) urdf: Option<File>,
    /// The pairs of links that are not tested. Without it: all pairs that joints move are tested, adjacent links
    /// included.
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub(super) srdf: Option<File>,
    /// Which shapes of a link are its bodies. They are exactly those of the URDF, not approximations. Closed meshes
    /// become solids, others surfaces.
    #[arg(long, value_enum, default_value = "collision")]
    pub(super) shapes: ShapesName,
    /// Make solids, too, of meshes whose holes are all at most this wide, by capping the holes. The width of a hole is
    /// the greatest distance between two corners of its border, in the robot's unit.
    #[arg(long, value_name = "LENGTH", value_parser = crate::length)]
    pub(super) cap: Option<f64>,
    /// Planning problems, one JSON object per line in MotionBenchMaker's form: `start`, `goals` and `obstacles`. Are
    /// starts, goals and random configurations valid, and the motions between them free?
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub(super) problems: Option<File>,
    /// Classify whether each pair of bodies can meet, with at most this many boxes of joint values, and compare with
    /// the SRDF [default for the built-in arm: 20000].
    #[arg(long, value_name = "BOXES", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) pairs: Option<u32>,
    /// Write an SRDF file with the pairs of links that --pairs finds to meet never or always, and those that a joint
    /// connects. Planners that read it test all other pairs.
    #[arg(long, value_name = "FILE", requires = "pairs")]
    pub(super) write_srdf: Option<std::path::PathBuf>,
    /// Random motions for each problem, in addition to those from its start to its goals [default: 10].
    #[arg(long, value_name = "COUNT")]
    pub(super) edges: Option<u32>,
    /// Plan a path from the start of each problem to one of its goals: RRT-Connect on certified motions.
    #[arg(long)]
    pub(super) plan: bool,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    pub(super) isa: Isa,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(ValueEnum, Copy, Clone, Debug)]
pub(super) enum ShapesName {
    Collision,
    Visual,
}

impl From<ShapesName> for LinkShapes {
    fn from(shapes: ShapesName) -> Self {
        match shapes {
            ShapesName::Collision => Self::Collision,
            ShapesName::Visual => Self::Visual,
        }
    }
}
