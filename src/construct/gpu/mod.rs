//! Batch Neural Gas on a device, through wgpu: all nodes of a level at once, and the scalar builder's trees,
//! byte for byte.
//!
//! ```no_run
//! use core::ops::ControlFlow;
//! use simdop::{construct::{Builder, Magnification, Mesh, Splitter, gpu::Otherwise}, device::Gpu, hierarchy::Bvh, node::Node16};
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
//! The host tells the device which nodes the level has. Then, without a word between them: the box of each
//! node (`bounds`), its frame and prototypes (`start`), `local_coordinates`, the steps, `nearest`, full nodes
//! (`balance`), and a stable sort by lane (`lane_ends`, `sort_by_lane`, `replace`). The host reads once,
//! where the lanes end: that is the tree's own data, and says what the next level is.
//!
//! A *small* node (2048 primitives or fewer) is clustered by one workgroup, eight steps in one dispatch
//! (`cluster`). A *large* one is cut into chunks; each step is a dispatch that adds up each chunk
//! (`accumulate`) and one that adds up the chunks and moves the prototypes (`update`); nodes that have
//! settled sit the rest out.
//!
//! Nodes that clustering cannot split are cut by the host, in full precision: it reads the order of their
//! primitives, and keeps it where everything below will be cut so too.
//!
//! # Memory
//!
//! Allocated once a tree, and used again by every step and level: 40 bytes a primitive; 332 bytes (16 lanes)
//! or 140 (4 lanes) for each node that a level may have, which has more primitives than lanes; partial sums.
//! In all 61 bytes a primitive (16 lanes), 69 (4 lanes). The largest buffer has 12 bytes a primitive: 11
//! million fit in the 128 MiB that every device binds.
//!
//! # Sources
//!
//! The BNG paper, section 3.2, has the order of the steps: distances, ranks, sums per prototype, sort by
//! prototype. The number ranges are those of the scalar builder: every sum is of integers, so that their
//! order does not matter.

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
