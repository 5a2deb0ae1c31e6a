//! Batch Neural Gas on a device, through wgpu: all nodes of a level at once, with the same bytes as the scalar builder.
//!
//! ```no_run
//! use core::ops::ControlFlow;
//! use simdop::construct::{Builder, Magnification, Mesh, Splitter, gpu::Otherwise};
//! use simdop::{device::Gpu, hierarchy::Bvh, node::Node16};
//!
//! let gpu = Gpu::new()?; // or Gpu::with_adapter, Gpu::with_device; once
//! # let (vertices, triangles) = ([[0.0; 3]; 3], [[0, 1, 2]]);
//! let mesh = Mesh { vertices: &vertices, triangles: &triangles };
//! let splitter = Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 };
//! let builder = Builder::new().splitter(splitter);
//! let tree: Bvh<Node16<18>> = builder.build_on(&gpu, Otherwise::Scalar, &mesh, &mut |_| ControlFlow::Continue(()))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A level
//!
//! The host sends the nodes of the level. The device then computes, without synchronisation: the box of each node
//! (`bounds`), its frame and prototypes (`start`), `local_coordinates`, the steps, `nearest`, full nodes (`balance`),
//! and a stable sort by lane (`lane_ends`, `sort_by_lane`, `replace`). The host reads back once: the ends of the
//! lanes, which are part of the tree and determine the next level.
//!
//! One workgroup clusters a *small* node (2048 primitives or fewer), eight steps per dispatch (`cluster`). A *large*
//! node is divided into chunks; each step is a dispatch that sums each chunk (`accumulate`) and one that adds the sums
//! and moves the prototypes (`update`). Nodes that have settled skip the remaining steps.
//!
//! The host cuts nodes that clustering cannot split, in full precision. It reads the order of their primitives, and
//! keeps it if all nodes below will be cut in the same way.
//!
//! # Memory
//!
//! Allocated once per tree and reused by every step and level: 40 bytes per primitive; 332 bytes (16 lanes) or 140 (4
//! lanes) for each node that a level may have, which has more primitives than lanes; and partial sums. The total is 61
//! bytes per primitive (16 lanes) or 69 (4 lanes). The largest buffer has 12 bytes per primitive: 11 million primitives
//! fit in the 128 MiB that every device binds.
//!
//! # Sources
//!
//! The order of the steps is that of the BNG paper, section 3.2: distances, ranks, sums per prototype, sort by
//! prototype. The number ranges are those of the scalar builder: all sums are of integers, so their order does not
//! matter.

mod assign;
mod build;
mod chunks;
mod error;
mod jobs;
mod memory;
mod shader;
#[cfg(test)]
mod tests;

pub use assign::Spent;
pub(super) use assign::assign;
pub use build::Otherwise;
pub use error::GpuError;
