//! Shapes of links.

#[cfg(doc)]
use crate::motion::LinkBody;
use crate::primitive::Shape;
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
    /// A cuboid, cylinder, capsule or sphere about the origin; cylinders and capsules are along z.
    Shape(Shape),
}

impl LinkShape {
    /// The shape. `None` for a mesh file.
    #[must_use]
    pub const fn shape(&self) -> Option<Shape> {
        match self {
            Self::Mesh { .. } => None,
            Self::Shape(shape) => Some(*shape),
        }
    }
}
