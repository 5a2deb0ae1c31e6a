//! A body among points: a robot's spheres or its meshes, in a scan of what is around it.

use super::search::RangeDescent;
use super::{CloudRef, RangeCounters, RangeSearch, SearchError};
use crate::exact::power_of_two;
use crate::hierarchy::{AsBvh, BvhRef, MAX_DEPTH};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::{Aabb16, Box3, Bucket, Child, Link};
use crate::pose::Pose;
use crate::primitive::{Primitive, Sphere, Spheres};
use crate::query::{Lanes, Pairwise};
use crate::range::{MIN_COORDINATE, Point};
use crate::realign::greatest;
use core::ops::ControlFlow;

/// A primitive of a body and a point of a cloud that are near each other.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Contact {
    /// The primitive, by its index in what the body was built of.
    pub primitive: u32,
    /// The point, by its index.
    pub point: u32,
}

/// Lanes that wait: of each level all but the one that was entered.
const STACK: usize = MAX_DEPTH * 15 + 16;

/// More than what a dozen roundings in `f64` do to a number, relatively.
const ROUNDING: f64 = power_of_two(-44);

impl RangeSearch {
    /// Whether a body, placed by `pose` in the frame of the cloud, has a point of the cloud within `margin`, and if so, which:
    /// the first in the order of the tree's buckets. Touching counts; a sphere is solid, a mesh is a surface.
    ///
    /// The verdict is exact for the points as they are and the body's corners, or centres, as [`Pose::apply`] moves them, like
    /// those of [`Query::within`](crate::query::Query::within). Not in `f32`: unlike the other searches, this one does not round
    /// distances.
    ///
    /// ```
    /// use simdop::cloud::{Cloud, Contact, RangeSearch};
    /// use simdop::construct::{Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, isa::Isa, node::Node16, pose::Pose};
    ///
    /// let arm = [0.0, 0.3, 0.6].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 0.1 });
    /// let arm: Bvh<Node16<18>, Spheres> = Builder::new()
    ///     .build_geometry(&SphereSet { spheres: &arm }, &mut |_| core::ops::ControlFlow::Continue(()))?;
    /// let scan = Cloud::new(&[[1.0, 0.0, 0.5], [0.6, 0.25, 0.0]])?;
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
        B::Primitive: Pairwise<Spheres>,
    {
        if !(margin >= 0.0 && margin.is_finite()) {
            return Err(SearchError::Radius { query: 0 });
        }
        let body = body.as_bvh();
        if body.is_empty() {
            return Ok(None);
        }
        let around = Around::new(&body, pose, margin);
        Ok(on_isa!(self.isa, kernel => kernel.run(
            #[inline(always)]
            || {
                let mut descent = RangeDescent { kernel, cloud: *cloud, work: RangeCounters::default() };
                let mut turned = B::Node::NO_TURNED;
                let mut contact = None;
                // What overlaps the box has no gap.
                let _ = descent.go_down(&around.bounds, 0.0, |this, _: &Aabb16, _, bucket| {
                    let bucket = &this.cloud.buckets[bucket as usize];
                    contact = around.bucket(kernel, bucket, &mut turned);
                    if contact.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                });
                contact
            },
        )))
    }
}

/// A body at a pose, and what is around it.
struct Around<'a, N, P: Primitive> {
    body: &'a BvhRef<'a, N, P>,
    pose: &'a Pose,
    margin: f64,
    /// Holds all points within the margin.
    bounds: Box3,
    /// How far a point may be from a volume of the body's tree, in its frame and unit, if it is within the margin of what the
    /// volume holds; but for what is relative to the point's own coordinates.
    reach: f64,
}

impl<'a, N: Lanes, P: Pairwise<Spheres>> Around<'a, N, P> {
    fn new(body: &'a BvhRef<'a, N, P>, pose: &'a Pose, margin: f64) -> Self {
        let (extent, m, t) = (body.extent(), pose.rows(), pose.translation());
        let (skew, most) = (pose.skew(), extent.max_coordinate);
        let unscale = 1.0 / extent.frame.scale();
        // Where p of the body is moved to M p + t, and q is within r of that, transpose(M) (q - t) is within (1 + skew) r
        // + skew |p| of p. A radius is no longer than the largest coordinate, nor |p| than twice that.
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

    /// The first point of a bucket that is within the margin, and what it is near.
    #[inline(always)]
    fn bucket<E: Kernel>(&self, kernel: E, bucket: &Bucket, turned: &mut N::Turned) -> Option<Contact> {
        let point = |slot: usize| Sphere { centre: bucket.point(slot).map(f64::from), radius: 0.0 };
        let used = bucket.used();
        let slots = (0..16).filter(|&slot| used >> slot & 1 != 0);
        let far = slots.clone().map(|slot| greatest(&point(slot).centre)).fold(0.0, f64::max);
        let seen_from_body =
            |slot: usize| Sphere { centre: self.seen_from_body(point(slot).centre), radius: 0.0 };
        let frame = self.body.frame();
        N::aim::<Spheres>(
            turned,
            &frame,
            slots.clone().map(seen_from_body),
            self.reach + 4.0 * ROUNDING * far,
        );
        let (nodes, mut stack, mut waiting) = (self.body.nodes(), [Child::EMPTY; STACK], 1);
        stack[0] = self.body.header().root;
        let mut contact = None;
        while waiting > 0 && contact.is_none() {
            waiting -= 1;
            match stack[waiting].link() {
                Link::Inner(node) => {
                    let node = &nodes[node as usize];
                    let mut left = node.overlap_rows(kernel, turned, 1).0.rows[0];
                    while left != 0 {
                        stack[waiting] = node.children()[left.trailing_zeros() as usize];
                        waiting += 1;
                        left &= left - 1;
                    }
                }
                Link::Leaf { first, count } => {
                    for i in first..first + count {
                        let moved = P::moved(&self.body.primitive(i), self.pose);
                        let is_near = |slot: usize| self.is_near(&moved, &point(slot));
                        if let Some(slot) = slots.clone().find(|slot| is_near(*slot)) {
                            contact =
                                Some(Contact { primitive: self.body.source(i), point: bucket.indices[slot] });
                            break;
                        }
                    }
                }
                Link::Empty => {}
            }
        }
        contact
    }

    #[inline(always)]
    fn is_near(&self, moved: &P::Item, point: &Sphere) -> bool {
        let mut exact = 0;
        if self.margin > 0.0 {
            P::within(moved, point, self.margin, &mut exact)
        } else {
            P::meets(&P::probe(moved, 0.0), point, &mut exact)
        }
    }

    /// Where a point is, seen from the body.
    #[inline(always)]
    fn seen_from_body(&self, q: Point) -> Point {
        let (m, t) = (self.pose.rows(), self.pose.translation());
        let d = [q[0] - t[0], q[1] - t[1], q[2] - t[2]];
        [0, 1, 2].map(|j| (m[0][j] * d[0] + m[1][j] * d[1]) + m[2][j] * d[2])
    }
}
