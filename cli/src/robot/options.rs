//! What can be chosen.

use crate::{File, isa};
use clap::{Args, ValueEnum};
use simdop::isa::Isa;
use simdop::robot::LinkShapes;

#[derive(Args, Debug)]
pub(crate) struct Options {
    /// The robot. Without it: an arm that is built in, with problems and pairs.
    pub(super) urdf: Option<File>,
    /// The pairs of links that are not asked against each other. Without it all are that joints move, neighbours
    /// too.
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub(super) srdf: Option<File>,
    /// Which shapes of a link are its bodies. Of a mesh that is closed, they are solids.
    #[arg(long, value_enum, default_value = "collision")]
    pub(super) shapes: ShapesName,
    /// Problems of planning, one JSON object a line, as MotionBenchMaker's: `start`, `goals` and `obstacles`.
    /// Are starts, goals and random configurations valid, and edges between them free?
    #[arg(long, value_name = "FILE", requires = "urdf")]
    pub(super) problems: Option<File>,
    /// Show of each pair of bodies whether it can meet, with at most so many boxes of values of the joints, and
    /// compare with the SRDF [default for the built-in arm: 20000].
    #[arg(long, value_name = "BOXES", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) pairs: Option<u32>,
    /// Random edges of each problem, beside those from its start to its goals [default: 10].
    #[arg(long, value_name = "COUNT")]
    pub(super) edges: Option<u32>,
    /// Instruction set: auto, scalar, neon, avx2 or avx512.
    #[arg(long, default_value = "auto", value_parser = isa)]
    pub(super) isa: Isa,
    /// One JSON object instead of a table.
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
