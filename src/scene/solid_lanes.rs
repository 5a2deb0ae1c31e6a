//! A body that is a sphere, capsule, cuboid or cylinder, in sixteen configurations at a time.
//!
//! A cylinder is a part of the capsule around its axis with its radius: what is apart from the capsule is apart from the
//! cylinder.
//!
//! Shapes are compared in the world, where a pose rounds their numbers by some 2^-52 of the coordinates, which the
//! allowance of the kernels, 2^-19, includes.

use crate::kernel::Kernel;
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::primitive::shape::Core;
use crate::primitive::shape::lanes::{CapsuleLanes, CuboidLanes, Decided, Solid, SolidLanes, SphereLanes};

/// The shape of one body in the world, lane by lane.
#[derive(Debug)]
pub(super) enum ShapeLanes {
    /// The kernels do not treat it.
    Other,
    Spheres(SphereLanes),
    Capsules(CapsuleLanes),
    /// Capsules around cylinders.
    Cylinders(CapsuleLanes),
    Cuboids(CuboidLanes),
}

impl ShapeLanes {
    /// The shape at the pose of each configuration. Lanes without a pose stay unused.
    pub(super) fn new(shape: &Shape, at: impl Iterator<Item = Option<Pose>>) -> Self {
        match shape.core() {
            Core::Point(_) => filled(shape, at).map(Self::Spheres),
            Core::Segment(_) => filled(shape, at).map(Self::Capsules),
            Core::Cuboid { .. } => filled(shape, at).map(Self::Cuboids),
            Core::Cylinder { .. } => around(shape).and_then(|shape| filled(&shape, at)).map(Self::Cylinders),
            Core::Triangle(_) | Core::Cone { .. } | Core::HalfSpace { .. } => None,
        }
        .unwrap_or(Self::Other)
    }

    /// The lanes that are certainly more than `margin` from `other` in the world, and those that certainly are not.
    pub(super) fn decide(&self, kernel: impl Kernel, other: &Shape, margin: f64) -> Decided {
        let capsule = around(other);
        let decided = match (self, capsule.as_ref().unwrap_or(other)) {
            (Self::Other, _) => None,
            (Self::Spheres(lanes), other) => against(kernel, lanes, other, margin),
            (Self::Capsules(lanes) | Self::Cylinders(lanes), other) => against(kernel, lanes, other, margin),
            (Self::Cuboids(lanes), other) => against(kernel, lanes, other, margin),
        };
        let mut decided = decided.unwrap_or_default();
        if capsule.is_some() || matches!(self, Self::Cylinders(_)) {
            decided.within = 0;
        }
        decided
    }
}

/// The capsule around a cylinder.
fn around(shape: &Shape) -> Option<Shape> {
    let Core::Cylinder { centre: c, half_axis: h, radius } = *shape.core() else { return None };
    let ends = [[0, 1, 2].map(|i| c[i] - h[i]), [0, 1, 2].map(|i| c[i] + h[i])];
    Some(Shape::unchecked(Core::Segment(ends), shape.radius() + radius))
}

fn filled<const N: usize>(shape: &Shape, at: impl Iterator<Item = Option<Pose>>) -> Option<SolidLanes<N>> {
    let mut lanes = SolidLanes::EMPTY;
    for (lane, pose) in at.enumerate().take(16) {
        if let Some(pose) = pose {
            lanes.set(lane, &Solid::new(&shape.moved(&pose), 0.0)?);
        }
    }
    Some(lanes)
}

fn against<const N: usize>(
    kernel: impl Kernel,
    lanes: &SolidLanes<N>,
    other: &Shape,
    margin: f64,
) -> Option<Decided> {
    match other.core() {
        Core::Point(_) => Solid::<0>::new(other, margin).map(|other| kernel.solids(&other, lanes)),
        Core::Segment(_) => Solid::<1>::new(other, margin).map(|other| kernel.solids(&other, lanes)),
        Core::Cuboid { .. } => Solid::<3>::new(other, margin).map(|other| kernel.solids(&other, lanes)),
        _ => None,
    }
}
