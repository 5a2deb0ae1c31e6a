//! The queries of a shape and a tree in a depth search.
//!
//! The largest ball about a point inside a convex shape has the point's depth in it as radius.

use super::bodies::slack;
use super::interval::OutOfBudget;
use super::overlaps::{DeepestPrimitives, beneath};
use super::posed_pair::{PosedPair, Seed, Shared, finished, gap_of, spend, verdict_of, widened};
use crate::hierarchy::BvhRef;
use crate::pose::Pose;
use crate::primitive::shape::{Core, depth};
use crate::primitive::{Primitive, Shape, Shapes};
use crate::query::entry::{Hint, PrimitivePair, Query, QueryStats};
use crate::query::lanes::Lanes;
use crate::range::{MAX_COORDINATE, Point};
use crate::vector::{difference, length, unit};

/// Tolerance of a ball inside a shape.
const TOLERANCE: f64 = crate::exact::power_of_two(-20);

pub(super) struct PosedShape<'t, N: Lanes, Q: Primitive> {
    query: Query,
    /// In the tree's frame; bounded.
    shape: &'t Shape,
    /// [`Shape::ball`].
    ball: (Point, f64),
    tree: &'t BvhRef<'t, N, Q>,
    /// The bodies count as meeting up to this distance.
    margin: f64,
    stats: QueryStats,
}

impl<'t, N: Lanes, Q: Primitive> PosedShape<'t, N, Q> {
    pub(super) fn new(query: &Query, shape: &'t Shape, tree: &'t BvhRef<'t, N, Q>, margin: f64) -> Self {
        let (query, stats) = (query.with_hint(Hint::NONE), QueryStats::default());
        Self { query, shape, ball: shape.ball(), tree, margin, stats }
    }
}

/// The shape after a translation; `None` if it is out of range.
pub(super) fn translated(shape: &Shape, t: &Point) -> Option<Shape> {
    let moved = shape.moved(&Pose::IDENTITY.shifted(t));
    let is_in_range = |p: &Point| p.iter().all(|x| x.abs() <= MAX_COORDINATE);
    (is_in_range(t) && is_in_range(&Shapes::point(&moved))).then_some(moved)
}

impl<N: Lanes, Q: Primitive> PosedShape<'_, N, Q>
where
    Shapes: PrimitivePair<Q>,
{
    /// The primitive that the shape penetrates the deepest after a translation, among the first few hundred that it
    /// meets.
    fn deepest_primitive(&mut self, t: &Point) -> Result<DeepestPrimitives, OutOfBudget> {
        let (tree, mut deepest) = (self.tree, DeepestPrimitives::new());
        let Some(shape) = translated(self.shape, t) else { return Ok(deepest) };
        let completion = self.query.for_each_met_by_shape(&shape, tree, &mut self.stats, &mut |index| {
            deepest.offer::<Shapes, Q>((0, &shape), (index, &tree.primitive(index)));
            deepest.go_on()
        });
        finished(completion)?;
        spend(&self.query, &mut self.stats, deepest.computed)?;
        Ok(deepest)
    }

    /// The radius plus the margin; 0 if the radius is not positive.
    fn with_margin(&self, radius: f64) -> f64 {
        if radius > 0.0 { radius + self.margin } else { 0.0 }
    }

    fn slack(&self, t: &Point) -> f64 {
        let (centre, reach) = self.ball;
        slack((length(&centre) + reach) + self.tree.extent().max_coordinate, t)
    }

    /// The balls about a point of the shape before the translation.
    fn shared(
        &mut self,
        point: &Point,
        t: &Point,
        is_unknown: [bool; 2],
    ) -> Result<Option<Shared>, OutOfBudget> {
        let of_shape = depth(&Shape::unchecked(Core::Point(*point), 0.0), self.shape, TOLERANCE);
        let moved = core::array::from_fn(|i| point[i] + t[i]);
        let Some(in_b) = self.query.inside(self.tree, &moved, is_unknown[1], &mut self.stats)? else {
            return Ok(None);
        };
        let Some(from_b) = unit(&in_b.inwards).filter(|_| of_shape.lower > 0.0) else {
            return Ok(None);
        };
        let from_a = of_shape.direction.map(|x| -x);
        let slack = self.slack(t);
        Ok(Some(Shared {
            radius: of_shape.lower + in_b.radius - slack,
            point: *point,
            inwards: [from_b, from_a],
            radii: [of_shape.lower - slack, in_b.radius - slack],
        }))
    }
}

impl<N: Lanes, Q: Primitive> PosedPair for PosedShape<'_, N, Q>
where
    Shapes: PrimitivePair<Q>,
{
    fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget> {
        let Some(shape) = translated(self.shape, t) else { return Ok(false) };
        let answer = self.query.after(&self.stats).shape_within(&shape, self.tree, self.margin);
        self.stats = self.stats.and(&answer.stats);
        verdict_of(&answer)
    }

    fn gap(&mut self, t: &Point, tolerance: f64) -> Result<Option<(f64, Point)>, OutOfBudget> {
        let Some(shape) = translated(self.shape, t) else { return Ok(None) };
        let found = self.query.after(&self.stats).shape_distance(&shape, self.tree, tolerance, f64::INFINITY);
        self.stats = self.stats.and(&found.stats);
        gap_of(&found, self.margin)
    }

    fn far(&self) -> f64 {
        let (centre, reach) = self.ball;
        let tree = self.tree.extent();
        let apart = length(&difference(&centre, &tree.frame.centre));
        1.01 * (reach + tree.radius + apart + self.margin)
    }

    fn forbidden(
        &mut self,
        t: &Point,
        seed: Option<Seed>,
        steps: usize,
        _: f64,
    ) -> Result<(f64, Option<Shared>), OutOfBudget> {
        if !self.tree.is_solid() {
            let deepest = self.deepest_primitive(t)?.depth.lower - self.slack(t);
            return Ok((self.with_margin(deepest), None));
        }
        let (centre, _) = self.ball;
        let back = difference(&self.tree.extent().frame.centre, t);
        let middle = core::array::from_fn(|i| 0.5 * (centre[i] + back[i]));
        let mut best: Option<Shared> = None;
        for point in [seed.map(|seed| seed.point), Some(centre), Some(middle)].into_iter().flatten() {
            if let Some(found) = self.shared(&point, t, [true; 2])?
                && best.is_none_or(|best| found.radius > best.radius)
            {
                best = Some(found);
            }
        }
        let mut known = 0.0;
        if best.is_none() {
            let deepest = self.deepest_primitive(t)?;
            known = deepest.depth.lower - self.slack(t);
            if known > 0.0 {
                let moved = core::array::from_fn(|i| centre[i] + t[i]);
                let below = beneath::<Q>(&moved, &self.tree.primitive(deepest.b), &deepest.depth, -0.5);
                let below = below.map(|p| difference(&p, t));
                best = below.map(|point| self.shared(&point, t, [true; 2])).transpose()?.flatten();
            }
        }
        let Some(start) = best else { return Ok((self.with_margin(known), None)) };
        let found = widened(start, steps, |v| *v, |point, is_unknown| self.shared(point, t, is_unknown))?;
        Ok((f64::max(found.radius, known) + self.margin, Some(found)))
    }

    fn stats(&self) -> QueryStats {
        self.stats
    }

    fn spend(&mut self, visits: u64) -> Result<(), OutOfBudget> {
        spend(&self.query, &mut self.stats, visits)
    }
}
