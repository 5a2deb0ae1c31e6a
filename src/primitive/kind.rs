//! Kinds of primitives.

#[cfg(doc)]
use super::{Shapes, Spheres, Triangles};
use core::fmt;

/// The type of a tree's primitives, as stored in its header.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Kind(u16);

impl Kind {
    /// [`Triangles`].
    pub const TRIANGLES: Self = Self(1);
    /// [`Spheres`].
    pub const SPHERES: Self = Self(2);

    /// [`Shapes`].
    pub const SHAPES: Self = Self(3);

    /// A kind that a user of this crate defines: `number` is below 2^15.
    ///
    /// # Panics
    /// If `number` is not below 2^15.
    #[must_use]
    pub const fn of_user(number: u16) -> Self {
        assert!(number < 1 << 15, "the number of a user's kind is below 2^15");
        Self(1 << 15 | number)
    }

    /// The code in the header of a tree.
    #[must_use]
    pub const fn code(self) -> u16 {
        self.0
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TRIANGLES => f.write_str("triangles"),
            Self::SPHERES => f.write_str("spheres"),
            Self::SHAPES => f.write_str("shapes"),
            Self(code) => write!(f, "primitives of kind {code}"),
        }
    }
}
