//! Convex shapes, by kind, numbers and pose.

use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use simdop::primitive::Shape;

/// The kind of a shape, and its numbers. Shapes are closed solids.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_shape_kind {
    /// A ball about the origin: its radius.
    Sphere = 0,
    /// A capsule about the origin, along z: its radius, and the distance between the centres of its two hemispheres.
    Capsule = 1,
    /// A cuboid about the origin: its side lengths along x, y and z.
    Cuboid = 2,
    /// A cylinder about the origin, along z: its radius and height.
    Cylinder = 3,
    /// A cone along z, with the middle of its height at the origin and its tip above: its radius and height.
    Cone = 4,
    /// All points p with n . p <= d, such as the ground: the coordinates of n, which points out of the half-space and
    /// has any length but 0, and d, in units of the length of n.
    HalfSpace = 5,
}

/// A convex shape at a pose, widened by a radius: all points at most `radius` from it.
///
/// Verdicts are exact, with two exceptions: a cylinder or cone against a cylinder or cone; and a cylinder or cone
/// against a capsule, cuboid or triangle if a radius, of the capsule or around either shape, or the margin is above 0.
/// There, free is certain, and the shapes of a hit may be apart by up to 2^-40 of their size.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_shape {
    /// One of simdop_shape_kind.
    pub kind: u32,
    /// The numbers of the kind, in the order given there; the others are ignored. Lengths are 2^-250 to 2^300. The
    /// numbers of a half-space are 0, or have such a magnitude.
    pub numbers: [f64; 4],
    /// The radius around the shape: 0, or a length.
    pub radius: f64,
    /// Places the shape in the frame of the body.
    pub pose: simdop_pose,
}

impl simdop_shape {
    pub(crate) fn checked(&self) -> Result<Shape, Failure> {
        let kinds = [
            simdop_shape_kind::Sphere,
            simdop_shape_kind::Capsule,
            simdop_shape_kind::Cuboid,
            simdop_shape_kind::Cylinder,
            simdop_shape_kind::Cone,
            simdop_shape_kind::HalfSpace,
        ];
        // As for the kind of a joint, a field of the enumeration's type could not be checked.
        let Some(kind) = kinds.into_iter().find(|kind| *kind as u32 == self.kind) else {
            let message = format!("{} is no kind of a shape", self.kind);
            return Err(Failure::new(simdop_error::ShapeNoSuchKind, message));
        };
        let [x, y, z, offset] = self.numbers;
        let shape = match kind {
            simdop_shape_kind::Sphere => Shape::sphere(x),
            simdop_shape_kind::Capsule => Shape::capsule(x, y),
            simdop_shape_kind::Cuboid => Shape::cuboid([x, y, z]),
            simdop_shape_kind::Cylinder => Shape::cylinder(x, y),
            simdop_shape_kind::Cone => Shape::cone(x, y),
            simdop_shape_kind::HalfSpace => Shape::half_space([x, y, z], offset),
        }?;
        let placed = shape.widened(self.radius)?.moved(&self.pose.checked()?);
        // A pose may move a shape out of range, and skew a cuboid.
        Ok(Shape::new(*placed.core(), placed.radius())?)
    }
}
