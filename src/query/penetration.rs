//! How deep two bodies of spheres are in each other: the volume that they have in common.
//!
//! Weller and Zachmann, *Inner Sphere Trees for Proximity and Penetration Queries*, RSS 2009. The spheres of a packing
//! are disjoint, so what two packings have in common is the sum of what each of their spheres has in common with each
//! of the other's: lenses. It is continuous in the pose, and grows where a distance is zero.

use super::balls::{BallSearch, Rest};
use super::lens::{LensSums, Outlook};
use super::placing::Touching;
use super::reject::are_apart;
use super::{Completion, Lanes, Query, QueryStats};
use crate::exact::power_of_two;
use crate::hierarchy::{AsBvh, BvhRef};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Node;
use crate::pose::Pose;
use crate::primitive::{Primitive, Spheres};
use crate::range::Point;
use crate::realign::BallMap;
use core::ops::ControlFlow;

/// What two bodies of spheres have in common.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Penetration {
    /// The sum over all pairs of spheres of the volume that the two share, in the bodies' unit to the third. Where the
    /// spheres of a body overlap each other, what is covered twice counts twice.
    ///
    /// Of packings: the volume that they have in common. What the meshes that they fill have in common is not less, and
    /// not more than this and what each of the packings leaves of its mesh uncovered, added up: wherever both meshes are
    /// and not both packings, one of them has no sphere. What is uncovered is
    /// [`Packing::volume`](crate::packing::Packing::volume) less the last of
    /// [`Packing::shares`](crate::packing::Packing::shares) of it, where the mesh does not overlap itself. A packing that
    /// covers 82 % of a mesh lacks 18 % of its volume in its own place, half of this bound.
    ///
    /// In `f64`: a lens is right to some 1e-15 of the smaller of its spheres, times how much larger the other one is.
    pub volume: f64,
    /// Not below the volume of a complete search, where neither body's spheres overlap each other, as those of packings do
    /// not: the same as `volume` if the search was complete. Else with what the spheres in all volumes that wait share
    /// at most. What the meshes of packings have in common may be more by what these leave uncovered, as of `volume`.
    /// Infinite for trees without balls ([`crate::construct::Builder::without_balls`]) and for those of arity 4.
    pub upper: f64,
    /// What the volume of a complete search probably is, if that is not known: `volume` and what waits, as if spheres were
    /// spread evenly in the balls that hold them. Not a bound, but between `volume` and `upper`, and nearer than both:
    /// with a tenth of the visits, of packings of 2,000 and 10,000 spheres, 2 to 5 % off in the median, and far too large
    /// where little is shared (`benches/results/spheres.md`). Without balls, and before the first visit, `volume`.
    pub estimate: f64,
    /// Where A is pushed: the mean, weighted by volume, of the unit vectors from the centres of B's spheres to those of
    /// A's. As long as 1 if all agree, shorter the less they do.
    pub direction: Point,
    /// The mean, weighted by volume, of the middles of the lenses, in B's frame and unit. `None` if no two spheres
    /// share a volume.
    pub point: Option<Point>,
    /// The pairs of spheres that meet.
    pub pairs: u64,
    /// Unless [`Completion::Complete`], pairs are missing: the volume is a lower bound, and direction and point are those of
    /// the pairs that were found.
    pub completion: Completion,
    /// The work.
    pub stats: QueryStats,
}

impl Query {
    /// How much of their volume two bodies of spheres have in common, body `a` placed by `pose` in the frame of body
    /// `b`, and where they would part. Zero if and only if no spheres overlap: those that touch share no volume.
    ///
    /// The sums do not depend on the order in which pairs are found: the same bits on every instruction set, with and
    /// without balls.
    ///
    /// With a [budget](Query::with_budget), what may share the most volume is looked at first, so that the bounds close in
    /// soon: `volume` from below and `upper` from above, and between them `estimate`. Without one, depth first, which is faster. A hint is not heeded.
    ///
    /// ```
    /// use core::ops::ControlFlow;
    /// use simdop::construct::{Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, isa::Isa, node::Node16, pose::Pose, query::Query};
    ///
    /// let ball = SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 1.0 }] };
    /// let body: Bvh<Node16<18>, Spheres> =
    ///     Builder::new().build_geometry(&ball, &mut |_| ControlFlow::Continue(()))?;
    /// let to_the_right = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    /// let found = Query::new(Isa::detect()).penetration(&body, &body, &to_the_right);
    /// assert!((found.volume - 5.0 / 12.0 * core::f64::consts::PI).abs() < 1e-15);
    /// assert_eq!((found.direction, found.point), ([1.0, 0.0, 0.0], Some([0.5, 0.0, 0.0])));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn penetration<A, B>(&self, a: &A, b: &B, pose: &Pose) -> Penetration
    where
        A: AsBvh<Primitive = Spheres, Node: Lanes>,
        B: AsBvh<Primitive = Spheres, Node = A::Node>,
    {
        let is_far = are_apart(a.header(), b.header(), pose, 0.0);
        let (a, b) = (a.as_bvh(), b.as_bvh());
        let mut sums = LensSums::new(&a.frame(), &b.frame(), pose);
        let mut stats = QueryStats::default();
        if is_far {
            return sums.finish(None, stats);
        }
        if !a.balls().is_empty() && !b.balls().is_empty() {
            let rest = self.by_balls(&a, &b, pose, &mut sums, &mut stats);
            return sums.finish(rest, stats);
        }
        let stop = self.run((&a, &b), pose, Touching, &mut stats, &mut |found| {
            sums.add(&Spheres::moved(&a.primitive(found.a), pose), &b.primitive(found.b));
            ControlFlow::Continue(())
        });
        sums.finish(stop.map(|_| Outlook { estimate: 0.0, upper: f64::INFINITY }), stats)
    }

    /// Depth first, or what may share the most first. Two functions, of which only the second has room for what waits on
    /// its stack.
    #[inline(never)]
    fn search_balls<N: Node, const BEST_FIRST: bool>(
        &self,
        trees: (&BvhRef<'_, N, Spheres>, &BvhRef<'_, N, Spheres>),
        (pose, map): (&Pose, &BallMap),
        sums: &mut LensSums,
        stats: &mut QueryStats,
    ) -> Option<Rest> {
        on_isa!(self.isa, token => token.run(
            #[inline(always)]
            || {
                let (a, b) = trees;
                let mut search = BallSearch::new(token, (*a, *b), pose, map, self.budget, (stats, sums));
                if BEST_FIRST {
                    search.best_first().break_value()
                } else {
                    // Without a budget nothing breaks it off.
                    let _ = search.all();
                    None
                }
            },
        ))
    }

    /// Adds up all pairs that the balls of two trees lead to. If the budget is spent, what is known of the whole volume.
    fn by_balls<N: Node>(
        &self,
        a: &BvhRef<'_, N, Spheres>,
        b: &BvhRef<'_, N, Spheres>,
        pose: &Pose,
        sums: &mut LensSums,
        stats: &mut QueryStats,
    ) -> Option<Outlook> {
        let map = BallMap::new(pose, &a.extent(), &b.extent())?;
        let rest = if self.budget == u64::MAX {
            self.search_balls::<N, false>((a, b), (pose, &map), sums, stats)
        } else {
            self.search_balls::<N, true>((a, b), (pose, &map), sums, stats)
        };
        let Rest { known, bound, expected } = rest?;
        // A pose may bring A's spheres nearer to each other, as much as its matrix is no rotation: of what so overlaps, each
        // of them has three times that share of its volume.
        let volume = |tree: &BvhRef<'_, N, Spheres>| {
            let unscale = 1.0 / tree.frame().scale();
            let lanes = tree.balls()[0].volume.iter().map(|x| f64::from(*x)).sum::<f64>();
            lanes * (unscale * unscale * unscale)
        };
        let unscale = 1.0 / b.frame().scale();
        let [bound, expected] = [bound, expected].map(|x| x * (unscale * unscale * unscale));
        let overlaps = 3.0 * pose.skew() * (1.0 + 2.0 * pose.skew()) * volume(a);
        let whole = f64::min(known + bound, f64::min(volume(a), volume(b)));
        let upper = (whole + overlaps) * (1.0 + power_of_two(-30));
        Some(Outlook { estimate: known + expected, upper })
    }
}
