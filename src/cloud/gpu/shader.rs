//! The compute shaders: their source and interfaces.

use super::memory::CloudBinding;
use crate::device::Program;
use crate::hierarchy::MAX_DEPTH;
use crate::node::{Bucket, FIRST, INDEX, LEAF_BIT};
use alloc::format;
use alloc::string::String;

/// Threads per workgroup: four for each query of a packet. On an H200, 32 to 256 are equally fast.
pub(super) const WORKGROUP: u32 = 64;

/// Buckets that a packet collects before its queries test them. With the masks of their points they fit into the
/// workgroup memory that every device has.
const FOUND: u32 = 128;

/// Maximum number of steps from lane to lane that a packet makes. An invocation must not exceed 65,535 loop
/// iterations: beyond that, llvmpipe (Mesa 22.3) silently exits loops, and systems stop a dispatch that takes
/// seconds. A step is one or two iterations, and what it finds takes half an iteration of each thread.
pub(super) const MOST_STEPS: u32 = 24 << 10;

/// Marks the counts of a query whose packet made too many steps.
pub(super) const ENDLESS: u32 = u32::MAX - 2;

/// Marks a seat whose nearest bucket the device cannot determine.
pub(super) const UNSURE: u32 = u32::MAX;

/// Marks a search whose queries are not the cloud's own points.
pub(super) const NO_BUCKET: u32 = u32::MAX;

/// The kernels.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum CloudShader {
    Arithmetic,
    MovePoints,
    Refit,
    Seat,
    Count,
    Scan,
    ScanTotals,
    WriteLists,
    Fill,
}

impl CloudShader {
    pub(super) const ALL: [Self; 9] = [
        Self::Arithmetic,
        Self::MovePoints,
        Self::Refit,
        Self::Seat,
        Self::Count,
        Self::Scan,
        Self::ScanTotals,
        Self::WriteLists,
        Self::Fill,
    ];

    /// Its entry point, and the buffers that it uses.
    pub(super) fn interface(self) -> (&'static str, &'static [CloudBinding]) {
        use CloudBinding as B;
        match self {
            Self::Arithmetic => ("arithmetic", &[B::Search, B::Asks, B::Results]),
            Self::MovePoints => ("move_points", &[B::Moved, B::Positions]),
            Self::Refit => ("refit", &[B::Level, B::Buckets, B::Refitted]),
            Self::Seat => ("seat", &[B::Search, B::Nodes, B::Asks, B::Seats]),
            Self::Count => {
                ("count", &[B::Search, B::Nodes, B::Buckets, B::Asks, B::Packets, B::Squares, B::Counts])
            }
            Self::Scan => ("scan", &[B::Search, B::Counts, B::Starts, B::Totals]),
            Self::ScanTotals => ("scan_totals", &[B::Search, B::Totals]),
            Self::WriteLists => (
                "write_lists",
                &[
                    B::Search,
                    B::Buckets,
                    B::Asks,
                    B::Packets,
                    B::Squares,
                    B::Counts,
                    B::Starts,
                    B::Totals,
                    B::Lists,
                ],
            ),
            Self::Fill => (
                "fill",
                &[B::Search, B::Nodes, B::Buckets, B::Asks, B::Packets, B::Squares, B::Starts, B::Indices],
            ),
        }
    }
}

/// The WGSL source of all kernels.
pub(super) fn source() -> String {
    let sure = super::limits::SURE_SQUARE.to_bits();
    let constants = format!(
        "const WORKGROUP = {WORKGROUP}u;\nconst PARTS = {}u;\nconst UNUSED = {}u;\nconst UNSURE = {UNSURE}u;\n\
        const NO_BUCKET = {NO_BUCKET}u;\nconst LEAF_BIT = {LEAF_BIT}u;\nconst NODE_BITS = {INDEX}u;\n\
        const BUCKET_BITS = {FIRST}u;\nconst MAX_DEPTH = {MAX_DEPTH}u;\nconst FOUND = {FOUND}u;\n\
        const MOST_STEPS = {MOST_STEPS}u;\nconst ENDLESS = {ENDLESS}u;\nconst SURE_SQUARE = {sure}u;\n",
        WORKGROUP / 16,
        Bucket::UNUSED,
    );
    [
        &*constants,
        include_str!("wgsl/bindings.wgsl"),
        include_str!("wgsl/exact.wgsl"),
        include_str!("wgsl/refit.wgsl"),
        include_str!("wgsl/seat.wgsl"),
        include_str!("wgsl/search.wgsl"),
        include_str!("wgsl/scan.wgsl"),
    ]
    .concat()
}

/// All kernels.
pub(super) fn program() -> Program {
    Program {
        label: "simdop cloud",
        variant: 0,
        source: |_, _| source(),
        kernels: CloudShader::ALL.iter().map(|kernel| kernel.interface().0).collect(),
    }
}
