//! Spheres.

use crate::range::Point;

/// A closed ball: all points at most `radius` from `centre`, in its body's coordinates and unit.
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub struct Sphere {
    /// Its centre.
    pub centre: Point,
    /// Its radius, not negative. One of radius 0 is a point.
    pub radius: f64,
}
