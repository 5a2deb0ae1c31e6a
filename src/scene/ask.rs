//! What is asked of a scene.

use super::broad::{Batch, NearPair, are_turned_boxes_apart};
use super::{BodyId, BodyTree, Scene, SceneError, Slot};
use crate::pose::{Pose, Relative};
use crate::query::{
    Answer, Completion, Distance, Hint, Lanes, Pair, Query, QueryStats, ToleranceError, Verdict, checked,
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
    pub stats: QueryStats,
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
    pub stats: QueryStats,
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

/// An expression with the trees of two bodies, whatever their primitives, and one for a tree and a cloud.
macro_rules! with_trees {
    (($a:expr, $b:expr), |$x:ident, $y:ident| $with:expr, |$tree:ident, $cloud:ident| $among:expr) => {
        match ($a, $b) {
            (BodyTree::Mesh($x), BodyTree::Mesh($y)) => $with,
            (BodyTree::Mesh($x), BodyTree::Spheres($y)) => $with,
            (BodyTree::Spheres($x), BodyTree::Mesh($y)) => $with,
            (BodyTree::Spheres($x), BodyTree::Spheres($y)) => $with,
            (BodyTree::Mesh($tree), BodyTree::PointCloud($cloud)) => $among,
            (BodyTree::Spheres($tree), BodyTree::PointCloud($cloud)) => $among,
            (BodyTree::PointCloud(_), _) => {
                unreachable!("a cloud is the second of a pair, and not of another cloud")
            }
        }
    };
}

/// Two bodies that are asked about, and how they stand to each other.
pub(super) struct AskedPair<'s, 't, N> {
    pub(super) trees: (&'s BodyTree<'t, N>, &'s BodyTree<'t, N>),
    /// The first in the frame of the second.
    pub(super) relative: Relative,
    /// The sum of the bodies' radii, and that of their primitives' greatest ones.
    pub(super) radii: f64,
    round: f64,
    /// Largest coordinate of the first.
    max_coordinate: f64,
}

impl<'s, 't, N> AskedPair<'s, 't, N> {
    /// Of two bodies that stand there in the world.
    pub(super) fn new([a, b]: [&'s Slot<'t, N>; 2], [world_a, world_b]: [&Pose; 2]) -> Self {
        let (Some(body_a), Some(body_b)) = (&a.body, &b.body) else {
            unreachable!("there is no box where there is no body")
        };
        Self {
            trees: (&body_a.tree, &body_b.tree),
            relative: b.relative(world_a, world_b),
            radii: body_a.radius + body_b.radius,
            round: a.size.greatest_radius + b.size.greatest_radius,
            max_coordinate: a.size.max_coordinate,
        }
    }

    /// What a distance of primitives in the world may be in the frame of the second, at most.
    fn padded(&self, distance: f64) -> f64 {
        self.relative.margin(distance, self.max_coordinate, self.round)
    }
}

impl<'t, N: Lanes> Scene<'t, N> {
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
        let (completion, pairs, stats) = self.for_each_hit(query, margin, |hit| {
            found = Some(hit);
            ControlFlow::Break(())
        })?;
        let verdict = match found {
            Some(hit) => SceneVerdict::Hit(hit),
            None if completion == Completion::OutOfBudget => SceneVerdict::Unknown,
            None => SceneVerdict::Free,
        };
        Ok(SceneAnswer { verdict, pairs, stats })
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
    ) -> Result<(Completion, u64, QueryStats), SceneError> {
        if !(0.0..=MAX_COORDINATE).contains(&margin) {
            return Err(SceneError::Tolerance(ToleranceError { given: margin }));
        }
        let (mut pairs, mut work) = (0, QueryStats::default());
        let mut batch = Batch::new();
        loop {
            let candidates = batch.next(self, query, margin);
            if candidates.is_empty() {
                return Ok((Completion::Complete, pairs, work));
            }
            for candidate in candidates {
                pairs += 1;
                let answer = self.ask_within(&query.after(&work), candidate, margin)?;
                work = work.and(&answer.stats);
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
        // Also where no pair is near enough to be asked.
        let tolerance = checked(tolerance).map_err(SceneError::Tolerance)?;
        let mut found = SceneDistance {
            lower: cutoff,
            upper: f64::INFINITY,
            witness: None,
            completion: Completion::Complete,
            pairs: 0,
            stats: QueryStats::default(),
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
                let left = query.after(&found.stats);
                found.pairs += 1;
                let (lower, upper, answer) = self.ask_distance(&left, candidate, tolerance, nearest)?;
                found.stats = found.stats.and(&answer.stats);
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

    pub(super) fn hit(&self, candidate: &NearPair, pair: Pair) -> SceneHit {
        SceneHit { a: self.id(candidate.a as usize), b: self.id(candidate.b as usize), pair }
    }

    fn slots_of(&self, candidate: &NearPair) -> [&Slot<'t, N>; 2] {
        [candidate.a, candidate.b].map(|i| &self.memory.slots[i as usize])
    }

    pub(super) fn ask_within(
        &self,
        query: &Query,
        candidate: &NearPair,
        margin: f64,
    ) -> Result<Answer, ToleranceError> {
        let [a, b] = self.slots_of(candidate);
        self.ask_within_at(query, candidate, [&a.world, &b.world], margin)
    }

    /// The same where the bodies stand elsewhere.
    pub(super) fn ask_within_at(
        &self,
        query: &Query,
        candidate: &NearPair,
        worlds: [&Pose; 2],
        margin: f64,
    ) -> Result<Answer, ToleranceError> {
        let slots @ [a, b] = self.slots_of(candidate);
        if are_turned_boxes_apart((&a.size, worlds[0]), (&b.size, worlds[1]), margin) {
            return Ok(Answer { verdict: Verdict::Free, stats: QueryStats::default(), hint: Hint::NONE });
        }
        let asked = AskedPair::new(slots, worlds);
        let (pose, margin) = (asked.relative.pose(), asked.padded(margin + asked.radii));
        with_trees!(
            (asked.trees.0, asked.trees.1),
            |a, b| query.within(a, b, pose, margin),
            |tree, cloud| Ok(cloud.body_within(query, tree, pose, margin))
        )
    }

    /// Bounds of the distance in the world, and the answer in the frame of b.
    fn ask_distance(
        &self,
        query: &Query,
        candidate: &NearPair,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<(f64, f64, Distance), ToleranceError> {
        let slots @ [a, b] = self.slots_of(candidate);
        let asked = AskedPair::new(slots, [&a.world, &b.world]);
        let (pose, cutoff) = (asked.relative.pose(), asked.padded(cutoff + asked.radii));
        let answer = with_trees!(
            (asked.trees.0, asked.trees.1),
            |a, b| query.distance_up_to(a, b, pose, tolerance, cutoff),
            |tree, cloud| Ok(cloud.body_distance(query, tree, pose, checked(tolerance)?, cutoff))
        )?;
        // What a distance in the frame of b may be in the world.
        let off = |x: f64| asked.padded(x) - x;
        let lower = (answer.lower - off(answer.lower) - asked.radii).max(0.0);
        let upper =
            if answer.upper == 0.0 { 0.0 } else { (answer.upper + off(answer.upper) - asked.radii).max(0.0) };
        Ok((lower, upper, answer))
    }
}
