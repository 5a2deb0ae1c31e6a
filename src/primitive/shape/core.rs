//! The core of a shape, which a radius widens.

use super::error::{self, ShapeError};
use crate::pose::Pose;
use crate::range::{MAX_COORDINATE, MIN_COORDINATE, Point, flush};
use crate::vector::dot;

/// A closed convex set.
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum Core {
    /// One point.
    Point(Point),
    /// The segment between two points, which may be equal.
    Segment([Point; 2]),
    /// The triangle with these corners, which may lie on a line.
    Triangle([Point; 3]),
    /// All points `centre + x half[0] + y half[1] + z half[2]` with x, y and z in -1 ..= 1.
    Cuboid {
        /// Its centre.
        centre: Point,
        /// Half its edges.
        half: [Point; 3],
    },
    /// All points at most `radius` from the axis `centre - half_axis .. centre + half_axis` that are between the planes
    /// through its ends perpendicular to it.
    Cylinder {
        /// Its centre.
        centre: Point,
        /// From the centre to the middle of a disc.
        half_axis: Point,
        /// Its radius.
        radius: f64,
    },
    /// The convex hull of a disc and a tip above its middle.
    Cone {
        /// The middle of the disc, which is perpendicular to the axis.
        base: Point,
        /// From the middle of the disc to the tip.
        axis: Point,
        /// The radius of the disc.
        radius: f64,
    },
    /// All points p with `normal . p <= offset`.
    HalfSpace {
        /// Points outwards. The largest component is between 1/2 and 1 up to rounding
        /// ([`Shape::half_space`](super::Shape::half_space) scales it by a power of two); for a moved half-space,
        /// between 1/4 and 2.
        normal: Point,
        /// In units of the normal's length.
        offset: f64,
    },
}

impl Core {
    pub(super) fn check(&self) -> Result<(), ShapeError> {
        match self {
            Self::Point(p) => error::point(p),
            Self::Segment(ends) => ends.iter().try_for_each(error::point),
            Self::Triangle(corners) => corners.iter().try_for_each(error::point),
            Self::Cuboid { centre, half } => {
                error::point(centre)?;
                half.iter().try_for_each(error::point)?;
                for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                    let (x, y) = (unit(&half[i])?, unit(&half[j])?);
                    let cosine = dot(&x, &y);
                    if cosine.abs() > Pose::TOLERANCE {
                        return Err(ShapeError::NotPerpendicular { cosine });
                    }
                }
                Ok(())
            }
            Self::Cylinder { centre, half_axis: axis, radius }
            | Self::Cone { base: centre, axis, radius } => {
                error::point(centre)?;
                error::point(axis)?;
                unit(axis)?;
                error::length(*radius).map(drop)
            }
            Self::HalfSpace { normal, offset } => {
                error::point(normal)?;
                let largest = normal[0].abs().max(normal[1].abs()).max(normal[2].abs());
                if !(0.25..=2.0).contains(&largest) {
                    return Err(ShapeError::NoDirection);
                }
                error::point(&[*offset, 0.0, 0.0])
            }
        }
    }

    /// The core at a pose.
    // A call would copy the core, which takes longer than moving it.
    #[inline(always)]
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        let vector = |v: &Point| pose.rotate(v).map(flush);
        match *self {
            Self::Point(p) => Self::Point(pose.apply(p)),
            Self::Segment([p, q]) => Self::Segment([pose.apply(p), pose.apply(q)]),
            Self::Triangle([p, q, r]) => Self::Triangle([pose.apply(p), pose.apply(q), pose.apply(r)]),
            Self::Cuboid { centre, half: [x, y, z] } => {
                Self::Cuboid { centre: pose.apply(centre), half: [vector(&x), vector(&y), vector(&z)] }
            }
            Self::Cylinder { centre, half_axis, radius } => {
                Self::Cylinder { centre: pose.apply(centre), half_axis: vector(&half_axis), radius }
            }
            Self::Cone { base, axis, radius } => {
                Self::Cone { base: pose.apply(base), axis: vector(&axis), radius }
            }
            Self::HalfSpace { normal, offset } => {
                let normal = vector(&normal);
                Self::HalfSpace { normal, offset: flush(offset + dot(&normal, &pose.translation())) }
            }
        }
    }
}

#[cfg(test)]
impl Core {
    /// Replaces each number of the core, in order, except a normal.
    pub(super) fn map(&self, mut number: impl FnMut(f64) -> f64) -> Self {
        let mut vector = |v: Point| v.map(&mut number);
        match *self {
            Self::Point(p) => Self::Point(vector(p)),
            Self::Segment(ends) => Self::Segment(ends.map(vector)),
            Self::Triangle(corners) => Self::Triangle(corners.map(vector)),
            Self::Cuboid { centre, half } => Self::Cuboid { centre: vector(centre), half: half.map(vector) },
            Self::Cylinder { centre, half_axis, radius } => {
                let (centre, half_axis) = (vector(centre), vector(half_axis));
                Self::Cylinder { centre, half_axis, radius: number(radius) }
            }
            Self::Cone { base, axis, radius } => {
                let (base, axis) = (vector(base), vector(axis));
                Self::Cone { base, axis, radius: number(radius) }
            }
            Self::HalfSpace { normal, offset } => Self::HalfSpace { normal, offset: number(offset) },
        }
    }
}

/// A vector of length 1 up to rounding.
fn unit(v: &Point) -> Result<Point, ShapeError> {
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    if !(MIN_COORDINATE..=MAX_COORDINATE).contains(&largest) {
        return Err(ShapeError::NoDirection);
    }
    let scaled = v.map(|x| x / largest);
    let length = crate::vector::length(&scaled);
    Ok(scaled.map(|x| x / length))
}
