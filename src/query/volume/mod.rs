//! Penetration of two bodies of spheres: their common volume.
//!
//! Weller and Zachmann, *Inner Sphere Trees for Proximity and Penetration Queries*, RSS 2009. The spheres of a packing
//! are disjoint, so the common volume of two packings is the sum of the lenses that pairs of their spheres share. It is
//! continuous in the pose, and grows where a distance would be zero.

mod balls;
mod lens;
mod penetration;
mod queue;

pub use penetration::Penetration;
pub use queue::PENETRATION_QUEUE_BYTES;

use super::entry::{Query, QueryStats};
use super::lanes::Lanes;
use super::setup::{Touching, are_apart};
use crate::exact::power_of_two;
use crate::hierarchy::{AsBvh, BvhRef};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Node;
use crate::pose::Pose;
use crate::primitive::{Primitive, Spheres};
use crate::realign::BallMap;
use balls::{BallSearch, Rest};
use core::ops::ControlFlow;
use lens::{LensSums, Outlook};

impl Query {
    /// The common volume of two bodies of spheres, with body `a` placed by `pose` in the frame of body `b`, and the
    /// direction in which they would separate. Zero if and only if no spheres overlap: touching spheres share no
    /// volume.
    ///
    /// The sums do not depend on the order in which pairs are found: they have the same bits on every instruction set,
    /// with and without balls.
    ///
    /// With a [budget](Query::with_budget), the pairs that may share the most volume are visited first, so that the
    /// bounds (`volume` from below, `upper` from above) and the `estimate` between them converge quickly. Without one,
    /// the search is depth first, which is faster. The hint is ignored.
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

    /// Depth first, or best first. Two functions, since only best first needs room for the queue on its stack.
    #[inline(never)]
    fn search_balls<N: Node, const BEST_FIRST: bool>(
        &self,
        trees: (&BvhRef<'_, N, Spheres>, &BvhRef<'_, N, Spheres>),
        (pose, map): (&Pose, &BallMap),
        sums: &mut LensSums,
        stats: &mut QueryStats,
    ) -> Option<Rest> {
        on_isa!(self.isa(), token => token.run(
            #[inline(always)]
            || {
                let (a, b) = trees;
                let mut search = BallSearch::new(token, (*a, *b), pose, map, self.budget(), (stats, sums));
                if BEST_FIRST {
                    search.best_first().break_value()
                } else {
                    // Only a budget can break the search.
                    let _ = search.all();
                    None
                }
            },
        ))
    }

    /// Adds up all pairs found by the balls of two trees. If the budget is spent, returns bounds of the whole volume.
    fn by_balls<N: Node>(
        &self,
        a: &BvhRef<'_, N, Spheres>,
        b: &BvhRef<'_, N, Spheres>,
        pose: &Pose,
        sums: &mut LensSums,
        stats: &mut QueryStats,
    ) -> Option<Outlook> {
        let map = BallMap::new(pose, &a.extent(), &b.extent())?;
        let rest = if self.budget() == u64::MAX {
            self.search_balls::<N, false>((a, b), (pose, &map), sums, stats)
        } else {
            self.search_balls::<N, true>((a, b), (pose, &map), sums, stats)
        };
        let Rest { known, bound, expected } = rest?;
        // A pose may move A's spheres nearer to each other, since its matrix may deviate from a rotation. Each sphere
        // then overlaps others by at most three times the deviation, as a fraction of its volume.
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
