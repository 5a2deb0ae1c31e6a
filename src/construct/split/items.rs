//! Boxes, centroids and weights of the primitives, and the call of the chosen splitter.

use super::assignment::Assignment;
use super::cost::{self, Aabb};
use super::progress::Observer;
use super::splitter::{Magnification, Splitter};
use super::{longest_axis, neural_gas};
use crate::construct::error::BuildError;
use crate::construct::input::{Checked, Geometry, SphereSet};
use crate::halving::Halving;
use crate::primitive::Sphere;
use crate::range::Point;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// The input of a splitter.
pub(in crate::construct) struct Items {
    boxes: Vec<Aabb>,
    /// `None` if all are equal.
    pub(in crate::construct) weights: Option<Vec<f64>>,
}

impl Items {
    /// Computes weights only if this splitter uses them.
    pub(in crate::construct) fn new<G: Geometry>(
        table: &Checked<'_, G::Primitive>,
        splitter: Splitter,
    ) -> Self {
        let weights = match splitter {
            Splitter::BatchNeuralGas { magnification: Magnification::Area, .. } => Some(table.weights::<G>()),
            _ => None,
        };
        Self { boxes: table.boxes().map(Aabb::of).collect(), weights }
    }

    pub(in crate::construct) fn centroids(&self) -> Vec<Point> {
        self.boxes.iter().map(Aabb::centre).collect()
    }

    /// The shape of a tree over these items.
    pub(in crate::construct) fn split(
        &self,
        splitter: Splitter,
        leaf_size: u32,
        arity: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Assignment, BuildError> {
        let centroids = self.centroids();
        let leaf_size = leaf_size as usize;
        let halving = |extended| Halving { arity, leaf_size, extended };
        let by_cost = |measure, passes, observer: &mut Observer<'_>| {
            let primitives = cost::Primitives { boxes: &self.boxes, centroids: &centroids };
            cost::assign(primitives, cost::Plan { arity, leaf_size, measure, passes }, observer)
        };
        match splitter {
            Splitter::LongestAxis => longest_axis::assign(&centroids, &halving(false), observer),
            Splitter::ExtendedLongestAxis => longest_axis::assign(&centroids, &halving(true), observer),
            Splitter::SurfaceArea => by_cost(cost::Measure::Area, 0, observer),
            Splitter::MeanWidth => by_cost(cost::Measure::MeanWidth, 3, observer),
            Splitter::BatchNeuralGas { seed, .. } => {
                let samples = neural_gas::Samples::new(&centroids, self.weights.as_deref());
                neural_gas::assign(&samples, &halving(true), seed, observer)
            }
        }
    }
}

/// The shape of a tree with sixteen lanes over points, each of which is a primitive.
pub(crate) fn assign_points(
    points: &[[f32; 3]],
    splitter: Splitter,
    leaf_size: u32,
) -> Result<Assignment, BuildError> {
    let sphere = |p: &[f32; 3]| Sphere { centre: p.map(f64::from), radius: 0.0 };
    let spheres: Vec<_> = points.iter().map(sphere).collect();
    let set = SphereSet { spheres: &spheres };
    let items = Items::new::<SphereSet<'_>>(&Checked::new(&set)?, splitter);
    items.split(splitter, leaf_size, 16, &mut |_| ControlFlow::Continue(()))
}
