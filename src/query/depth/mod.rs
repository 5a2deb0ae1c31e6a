//! How deep two bodies are in each other: the least translation that takes one out of the other, as a certain interval.
//!
//! The upper bound is the length of a translation after which the exact query finds the bodies to be free. The lower
//! bound is the radius of a ball of translations that are all forbidden, by balls inside of both bodies.

mod beside_shape;
mod bodies;
mod by_queries;
mod clusters;
mod cover;
mod interval;
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
    /// How far body `a`, placed by `pose` in the frame of body `b`, has to be translated at least until it is apart from
    /// `b` or touches it.
    ///
    /// The bodies are [solid](crate::construct::Builder::solid): of others the lower bound is 0, unless `packings` says
    /// what is inside of them. Of solid triangles, packings are a help: they start the search for balls inside of both
    /// bodies. Of bodies of spheres, the packing of a body may be the body itself. Packings need trees with balls.
    ///
    /// The search is anytime: with a larger [budget](Query::with_budget) neither bound is worse. It ends by itself where
    /// the bounds differ by less than 2^-8 of the lower one, or when it finds nothing better. For meshes that takes some
    /// ten milliseconds; 2,000 visits take 0.3 ms. The bounds are the same on every instruction set. The hint is tried
    /// first.
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
            interval(&mut PosedBodies { packings, hint: self.hint, ..PosedBodies::new(self, a, b, pose) })
        })
    }

    /// How far body `a`, placed by `pose` in the frame of body `b`, has to be translated along `direction` until it does
    /// not meet `b` any more, however far it goes on: an upper bound that exceeds the least such translation by at most
    /// about 2^-30 of it. [`Query::collide`] finds the bodies to be free after it. Zero for bodies that are free there,
    /// and infinite if the budget was spent or the direction is zero or not finite.
    ///
    /// For the depth of a contact [patch](super::ContactPatch) along its normal.
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
            let mut bodies = PosedBodies::new(self, a, b, pose);
            let far = way_out::along(&direction, &mut bodies).unwrap_or(f64::INFINITY);
            (far, bodies.stats)
        })
    }

    /// [`Query::depth`] of two shapes: the bounds differ by at most `tolerance` times the upper one, or by rounding (see
    /// [`depth`]).
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

/// Bodies of scenes, which meet if they are not farther apart than a margin.
impl Query {
    // Not inlined: scenes that ask for no depths should not pay for its stack frame.
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

    /// Of a shape in the tree's frame.
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
