//! The penetration depth of two bodies: certain bounds of the length of the shortest translation that separates them.
//!
//! The upper bound is the length of a translation after which the exact query finds the bodies to be free. The lower
//! bound is the radius of a ball of translations that are all forbidden, by balls inside both bodies, and by pairs of
//! convex primitives.

mod beside_shape;
mod bodies;
mod by_queries;
mod clusters;
mod cover;
mod interval;
mod overlaps;
mod packings;
mod posed_pair;
mod search;
mod signed;
mod way_out;

pub(crate) use by_queries::{ByQueries, depth_along_by, depth_by, half_space_depth};
pub use interval::DepthInterval;
pub use packings::Packings;
pub use signed::SignedDistance;

use super::entry::{Completion, PrimitivePair, Query, QueryStats};
use super::lanes::Lanes;
use crate::hierarchy::{AsBvh, BvhRef, with_bvhs};
use crate::pose::Pose;
use crate::primitive::shape::depth;
use crate::primitive::triangle::distance::TIGHT as TIGHTEST;
use crate::primitive::{Primitive, Shape, Shapes};
use crate::range::Point;
use beside_shape::PosedShape;
use bodies::PosedBodies;
use search::interval;

impl Query {
    /// The penetration depth of two bodies: the length of the shortest translation of body `a`, placed by `pose` in the
    /// frame of body `b`, after which it is apart from `b` or touches it.
    ///
    /// Spheres and shapes are solid, and so are triangles that [bound a solid](crate::construct::Builder::solid). The
    /// interior of other meshes is unknown: against a mesh, the lower bound is 0 unless `packings` describe the
    /// interiors; against spheres and shapes, it is that of single triangles. For solid triangles, packings help: they
    /// start the search for balls inside both bodies. Without `packings`, the query uses those that the bodies
    /// [carry](crate::construct::Builder::add_packing). Packings need trees with balls.
    ///
    /// The search is anytime: with a larger [budget](Query::with_budget) neither bound is worse. It ends by itself when
    /// the bounds differ by less than 2^-8 of the lower one, or when it finds nothing better. For meshes that takes
    /// some ten milliseconds; 2,000 visits take 0.3 ms. The bounds are the same on every instruction set. The search
    /// tries the hint first.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// let vertices: Vec<[f64; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| 2.0 * f64::from(x))).collect();
    /// let triangles = [
    ///     [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
    ///     [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    /// ];
    /// let cube = Builder::new().solid().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let query = Query::new(Isa::detect());
    /// let pose = Pose::from_rows([[1.0, 0.0, 0.0, 1.5], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 0.25]])?;
    /// let depth = query.depth(&cube, &cube, &pose, None);
    /// assert!(depth.lower <= 0.5 && 0.5 <= depth.upper && depth.upper < 0.5 + 1e-9);
    /// assert!(depth.lower > 0.49 && depth.translation[0] > 0.5 - 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn depth<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        packings: Option<&Packings<'_, A::Node>>,
    ) -> DepthInterval
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
        Shapes: PrimitivePair<A::Primitive> + PrimitivePair<B::Primitive>,
    {
        with_bvhs(a, b, |a, b| {
            let bodies = PosedBodies { hint: self.hint, ..PosedBodies::new(self, a, b, pose) };
            interval(&mut bodies.with_packings(packings))
        })
    }

    /// How far body `a`, placed by `pose` in the frame of body `b`, must be translated along `direction` until it no
    /// longer meets `b`, however much farther it moves: an upper bound that exceeds the least such translation by at
    /// most about 2^-30 of it. [`Query::collide`] finds the bodies to be free after it. Zero if they do not meet at the
    /// pose. Infinite if the budget was spent, or if they meet and the direction is zero or not finite.
    ///
    /// Use it for the depth of a contact [patch](super::ContactPatch) along its normal.
    pub fn depth_along<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        direction: Point,
    ) -> (f64, QueryStats)
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
        Shapes: PrimitivePair<A::Primitive> + PrimitivePair<B::Primitive>,
    {
        with_bvhs(a, b, |a, b| {
            let met = self.collide(a, b, pose);
            if met.is_free() {
                return (0.0, met.stats);
            }
            let left = self.after(&met.stats);
            let mut bodies = PosedBodies::new(&left, a, b, pose);
            let far = way_out::along(&direction, &mut bodies).unwrap_or(f64::INFINITY);
            (far, met.stats.and(&bodies.stats))
        })
    }

    /// [`Query::depth`] of two shapes: the bounds differ by at most `tolerance` times the upper one, or by rounding
    /// (see [`depth`]).
    pub fn depth_shapes(&self, a: &Shape, b: &Shape, pose: &Pose, tolerance: f64) -> DepthInterval {
        let found = depth(&a.moved(pose), b, tolerance);
        let stats = QueryStats { primitive_pairs: 1, ..QueryStats::default() };
        DepthInterval {
            lower: found.lower,
            upper: found.upper,
            translation: found.direction.map(|x| if found.upper > 0.0 { x * found.upper } else { 0.0 }),
            completion: Completion::Complete,
            stats,
        }
    }
}

/// Depths for scenes, whose bodies count as meeting up to a margin.
impl Query {
    // Not inlined: scenes that need no depths should not pay for its stack frame.
    #[inline(never)]
    pub(crate) fn depth_within<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        margin: f64,
    ) -> DepthInterval
    where
        Shapes: PrimitivePair<P> + PrimitivePair<Q>,
    {
        interval(&mut PosedBodies { margin, hint: self.hint, ..PosedBodies::new(self, a, b, pose) })
    }

    /// The depth of a shape in the tree's frame.
    #[inline(never)]
    pub(crate) fn shape_depth_within<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        tree: &BvhRef<'_, N, Q>,
        margin: f64,
    ) -> DepthInterval
    where
        Shapes: PrimitivePair<Q>,
    {
        if shape.is_half_space() {
            let distance = |away: &Shape| self.shape_distance(away, tree, TIGHTEST, f64::INFINITY);
            return half_space_depth(shape, &tree.extent(), margin, distance);
        }
        interval(&mut PosedShape::new(self, shape, tree, margin))
    }
}
