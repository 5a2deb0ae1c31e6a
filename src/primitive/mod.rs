//! Primitives: what the leaves of a hierarchy contain.
//!
//! A [`Primitive`] is a type of geometry: triangles and spheres today. Hierarchies, their header, the packer and the
//! traversal are the same for all types. This module has what differs: how primitives are stored and read, how a pose
//! moves them, and whether a plane bounds them. The tests of one primitive against another have a trait of their own,
//! [`crate::query::PrimitivePair`].

pub(crate) mod lattice;
pub mod sphere;
mod store;
pub mod triangle;

pub use lattice::{Lattice, LatticeCorners};
pub use sphere::{Sphere, Spheres};
pub(crate) use store::Fault;
pub use store::Store;
pub use triangle::Triangles;

use crate::frame::Frame;
use crate::key::{Key, Storage};
use crate::pose::Pose;
use crate::range::Point;
use core::fmt;

/// The type of a tree's primitives, as stored in its header.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Kind(u16);

impl Kind {
    /// [`Triangles`].
    pub const TRIANGLES: Self = Self(1);
    /// [`Spheres`].
    pub const SPHERES: Self = Self(2);

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
            Self(code) => write!(f, "primitives of kind {code}"),
        }
    }
}

/// A type of primitive: the convex hull of a few corners, widened by a radius. A triangle has three corners and no
/// radius, a sphere one corner and a radius.
///
/// A tree keeps its primitives in a [`Store`]: a table of vertices, and a record for each primitive, such as the
/// indices of its corners.
pub trait Primitive: Copy + fmt::Debug + Send + Sync + 'static {
    /// The kind in the header of trees of these primitives.
    const KIND: Kind;
    /// Whether primitives of this type may have a radius. If not, [`Primitive::radius`] is never called, and support
    /// for radii costs nothing.
    const IS_ROUND: bool = false;
    /// Whether every primitive is a ball, so that trees store a ball for each lane: only [`Spheres`].
    const HAS_BALLS: bool = false;

    /// Whether closed sets of these primitives bound solids: only [`Triangles`]. Their records are the indices of three
    /// corners.
    const BOUNDS_SOLIDS: bool = false;

    /// Whether [`Primitive::on_lattice`] is implemented.
    #[doc(hidden)]
    const IS_ON_LATTICE: bool = false;

    /// A vertex in single precision, stored where narrowing is exact.
    type Single: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// A vertex in double precision. Its size differs from that of [`Primitive::Single`], and is a multiple of 8 bytes.
    type Double: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// The stored record of a primitive: numbers of 4 bytes.
    type Record: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// One primitive, in its body's coordinates and unit.
    type Item: Copy + PartialEq + Default + fmt::Debug + Send + Sync;

    /// Converts a vertex from single precision.
    fn widen(vertex: Self::Single) -> Self::Double;

    /// A vertex in single precision, if narrowing is exact.
    fn narrow(vertex: &Self::Double) -> Option<Self::Single>;

    /// The vertex as a ball: its point, and the radius of the primitives of which it is a corner.
    fn ball(vertex: &Self::Double) -> Sphere;

    /// Applies `number` to each coordinate of a vertex, and to its radius if it has one.
    #[must_use]
    fn map(vertex: &Self::Double, number: impl Fn(f64) -> f64) -> Self::Double;

    /// Whether all vertices of a record are among the first `vertices`.
    fn is_among(record: &Self::Record, vertices: u32) -> bool;

    /// Primitive `index`.
    ///
    /// # Panics
    /// If there is no such primitive.
    fn item(store: &Store<'_, Self>, index: u32) -> Self::Item;

    /// The corners, at least one.
    fn corners(item: &Self::Item) -> impl Iterator<Item = Point>;

    /// The radius around the hull of the corners. Not negative.
    #[inline(always)]
    #[must_use]
    fn radius(_item: &Self::Item) -> f64 {
        0.0
    }

    /// The primitive at a pose: moves each corner by [`Pose::apply`]. The radius stays as it is.
    #[must_use]
    fn moved(item: &Self::Item, pose: &Pose) -> Self::Item;

    /// The corners of primitive `index` on a lattice, moved or not. Only triangles implement it.
    ///
    /// # Panics
    /// If there is no such primitive.
    #[doc(hidden)]
    #[inline(always)]
    #[must_use]
    fn on_lattice(
        _store: &Store<'_, Self>,
        _index: u32,
        _lattice: &Lattice,
        _is_moved: bool,
    ) -> Option<LatticeCorners> {
        None
    }

    /// Directions along which the primitive is thin, the thinnest first: the normals of its plane and of its edges. One
    /// direction per column, with a largest component of about 1; zeros in unused columns. They need not be exact.
    #[inline(always)]
    #[must_use]
    fn own_directions(_item: &Self::Item) -> [[f64; OWN_DIRECTIONS]; 3] {
        [[0.0; OWN_DIRECTIONS]; 3]
    }

    /// How the ray from `origin` along the first axis crosses the primitive: 1 where the ray leaves the solid, -1 where
    /// it enters, and 0 if it does not cross. Only for primitives that [bound solids](Self::BOUNDS_SOLIDS). The result
    /// is exact, and consistent for primitives that share corners: over a closed set, the sum is its winding number
    /// around the origin. Adds 1 to `exact` if `f64` did not suffice.
    #[inline(always)]
    #[must_use]
    fn crossing(_item: &Self::Item, _origin: &Point, _exact: &mut u64) -> i8 {
        0
    }

    /// Whether plane `key` of a tree in `frame` bounds the primitive in `direction`. Exact.
    #[must_use]
    fn is_bounded<S: Storage>(item: &Self::Item, frame: &Frame, direction: &Point, key: Key<S>) -> bool {
        let radius = radius_of::<Self>(item);
        Self::corners(item).all(|p| frame.is_bounded_around(direction, p, radius, key))
    }
}

/// The radius of a primitive; constant 0 for types without one.
#[inline(always)]
pub(crate) fn radius_of<P: Primitive>(item: &P::Item) -> f64 {
    if P::IS_ROUND { P::radius(item) } else { 0.0 }
}

/// Largest number of a primitive's own directions: a triangle's plane and its three edges.
pub const OWN_DIRECTIONS: usize = 4;

/// The distance of two primitives, and their closest points.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Separation {
    /// Lower bound of the distance.
    pub lower: f64,
    /// Upper bound of the distance: 0 if and only if the two meet.
    pub upper: f64,
    /// The point of the first that is closest to the second, up to rounding of its coordinates.
    pub a: Point,
    /// The closest point of the second.
    pub b: Point,
}
