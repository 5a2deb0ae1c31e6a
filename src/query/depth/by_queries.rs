//! Depth of bodies that are known only by their queries, such as a cloud and a shape; and of half-spaces.

use super::beside_shape::translated;
use super::bodies::slack;
use super::interval::{DepthInterval, OutOfBudget};
use super::posed_pair::{PosedPair, Seed, Shared, gap_of, spend, verdict_of};
use super::search::interval;
use super::way_out;
use crate::frame::BodyBounds;
use crate::primitive::Shape;
use crate::primitive::shape::Core;
use crate::query::distance::Distance;
use crate::query::entry::{Answer, Completion, Query, QueryStats};
use crate::range::Point;
use crate::vector::{dot, length};

/// Two bodies, given by their queries after a translation. Each query gets the rest of the budget, and the distance
/// query a tolerance.
pub(crate) struct ByQueries<W, D> {
    pub(crate) query: Query,
    /// Whether the bodies come within the margin.
    pub(crate) within: W,
    pub(crate) distance: D,
    pub(crate) margin: f64,
    /// Length of a translation that separates the bodies in any direction.
    pub(crate) far: f64,
    pub(crate) stats: QueryStats,
}

impl<W: FnMut(&Query, &Point) -> Option<Answer>, D: FnMut(&Query, &Point, f64) -> Option<Distance>> PosedPair
    for ByQueries<W, D>
{
    fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget> {
        let Some(answer) = (self.within)(&self.query.after(&self.stats), t) else { return Ok(false) };
        self.stats = self.stats.and(&answer.stats);
        verdict_of(&answer)
    }

    fn gap(&mut self, t: &Point, tolerance: f64) -> Result<Option<(f64, Point)>, OutOfBudget> {
        let Some(found) = (self.distance)(&self.query.after(&self.stats), t, tolerance) else {
            return Ok(None);
        };
        self.stats = self.stats.and(&found.stats);
        gap_of(&found, self.margin)
    }

    fn far(&self) -> f64 {
        self.far
    }

    fn forbidden(
        &mut self,
        _: &Point,
        _: Option<Seed>,
        _: usize,
        _: f64,
    ) -> Result<(f64, Option<Shared>), OutOfBudget> {
        Ok((0.0, None))
    }

    fn stats(&self) -> QueryStats {
        self.stats
    }

    fn spend(&mut self, visits: u64) -> Result<(), OutOfBudget> {
        spend(&self.query, &mut self.stats, visits)
    }
}

/// [`Query::depth`] of bodies known by their queries; the lower bound is 0.
pub(crate) fn depth_by<W, D>(bodies: &mut ByQueries<W, D>) -> DepthInterval
where
    W: FnMut(&Query, &Point) -> Option<Answer>,
    D: FnMut(&Query, &Point, f64) -> Option<Distance>,
{
    interval(bodies)
}

/// [`Query::depth_along`] of bodies known by their queries.
pub(crate) fn depth_along_by<W, D>(bodies: &mut ByQueries<W, D>, direction: &Point) -> f64
where
    W: FnMut(&Query, &Point) -> Option<Answer>,
    D: FnMut(&Query, &Point, f64) -> Option<Distance>,
{
    way_out::along(direction, bodies).unwrap_or(f64::INFINITY)
}

/// The shortest translation that separates a half-space from a body is against its normal. Its length is the length of
/// a longer translation minus the distance after that. `distance` gives the distance of a half-space from the body,
/// with the smallest tolerance.
pub(crate) fn half_space_depth(
    half_space: &Shape,
    body: &BodyBounds,
    margin: f64,
    distance: impl FnOnce(&Shape) -> Distance,
) -> DepthInterval {
    let unknown = |stats| DepthInterval {
        lower: 0.0,
        upper: f64::INFINITY,
        translation: [0.0; 3],
        completion: Completion::OutOfBudget,
        stats,
    };
    let Core::HalfSpace { normal, offset } = *half_space.core() else {
        return unknown(QueryStats::default());
    };
    let long = length(&normal);
    let out = normal.map(|x| -x / long);
    // The depth of the ball around the body.
    let deep = (offset - dot(&normal, &body.frame.centre)) / long + half_space.radius() + body.radius;
    let far = 1.01 * (f64::max(deep, 0.0) + margin) + body.radius;
    let step = out.map(|x| x * far);
    let Some(away) = translated(half_space, &step) else { return unknown(QueryStats::default()) };
    let found = distance(&away);
    if found.completion != Completion::Complete {
        return unknown(found.stats);
    }
    let slack = 2.0 * slack(body.max_coordinate + offset.abs() + half_space.radius() + far, &step);
    let (lower, upper) = ((far - found.upper) + margin - slack, (far - found.lower) + margin + slack);
    let (lower, upper) = (f64::max(lower, 0.0), f64::max(upper, 0.0));
    let (translation, stats) = (out.map(|x| x * upper), found.stats);
    DepthInterval { lower, upper, translation, completion: Completion::Complete, stats }
}
