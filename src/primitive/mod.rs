//! What stands below the leaves of a hierarchy.
//!
//! A [`Primitive`] is a kind of body part: triangles and spheres today. Hierarchies, their header, the packer and the
//! traversal are the same for all kinds; what differs is here: how primitives are stored, what they are once
//! read, how a pose moves them, and whether a plane bounds them. The tests of one primitive against another
//! are a trait of their own, [`crate::query::PrimitivePair`].

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
use crate::key::Key;
use crate::pose::Pose;
use crate::range::Point;
use core::fmt;

/// What the primitives of a tree are, as its header says.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Kind(u16);

impl Kind {
    /// [`Triangles`].
    pub const TRIANGLES: Self = Self(1);
    /// [`Spheres`].
    pub const SPHERES: Self = Self(2);

    /// A kind that this crate does not know, defined by a user of it: `number` is below 2^15.
    ///
    /// # Panics
    /// If it is not.
    #[must_use]
    pub const fn of_user(number: u16) -> Self {
        assert!(number < 1 << 15, "the number of a user's kind is below 2^15");
        Self(1 << 15 | number)
    }

    /// As the header of a tree holds it.
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

/// A kind of primitive: the convex hull of a few corners, and everything within a radius of it. A triangle has
/// three corners and no radius, a sphere one corner and a radius.
///
/// A tree keeps its primitives in a [`Store`]: a table of vertices, and for each primitive a record, such as
/// the indices of its corners.
pub trait Primitive: Copy + fmt::Debug + Send + Sync + 'static {
    /// What the header of a tree of them says.
    const KIND: Kind;
    /// Whether there are primitives of this kind that have a radius. If not, [`Primitive::radius`] is not asked,
    /// and what would pay for one costs nothing.
    const IS_ROUND: bool = false;
    /// Whether every primitive is a ball, so that trees have the balls of their lanes: only [`Spheres`].
    const HAS_BALLS: bool = false;

    /// Whether closed sets of these primitives bound solids: only [`Triangles`]. The records of such ones are the indices
    /// of three corners.
    const BOUNDS_SOLIDS: bool = false;

    /// Whether [`Primitive::on_lattice`] is worth being asked.
    #[doc(hidden)]
    const IS_ON_LATTICE: bool = false;

    /// A vertex in single precision, as stored where that loses nothing.
    type Single: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// A vertex in double precision. Of another size than the other, and a multiple of 8 bytes.
    type Double: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// What a primitive is made of: numbers of 4 bytes.
    type Record: bytemuck::Pod + fmt::Debug + Send + Sync;
    /// One primitive, in its body's coordinates and unit.
    type Item: Copy + PartialEq + Default + fmt::Debug + Send + Sync;

    /// A vertex that was stored in single precision.
    fn widen(vertex: Self::Single) -> Self::Double;

    /// A vertex in single precision, if that loses nothing.
    fn narrow(vertex: &Self::Double) -> Option<Self::Single>;

    /// The point that a vertex is, and about it the radius of the primitives that it is a corner of.
    fn ball(vertex: &Self::Double) -> Sphere;

    /// A vertex with `number` of each of its coordinates, and of its radius if it has one.
    #[must_use]
    fn map(vertex: &Self::Double, number: impl Fn(f64) -> f64) -> Self::Double;

    /// Whether a record names no vertex but the first `vertices`.
    fn is_among(record: &Self::Record, vertices: u32) -> bool;

    /// Primitive `index`.
    ///
    /// # Panics
    /// If there is no such primitive.
    fn item(store: &Store<'_, Self>, index: u32) -> Self::Item;

    /// The corners, at least one.
    fn corners(item: &Self::Item) -> impl Iterator<Item = Point>;

    /// How far the primitive reaches beyond the hull of its corners, in every direction. Not negative.
    #[inline(always)]
    #[must_use]
    fn radius(_item: &Self::Item) -> f64 {
        0.0
    }

    /// The primitive where the pose places it: each corner by [`Pose::apply`]. The radius stays as it is.
    #[must_use]
    fn moved(item: &Self::Item, pose: &Pose) -> Self::Item;

    /// The corners of primitive `index` on a lattice, moved or not: of triangles only.
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

    /// Directions along which the primitive is thin, the thinnest first: the normals of its plane and of its
    /// edges. Their coordinates, by column, with a greatest component of about 1; zeros where there is none.
    /// They need not be exact.
    #[inline(always)]
    #[must_use]
    fn own_directions(_item: &Self::Item) -> [[f64; OWN_DIRECTIONS]; 3] {
        [[0.0; OWN_DIRECTIONS]; 3]
    }

    /// How the ray from `origin` along the first axis crosses the primitive: 1 where it leaves what primitives like this
    /// bound, -1 where it enters, and 0 if it does not cross. Of a primitive that [bounds solids](Self::BOUNDS_SOLIDS), and
    /// then exact, for primitives that share corners as well: of closed ones the sum is how often they wind around the
    /// origin. `exact` is increased by 1 where more than `f64` was needed.
    #[inline(always)]
    #[must_use]
    fn crossing(_item: &Self::Item, _origin: &Point, _exact: &mut u64) -> i8 {
        0
    }

    /// Whether plane `key` of a tree in `frame` bounds the primitive in `direction`: decided in exact
    /// arithmetic.
    #[must_use]
    fn is_bounded(item: &Self::Item, frame: &Frame, direction: &Point, key: Key) -> bool {
        let radius = radius_of::<Self>(item);
        Self::corners(item).all(|p| frame.is_bounded_around(direction, p, radius, key))
    }
}

/// The radius of a primitive: a constant, of a kind that has none.
#[inline(always)]
pub(crate) fn radius_of<P: Primitive>(item: &P::Item) -> f64 {
    if P::IS_ROUND { P::radius(item) } else { 0.0 }
}

/// How many directions of its own a primitive has at most: a triangle's plane and its three edges.
pub const OWN_DIRECTIONS: usize = 4;

/// How far apart two primitives are, and where.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Separation {
    /// The distance is at least this.
    pub lower: f64,
    /// The distance is at most this: 0 if and only if the two meet.
    pub upper: f64,
    /// The point of the first that is closest to the second, up to rounding of its coordinates.
    pub a: Point,
    /// The point of the second.
    pub b: Point,
}
