//! Computations on the planes of a node in traversals, for 1vs16 and 4vs4: overlap masks, gaps, supports.

mod along;
mod compare;
mod entries;
mod gaps;
mod primitive_gaps;
mod rows;
mod supports;

pub(super) use along::Along;
pub use compare::Compare;
pub(super) use compare::within_slabs;
pub(super) use entries::Entry;
pub(super) use entries::{Entries, least, remove, weight, weight_of};
pub(super) use gaps::growth;
pub(super) use primitive_gaps::PrimitiveGaps;
pub(super) use rows::Rows;
pub(super) use rows::{Descent, bits_of, used_lanes};
pub(super) use supports::AT_ONCE;

use crate::frame::{BodyBounds, Frame};
use crate::kernel::Turned;
use crate::key::{Key, Storage};
use crate::node::{Alignment, Arity, Child, DopNode, Node};
#[cfg(doc)]
use crate::node::{Node4, Node16};
use crate::pose::Pose;
use crate::primitive::{LatticeCorners, Primitive};
use crate::range::Point;
use crate::realign::{
    PrimitiveSlabs, Ray, Realignment, planes_of, planes_on_lattice, primitive_slabs, some_planes_of,
};
use entries::{entries, raise};
use supports::supports;

/// A node type that can be queried. Implemented by [`Node16`] and [`Node4`] only.
pub trait Lanes: Compare {
    /// Rotated planes of one volume, in `f32`.
    type Planes: Copy + core::fmt::Debug;
    /// Rotated planes of a node's children, in `f32`.
    type PlaneRows: Copy + core::fmt::Debug;
    /// Initial value, to be overwritten: all zeros, which need no copy.
    #[doc(hidden)]
    const UNTURNED: Self::Turned;
    /// Initial value, likewise.
    #[doc(hidden)]
    const UNMAPPED: Self::Map;
    #[doc(hidden)]
    const NO_PLANES: Self::Planes;
    #[doc(hidden)]
    const NO_PLANE_ROWS: Self::PlaneRows;

    #[doc(hidden)]
    fn map(map: &mut Self::Map, pose: &Pose, a: &BodyBounds, b: &Frame);
    /// Puts the planes of everything within `margin` of moved primitives into `aimed`.
    #[doc(hidden)]
    fn aim<P: Primitive>(
        aimed: &mut Self::Aimed,
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        margin: f64,
    );
    /// [`Lanes::aim`] for triangles on a lattice of `2^exponent` steps to the unit. Returns a bit for each plane that
    /// is not certain.
    #[doc(hidden)]
    fn aim_on_lattice(
        aimed: &mut Self::Aimed,
        b: &Frame,
        triangles: impl Iterator<Item = Option<LatticeCorners>>,
        exponent: i32,
        margin: f64,
    ) -> u32;
    /// [`Lanes::aim`], only for the planes that have a bit in `wanted`.
    #[doc(hidden)]
    fn aim_some<P: Primitive>(
        aimed: &mut Self::Aimed,
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        margin: f64,
        wanted: u32,
    );
    /// Puts the planes of a ray into `aimed`.
    #[doc(hidden)]
    fn aim_ray(aimed: &mut Self::Aimed, frame: &Frame, ray: &Ray);
    /// [`primitive_slabs`].
    #[doc(hidden)]
    fn primitive_slabs<P: Primitive>(
        item: &P::Item,
        margin: f64,
        body: &BodyBounds,
        pose: Option<&Pose>,
    ) -> PrimitiveSlabs;
    /// The least and the greatest support of some children, each along a direction of its own, by column.
    #[doc(hidden)]
    fn supports_of_children(
        children: [(&Self, usize); AT_ONCE],
        directions: &[[f64; AT_ONCE]; 3],
    ) -> [[f64; AT_ONCE]; 2];
    /// Widens the map, so that rotated planes bound everything within `margin` of the body.
    #[doc(hidden)]
    fn widen(map: &mut Self::Map, b: &Frame, margin: f64);
    /// Rotates the planes of the children into the other body's frame.
    #[doc(hidden)]
    fn turn(&self, map: &Self::Map, rows: &mut Self::PlaneRows);
    /// The planes of one child.
    #[doc(hidden)]
    fn planes_in(rows: &Self::PlaneRows, lane: usize) -> Self::Planes;
    /// The planes of moved primitives. `reach` bounds their coordinates and the frame's centre.
    #[doc(hidden)]
    fn planes_of<P: Primitive>(b: &Frame, items: &[P::Item], reach: f64) -> Self::Planes;
    /// Lower bounds of the distances between child `lane` of `b` and each child of `self`, whose rotated planes are in
    /// `rows`. `growth` converts the planes of `b` to the unit of the rotated ones.
    #[doc(hidden)]
    fn gaps_of_rows(&self, rows: &Self::PlaneRows, b: &Self, lane: usize, growth: f32) -> Entries;
    /// Lower bounds of the distances between a volume with these rotated planes and each child of `self`.
    #[doc(hidden)]
    fn gaps_of_planes(&self, planes: &Self::Planes, growth: f32) -> Entries;
    /// Raises bounds by a primitive's own slabs.
    #[doc(hidden)]
    fn raise(&self, entries: &mut Entries, gaps: &PrimitiveGaps);
    /// Prepares the supports of a body's volumes along an axis of its frame, in a unit of `2^-exponent`.
    #[doc(hidden)]
    fn along(axis: Point, body: &BodyBounds, exponent: i32) -> Along;
    /// Upper bound of the support of child `lane`.
    #[doc(hidden)]
    fn reach_along(&self, along: &Along, lane: usize) -> f32;
    /// Lower bounds of the gaps between each child of `self` and a volume whose support towards them is `other`,
    /// relative to the bodies' centres.
    #[doc(hidden)]
    fn gaps_along(&self, along: &Along, other: f32) -> Entries;
    /// The sum of the widths of child `lane` along the three axes; `growth` converts it to the unit. Zero if `growth`
    /// is.
    #[doc(hidden)]
    fn width(&self, lane: usize, growth: f32) -> f32;
    /// A node whose lane 0 is the hull of `self`, which is a root.
    #[doc(hidden)]
    #[must_use]
    fn hull(&self) -> Self;
}

impl<const W: usize, const K: usize, S: Storage> Lanes for DopNode<W, K, S>
where
    Arity<W>: Alignment,
    Self: bytemuck::Pod + Compare<Map = Realignment<K, S>, Turned = Turned<W, K>, Storage = S>,
{
    type Planes = gaps::Planes<K>;
    type PlaneRows = gaps::PlaneRows<W, K>;
    const NO_PLANES: Self::Planes = [0.0; K];
    const NO_PLANE_ROWS: Self::PlaneRows = [[0.0; W]; K];
    const UNTURNED: Self::Turned = [[0; W]; K];
    const UNMAPPED: Self::Map = Realignment::UNSET;

    #[inline(always)]
    fn map(map: &mut Self::Map, pose: &Pose, a: &BodyBounds, b: &Frame) {
        map.set(pose, a, b);
    }

    #[inline(always)]
    fn aim<P: Primitive>(
        aimed: &mut Self::Aimed,
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        margin: f64,
    ) {
        let planes: [Key<S>; K] = planes_of::<P, K, S>(b, items, margin);
        for (j, plane) in planes.into_iter().enumerate() {
            Self::aim_along(aimed, j, plane);
        }
    }

    #[inline(always)]
    fn aim_on_lattice(
        aimed: &mut Self::Aimed,
        b: &Frame,
        triangles: impl Iterator<Item = Option<LatticeCorners>>,
        exponent: i32,
        margin: f64,
    ) -> u32 {
        planes_on_lattice::<K, S>(b, triangles, exponent, margin, |j, plane| Self::aim_along(aimed, j, plane))
    }

    #[inline(always)]
    fn aim_some<P: Primitive>(
        aimed: &mut Self::Aimed,
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        margin: f64,
        wanted: u32,
    ) {
        some_planes_of::<P, K, S>(b, items, margin, wanted, |j, plane| Self::aim_along(aimed, j, plane));
    }

    #[inline(always)]
    fn aim_ray(aimed: &mut Self::Aimed, frame: &Frame, ray: &Ray) {
        let planes: [Key<S>; K] = ray.planes(frame);
        for (j, plane) in planes.into_iter().enumerate() {
            Self::aim_along(aimed, j, plane);
        }
    }

    #[inline(always)]
    fn primitive_slabs<P: Primitive>(
        item: &P::Item,
        margin: f64,
        body: &BodyBounds,
        pose: Option<&Pose>,
    ) -> PrimitiveSlabs {
        primitive_slabs::<P, K, S>(item, margin, body, pose)
    }

    #[inline(always)]
    fn supports_of_children(
        children: [(&Self, usize); AT_ONCE],
        directions: &[[f64; AT_ONCE]; 3],
    ) -> [[f64; AT_ONCE]; 2] {
        supports::<W, K, S>(children.map(|(node, lane)| (&node.planes, lane)), directions)
    }

    #[inline(always)]
    fn widen(map: &mut Self::Map, b: &Frame, margin: f64) {
        map.widen(margin * b.scale());
    }

    #[inline(always)]
    fn turn(&self, map: &Self::Map, rows: &mut Self::PlaneRows) {
        gaps::turn::<W, K, S>(map, &self.planes, rows);
    }

    #[inline(always)]
    fn planes_in(rows: &Self::PlaneRows, lane: usize) -> Self::Planes {
        gaps::column(rows, lane)
    }

    #[inline(always)]
    fn planes_of<P: Primitive>(b: &Frame, items: &[P::Item], reach: f64) -> Self::Planes {
        gaps::planes_of::<P, K>(b, items, reach)
    }

    #[inline(always)]
    fn gaps_of_rows(&self, rows: &Self::PlaneRows, b: &Self, lane: usize, growth: f32) -> Entries {
        entries(&gaps::gaps_of_rows::<W, K, S>(rows, &b.planes, lane, growth), &self.child)
    }

    #[inline(always)]
    fn gaps_of_planes(&self, planes: &Self::Planes, growth: f32) -> Entries {
        entries(&gaps::gaps_of_planes::<W, K, S>(planes, &self.planes, growth), &self.child)
    }

    #[inline(always)]
    fn raise(&self, entries: &mut Entries, gaps: &PrimitiveGaps) {
        raise(entries, &gaps.bounds::<W, K, S>(&self.planes));
    }

    fn along(axis: Point, body: &BodyBounds, exponent: i32) -> Along {
        Along::new::<K>(axis, body, exponent)
    }

    #[inline(always)]
    fn reach_along(&self, along: &Along, lane: usize) -> f32 {
        along::reach_of::<W, K, S>(&self.planes, along, lane)
    }

    #[inline(always)]
    fn gaps_along(&self, along: &Along, other: f32) -> Entries {
        entries(&along::bounds::<W, K, S>(&self.planes, along, other), &self.child)
    }

    #[inline(always)]
    fn width(&self, lane: usize, growth: f32) -> f32 {
        if growth > 0.0 { gaps::width::<W, K, S>(&self.planes, lane) * growth } else { 0.0 }
    }

    fn hull(&self) -> Self {
        let (mut whole, hull) = (Self::EMPTY, gaps::hull(&self.planes));
        (0..K).for_each(|j| whole.planes[j][0] = hull[j]);
        whole.child[0] = Child::ROOT;
        whole
    }
}
