//! The kernels: source and pipelines.

use super::chunks::BALANCED_SIZE;
use super::memory::{Binding, TreeMemory};
use crate::construct::split::neural_gas::{ClusterLimits, LIMITS};
use crate::device::{Compiled, Gpu, Program};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Threads per workgroup. On an H200, 64 take 1.1 to 1.5 times as long for up to 100,000 primitives and 16 lanes, and
/// 256 take 1.4 times as long from 100,000 on for 4 lanes.
const WORKGROUP: u32 = 128;

/// For `update`, which has few workgroups with many partial sums to add.
const UPDATE_WORKGROUP: u32 = 256;

/// Steps of a small node per dispatch, and primitives moved out of overfull lanes per dispatch. An invocation must not
/// exceed 65,535 loop iterations: beyond that, llvmpipe (Mesa 22.3) silently exits loops, and systems stop a dispatch
/// that takes seconds.
pub(super) const STEPS_AT_ONCE: usize = 8;
const MOVES_AT_ONCE: usize = 32;

/// Number of dispatches of [`Shader::Balance`] after which no lane is overfull. Leaves are distributed in multiples of
/// `lanes` - 1, each to the lane with the greatest deficit. So no lane has more free capacity than that, and the total
/// deficit is at most the total free capacity.
pub(super) fn balance_dispatches(lanes: usize, leaf_size: usize) -> usize {
    (lanes * (lanes - 1) * leaf_size).min(BALANCED_SIZE).div_ceil(MOVES_AT_ONCE)
}

/// Outcomes of a node, in `states` and `ends`, that require a cut by axes. No node has so many primitives that an end
/// could equal one of these.
pub(super) const SMALL: u32 = u32::MAX - 1;
/// One prototype took all primitives.
pub(super) const ONE_LANE: u32 = u32::MAX;

/// The kernels, each named for its scalar twin in [`crate::construct::split::neural_gas`].
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Shader {
    Bounds,
    Start,
    LocalCoordinates,
    Accumulate,
    Update,
    Cluster,
    Nearest,
    Balance,
    LaneEnds,
    SortByLane,
    Replace,
}

impl Shader {
    pub(super) const ALL: [Self; 11] = [
        Self::Bounds,
        Self::Start,
        Self::LocalCoordinates,
        Self::Accumulate,
        Self::Update,
        Self::Cluster,
        Self::Nearest,
        Self::Balance,
        Self::LaneEnds,
        Self::SortByLane,
        Self::Replace,
    ];

    /// Its entry point and the buffers it uses.
    pub(super) fn interface(self) -> (&'static str, &'static [Binding]) {
        use Binding as B;
        match self {
            Self::Bounds => ("bounds", &[B::Level, B::Chunks, B::Positions, B::Weights, B::Order, B::Boxes]),
            Self::Start => ("start", &[B::Level, B::Nodes, B::Boxes, B::States, B::Prototypes]),
            Self::LocalCoordinates => (
                "local_coordinates",
                &[B::Level, B::Chunks, B::Positions, B::Weights, B::Order, B::Places, B::Boxes, B::States],
            ),
            Self::Accumulate => (
                "accumulate",
                &[B::Level, B::Chunks, B::Schedule, B::Places, B::States, B::Prototypes, B::PartialSums],
            ),
            Self::Update => ("update", &[B::Level, B::Nodes, B::States, B::Prototypes, B::PartialSums]),
            Self::Cluster => {
                ("cluster", &[B::Level, B::Nodes, B::Schedule, B::Places, B::States, B::Prototypes])
            }
            Self::Nearest => {
                ("nearest", &[B::Level, B::Chunks, B::Places, B::Lanes, B::Prototypes, B::Counts])
            }
            Self::Balance => (
                "balance",
                &[B::Level, B::Nodes, B::Places, B::Lanes, B::States, B::Prototypes, B::Counts, B::Ends],
            ),
            Self::LaneEnds => ("lane_ends", &[B::Level, B::Nodes, B::States, B::Counts, B::Ends]),
            Self::SortByLane => {
                ("sort_by_lane", &[B::Level, B::Chunks, B::Order, B::Sorted, B::Lanes, B::States, B::Counts])
            }
            Self::Replace => ("replace", &[B::Level, B::Chunks, B::Order, B::Sorted, B::States]),
        }
    }

    /// Workgroups for a level.
    pub(super) fn groups(self, level: &super::memory::LevelData, lanes: usize) -> u32 {
        match self {
            Self::Start => (level.nodes * lanes as u32).div_ceil(WORKGROUP),
            Self::Accumulate => level.large_chunks,
            Self::Update => level.large_nodes,
            Self::Cluster | Self::Balance => level.nodes - level.large_nodes,
            Self::LaneEnds => level.nodes,
            Self::Bounds | Self::LocalCoordinates | Self::Nearest | Self::SortByLane | Self::Replace => {
                level.chunks
            }
        }
    }
}

/// How 64-bit sums are computed. The results are the same.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Int64 {
    /// By 64-bit integers of the adapter.
    Native,
    /// By two words and a carry.
    Pairs,
}

/// The source of all kernels for nodes with this many lanes.
pub(super) fn source(lanes: usize, int64: Int64) -> String {
    let ClusterLimits {
        steps, local_bits, weight_bits, weight_sum_bits, min_extent, cost_shift, never, ..
    } = LIMITS;
    let constants = format!(
        "const LANES = {lanes}u;\nconst STEPS = {steps}u;\nconst WORKGROUP = {WORKGROUP}u;\n\
        const UPDATE_WORKGROUP = {UPDATE_WORKGROUP}u;\nconst LOCAL_BITS = {local_bits}u;\n\
        const WEIGHT_BITS = {weight_bits}u;\nconst WEIGHT_SUM_BITS = {weight_sum_bits}u;\n\
        const MIN_EXTENT = {min_extent}u;\nconst COST_SHIFT = {cost_shift}u;\nconst NEVER = {never};\n\
        const STEPS_AT_ONCE = {STEPS_AT_ONCE}u;\nconst MOVES_AT_ONCE = {MOVES_AT_ONCE}u;\n\
        const SMALL = {SMALL}u;\nconst ONE_LANE = {ONE_LANE}u;\n"
    );
    let int64 = match int64 {
        Int64::Native => include_str!("wgsl/int64_native.wgsl"),
        Int64::Pairs => include_str!("wgsl/int64_pairs.wgsl"),
    };
    [
        &constants,
        int64,
        include_str!("wgsl/bindings.wgsl"),
        include_str!("wgsl/frame.wgsl"),
        include_str!("wgsl/cluster.wgsl"),
        include_str!("wgsl/balance.wgsl"),
        include_str!("wgsl/sort.wgsl"),
    ]
    .concat()
}

/// All kernels for one number of lanes.
pub(super) fn program(lanes: usize) -> Program {
    Program {
        label: "simdop neural gas",
        variant: lanes,
        source: |lanes, has_int64| source(lanes, if has_int64 { Int64::Native } else { Int64::Pairs }),
        kernels: Shader::ALL.iter().map(|kernel| kernel.interface().0).collect(),
    }
}

/// Bind groups of the kernels for a tree's buffers.
pub(super) fn bind(compiled: &Compiled, gpu: &Gpu, memory: &TreeMemory) -> Vec<wgpu::BindGroup> {
    let bind = |&kernel: &Shader| {
        let (_, bindings) = kernel.interface();
        let entry = |&binding: &Binding| (binding as u32, memory.buffer(binding).as_entire_binding());
        compiled.bind(&gpu.device, kernel as usize, bindings.iter().map(entry))
    };
    Shader::ALL.iter().map(bind).collect()
}
