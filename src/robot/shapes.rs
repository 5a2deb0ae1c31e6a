//! Shapes of links.

use crate::construct::{OwnedMesh, ShapeError};
#[cfg(doc)]
use crate::motion::LinkBody;
use crate::range::MAX_COORDINATE;
use alloc::string::String;

/// Which of a link's shapes become its bodies.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum LinkShapes {
    /// The collision shapes.
    Collision,
    /// The visual shapes.
    Visual,
}

/// A shape of a link, in its own frame ([`LinkBody::at`]).
#[derive(Clone, PartialEq, Debug)]
pub enum LinkShape {
    /// A mesh file, scaled along each axis.
    Mesh {
        /// File name, as in the description.
        file: String,
        /// Scale factors along x, y and z.
        scale: [f64; 3],
    },
    /// A cuboid centred at the origin.
    Cuboid {
        /// Side lengths along x, y and z.
        sides: [f64; 3],
    },
    /// A cylinder centred at the origin, along z.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A capsule centred at the origin, along z.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Distance of the centres of its two hemispheres.
        height: f64,
    },
    /// A ball centred at the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
}

impl LinkShape {
    /// A closed mesh, and a radius around it ([`crate::scene::Body::with_radius`]). `None` for a mesh file. A cylinder
    /// becomes a prism that contains it, at most `error` from it everywhere.
    ///
    /// # Errors
    /// [`ShapeError`] if a length or the error is not above 0.
    pub fn mesh(&self, error: f64) -> Result<Option<(OwnedMesh, f64)>, ShapeError> {
        Ok(Some(match *self {
            Self::Mesh { .. } => return Ok(None),
            Self::Cuboid { sides } => (OwnedMesh::cuboid(sides)?, 0.0),
            Self::Cylinder { radius, height } => (OwnedMesh::cylinder(radius, height, error)?, 0.0),
            Self::Capsule { radius, height } => (OwnedMesh::segment(height)?, positive(radius)?),
            Self::Sphere { radius } => (OwnedMesh::point(), positive(radius)?),
        }))
    }
}

fn positive(radius: f64) -> Result<f64, ShapeError> {
    let is_length = radius > 0.0 && radius <= MAX_COORDINATE;
    if is_length { Ok(radius) } else { Err(ShapeError::Length { given: radius }) }
}
