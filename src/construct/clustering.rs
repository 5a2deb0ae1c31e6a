//! Batch Neural Gas over weighted points.

use super::error::BuildError;
#[cfg(feature = "gpu")]
use super::gpu;
use super::split::{Assignment, Observer, neural_gas};
use crate::halving::Halving;
use crate::range::Point;

/// Batch Neural Gas over points with weights, such as the centres and volumes of spheres: the shape of a
/// tree, without bodies in it.
#[doc(hidden)]
#[derive(Copy, Clone, Debug)]
pub struct Clustering {
    /// 4 or 16.
    pub arity: usize,
    /// Points in a leaf, at most.
    pub leaf_size: usize,
    /// Decides where prototypes start, and nothing else.
    pub seed: u32,
}

impl Clustering {
    /// Of finite `points`, each with a finite weight that is not negative, or all alike.
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

    /// The same on a device, and where its time went.
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
