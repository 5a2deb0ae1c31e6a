//! One sphere.

use crate::range::Point;
use core::f64::consts::PI;

/// A closed ball: all points at most `radius` from `centre`, in its body's coordinates and unit.
#[derive(Copy, Clone, PartialEq, Default, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// Its centre.
    pub centre: Point,
    /// Its radius, not negative. A sphere of radius 0 is a point.
    pub radius: f64,
}

impl Sphere {
    /// Its volume.
    #[must_use]
    pub const fn volume(&self) -> f64 {
        volume(self.radius)
    }
}

/// The volume of a sphere.
pub(crate) const fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * (radius * radius * radius)
}
