//! Batch Neural Gas on a device, through wgpu: all nodes of a level at once, and the trees of [`super::neural_gas`], byte for byte.
//!
//! # A level
//!
//! The host tells the device which nodes the level has. Then, without a word between them: the box of each node ([`Kernel::Bounds`]),
//! its frame and prototypes ([`Kernel::Start`]), local coordinates, the steps, the nearest prototypes, full nodes (`balance`), a stable
//! sort by lane. The host reads where the lanes end: they are the tree's own data, and say what the next level is.
//!
//! A *small* node ([`shader::BALANCED_SIZE`] primitives or fewer) is clustered by one workgroup, all steps in one dispatch
//! ([`Kernel::Cluster`]). A *large* one is cut into chunks; each step is a dispatch that adds up each chunk ([`Kernel::Accumulate`]) and one
//! that adds up the chunks and moves the prototypes ([`Kernel::Update`]); nodes that have settled sit the rest out.
//!
//! Nodes that clustering cannot split are cut by the host, in full precision: it reads their primitives' order, and keeps it where
//! everything below will be cut so too.
//!
//! # Memory
//!
//! Allocated once a tree, and used again by every step and level: 40 bytes a primitive; 332 bytes (16 lanes) or 140 (4 lanes) for each
//! node that a level may have, which has more primitives than lanes; partial sums. In all 61 bytes a primitive (16 lanes), 69 (4 lanes).
//!
//! # Sources
//!
//! The BNG paper, section 3.2, has the order of the steps: distances, ranks, sums per prototype, sort by prototype. The number ranges are those of
//! [`super::neural_gas`].

mod assign;
mod device;
mod error;
mod memory;
mod shader;
#[cfg(test)]
mod tests;

pub use ::wgpu;
pub use assign::Spent;
pub use device::Gpu;
pub use error::GpuError;

use super::longest_axis::Cutter;
use super::neural_gas::Cloud;
use super::{Builder, Mesh, Progress, Splitter, centroids};
use crate::hierarchy::Bvh;
use crate::node::Node;
use core::ops::ControlFlow;

/// What [`Builder::build_on`] does where the device fails.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Otherwise {
    /// It returns the device's error.
    Fail,
    /// It builds the tree on the CPU: the same one, later. Errors of the mesh, and cancellation, stay errors.
    Scalar,
}

impl Builder {
    /// [`Builder::build_with`] on a device: the same bytes. The splitter must be [`Splitter::BatchNeuralGas`].
    ///
    /// `observer` is called after each level of the tree; if the device fails and the CPU is to build the tree, it begins anew.
    ///
    /// # Errors
    /// [`GpuError`]; with [`Otherwise::Scalar`] [`GpuError::Build`] and [`GpuError::Splitter`] only.
    pub fn build_on<N: Node>(
        &self,
        gpu: &Gpu,
        otherwise: Otherwise,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, GpuError> {
        let Splitter::BatchNeuralGas { magnification, seed } = self.splitter else {
            return Err(GpuError::Splitter);
        };
        let on_device = self.build_by(mesh, |mesh| {
            let (centroids, weights) = (centroids(mesh), magnification.weights(mesh));
            let cloud = Cloud::new(&centroids, weights.as_deref());
            let cutter = Cutter { arity: N::ARITY, leaf_size: self.leaf_size as usize, extended: true };
            assign(gpu, &cloud, &cutter, seed, observer).map(|(assignment, _)| assignment)
        });
        match on_device {
            Ok(tree) => Ok(tree),
            Err(error @ GpuError::Build(_)) => Err(error),
            Err(error) if otherwise == Otherwise::Fail => Err(error),
            Err(_) => Ok(self.build_with(mesh, observer)?),
        }
    }
}

pub(in crate::build) use assign::assign;
