//! Exact test of whether two closed triangles meet.
//!
//! The result depends only on the signs of determinants of the given coordinates. Each sign is first computed in plain
//! `f64` with a bound on its rounding error. Only if the bound does not decide is the determinant evaluated in
//! integers. So the verdict is correct for the given coordinates.
//!
//! 1. *Plane sides.* If the three vertices of one triangle lie strictly on one side of the other's plane, the triangles
//!    are disjoint. Nearly every pair ends here.
//! 2. *Intervals.* Otherwise each triangle cuts an interval out of the line shared by the two planes, and two more
//!    determinants compare the interval ends without constructing them (Devillers & Guigue, *Faster triangle-triangle
//!    intersection tests*, INRIA RR-4488, 2002).
//! 3. *Flat cases.* A separate module tests coplanar pairs, and triangles that are a segment or a point.
//!
//! # Range
//!
//! Every coordinate must be zero or have a magnitude in [`MIN_COORDINATE`] `..=` [`MAX_MOVED`]. The upper limit is four
//! times that of a body's own coordinates, since poses move them; poses flush smaller coordinates to zero. Then nothing
//! under- or overflows, as the error analysis assumes. Each coordinate is a multiple of 2^-302, the last place of
//! [`MIN_COORDINATE`]; so is each difference of two and its rounding error; so a product of three of them is a multiple
//! of 2^-906 and not subnormal. A difference is at most 2^303, so a sum of six products of three is below 2^912. The
//! exact integers have room for all of this.

mod crossing;
#[cfg(feature = "alloc")]
pub(crate) mod deep;
pub mod distance;
mod double_double;
mod features;
mod flat;
mod intersection;
mod interval;
mod on_lattice;
mod overlap;
pub(crate) mod point;
mod sides;
#[cfg(test)]
mod tests;
mod triangles;

pub use intersection::{Intersection, intersection};
pub(crate) use on_lattice::LatticeProbe;
pub use overlap::{Probe, is_degenerate, overlap};
#[cfg(simdop_x86)]
pub(crate) use sides::DETERMINANT_ERROR;
pub use sides::Triangle;
pub use triangles::Triangles;

#[cfg(doc)]
use crate::range::{MAX_MOVED, MIN_COORDINATE};
