//! Collision of one shape with the points of a cloud.

use super::CloudRef;
use super::body::{Ended, NearPoint, ROUNDING, Spending, points_of};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Box3;
use crate::primitive::Shape;
use crate::primitive::shape::{Core, hull_of, is_near};
use crate::query::{Answer, Hint, Pair, Query, QueryStats, Verdict};
use core::ops::ControlFlow;

impl CloudRef<'_> {
    /// Whether a shape in the cloud's frame comes within `margin` of a point. Touching counts. In the answer, `b` is
    /// the point.
    // Not inlined: scenes without clouds should not pay for its stack frame.
    #[inline(never)]
    pub(crate) fn shape_within(&self, query: &Query, shape: &Shape, margin: f64) -> Answer {
        let mut stats = QueryStats::default();
        let verdict = match self.near_shape(query, shape, margin, &mut stats) {
            None => Verdict::Free,
            Some(Ended::Near(near)) => Verdict::Hit(Pair { a: 0, b: near.point }),
            Some(Ended::OutOfBudget) => Verdict::Unknown { lower: 0.0, upper: f64::INFINITY },
        };
        Answer { verdict, stats, hint: Hint::NONE }
    }

    /// The first point within a margin of a shape, in the order of the buckets.
    pub(super) fn near_shape(
        &self,
        query: &Query,
        shape: &Shape,
        margin: f64,
        stats: &mut QueryStats,
    ) -> Option<Ended> {
        let bounds = bounds(shape, margin);
        let mut spending = Spending { stats, budget: query.budget() };
        on_isa!(query.isa(), kernel => kernel.run(
            #[inline(always)]
            || self.first_of_buckets(kernel, &bounds, &mut spending, |bucket, spending| {
                spending.visit()?;
                for (point, at) in points_of(bucket) {
                    spending.stats.primitive_pairs += 1;
                    let of_point = Shape::unchecked(Core::Point(at.centre), 0.0);
                    if is_near(shape, &of_point, margin, &mut spending.stats.exact_pairs) {
                        return ControlFlow::Break(Ended::Near(NearPoint { primitive: 0, point, at }));
                    }
                }
                ControlFlow::Continue(())
            }),
        ))
    }
}

/// A box around everything within a margin of a shape. Of a half-space, everything.
fn bounds(shape: &Shape, margin: f64) -> Box3 {
    let mut around = Box3 { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };
    if let Core::HalfSpace { .. } = shape.core() {
        return Box3 { lower: around.upper, upper: around.lower };
    }
    let (corners, radius) = hull_of(shape);
    let reach = radius + margin;
    for p in corners {
        for (i, x) in p.into_iter().enumerate() {
            let side = reach + ROUNDING * (x.abs() + reach);
            around.lower[i] = around.lower[i].min(((x - side) as f32).next_down());
            around.upper[i] = around.upper[i].max(((x + side) as f32).next_up());
        }
    }
    around
}
