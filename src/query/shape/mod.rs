//! One shape against a tree. The k-DOP of the shape, computed in the tree's frame, is tested against sixteen children
//! at a time; nothing is rotated. Half-spaces, which no k-DOP bounds, and shapes far away are tested along one axis.

mod bounds;
mod pair;
mod search;

use super::distance::{Distance, Witness};
use super::entry::{
    Answer, Completion, Hint, Pair, PrimitivePair, Query, QueryStats, ToleranceError, Verdict, checked,
};
use super::lanes::Lanes;
use crate::exact::power_of_two;
use crate::hierarchy::{AsBvh, BvhRef};
use crate::pose::Pose;
use crate::primitive::shape::{Core, is_near_posed, nearer_posed};
use crate::primitive::triangle::distance::TIGHT;
use crate::primitive::{Primitive, Separation, Shape, Shapes};
use crate::range::Point;
use bounds::Volume;
use core::ops::ControlFlow;

/// The relative difference of the bounds of a distance from a point.
const NEAR: f64 = power_of_two(-30);

impl Query {
    /// Whether a shape, placed by `pose` in the frame of body B, meets B, or is inside B, which is
    /// [solid](crate::construct::Builder::solid). Touching counts as meeting. As [`Query::collide`] with a body A of
    /// one primitive, but without a tree, and also for half-spaces.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// use simdop::primitive::Shape;
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let (query, ball) = (Query::new(Isa::detect()), Shape::sphere(0.5)?);
    /// let up = |z| Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]]);
    /// assert!(query.collide_shape(&ball, &body, &up(1.5)?).hit().is_some()); // it touches the tip
    /// assert!(query.collide_shape(&ball, &body, &up(1.500001)?).is_free());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn collide_shape<B: AsBvh>(&self, shape: &Shape, b: &B, pose: &Pose) -> Answer
    where
        B::Node: Lanes,
        Shapes: PrimitivePair<B::Primitive>,
    {
        self.shape_within(&shape.moved(pose), &b.as_bvh(), 0.0)
    }

    /// Whether a shape, placed by `pose` in the frame of body B, comes within `margin` of B, or is inside it. As
    /// [`Query::within`].
    ///
    /// # Errors
    /// [`ToleranceError`] if `margin` is negative, infinite or NaN.
    pub fn within_shape<B: AsBvh>(
        &self,
        shape: &Shape,
        b: &B,
        pose: &Pose,
        margin: f64,
    ) -> Result<Answer, ToleranceError>
    where
        B::Node: Lanes,
        Shapes: PrimitivePair<B::Primitive>,
    {
        Ok(self.shape_within(&shape.moved(pose), &b.as_bvh(), checked(margin)?))
    }

    /// The distance of a shape, placed by `pose` in the frame of body B, from B, if it is below `cutoff`. As
    /// [`Query::distance_up_to`].
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN, or `cutoff` negative or NaN.
    pub fn distance_shape<B: AsBvh>(
        &self,
        shape: &Shape,
        b: &B,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, ToleranceError>
    where
        B::Node: Lanes,
        Shapes: PrimitivePair<B::Primitive>,
    {
        let tolerance = checked(tolerance)?.max(TIGHT);
        // Above zero, so that bodies that touch are nearer.
        let cutoff = if cutoff == f64::INFINITY { cutoff } else { checked(cutoff)?.max(f64::MIN_POSITIVE) };
        Ok(self.shape_distance(&shape.moved(pose), &b.as_bvh(), tolerance, cutoff))
    }

    /// Calls `visit` with each primitive of body B that meets a shape, placed by `pose` in the frame of B, until it
    /// breaks; in the pairs, `a` is 0. As [`Query::for_each_pair`].
    pub fn for_each_pair_shape<B: AsBvh>(
        &self,
        shape: &Shape,
        b: &B,
        pose: &Pose,
        mut visit: impl FnMut(Pair) -> ControlFlow<()>,
    ) -> (Completion, QueryStats)
    where
        B::Node: Lanes,
        Shapes: PrimitivePair<B::Primitive>,
    {
        let (shape, tree, mut stats) = (shape.moved(pose), b.as_bvh(), QueryStats::default());
        let volume = Volume::of(&shape, &tree);
        let visit = &mut |index| visit(Pair { a: 0, b: tree.source(index) });
        let completion = self.for_each_near_shape(&shape, &volume, &tree, 0.0, &mut stats, visit);
        (completion, stats)
    }

    /// Calls `visit` with the index, in leaf order, of each primitive that meets a shape in the tree's frame, until it
    /// breaks.
    #[inline(never)]
    pub(in crate::query) fn for_each_met_by_shape<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        tree: &BvhRef<'_, N, Q>,
        stats: &mut QueryStats,
        visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
    ) -> Completion
    where
        Shapes: PrimitivePair<Q>,
    {
        self.for_each_near_shape(shape, &Volume::of(shape, tree), tree, 0.0, stats, visit)
    }

    // Not inlined: scenes without shapes should not pay for its stack frame.
    #[inline(never)]
    pub(in crate::query) fn shape_within<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        tree: &BvhRef<'_, N, Q>,
        margin: f64,
    ) -> Answer
    where
        Shapes: PrimitivePair<Q>,
    {
        let mut stats = QueryStats::default();
        let volume = Volume::of(shape, tree);
        let mut verdict = Verdict::Free;
        let completion = self.for_each_near_shape(shape, &volume, tree, margin, &mut stats, &mut |index| {
            verdict = Verdict::Hit(Pair { a: 0, b: tree.source(index) });
            ControlFlow::Break(())
        });
        if completion == Completion::OutOfBudget {
            verdict = Verdict::Unknown { lower: 0.0, upper: volume.farthest(shape, tree) };
        }
        if verdict == Verdict::Free
            && let Some(inside) = self.shape_inside(shape, tree, &mut stats)
        {
            verdict = match inside {
                Ok(index) => Verdict::Hit(Pair { a: 0, b: tree.source(index) }),
                Err(upper) => Verdict::Unknown { lower: 0.0, upper },
            };
        }
        Answer { verdict, stats, hint: Hint::NONE }
    }

    // Not inlined: scenes without shapes should not pay for its stack frame.
    #[inline(never)]
    pub(in crate::query) fn shape_distance<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        tree: &BvhRef<'_, N, Q>,
        tolerance: f64,
        cutoff: f64,
    ) -> Distance
    where
        Shapes: PrimitivePair<Q>,
    {
        let mut stats = QueryStats::default();
        let volume = Volume::of(shape, tree);
        let nearest = self.nearest_to_shape(shape, &volume, tree, (tolerance, cutoff), &mut stats);
        let mut distance = Distance {
            lower: nearest.lower,
            upper: f64::INFINITY,
            witness: None,
            completion: if nearest.is_complete { Completion::Complete } else { Completion::OutOfBudget },
            stats,
            hint: Hint::NONE,
        };
        if let Some((index, found)) = nearest.found {
            distance.upper = found.upper;
            distance.witness =
                Some(Witness { pair: Pair { a: 0, b: tree.source(index) }, a: found.a, b: found.b });
        }
        if distance.upper > 0.0
            && distance.completion == Completion::Complete
            && let Some(inside) = self.shape_inside(shape, tree, &mut distance.stats)
        {
            distance.lower = 0.0;
            match inside {
                Ok(index) => {
                    let point = Shapes::point(shape);
                    distance.upper = 0.0;
                    distance.witness =
                        Some(Witness { pair: Pair { a: 0, b: tree.source(index) }, a: point, b: point });
                }
                Err(_) => distance.completion = Completion::OutOfBudget,
            }
        }
        distance
    }

    /// Bounds of the distance of a point from the primitives of a tree, and the nearest points, with the given one as
    /// A's. `None` if the budget was spent, `Some(None)` if the tree is empty.
    pub(in crate::query) fn nearest_on_surface<N: Lanes, Q: Primitive>(
        &self,
        point: &Point,
        tree: &BvhRef<'_, N, Q>,
        stats: &mut QueryStats,
    ) -> Option<Option<Separation>>
    where
        Shapes: PrimitivePair<Q>,
    {
        let shape = Shape::unchecked(Core::Point(*point), 0.0);
        let limits = (NEAR, f64::INFINITY);
        let found = self.nearest_to_shape(&shape, &Volume::of(&shape, tree), tree, limits, stats);
        found
            .is_complete
            .then(|| found.found.map(|(_, nearest)| Separation { lower: found.lower, ..nearest }))
    }

    /// If a shape that meets no primitive is inside a solid: the crossed primitive to report, or an upper bound of the
    /// distance if the budget was spent.
    fn shape_inside<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        tree: &BvhRef<'_, N, Q>,
        stats: &mut QueryStats,
    ) -> Option<Result<u32, f64>>
    where
        Shapes: PrimitivePair<Q>,
    {
        // A half-space is inside no bounded body.
        if !tree.is_solid() || tree.is_empty() || shape.is_half_space() {
            return None;
        }
        let inside = self.inside_of_solid(tree, &Shapes::point(shape), stats).transpose();
        inside.or_else(|| tree.has_caps().then(|| self.shape_on_caps(shape, tree, stats)).flatten())
    }

    /// If a shape meets a cap of a solid, and so is partly inside: a primitive at the border of the hole. An error if
    /// the budget was spent.
    #[cold]
    fn shape_on_caps<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        solid: &BvhRef<'_, N, Q>,
        stats: &mut QueryStats,
    ) -> Option<Result<u32, f64>>
    where
        Shapes: PrimitivePair<Q>,
    {
        let caps = solid.caps()?;
        let (volume, mut found) = (Volume::of(shape, &caps), None);
        let completion = self.for_each_near_shape(shape, &volume, &caps, 0.0, stats, &mut |cap| {
            found = Some(Ok(caps.source(cap)));
            ControlFlow::Break(())
        });
        if completion == Completion::OutOfBudget { Some(Err(volume.farthest(shape, solid))) } else { found }
    }
}

/// Queries of two shapes, for bodies that are shapes.
impl Query {
    // Inlined, so that a caller pays only for the parts of an answer that it reads.
    #[inline]
    pub(crate) fn shapes_within(&self, a: &Shape, pose: &Pose, b: &Shape, margin: f64) -> Answer {
        let mut stats = QueryStats { primitive_pairs: 1, ..QueryStats::default() };
        let is_near = is_near_posed(a, pose, b, margin, &mut stats.exact_pairs);
        let verdict = if is_near { Verdict::Hit(Pair { a: 0, b: 0 }) } else { Verdict::Free };
        Answer { verdict, stats, hint: Hint::NONE }
    }

    // Inlined, so that a caller pays only for the parts of an answer that it reads.
    #[inline]
    pub(crate) fn shapes_distance(
        &self,
        a: &Shape,
        pose: &Pose,
        b: &Shape,
        tolerance: f64,
        cutoff: f64,
    ) -> Distance {
        let mut stats = QueryStats { primitive_pairs: 1, ..QueryStats::default() };
        let tolerance = if tolerance > TIGHT { tolerance } else { TIGHT };
        let found = nearer_posed(a, pose, b, cutoff, tolerance, &mut stats.exact_pairs)
            .filter(|found| found.upper <= cutoff);
        Distance {
            lower: found.map_or(cutoff, |found| found.lower),
            upper: found.map_or(f64::INFINITY, |found| found.upper),
            witness: found.map(|found| Witness { pair: Pair { a: 0, b: 0 }, a: found.a, b: found.b }),
            completion: Completion::Complete,
            stats,
            hint: Hint::NONE,
        }
    }
}
