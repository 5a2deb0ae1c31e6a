//! What a depth query asks of two bodies: are they free after a translation, how far are they apart then, and which
//! translations near another are certainly not free?
//!
//! # Forbidden translations
//!
//! Let a ball of radius r about c lie inside of solid A, and one of radius r' about c' inside of solid B. After every
//! translation t of A with `|c + t - c'| < r + r'` the balls overlap, and so do the solids. Two kinds of balls are used:
//! those of the packings, and balls about one point q of A, at the place where the translation x puts it, as large as
//! the distance of that point from either surface allows. The latter forbid all translations nearer to x than the sum of
//! their radii.
//!
//! The radii are rounded down. A pose whose matrix is not quite a rotation shortens lengths by at most
//! [`Pose::skew`] relatively. [`Pose::apply`], and the sum of two translations, move a corner by less than `2^-47 (c +
//! abs(t))` and [`MIN_COORDINATE`](crate::range::MIN_COORDINATE) per axis, where c is the largest coordinate of A and t
//! the translation; a surface that moves by less than its distance from a point winds around the point as before.
//! [`ROUNDING`] times the sum of all coordinates covers these, those of the centres, and the sums of radii.

use super::clusters::{Clusters, crossing, triangle};
use super::interval::OutOfBudget;
use super::packings::{self, DeepestPair, Packings};
use super::posed_pair::{PosedPair, Seed, Shared, gap_of, spend, verdict_of, widened};
use crate::exact::power_of_two;
use crate::hierarchy::BvhRef;
use crate::pose::Pose;
use crate::primitive::{Primitive, Separation, Shapes};
use crate::query::entry::{Completion, Hint, PrimitivePair, Query, QueryStats, Verdict};
use crate::query::lanes::Lanes;
use crate::query::setup::reach;
use crate::range::{MAX_COORDINATE, Point};
use crate::vector::{difference, dot, length, unit};
use core::ops::ControlFlow;

const ROUNDING: f64 = power_of_two(-44);
/// Far above the least coordinate, and far below anything of a body.
const LEAST: f64 = power_of_two(-240);

pub(super) struct PosedBodies<'t, N: Lanes, P: Primitive, Q: Primitive> {
    pub(super) query: Query,
    pub(super) a: &'t BvhRef<'t, N, P>,
    pub(super) b: &'t BvhRef<'t, N, Q>,
    pub(super) pose: &'t Pose,
    pub(super) packings: Option<&'t Packings<'t, N>>,
    /// The bodies meet if they are not farther apart.
    pub(super) margin: f64,
    pub(super) stats: QueryStats,
    pub(super) hint: Hint,
    /// Of distances.
    pub(super) nearest: Hint,
}

impl<'t, N: Lanes, P: Primitive, Q: Primitive> PosedBodies<'t, N, P, Q> {
    /// With the query's budget, and neither its hint nor packings nor a margin.
    pub(super) fn new(
        query: &Query,
        a: &'t BvhRef<'t, N, P>,
        b: &'t BvhRef<'t, N, Q>,
        pose: &'t Pose,
    ) -> Self {
        let (query, stats) = (query.with_hint(Hint::NONE), QueryStats::default());
        Self { query, a, b, pose, packings: None, margin: 0.0, stats, hint: Hint::NONE, nearest: Hint::NONE }
    }
}

impl<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>> PosedBodies<'_, N, P, Q>
where
    Shapes: PrimitivePair<P> + PrimitivePair<Q>,
{
    /// The pose after a translation; `None` if it is out of range.
    pub(super) fn at(&self, t: &Point) -> Option<Pose> {
        let pose = self.pose.shifted(t);
        pose.translation().iter().all(|x| x.abs() <= MAX_COORDINATE).then_some(pose)
    }

    /// The best of some points, moved to a better place in some steps, if that is better than what was found.
    fn improve(
        &mut self,
        found: &mut (f64, Option<Shared>),
        (seeds, is_unknown): (&[Option<Point>], [bool; 2]),
        (pose, t): (&Pose, &Point),
        steps: usize,
    ) -> Result<(), OutOfBudget> {
        let mut best: Option<Shared> = None;
        for seed in seeds.iter().flatten() {
            if let Some(other) = self.shared(seed, pose, t, is_unknown)?
                && best.is_none_or(|best| other.radius > best.radius)
            {
                best = Some(other);
            }
        }
        let Some(start) = best else { return Ok(()) };
        let turned = *self.pose;
        let widened = widened(
            start,
            steps,
            |v| turned_back(&turned, v),
            |point, is_unknown| self.shared(point, pose, t, is_unknown),
        )?;
        if found.1.is_none_or(|known| widened.radius > known.radius) {
            *found = (f64::max(found.0, widened.radius), Some(widened));
        }
        Ok(())
    }

    /// The middle of what two spheres share, in A's frame.
    fn middle_of_lens(&self, pair: &DeepestPair, pose: &Pose) -> Point {
        let apart = difference(&pair.b.centre, &pose.unflushed(&pair.a.centre));
        let far = length(&apart);
        // On the way from the centre in A to that in B.
        let middle = 0.5 * (far - pair.b.radius + f64::min(pair.a.radius, far + pair.b.radius));
        let share = if far > 0.0 { f64::max(middle, 0.0) / far } else { 0.0 };
        let back = turned_back(self.pose, &apart);
        core::array::from_fn(|i| pair.a.centre[i] + share * back[i])
    }

    /// The middle of what the bodies' boxes share, along the axes of B's frame, in A's frame.
    fn middle_of_boxes(&self, pose: &Pose) -> Option<Point> {
        let (a, b) = (self.a.extent(), self.b.extent());
        let [of_a, of_b] = [&a, &b].map(|body| body.half_width.map(|x| f64::from(x) / body.frame.scale()));
        let centre = pose.unflushed(&a.frame.centre);
        let mut middle = [0.0; 3];
        for i in 0..3 {
            let wide = dot(&pose.rows()[i].map(f64::abs), &of_a);
            let low = f64::max(centre[i] - wide, b.frame.centre[i] - of_b[i]);
            let high = f64::min(centre[i] + wide, b.frame.centre[i] + of_b[i]);
            if low > high {
                return None;
            }
            middle[i] = 0.5 * (low + high);
        }
        Some(self.in_a(&middle, pose))
    }

    /// A point of B's frame in A's, up to rounding and the deviation of the matrix.
    fn in_a(&self, point: &Point, pose: &Pose) -> Point {
        let centre = self.a.frame().centre;
        let back = turned_back(self.pose, &difference(point, &pose.unflushed(&centre)));
        core::array::from_fn(|i| centre[i] + back[i])
    }

    /// The balls about a point of A. `None` if it is not inside of both bodies; `is_unknown` of A and B: whether that
    /// has to be asked.
    fn shared(
        &mut self,
        point: &Point,
        pose: &Pose,
        t: &Point,
        is_unknown: [bool; 2],
    ) -> Result<Option<Shared>, OutOfBudget> {
        let moved = pose.apply(*point);
        let Some(in_b) = self.query.inside(self.b, &moved, is_unknown[1], &mut self.stats)? else {
            return Ok(None);
        };
        let Some(in_a) = self.query.inside(self.a, point, is_unknown[0], &mut self.stats)? else {
            return Ok(None);
        };
        let of_a = in_a.lower * (1.0 - self.pose.skew());
        let sum = of_a + in_b.lower;
        let from_a = self.pose.rotate(&difference(&in_a.a, &in_a.b));
        let (Some(from_b), Some(from_a)) = (unit(&difference(&in_b.a, &in_b.b)), unit(&from_a)) else {
            return Ok(None);
        };
        let slack = slack(reach(self.a, self.b, self.pose), t);
        Ok(Some(Shared {
            radius: sum - slack,
            point: *point,
            inwards: [from_b, from_a],
            radii: [in_a.lower - slack, in_b.lower - slack],
        }))
    }

    /// Where primitives meet, of at most [`MOST_PAIRS`].
    fn contacts_after(&mut self, pose: &Pose) -> Result<Clusters, OutOfBudget> {
        let (mut clusters, mut pairs) = (Clusters::new(), 0);
        let (a, b) = (self.a, self.b);
        let (completion, stats) = self.query.after(&self.stats).for_each_found(a, b, pose, &mut |found| {
            let (moved, still) = (P::moved(&a.primitive(found.a), pose), b.primitive(found.b));
            if let (Some(a), Some(b)) = (triangle(P::corners(&moved)), triangle(Q::corners(&still))) {
                clusters.add(crossing(&a, &b));
            }
            pairs += 1;
            if pairs < MOST_PAIRS { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        self.stats = self.stats.and(&stats);
        if completion == Completion::OutOfBudget {
            return Err(OutOfBudget);
        }
        Ok(clusters)
    }
}

impl<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>> PosedPair for PosedBodies<'_, N, P, Q>
where
    Shapes: PrimitivePair<P> + PrimitivePair<Q>,
{
    fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget> {
        let Some(pose) = self.at(t) else { return Ok(false) };
        let query = self.query.after(&self.stats).with_hint(self.hint);
        let answer = if self.margin > 0.0 {
            let Ok(answer) = query.within(self.a, self.b, &pose, self.margin) else { return Ok(false) };
            answer
        } else {
            query.collide(self.a, self.b, &pose)
        };
        self.stats = self.stats.and(&answer.stats);
        if let Verdict::Hit(_) = answer.verdict {
            self.hint = answer.hint;
        }
        verdict_of(&answer)
    }

    fn gap(&mut self, t: &Point, tolerance: f64) -> Result<Option<(f64, Point)>, OutOfBudget> {
        let Some(pose) = self.at(t) else { return Ok(None) };
        let query = self.query.after(&self.stats).with_hint(self.nearest);
        let Ok(found) = query.distance(self.a, self.b, &pose, tolerance) else { return Ok(None) };
        self.nearest = found.hint;
        self.stats = self.stats.and(&found.stats);
        gap_of(&found, self.margin)
    }

    fn far(&self) -> f64 {
        let (a, b) = (self.a.extent(), self.b.extent());
        let apart = length(&difference(&self.pose.unflushed(&a.frame.centre), &b.frame.centre));
        1.01 * (a.radius + b.radius + apart + self.margin)
    }

    /// Tries the seed of the other translation; then the packings, and where the bodies are likely to overlap; and from
    /// the best of these, points on the way to a better one.
    fn forbidden(
        &mut self,
        t: &Point,
        seed: Option<Seed>,
        steps: usize,
        wanted: f64,
    ) -> Result<(f64, Option<Shared>), OutOfBudget> {
        let Some(pose) = self.at(t) else { return Ok((0.0, None)) };
        let (at, mut found) = ((&pose, t), (0.0, None));
        if let Some(Seed { point, translation, radii }) = seed {
            let back = turned_back(self.pose, &difference(&translation, t));
            let half = 0.5 * length(&back);
            let is_unknown = radii.map(|radius| half > 0.99 * radius);
            // Half as deep in either body as the other translation left it, at worst.
            let halfway = core::array::from_fn(|i| point[i] + 0.5 * back[i]);
            self.improve(&mut found, (&[Some(halfway)], is_unknown), at, steps)?;
            if found.1.is_none() {
                self.improve(&mut found, (&[Some(point)], UNKNOWN), at, steps)?;
            }
        }
        if found.0 <= wanted
            && let Some(packings) = self.packings
            && let Some(pair) =
                packings::deepest(packings, &pose, &mut self.stats.visits, self.query.budget())?
        {
            let slack = slack(reach(self.a, self.b, self.pose), t);
            found.0 = f64::max(found.0, pair.depth - self.pose.skew() * pair.a.radius - slack);
            let middle = Some(self.middle_of_lens(&pair, &pose));
            self.improve(&mut found, (&[middle], UNKNOWN), at, steps)?;
        }
        if found.0 <= wanted && self.a.is_solid() && self.b.is_solid() {
            let contacts = self.contacts_after(&pose)?;
            let in_a = |point: Option<Point>| point.map(|point| self.in_a(&point, &pose));
            let (middles, inner) = (contacts.middles().map(in_a), contacts.inner().map(in_a));
            self.improve(&mut found, (&middles, UNKNOWN), at, steps)?;
            for seed in inner.into_iter().chain([self.middle_of_boxes(&pose)]) {
                if found.1.is_none() {
                    self.improve(&mut found, (&[seed], UNKNOWN), at, steps)?;
                }
            }
        }
        // Nor are they farther apart than the margin after a translation that is farther by that.
        let farther = if found.0 > 0.0 { self.margin } else { 0.0 };
        Ok((found.0 + farther, found.1))
    }

    fn likely_direction(&mut self) -> Result<Option<Point>, OutOfBudget> {
        let Some(Packings { a, b }) = self.packings else { return Ok(None) };
        let rest = self.query.after(&self.stats).budget();
        let few = if rest < VOLUME_VISITS { rest } else { VOLUME_VISITS };
        let found = self.query.with_budget(few).penetration(a, b, self.pose);
        self.stats = self.stats.and(&found.stats);
        if found.completion == Completion::OutOfBudget && few < VOLUME_VISITS {
            return Err(OutOfBudget);
        }
        Ok(Some(found.direction))
    }

    fn stats(&self) -> QueryStats {
        self.stats
    }

    fn spend(&mut self, visits: u64) -> Result<(), OutOfBudget> {
        spend(&self.query, &mut self.stats, visits)
    }
}

/// What is lost to rounding after a translation, with a bound of all coordinates.
pub(super) fn slack(coordinates: f64, t: &Point) -> f64 {
    ROUNDING * (coordinates + t.iter().fold(0.0, |sum, x| sum + x.abs())) + LEAST
}

/// A vector of B's frame in A's.
fn turned_back(pose: &Pose, v: &Point) -> Point {
    let r = pose.rows();
    core::array::from_fn(|i| (r[0][i] * v[0] + r[1][i] * v[1]) + r[2][i] * v[2])
}

const UNKNOWN: [bool; 2] = [true; 2];
const MOST_PAIRS: u32 = 48;
/// Visits of the penetration volume, for its direction.
const VOLUME_VISITS: u64 = 256;

impl Query {
    /// The distance of a point inside of a solid from its surface, and the nearest point there. `None` if the body is
    /// not solid or the point is not inside, which is only asked if it is unknown.
    pub(super) fn inside<N: Lanes, P: Primitive>(
        &self,
        solid: &BvhRef<'_, N, P>,
        point: &Point,
        is_unknown: bool,
        stats: &mut QueryStats,
    ) -> Result<Option<Separation>, OutOfBudget>
    where
        Shapes: PrimitivePair<P>,
    {
        if !solid.is_solid() {
            return Ok(None);
        }
        if is_unknown && self.inside_of_solid(solid, point, stats).map_err(|_| OutOfBudget)?.is_none() {
            return Ok(None);
        }
        let mut nearest = self.nearest_on_surface(point, solid, stats).ok_or(OutOfBudget)?;
        if let Some(caps) = solid.caps() {
            let cap = self.nearest_on_surface(point, &caps, stats).ok_or(OutOfBudget)?;
            if cap.is_some_and(|cap| nearest.is_none_or(|nearest| cap.lower < nearest.lower)) {
                nearest = cap;
            }
        }
        Ok(nearest.filter(|nearest| nearest.lower > 0.0))
    }
}
