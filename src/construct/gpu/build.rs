//! The methods of [`Builder`] that build on a device.

use super::assign::assign;
use super::error::GpuError;
use crate::construct::builder::Builder;
use crate::construct::input::{Geometry, Mesh};
use crate::construct::split::neural_gas::Samples;
use crate::construct::split::{Items, Progress, Splitter};
use crate::device::Gpu;
use crate::halving::Halving;
use crate::hierarchy::Bvh;
use crate::node::Dop;
use core::ops::ControlFlow;

/// What [`Builder::build_on`] does if the device fails.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Otherwise {
    /// Return the error of the device.
    Fail,
    /// Build the same tree on the CPU. Errors of the mesh, and cancellation, are still returned.
    Scalar,
}

impl Builder {
    /// [`Builder::build_with`] on a device, with the same bytes. The splitter must be [`Splitter::BatchNeuralGas`].
    ///
    /// `observer` is called after each level of the tree, and from the start again if the device fails and the CPU
    /// builds the tree.
    ///
    /// # Errors
    /// [`GpuError`]; with [`Otherwise::Scalar`] only [`GpuError::Build`] and [`GpuError::Splitter`].
    pub fn build_on<N: Dop>(
        &self,
        gpu: &Gpu,
        otherwise: Otherwise,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, GpuError> {
        self.build_geometry_on(gpu, otherwise, mesh, observer)
    }

    /// [`Builder::build_on`] for any primitives, such as the spheres of a packing.
    ///
    /// # Errors
    /// As [`Builder::build_on`].
    pub fn build_geometry_on<N: Dop, G: Geometry>(
        &self,
        gpu: &Gpu,
        otherwise: Otherwise,
        geometry: &G,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N, G::Primitive>, GpuError> {
        let Splitter::BatchNeuralGas { seed, .. } = self.splitter else {
            return Err(GpuError::Splitter);
        };
        let on_device = self.build_by(geometry, |table| {
            let halving = Halving { arity: N::ARITY, leaf_size: self.leaf_size as usize, extended: true };
            let items = Items::new::<G>(table, self.splitter);
            let centroids = items.centroids();
            let samples = Samples::new(&centroids, items.weights.as_deref());
            assign(gpu, &samples, &halving, seed, observer).map(|(assignment, _)| assignment)
        });
        match on_device {
            Ok(tree) => Ok(tree),
            Err(error @ GpuError::Build(_)) => Err(error),
            Err(error) if otherwise == Otherwise::Fail => Err(error),
            Err(_) => Ok(self.build_geometry(geometry, observer)?),
        }
    }
}
