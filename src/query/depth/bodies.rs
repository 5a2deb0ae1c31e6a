//! The queries of two bodies in a depth search: are they free after a translation, what is their distance then, and
//! which translations near it are certainly not free?
//!
//! # Forbidden translations
//!
//! Two spheres or shapes of the bodies with penetration depth d forbid all translations shorter than d.
//!
//! Let a ball of radius r about c lie inside solid A, and one of radius r' about c' inside solid B. After every
//! translation t of A with `|c + t - c'| < r + r'` the balls overlap, and so do the solids. The search uses two kinds
//! of balls: those of packings and of bodies of spheres, and for one point q of A, moved by a translation x, the
//! largest balls about it inside either body. The latter forbid all translations nearer to x than the sum of their
//! radii.
//!
//! The radii are rounded down. A pose whose matrix is not quite a rotation shortens lengths by a fraction of at most
//! [`Pose::skew`]. [`Pose::apply`], and the sum of two translations, move a corner by less than `2^-47 (c + abs(t))`
//! and [`MIN_COORDINATE`](crate::range::MIN_COORDINATE) per axis, where c is the largest coordinate of A and t the
//! translation; a surface that moves by less than its distance from a point winds around the point as before.
//! [`ROUNDING`] times the sum of all coordinates covers these errors, those of the centres, and the sums of radii.

use super::clusters::{Clusters, crossing, triangle};
use super::interval::OutOfBudget;
use super::overlaps::{DeepestPrimitives, beneath, middle};
use super::packings::{self, DeepestPair, InnerBalls, Packings};
use super::posed_pair::{PosedPair, Seed, Shared, finished, gap_of, spend, verdict_of, widened};
use crate::exact::power_of_two;
use crate::hierarchy::BvhRef;
use crate::pose::Pose;
use crate::primitive::shape::{Core, Depth};
use crate::primitive::{Primitive, Separation, Shape, Shapes, Spheres};
use crate::query::entry::{Completion, Found, Hint, PrimitivePair, Query, QueryStats, Verdict};
use crate::query::lanes::Lanes;
use crate::query::setup::reach;
use crate::range::{MAX_COORDINATE, Point};
use crate::vector::{difference, dot, length, unit};
use core::ops::ControlFlow;

const ROUNDING: f64 = power_of_two(-44);
/// Far above the least coordinate, and far below any length of a body.
const LEAST: f64 = power_of_two(-240);

pub(super) struct PosedBodies<'t, N: Lanes, P: Primitive, Q: Primitive> {
    pub(super) query: Query,
    pub(super) a: &'t BvhRef<'t, N, P>,
    pub(super) b: &'t BvhRef<'t, N, Q>,
    pub(super) pose: &'t Pose,
    /// Spheres inside each body.
    pub(super) packings: [Option<BvhRef<'t, N, Spheres>>; 2],
    /// The bodies count as meeting up to this distance.
    pub(super) margin: f64,
    pub(super) stats: QueryStats,
    pub(super) hint: Hint,
    /// The hint of distance queries.
    pub(super) nearest: Hint,
}

impl<'t, N: Lanes, P: Primitive, Q: Primitive> PosedBodies<'t, N, P, Q> {
    /// Takes the query's budget, but not its hint; no margin; and the packings that the bodies carry.
    pub(super) fn new(
        query: &Query,
        a: &'t BvhRef<'t, N, P>,
        b: &'t BvhRef<'t, N, Q>,
        pose: &'t Pose,
    ) -> Self {
        let (query, stats) = (query.with_hint(Hint::NONE), QueryStats::default());
        let packings = [a.packing(), b.packing()];
        Self { query, a, b, pose, packings, margin: 0.0, stats, hint: Hint::NONE, nearest: Hint::NONE }
    }

    /// Uses these packings instead, if given.
    pub(super) fn with_packings(self, packings: Option<&Packings<'t, N>>) -> Self {
        match packings {
            Some(&Packings { a, b }) => Self { packings: [Some(a), Some(b)], ..self },
            None => self,
        }
    }

    /// Spheres in both bodies: the packings, or the bodies themselves.
    fn inner_balls(&self) -> Option<[&dyn InnerBalls<N>; 2]> {
        Some([
            inner_balls_of(self.a, self.packings[0].as_ref())?,
            inner_balls_of(self.b, self.packings[1].as_ref())?,
        ])
    }
}

fn inner_balls_of<'b, N: Lanes, P: Primitive>(
    body: &'b BvhRef<'_, N, P>,
    packing: Option<&'b BvhRef<'_, N, Spheres>>,
) -> Option<&'b dyn InnerBalls<N>> {
    match packing {
        Some(packing) => Some(packing),
        None if P::HAS_BALLS => Some(body),
        None => None,
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

    /// Moves the best of some points to a better place in some steps, and keeps the result if it is better than
    /// `found`.
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

    /// The middle of the lens of two spheres, in A's frame.
    fn middle_of_lens(&self, pair: &DeepestPair, pose: &Pose) -> Point {
        let apart = difference(&pair.b.centre, &pose.unflushed(&pair.a.centre));
        let far = length(&apart);
        // Distance from A's centre along the line to B's.
        let middle = 0.5 * (far - pair.b.radius + f64::min(pair.a.radius, far + pair.b.radius));
        let share = if far > 0.0 { f64::max(middle, 0.0) / far } else { 0.0 };
        let back = turned_back(self.pose, &apart);
        core::array::from_fn(|i| pair.a.centre[i] + share * back[i])
    }

    /// The middle, in A's frame, of the overlap of the bodies' boxes along the axes of B's frame.
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

    /// The balls about a point of A. `None` if it is not inside both bodies; `is_unknown` says, for A and for B,
    /// whether that must be tested.
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
        // The pose keeps the radii of spheres and shapes, though it changes other lengths.
        let of_a = if P::BOUNDS_SOLIDS {
            in_a.radius * (1.0 - self.pose.skew())
        } else {
            in_a.radius - 4.0 * self.pose.skew() * self.a.extent().radius
        };
        let sum = of_a + in_b.radius;
        let from_a = self.pose.rotate(&in_a.inwards);
        let (Some(from_b), Some(from_a)) = (unit(&in_b.inwards), unit(&from_a)) else { return Ok(None) };
        let slack = self.slack(t);
        Ok(Some(Shared {
            radius: sum - slack,
            point: *point,
            inwards: [from_b, from_a],
            radii: [in_a.radius - slack, in_b.radius - slack],
        }))
    }

    /// The deepest pair of spheres in the bodies.
    fn deepest_balls(&mut self, pose: &Pose) -> Result<Option<DeepestPair>, OutOfBudget> {
        let mut visits = self.stats.visits;
        let Some(balls) = self.inner_balls() else { return Ok(None) };
        let found = packings::deepest(balls, pose, &mut visits, self.query.budget());
        self.stats.visits = visits;
        found
    }

    /// The deepest pair among the first few hundred pairs of primitives that meet after a translation.
    fn deepest_primitives(&mut self, pose: &Pose) -> Result<DeepestPrimitives, OutOfBudget> {
        let mut deepest = DeepestPrimitives::new();
        self.for_each_met(pose, |found, moved, still| {
            deepest.offer::<P, Q>((found.a, moved), (found.b, still));
            deepest.go_on()
        })?;
        self.spend(deepest.computed)?;
        Ok(deepest)
    }

    /// Improves the forbidden neighbourhood by pairs of primitives, which need no solid bodies.
    fn improve_by_primitives(
        &mut self,
        found: &mut (f64, Option<Shared>),
        (pose, t): (&Pose, &Point),
        steps: usize,
    ) -> Result<(), OutOfBudget> {
        let deepest = self.deepest_primitives(pose)?;
        found.0 = f64::max(found.0, deepest.depth.lower - self.slack(t));
        if deepest.depth.lower == 0.0 || !(self.a.is_solid() || self.b.is_solid()) {
            // Convex sets inside the two primitives would be no deeper in each other than these.
            return Ok(());
        }
        let (a, b) = (P::moved(&self.a.primitive(deepest.a), pose), self.b.primitive(deepest.b));
        let (of_a, of_b) = (middle::<P>(&a), middle::<Q>(&b));
        // A moves out along the direction.
        let beneath = if self.a.is_solid() {
            beneath::<P>(&of_b, &a, &deepest.depth, 0.5)
        } else {
            beneath::<Q>(&of_a, &b, &deepest.depth, -0.5)
        };
        let in_a = [Some(of_a), Some(of_b), beneath].map(|seed| seed.map(|seed| self.in_a(&seed, pose)));
        self.improve(found, (&in_a, UNKNOWN), (pose, t), steps)
    }

    /// The contact points of at most [`MOST_PAIRS`] pairs of primitives.
    fn contacts_after(&mut self, pose: &Pose) -> Result<Clusters, OutOfBudget> {
        let (mut clusters, mut pairs) = (Clusters::new(), 0);
        self.for_each_met(pose, |_, moved, still| {
            if let (Some(a), Some(b)) = (triangle(P::corners(moved)), triangle(Q::corners(still))) {
                clusters.add(crossing(&a, &b));
            }
            pairs += 1;
            if pairs < MOST_PAIRS { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        Ok(clusters)
    }

    /// The pairs of primitives that meet after a translation, until `visit` breaks. That of A is moved.
    fn for_each_met(
        &mut self,
        pose: &Pose,
        mut visit: impl FnMut(Found, &P::Item, &Q::Item) -> ControlFlow<()>,
    ) -> Result<(), OutOfBudget> {
        let (a, b) = (self.a, self.b);
        let (completion, stats) = self.query.after(&self.stats).for_each_found(a, b, pose, &mut |found| {
            visit(found, &P::moved(&a.primitive(found.a), pose), &b.primitive(found.b))
        });
        self.stats = self.stats.and(&stats);
        finished(completion)
    }

    /// Bounds the rounding of positions after a translation.
    fn slack(&self, t: &Point) -> f64 {
        slack(reach(self.a, self.b, self.pose), t)
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

    /// Tries the seed of the other translation, then the packings, then points where the bodies are likely to overlap.
    /// Moves the best points of each in steps to better ones.
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
            // The halfway point splits the difference of the translations between the two bodies.
            let halfway = core::array::from_fn(|i| point[i] + 0.5 * back[i]);
            self.improve(&mut found, (&[Some(halfway)], is_unknown), at, steps)?;
            if found.1.is_none() {
                self.improve(&mut found, (&[Some(point)], UNKNOWN), at, steps)?;
            }
        }
        if found.0 <= wanted
            && let Some(pair) = self.deepest_balls(&pose)?
        {
            let slack = self.slack(t);
            found.0 = f64::max(found.0, pair.depth - self.pose.skew() * pair.a.radius - slack);
            if self.a.is_solid() || self.b.is_solid() {
                let middle = Some(self.middle_of_lens(&pair, &pose));
                self.improve(&mut found, (&[middle], UNKNOWN), at, steps)?;
            }
        }
        if found.0 <= wanted && !(P::BOUNDS_SOLIDS && Q::BOUNDS_SOLIDS) {
            self.improve_by_primitives(&mut found, at, steps)?;
            if found.1.is_none() && (self.a.is_solid() || self.b.is_solid()) {
                self.improve(&mut found, (&[self.middle_of_boxes(&pose)], UNKNOWN), at, steps)?;
            }
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
        // A translation that goes farther by the margin leaves the bodies within the margin.
        let farther = if found.0 > 0.0 { self.margin } else { 0.0 };
        Ok((found.0 + farther, found.1))
    }

    fn likely_direction(&mut self) -> Result<Option<Point>, OutOfBudget> {
        let [Some(a), Some(b)] = self.packings else { return Ok(None) };
        let rest = self.query.after(&self.stats).budget();
        let few = if rest < VOLUME_VISITS { rest } else { VOLUME_VISITS };
        let found = self.query.with_budget(few).penetration(&a, &b, self.pose);
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

/// Bound of the rounding errors after a translation, from a bound of all coordinates.
pub(super) fn slack(coordinates: f64, t: &Point) -> f64 {
    ROUNDING * (coordinates + t.iter().fold(0.0, |sum, x| sum + x.abs())) + LEAST
}

/// Rotates a vector from B's frame into A's.
fn turned_back(pose: &Pose, v: &Point) -> Point {
    let r = pose.rows();
    core::array::from_fn(|i| (r[0][i] * v[0] + r[1][i] * v[1]) + r[2][i] * v[2])
}

/// A ball about a point inside a body.
#[derive(Copy, Clone, Debug)]
pub(super) struct InnerBall {
    pub(super) radius: f64,
    /// Vector from the nearest point of the surface, of any length.
    pub(super) inwards: Point,
}

const UNKNOWN: [bool; 2] = [true; 2];
const MOST_PAIRS: u32 = 48;
/// Budget of the penetration query that suggests a direction.
const VOLUME_VISITS: u64 = 256;

impl Query {
    /// A ball about a point inside a body. `None` if the body is a surface or the point is not inside. Tests whether
    /// the point is inside a solid only if `is_unknown`.
    pub(super) fn inside<N: Lanes, P: Primitive>(
        &self,
        solid: &BvhRef<'_, N, P>,
        point: &Point,
        is_unknown: bool,
        stats: &mut QueryStats,
    ) -> Result<Option<InnerBall>, OutOfBudget>
    where
        Shapes: PrimitivePair<P>,
    {
        if !P::BOUNDS_SOLIDS {
            return self.inside_of_a_primitive(solid, point, stats);
        }
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
        let ball = |near: Separation| InnerBall { radius: near.lower, inwards: difference(&near.a, &near.b) };
        Ok(nearest.filter(|nearest| nearest.lower > 0.0).map(ball))
    }

    /// The largest of the balls about a point inside single primitives.
    fn inside_of_a_primitive<N: Lanes, P: Primitive>(
        &self,
        body: &BvhRef<'_, N, P>,
        point: &Point,
        stats: &mut QueryStats,
    ) -> Result<Option<InnerBall>, OutOfBudget>
    where
        Shapes: PrimitivePair<P>,
    {
        let (shape, mut deepest) = (Shape::unchecked(Core::Point(*point), 0.0), DeepestPrimitives::new());
        let completion = self.for_each_met_by_shape(&shape, body, stats, &mut |index| {
            deepest.offer::<Shapes, P>((0, &shape), (index, &body.primitive(index)));
            ControlFlow::Continue(())
        });
        finished(completion)?;
        let Depth { lower, direction, .. } = deepest.depth;
        Ok((lower > 0.0).then(|| InnerBall { radius: lower, inwards: direction.map(|x| -x) }))
    }
}
