//! Why numbers do not form a shape.

use crate::range::{MAX_COORDINATE, MIN_COORDINATE, Point};
use core::fmt;

/// Why numbers do not form a shape.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum ShapeError {
    /// A radius, side or height is negative, NaN, or too large; or it is zero where it must not be.
    Length {
        /// The number given.
        given: f64,
    },
    /// A coordinate is not finite, or its magnitude is out of range ([`crate::range`]).
    Coordinate {
        /// The number given.
        given: f64,
    },
    /// An axis, normal or half edge has no direction: it is zero.
    NoDirection,
    /// A tree cannot hold a half-space, which is not bounded.
    Unbounded,
    /// Two half edges of a cuboid are not perpendicular.
    NotPerpendicular {
        /// The cosine of the angle between them.
        cosine: f64,
    },
    /// A mesh of a round shape would need too many sides to be within this error of it, or the error is not above 0.
    Error {
        /// The number given.
        given: f64,
    },
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { given } => write!(f, "{given:e} is not a length of a shape"),
            Self::Coordinate { given } => write!(f, "{given:e} is not a coordinate of a shape"),
            Self::NoDirection => f.write_str("an axis, normal or half edge of a shape is zero"),
            Self::Unbounded => f.write_str("a tree of shapes cannot hold a half-space"),
            Self::NotPerpendicular { cosine } => {
                write!(
                    f,
                    "two edges of a cuboid are not perpendicular: the cosine of their angle is {cosine:e}"
                )
            }
            Self::Error { given } => {
                write!(
                    f,
                    "a mesh of a round shape cannot be within an error of {given:e}: it has at most 4096 sides"
                )
            }
        }
    }
}

impl core::error::Error for ShapeError {}

/// A length above 0.
pub(crate) fn length(given: f64) -> Result<f64, ShapeError> {
    let is_length = (MIN_COORDINATE..=MAX_COORDINATE).contains(&given);
    if is_length { Ok(given) } else { Err(ShapeError::Length { given }) }
}

/// A length, or 0.
pub(super) fn length_or_zero(given: f64) -> Result<f64, ShapeError> {
    if given == 0.0 { Ok(0.0) } else { length(given) }
}

pub(super) fn point(p: &Point) -> Result<(), ShapeError> {
    let is_valid = |x: f64| x == 0.0 || (MIN_COORDINATE..=MAX_COORDINATE).contains(&x.abs());
    match p.iter().find(|x| !is_valid(**x)) {
        Some(given) => Err(ShapeError::Coordinate { given: *given }),
        None => Ok(()),
    }
}
