//! A convex shape: a core and a radius.

use super::core::Core;
use super::error::{self, ShapeError};
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::range::{Point, flush};

/// A closed convex solid: all points at most a radius from its core.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Shape {
    pub(super) core: Core,
    pub(super) radius: f64,
}

impl Default for Shape {
    /// The origin.
    fn default() -> Self {
        Self { core: Core::Point([0.0; 3]), radius: 0.0 }
    }
}

impl Shape {
    /// A shape from its core and radius.
    ///
    /// # Errors
    /// [`ShapeError`] if a number is out of range, a radius is negative, a required length is zero, or the half edges
    /// of a cuboid are not perpendicular within [`Pose::TOLERANCE`].
    pub fn new(core: Core, radius: f64) -> Result<Self, ShapeError> {
        core.check()?;
        error::length_or_zero(radius)?;
        Ok(Self { core, radius })
    }

    /// A shape from numbers that are known to be valid.
    #[inline(always)]
    pub(crate) const fn unchecked(core: Core, radius: f64) -> Self {
        Self { core, radius }
    }

    pub(crate) const fn is_half_space(&self) -> bool {
        matches!(self.core, Core::HalfSpace { .. })
    }

    /// A ball about the origin.
    ///
    /// # Errors
    /// [`ShapeError`] if the radius is not a positive length.
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        Self::new(Core::Point([0.0; 3]), error::length(radius)?)
    }

    /// A capsule about the origin, along z: `height` is the distance between the centres of its two hemispheres.
    ///
    /// # Errors
    /// [`ShapeError`] if one of the two is not a positive length.
    pub fn capsule(radius: f64, height: f64) -> Result<Self, ShapeError> {
        let half = 0.5 * error::length(height)?;
        Self::new(Core::Segment([[0.0, 0.0, -half], [0.0, 0.0, half]]), error::length(radius)?)
    }

    /// A cuboid about the origin with these side lengths along x, y and z.
    ///
    /// # Errors
    /// [`ShapeError`] if one of them is not a positive length.
    pub fn cuboid(sides: [f64; 3]) -> Result<Self, ShapeError> {
        let mut half = [[0.0; 3]; 3];
        for i in 0..3 {
            half[i][i] = 0.5 * error::length(sides[i])?;
        }
        Self::new(Core::Cuboid { centre: [0.0; 3], half }, 0.0)
    }

    /// A cylinder about the origin, along z.
    ///
    /// # Errors
    /// [`ShapeError`] if one of the two is not a positive length.
    pub fn cylinder(radius: f64, height: f64) -> Result<Self, ShapeError> {
        let half_axis = [0.0, 0.0, 0.5 * error::length(height)?];
        Self::new(Core::Cylinder { centre: [0.0; 3], half_axis, radius: error::length(radius)? }, 0.0)
    }

    /// A cone along z, with the middle of its height at the origin and its tip above.
    ///
    /// # Errors
    /// [`ShapeError`] if one of the two is not a positive length.
    pub fn cone(radius: f64, height: f64) -> Result<Self, ShapeError> {
        let height = error::length(height)?;
        let core = Core::Cone {
            base: [0.0, 0.0, -0.5 * height],
            axis: [0.0, 0.0, height],
            radius: error::length(radius)?,
        };
        Self::new(core, 0.0)
    }

    /// All points p with `normal . p <= offset`. The normal need not have unit length.
    ///
    /// # Errors
    /// [`ShapeError`] if the normal is zero or a number is out of range.
    pub fn half_space(normal: Point, offset: f64) -> Result<Self, ShapeError> {
        error::point(&normal)?;
        let largest = normal[0].abs().max(normal[1].abs()).max(normal[2].abs());
        if largest == 0.0 {
            return Err(ShapeError::NoDirection);
        }
        // The power of two that brings the largest component into 1/2 .. 1.
        let scale = power_of_two(1022 - (largest.to_bits() >> 52) as i32);
        Self::new(Core::HalfSpace { normal: normal.map(|x| flush(x * scale)), offset: offset * scale }, 0.0)
    }

    /// The shape widened by another radius.
    ///
    /// # Errors
    /// [`ShapeError`] if `by` is negative, or the sum out of range.
    pub fn widened(&self, by: f64) -> Result<Self, ShapeError> {
        Self::new(self.core, self.radius + error::length_or_zero(by)?)
    }

    /// Its core.
    #[inline]
    #[must_use]
    pub const fn core(&self) -> &Core {
        &self.core
    }

    /// The radius around the core.
    #[inline]
    #[must_use]
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// The shape at a pose.
    // Not inlined: with a copy for each kind of question, a scene's queries would take a third more stack.
    #[inline(never)]
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        self.moved_here(pose)
    }

    /// [`Shape::moved`] for the tests of pairs. A call would copy the shape, which takes longer than moving it.
    #[inline(always)]
    pub(super) fn moved_here(&self, pose: &Pose) -> Self {
        Self { core: self.core.moved(pose), radius: self.radius }
    }
}
