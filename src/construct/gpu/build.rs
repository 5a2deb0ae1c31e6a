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

/// What [`Builder::build_on`] does where the device fails.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Otherwise {
    /// It returns the device's error.
    Fail,
    /// It builds the tree on the CPU: the same one, later. Errors of the mesh, and cancellation, stay errors.
    Scalar,
}

impl Builder {
    /// [`Builder::build_with`] on a device: the same bytes. The splitter must be
    /// [`Splitter::BatchNeuralGas`].
    ///
    /// `observer` is called after each level of the tree; if the device fails and the CPU is to build the
    /// tree, it begins anew.
    ///
    /// # Errors
    /// [`GpuError`]; with [`Otherwise::Scalar`] [`GpuError::Build`] and [`GpuError::Splitter`] only.
    pub fn build_on<N: Dop>(
        &self,
        gpu: &Gpu,
        otherwise: Otherwise,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, GpuError> {
        self.build_geometry_on(gpu, otherwise, mesh, observer)
    }

    /// [`Builder::build_on`] of any primitives, such as the spheres of a packing.
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
