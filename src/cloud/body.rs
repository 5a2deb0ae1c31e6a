//! Collision and proximity of a body (spheres or a mesh) with the points of a cloud, such as a scan.

use super::search::RangeDescent;
use super::{CloudRef, RangeSearch, RangeStats, SearchError};
use crate::exact::power_of_two;
use crate::hierarchy::{AsBvh, BvhRef, MAX_DEPTH};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::{Aabb16, Box3, Bucket, Child, Dop, Link};
use crate::pose::Pose;
use crate::primitive::{Primitive, Shape, Sphere, Spheres, radius_of};
use crate::query::{Answer, Hint, Lanes, Pair, PrimitivePair, Query, QueryStats, Verdict};
use crate::range::{MIN_COORDINATE, Point};
use crate::realign::greatest;
use crate::vector::{dot, sqrt};
use core::ops::ControlFlow;

/// A primitive of a body and a nearby point of a cloud.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Contact {
    /// Index of the primitive in the input that the body was built from.
    pub primitive: u32,
    /// Index of the point.
    pub point: u32,
}

/// A primitive of a body, by its index in leaf order, and a nearby point.
#[derive(Copy, Clone, Debug)]
pub(super) struct NearPoint {
    pub(super) primitive: u32,
    pub(super) point: u32,
    pub(super) at: Sphere,
}

impl NearPoint {
    /// The pair, by the indices in the input.
    pub(super) fn pair<N: Dop, P: Primitive>(&self, body: &BvhRef<'_, N, P>) -> Pair {
        Pair { a: body.source(self.primitive), b: self.point }
    }
}

/// Why a search ended early.
#[derive(Debug)]
pub(super) enum Ended {
    Near(NearPoint),
    OutOfBudget,
}

/// The work of a search and its budget in visits. A visit is a pair of a bucket and a node of the body.
pub(super) struct Spending<'c> {
    pub(super) stats: &'c mut QueryStats,
    pub(super) budget: u64,
}

impl Spending<'_> {
    #[inline(always)]
    pub(super) fn visit(&mut self) -> ControlFlow<Ended> {
        if self.stats.visits == self.budget {
            return ControlFlow::Break(Ended::OutOfBudget);
        }
        self.stats.visits += 1;
        ControlFlow::Continue(())
    }
}

/// Capacity of the stack: per level, every lane but the one that is entered.
const STACK: usize = MAX_DEPTH * 15 + 16;

/// A relative error larger than that of a dozen `f64` roundings.
pub(super) const ROUNDING: f64 = power_of_two(-44);

impl RangeSearch {
    /// Finds the first point of the cloud, in the order of the buckets, that is within `margin` of a body placed by
    /// `pose` in the cloud's frame. Returns it with a nearby primitive of the body, or `None` if no point is near.
    /// Touching counts. Spheres are solid balls. A mesh is a surface unless it is
    /// [solid](crate::construct::Builder::solid); points inside a solid count as near, each reported with one of the
    /// triangles that a ray from the point crosses.
    ///
    /// The verdict is exact for the stored points and for the body's vertices or centres as moved by [`Pose::apply`],
    /// as in [`Query::within`](crate::query::Query::within). Unlike the other searches, this one does not round
    /// distances to `f32`.
    ///
    /// ```
    /// use simdop::cloud::{PointCloud, Contact, RangeSearch};
    /// use simdop::construct::{Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, isa::Isa, node::Node16, pose::Pose};
    ///
    /// let arm = [0.0, 0.3, 0.6].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 0.1 });
    /// let arm: Bvh<Node16<18>, Spheres> = Builder::new()
    ///     .build_geometry(&SphereSet { spheres: &arm }, &mut |_| core::ops::ControlFlow::Continue(()))?;
    /// let scan = PointCloud::new(&[[1.0, 0.0, 0.5], [0.6, 0.25, 0.0]])?;
    /// let search = RangeSearch::new(Isa::detect());
    /// assert_eq!(search.body_within(&scan.view(), &arm, &Pose::IDENTITY, 0.125)?, None);
    /// let near = search.body_within(&scan.view(), &arm, &Pose::IDENTITY, 0.1875)?;
    /// assert_eq!(near, Some(Contact { primitive: 2, point: 1 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SearchError::Radius`] if the margin is negative, NaN or infinite.
    pub fn body_within<B: AsBvh>(
        &self,
        cloud: &CloudRef<'_>,
        body: &B,
        pose: &Pose,
        margin: f64,
    ) -> Result<Option<Contact>, SearchError>
    where
        B::Node: Lanes,
        B::Primitive: PrimitivePair<Spheres>,
    {
        let answer = cloud.body_within(&Query::new(self.isa), &body.as_bvh(), pose, checked(margin)?);
        Ok(answer.hit().map(|Pair { a, b }| Contact { primitive: a, point: b }))
    }

    /// Finds the first point of the cloud, in the order of the buckets, that is within `margin` of a shape placed by
    /// `pose` in the cloud's frame; `None` if no point is near. Touching points and points inside count. Works as
    /// [`RangeSearch::body_within`] with a body of one primitive, but needs no tree and also accepts half-spaces.
    ///
    /// # Errors
    /// [`SearchError::Radius`] if the margin is negative, NaN or infinite.
    pub fn shape_within(
        &self,
        cloud: &CloudRef<'_>,
        shape: &Shape,
        pose: &Pose,
        margin: f64,
    ) -> Result<Option<Contact>, SearchError> {
        let answer = cloud.shape_within(&Query::new(self.isa), &shape.moved(pose), checked(margin)?);
        Ok(answer.hit().map(|Pair { a, b }| Contact { primitive: a, point: b }))
    }
}

fn checked(margin: f64) -> Result<f64, SearchError> {
    let is_margin = margin >= 0.0 && margin.is_finite();
    if is_margin { Ok(margin) } else { Err(SearchError::Radius { query: 0 }) }
}

impl CloudRef<'_> {
    /// As [`RangeSearch::body_within`], within the budget of a query. In the answer, `a` is a primitive of the body
    /// and `b` a point. Visits count pairs of a node of the body and a bucket; kernel calls count tests of
    /// sixteen boxes of either tree, or of the points of a bucket.
    // Not inlined: scenes without clouds should not pay for its stack frame.
    #[inline(never)]
    pub(crate) fn body_within<N: Lanes, P: PrimitivePair<Spheres>>(
        &self,
        query: &Query,
        body: &BvhRef<'_, N, P>,
        pose: &Pose,
        margin: f64,
    ) -> Answer {
        let mut stats = QueryStats::default();
        let mut ended = self.surface_within(query, body, pose, margin, &mut stats);
        if ended.is_none() && body.is_solid() {
            ended = self.first_inside(query, body, pose, &mut stats);
        }
        let verdict = match ended {
            None => Verdict::Free,
            Some(Ended::Near(near)) => Verdict::Hit(near.pair(body)),
            Some(Ended::OutOfBudget) => Verdict::Unknown { lower: 0.0, upper: f64::INFINITY },
        };
        Answer { verdict, stats, hint: Hint::NONE }
    }

    /// The first point within a margin of the body's primitives.
    pub(super) fn surface_within<N: Lanes, P: PrimitivePair<Spheres>>(
        &self,
        query: &Query,
        body: &BvhRef<'_, N, P>,
        pose: &Pose,
        margin: f64,
        stats: &mut QueryStats,
    ) -> Option<Ended> {
        if body.is_empty() {
            return None;
        }
        let around = Around::new(body, pose, margin);
        let mut spending = Spending { stats, budget: query.budget() };
        on_isa!(query.isa(), kernel => kernel.run(
            #[inline(always)]
            || {
                let mut aimed = N::NO_AIMED;
                self.first_of_buckets(kernel, &around.bounds, &mut spending, |bucket, spending| {
                    around.bucket(kernel, bucket, &mut aimed, spending)
                })
            },
        ))
    }

    /// The first point inside a solid whose surface touches no point.
    pub(super) fn first_inside<N: Lanes, P: PrimitivePair<Spheres>>(
        &self,
        query: &Query,
        solid: &BvhRef<'_, N, P>,
        pose: &Pose,
        stats: &mut QueryStats,
    ) -> Option<Ended> {
        let (around, cloud) = (Around::new(solid, pose, 0.0), self.extent());
        let mut spending = Spending { stats, budget: query.budget() };
        on_isa!(query.isa(), kernel => kernel.run(
            #[inline(always)]
            || self.first_of_buckets(kernel, &around.bounds, &mut spending, |bucket, spending| {
                for (index, at) in points_of(bucket) {
                    let crossed = query.winds_around(solid, pose, &at.centre, &cloud, spending.stats);
                    match crossed {
                        Ok(None) => {}
                        Ok(Some(primitive)) => {
                            return ControlFlow::Break(Ended::Near(NearPoint { primitive, point: index, at }));
                        }
                        Err(_) => return ControlFlow::Break(Ended::OutOfBudget),
                    }
                }
                ControlFlow::Continue(())
            }),
        ))
    }

    /// Visits the buckets that overlap a box, in order, until `look` breaks.
    #[inline(always)]
    pub(super) fn first_of_buckets<E: Kernel>(
        &self,
        kernel: E,
        bounds: &Box3,
        spending: &mut Spending<'_>,
        mut look: impl FnMut(&Bucket, &mut Spending<'_>) -> ControlFlow<Ended>,
    ) -> Option<Ended> {
        let mut descent = RangeDescent { kernel, cloud: *self, work: RangeStats::default() };
        let mut ended = None;
        // The squared gap to an overlapping box is 0.
        let _ = descent.go_down(bounds, 0.0, |this, _: &Aabb16, _, bucket| {
            match look(&this.cloud.buckets[bucket as usize], spending) {
                ControlFlow::Continue(()) => ControlFlow::Continue(()),
                ControlFlow::Break(because) => {
                    ended = Some(because);
                    ControlFlow::Break(())
                }
            }
        });
        spending.stats.kernels += descent.work.boxes;
        ended
    }
}

/// The points of a bucket and their indices.
#[inline(always)]
pub(crate) fn points_of(bucket: &Bucket) -> impl Iterator<Item = (u32, Sphere)> + Clone + '_ {
    points_in(bucket, bucket.used())
}

/// The points in these slots of a bucket, and their indices.
#[inline(always)]
fn points_in(bucket: &Bucket, slots: u16) -> impl Iterator<Item = (u32, Sphere)> + Clone + '_ {
    (0..16).filter(move |&slot| slots >> slot & 1 != 0).map(|slot| {
        let at = Sphere { centre: bucket.point(slot).map(f64::from), radius: 0.0 };
        (bucket.indices[slot], at)
    })
}

/// A point, and a square that the kernel's squared distance from it does not exceed for points within a margin of a
/// primitive.
///
/// A point within the margin is at most the margin, the primitive's radius and the distance of the farthest corner
/// away. The factors cover the roundings of `f64`, and 8 of `f32`: in the kernel each coordinate of the difference is
/// rounded, squared and added. What underflows there is less than the smallest normal number.
#[inline(always)]
fn around<P: Primitive>(item: &P::Item, margin: f64) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in P::corners(item) {
        for k in 0..3 {
            low[k] = if corner[k] < low[k] { corner[k] } else { low[k] };
            high[k] = if corner[k] > high[k] { corner[k] } else { high[k] };
        }
    }
    let centre = [0, 1, 2].map(|k| (0.5 * (low[k] + high[k])) as f32);
    let mut farthest = 0.0;
    for corner in P::corners(item) {
        let d = [0, 1, 2].map(|k| corner[k] - f64::from(centre[k]));
        let square = dot(&d, &d);
        farthest = if square > farthest { square } else { farthest };
    }
    let reach = (sqrt(farthest) + radius_of::<P>(item)) + margin;
    let square = (reach * reach) * (1.0 + power_of_two(-20));
    (centre, (square as f32).next_up() + f32::MIN_POSITIVE)
}

/// A body at a pose, and bounds of its neighbourhood.
struct Around<'a, N, P: Primitive> {
    body: &'a BvhRef<'a, N, P>,
    pose: &'a Pose,
    margin: f64,
    /// Contains all points within the margin.
    bounds: Box3,
    /// Maximum distance, in the frame and unit of the body's tree, between a point and a volume of the tree that
    /// contains something within the margin of the point. Excludes the error relative to the point's own coordinates.
    reach: f64,
}

impl<'a, N: Lanes, P: PrimitivePair<Spheres>> Around<'a, N, P> {
    fn new(body: &'a BvhRef<'a, N, P>, pose: &'a Pose, margin: f64) -> Self {
        let (extent, m, t) = (body.extent(), pose.rows(), pose.translation());
        let (skew, most) = (pose.skew(), extent.max_coordinate);
        let unscale = 1.0 / extent.frame.scale();
        // The pose maps p of the body to M p + t. If q is within r of that, transpose(M) (q - t) is within (1 + skew)
        // r + skew |p| of p. A radius is at most the largest coordinate, and |p| at most twice that.
        let reach =
            margin * (1.0 + skew) + 3.0 * skew * most + ROUNDING * (most + greatest(&t)) + MIN_COORDINATE;
        let middle = pose.apply(extent.frame.centre);
        let sides = [0, 1, 2].map(|i| {
            let half = |j: usize| m[i][j].abs() * f64::from(extent.half_width[j]) * unscale;
            let side = (half(0) + half(1) + half(2)) * (1.0 + 2.0 * skew) + reach;
            side + ROUNDING * (greatest(&middle) + side)
        });
        let bounds = Box3 {
            lower: [0, 1, 2].map(|i| ((middle[i] - sides[i]) as f32).next_down()),
            upper: [0, 1, 2].map(|i| ((middle[i] + sides[i]) as f32).next_up()),
        };
        Self { body, pose, margin, bounds, reach }
    }

    /// The first point of a bucket within the margin, and the primitive that it is near.
    #[inline(always)]
    fn bucket<E: Kernel>(
        &self,
        kernel: E,
        bucket: &Bucket,
        aimed: &mut N::Aimed,
        spending: &mut Spending<'_>,
    ) -> ControlFlow<Ended> {
        let points = points_of(bucket);
        let far = points.clone().map(|(_, at)| greatest(&at.centre)).fold(0.0, f64::max);
        let seen_from_body =
            points.clone().map(|(_, at)| Sphere { centre: self.seen_from_body(at.centre), radius: 0.0 });
        let frame = self.body.frame();
        N::aim::<Spheres>(aimed, &frame, seen_from_body, self.reach + 4.0 * ROUNDING * far);
        let (nodes, mut stack, mut waiting) = (self.body.nodes(), [Child::EMPTY; STACK], 1);
        stack[0] = self.body.header().root;
        while waiting > 0 {
            waiting -= 1;
            match stack[waiting].link() {
                Link::Inner(node) => {
                    spending.visit()?;
                    let node = &nodes[node as usize];
                    let mut left = node.overlap_aimed(kernel, aimed);
                    spending.stats.kernels += 1;
                    while left != 0 {
                        stack[waiting] = node.children()[left.trailing_zeros() as usize];
                        waiting += 1;
                        left &= left - 1;
                    }
                }
                Link::Leaf { first, count } => {
                    for primitive in first..first + count {
                        let moved = P::moved(&self.body.primitive(primitive), self.pose);
                        let (centre, square) = around::<P>(&moved, self.margin);
                        let near = kernel.points_near(centre, square, bucket);
                        spending.stats.kernels += 1;
                        for (point, at) in points_in(bucket, near) {
                            if self.is_near(&moved, &at, spending.stats) {
                                return ControlFlow::Break(Ended::Near(NearPoint { primitive, point, at }));
                            }
                        }
                    }
                }
                Link::Empty => {}
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn is_near(&self, moved: &P::Item, point: &Sphere, stats: &mut QueryStats) -> bool {
        stats.primitive_pairs += 1;
        let exact = &mut stats.exact_pairs;
        if self.margin > 0.0 {
            P::within(moved, point, self.margin, exact)
        } else {
            P::meets(&P::probe(moved, 0.0), point, exact)
        }
    }

    /// A point, in the body's frame.
    #[inline(always)]
    fn seen_from_body(&self, q: Point) -> Point {
        let (m, t) = (self.pose.rows(), self.pose.translation());
        let d = [q[0] - t[0], q[1] - t[1], q[2] - t[2]];
        [0, 1, 2].map(|j| (m[0][j] * d[0] + m[1][j] * d[1]) + m[2][j] * d[2])
    }
}
