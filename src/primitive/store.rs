//! The trait of a type of primitives, and the primitives of a baked tree, read in place.

use super::ball::Sphere;
use super::kind::Kind;
use super::lattice::{Lattice, LatticeCorners};
#[cfg(doc)]
use super::{Spheres, Triangles};
use crate::frame::Frame;
use crate::key::{Key, Storage};
use crate::pose::Pose;
use crate::range::Point;
use core::fmt;

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
    /// Whether every primitive is a separate part: a solid that shares no vertex with others. If not, each vertex has
    /// one ball, and primitives that share a vertex are in one part.
    const ARE_PARTS: bool = false;

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

    /// Balls whose convex hull contains what a vertex contributes to a primitive: for a corner its point, with the
    /// radius of the primitives that have this corner. At least one. NaN if the numbers of a vertex are not valid
    /// together.
    fn balls(vertex: &Self::Double) -> impl Iterator<Item = Sphere>;

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

    /// The corners, at least one. For curved primitives, the corners of a polytope around them.
    fn corners(item: &Self::Item) -> impl Iterator<Item = Point>;

    /// A point of the primitive.
    #[inline(always)]
    fn point(item: &Self::Item) -> Point {
        Self::corners(item).next().unwrap_or_default()
    }

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

/// A table of vertices: in single precision where that is exact, else in double.
#[derive(Debug)]
enum Vertices<'a, P: Primitive> {
    Single(&'a [P::Single]),
    Double(&'a [P::Double]),
}

/// The vertices of a tree, and a record for each primitive that lists its vertices.
#[derive(Debug)]
pub struct Store<'a, P: Primitive> {
    vertices: Vertices<'a, P>,
    records: &'a [P::Record],
}

impl<P: Primitive> Copy for Vertices<'_, P> {}
impl<P: Primitive> Clone for Vertices<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<P: Primitive> Copy for Store<'_, P> {}
impl<P: Primitive> Clone for Store<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

/// Why a store is invalid.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Fault {
    /// A vertex is not accepted.
    Vertex { index: u32 },
    /// A primitive refers to a vertex that does not exist.
    Primitive { index: u32 },
}

impl<'a, P: Primitive> Store<'a, P> {
    /// Whether `size` is a valid size of a vertex in bytes.
    pub(crate) const fn takes_vertices_of(size: u16) -> bool {
        size as usize == size_of::<P::Single>() || size as usize == size_of::<P::Double>()
    }

    /// Reads a store in place. `None` if the bytes are misaligned or not a whole number of vertices and records.
    #[inline(always)]
    pub(crate) fn read(vertex_size: u16, vertices: &'a [u8], records: &'a [u8]) -> Option<Self> {
        let vertices = if usize::from(vertex_size) == size_of::<P::Single>() {
            Vertices::Single(bytemuck::try_cast_slice(vertices).ok()?)
        } else {
            Vertices::Double(bytemuck::try_cast_slice(vertices).ok()?)
        };
        Some(Self { vertices, records: bytemuck::try_cast_slice(records).ok()? })
    }

    /// Checks that every primitive's vertices exist, and that `accepts` holds for all vertices.
    pub(crate) fn check(&self, accepts: impl Fn(&P::Double) -> bool) -> Result<(), Fault> {
        let count = match self.vertices {
            Vertices::Single(all) => all.len(),
            Vertices::Double(all) => all.len(),
        } as u32;
        if let Some(index) = (0..count).find(|&index| !accepts(&self.vertex(index))) {
            return Err(Fault::Vertex { index });
        }
        match self.records.iter().position(|record| !P::is_among(record, count)) {
            Some(index) => Err(Fault::Primitive { index: index as u32 }),
            None => Ok(()),
        }
    }

    /// The record of primitive `index`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    #[must_use]
    pub const fn record(&self, index: u32) -> &'a P::Record {
        &self.records[index as usize]
    }

    /// Applies one function or the other to the vertex at `index`, depending on its stored precision.
    #[inline(always)]
    pub(crate) fn vertex_by<R>(
        &self,
        index: u32,
        single: impl Fn(&P::Single) -> R,
        double: impl Fn(&P::Double) -> R,
    ) -> R {
        match self.vertices {
            Vertices::Single(all) => single(&all[index as usize]),
            Vertices::Double(all) => double(&all[index as usize]),
        }
    }

    /// The vertex at `index`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    #[must_use]
    pub fn vertex(&self, index: u32) -> P::Double {
        match self.vertices {
            Vertices::Single(all) => P::widen(all[index as usize]),
            Vertices::Double(all) => all[index as usize],
        }
    }
}
