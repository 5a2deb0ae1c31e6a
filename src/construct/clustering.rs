//! Batch Neural Gas over weighted points.

use super::error::BuildError;
#[cfg(feature = "gpu")]
use super::gpu;
use super::split::{Assignment, Observer, neural_gas};
use crate::halving::Halving;
use crate::range::Point;

/// Batch Neural Gas over weighted points, such as the centres and volumes of spheres. The result is the shape of a
/// tree, without bodies.
#[doc(hidden)]
#[derive(Copy, Clone, Debug)]
pub struct Clustering {
    /// 4 or 16.
    pub arity: usize,
    /// The largest number of points in a leaf.
    pub leaf_size: usize,
    /// Seed of the initial prototypes.
    pub seed: u32,
}

impl Clustering {
    /// Assigns `points`, which must be finite. Weights must be finite and not negative; without weights all are equal.
    ///
    /// # Errors
    /// [`BuildError::Cancelled`], [`BuildError::TooDeep`].
    pub fn assign(
        &self,
        points: &[Point],
        weights: Option<&[f64]>,
        observer: &mut Observer<'_>,
    ) -> Result<Assignment, BuildError> {
        let samples = neural_gas::Samples::new(points, weights);
        neural_gas::assign(&samples, &self.halving(), self.seed, observer)
    }

    /// [`Clustering::assign`] on a device, with the times of its phases.
    ///
    /// # Errors
    /// [`gpu::GpuError`].
    #[cfg(feature = "gpu")]
    pub fn assign_on(
        &self,
        device: &crate::device::Gpu,
        points: &[Point],
        weights: Option<&[f64]>,
        observer: &mut Observer<'_>,
    ) -> Result<(Assignment, gpu::Spent), gpu::GpuError> {
        let samples = neural_gas::Samples::new(points, weights);
        gpu::assign(device, &samples, &self.halving(), self.seed, observer)
    }

    fn halving(&self) -> Halving {
        Halving { arity: self.arity, leaf_size: self.leaf_size, extended: true }
    }
}
