//! What is asked of a scene.

use super::broad::{Batch, NearPair, are_turned_boxes_apart};
use super::{BodyId, BodyTree, Scene, SceneError};
use crate::hierarchy::BvhRef;
use crate::pose::Relative;
use crate::primitive::{Spheres, Triangles};
use crate::query::{
    Answer, Completion, Counters, Distance, Lanes, Pair, Pairwise, Query, ToleranceError, Verdict,
};
use crate::range::{MAX_COORDINATE, Point};
use core::ops::ControlFlow;

/// Two bodies that meet, and where.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct SceneHit {
    /// One of the bodies.
    pub a: BodyId,
    /// The other.
    pub b: BodyId,
    /// Primitives of theirs, by their indices in what was built.
    pub pair: Pair,
}

/// What a query of a scene found out.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum SceneVerdict {
    /// Two bodies meet, or come within the margin of each other.
    Hit(SceneHit),
    /// No two bodies that are asked do.
    Free,
    /// The budget was spent before the answer was known.
    Unknown,
}

/// A verdict and what it cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct SceneAnswer {
    /// The verdict.
    pub verdict: SceneVerdict,
    /// Pairs of bodies whose boxes were near each other, and which were asked about.
    pub pairs: u64,
    /// The work for these pairs.
    pub counters: Counters,
}

impl SceneAnswer {
    /// Whether all bodies are certainly free of those that they are asked against. With a budget, no hit does not mean free.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self.verdict, SceneVerdict::Free)
    }

    /// The bodies of a hit. `None` is not "free": the budget may have been spent before one was found.
    #[must_use]
    pub const fn hit(&self) -> Option<SceneHit> {
        match self.verdict {
            SceneVerdict::Hit(hit) => Some(hit),
            _ => None,
        }
    }
}

/// How near bodies come to each other: the least distance of any two that are asked lies in `lower ..= upper`.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SceneDistance {
    /// Lower bound, in the bodies' unit: the cutoff, if no two are nearer.
    pub lower: f64,
    /// Upper bound. Infinite without a witness.
    pub upper: f64,
    /// Bodies that are `upper` apart.
    pub witness: Option<SceneWitness>,
    /// [`Completion::Complete`], or [`Completion::OutOfBudget`]: then the bounds are valid, and as far apart as they are.
    pub completion: Completion,
    /// Pairs of bodies that were asked about.
    pub pairs: u64,
    /// The work for these pairs.
    pub counters: Counters,
}

/// Two bodies and their closest points.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SceneWitness {
    /// The bodies and their primitives.
    pub hit: SceneHit,
    /// The point of `a`'s primitive in the world, up to rounding. A body's radius is not heeded.
    pub a: Point,
    /// The point of `b`'s primitive.
    pub b: Point,
}

/// A question about two trees of one node type, of whatever primitives.
trait Question<N: Lanes> {
    type Answer;

    fn ask<P: Pairwise<Q>, Q: Pairwise<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
    ) -> Result<Self::Answer, ToleranceError>;
}

struct IsWithin<'q> {
    query: &'q Query,
    relative: &'q Relative,
    margin: f64,
}

impl<N: Lanes> Question<N> for IsWithin<'_> {
    type Answer = Answer;

    fn ask<P: Pairwise<Q>, Q: Pairwise<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
    ) -> Result<Answer, ToleranceError> {
        self.query.within(a, b, self.relative.pose(), self.margin)
    }
}

struct HowFar<'q> {
    query: &'q Query,
    relative: &'q Relative,
    tolerance: f64,
    cutoff: f64,
}

impl<N: Lanes> Question<N> for HowFar<'_> {
    type Answer = Distance;

    fn ask<P: Pairwise<Q>, Q: Pairwise<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
    ) -> Result<Distance, ToleranceError> {
        self.query.distance_up_to(a, b, self.relative.pose(), self.tolerance, self.cutoff)
    }
}

fn ask<N: Lanes, Q: Question<N>>(
    question: &Q,
    a: &BodyTree<'_, N>,
    b: &BodyTree<'_, N>,
) -> Result<Q::Answer, ToleranceError>
where
    Triangles: Pairwise<Spheres>,
    Spheres: Pairwise<Triangles>,
{
    match (a, b) {
        (BodyTree::Mesh(a), BodyTree::Mesh(b)) => question.ask(a, b),
        (BodyTree::Mesh(a), BodyTree::Spheres(b)) => question.ask(a, b),
        (BodyTree::Spheres(a), BodyTree::Mesh(b)) => question.ask(a, b),
        (BodyTree::Spheres(a), BodyTree::Spheres(b)) => question.ask(a, b),
    }
}

impl<N: Lanes> Scene<'_, N> {
    /// Do any two bodies meet that are asked against each other? Touching counts. The first pair found ends it.
    ///
    /// The query's hint is not heeded; its budget is for all pairs together.
    ///
    /// # Errors
    /// None but those of [`Scene::within`], which a margin of 0 has not.
    pub fn collide(&self, query: &Query) -> Result<SceneAnswer, SceneError> {
        self.within(query, 0.0)
    }

    /// Do any two bodies that are asked against each other come within `margin`, in their unit, in the world?
    ///
    /// # Errors
    /// [`SceneError::Tolerance`] if the margin is negative, NaN or beyond [`MAX_COORDINATE`].
    pub fn within(&self, query: &Query, margin: f64) -> Result<SceneAnswer, SceneError> {
        let mut found = None;
        let (completion, pairs, counters) = self.for_each_hit(query, margin, |hit| {
            found = Some(hit);
            ControlFlow::Break(())
        })?;
        let verdict = match found {
            Some(hit) => SceneVerdict::Hit(hit),
            None if completion == Completion::OutOfBudget => SceneVerdict::Unknown,
            None => SceneVerdict::Free,
        };
        Ok(SceneAnswer { verdict, pairs, counters })
    }

    /// Calls `visit` with every two bodies that are asked against each other and come within `margin`, each two once, until
    /// it breaks. How it ended, the number of pairs that were asked about, and the work for them.
    ///
    /// # Errors
    /// As [`Scene::within`].
    pub fn for_each_hit(
        &self,
        query: &Query,
        margin: f64,
        mut visit: impl FnMut(SceneHit) -> ControlFlow<()>,
    ) -> Result<(Completion, u64, Counters), SceneError> {
        if !(0.0..=MAX_COORDINATE).contains(&margin) {
            return Err(SceneError::Tolerance(ToleranceError { given: margin }));
        }
        let (mut pairs, mut work) = (0, Counters::default());
        let mut batch = Batch::new();
        loop {
            let candidates = batch.next(self, query, margin);
            if candidates.is_empty() {
                return Ok((Completion::Complete, pairs, work));
            }
            for candidate in candidates {
                let left = query.with_budget(query.budget() - work.visits);
                pairs += 1;
                let answer = self.ask_within(&left, candidate, margin)?;
                work = work.and(&answer.counters);
                match answer.verdict {
                    Verdict::Hit(pair) => {
                        if visit(self.hit(candidate, pair)).is_break() {
                            return Ok((Completion::Stopped, pairs, work));
                        }
                    }
                    Verdict::Free => {}
                    Verdict::Unknown { .. } => return Ok((Completion::OutOfBudget, pairs, work)),
                }
            }
        }
    }

    /// How near do two bodies come that are asked against each other, up to `cutoff`? Zero if and only if two meet.
    ///
    /// `tolerance` and `cutoff` are those of [`Query::distance_up_to`]; the tolerance is relative to the distance between
    /// primitives, before the bodies' radii are taken off.
    ///
    /// # Errors
    /// [`SceneError::Tolerance`] if the tolerance is negative, NaN or infinite, or the cutoff negative or NaN.
    pub fn clearance(&self, query: &Query, tolerance: f64, cutoff: f64) -> Result<SceneDistance, SceneError> {
        if cutoff.is_nan() || cutoff < 0.0 {
            return Err(SceneError::Tolerance(ToleranceError { given: cutoff }));
        }
        let mut found = SceneDistance {
            lower: cutoff,
            upper: f64::INFINITY,
            witness: None,
            completion: Completion::Complete,
            pairs: 0,
            counters: Counters::default(),
        };
        let (mut batch, mut nearest) = (Batch::new(), cutoff);
        loop {
            let candidates = batch.next(self, query, nearest);
            if candidates.is_empty() {
                return Ok(found);
            }
            for candidate in candidates {
                // In f32, as the boxes are.
                if f64::from(-candidate.depth) > nearest * (1.0 + 1e-6) {
                    continue;
                }
                let left = query.with_budget(query.budget() - found.counters.visits);
                found.pairs += 1;
                let (lower, upper, answer) = self.ask_distance(&left, candidate, tolerance, nearest)?;
                found.counters = found.counters.and(&answer.counters);
                found.lower = found.lower.min(lower);
                if upper < found.upper
                    && let Some(witness) = answer.witness
                {
                    let b = &self.memory.slots[candidate.b as usize].world;
                    found.upper = upper;
                    found.witness = Some(SceneWitness {
                        hit: self.hit(candidate, witness.pair),
                        a: b.apply(witness.a),
                        b: b.apply(witness.b),
                    });
                    nearest = nearest.min(upper);
                }
                if answer.completion != Completion::Complete {
                    // Of the pairs that were not asked, nothing is known.
                    (found.lower, found.completion) = (0.0, answer.completion);
                    return Ok(found);
                }
                if found.upper == 0.0 {
                    found.lower = 0.0;
                    return Ok(found);
                }
            }
        }
    }

    fn hit(&self, candidate: &NearPair, pair: Pair) -> SceneHit {
        SceneHit { a: self.id(candidate.a as usize), b: self.id(candidate.b as usize), pair }
    }

    fn ask_within(&self, query: &Query, candidate: &NearPair, margin: f64) -> Result<Answer, ToleranceError> {
        let free =
            Answer { verdict: Verdict::Free, counters: Counters::default(), hint: crate::query::Hint::NONE };
        let [a, b] = [candidate.a, candidate.b].map(|i| &self.memory.slots[i as usize]);
        let (Some(body_a), Some(body_b)) = (&a.body, &b.body) else { return Ok(free) };
        if are_turned_boxes_apart((&a.size, &a.world), (&b.size, &b.world), margin) {
            return Ok(free);
        }
        let relative = b.relative(&a.world);
        let apart = margin + (body_a.radius + body_b.radius);
        let margin =
            relative.margin(apart, a.size.max_coordinate, a.size.greatest_radius + b.size.greatest_radius);
        ask(&IsWithin { query, relative: &relative, margin }, &body_a.shape, &body_b.shape)
    }

    /// Bounds of the distance in the world, and the answer in the frame of b.
    fn ask_distance(
        &self,
        query: &Query,
        candidate: &NearPair,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<(f64, f64, Distance), ToleranceError> {
        let [a, b] = [candidate.a, candidate.b].map(|i| &self.memory.slots[i as usize]);
        let [body_a, body_b] = [a, b].map(|slot| slot.body.as_ref());
        let relative = b.relative(&a.world);
        let round = a.size.greatest_radius + b.size.greatest_radius;
        let radii = body_a.map_or(0.0, |body| body.radius) + body_b.map_or(0.0, |body| body.radius);
        let reach = relative.margin(cutoff + radii, a.size.max_coordinate, round);
        let question = HowFar { query, relative: &relative, tolerance, cutoff: reach };
        let (Some(body_a), Some(body_b)) = (body_a, body_b) else {
            return Err(ToleranceError { given: tolerance });
        };
        let answer = ask(&question, &body_a.shape, &body_b.shape)?;
        // What a distance in the frame of b may be in the world.
        let off = |x: f64| relative.margin(x, a.size.max_coordinate, round) - x;
        let lower = (answer.lower - off(answer.lower) - radii).max(0.0);
        let upper =
            if answer.upper == 0.0 { 0.0 } else { (answer.upper + off(answer.upper) - radii).max(0.0) };
        Ok((lower, upper, answer))
    }
}
