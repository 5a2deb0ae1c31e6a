//! Queries of a scene at its current poses.

use super::body::{BodyId, BodyTree};
use super::body_size::are_turned_boxes_apart;
use super::broad::{Batch, NearPair};
use super::error::SceneError;
use super::memory::Slot;
use super::placement::Scene;
use crate::node::Dop;
use crate::pose::{Pose, Relative};
use crate::primitive::shape::Core;
use crate::query::{
    Answer, Completion, Distance, Hint, Lanes, Pair, Query, QueryStats, ToleranceError, Verdict, checked,
};
use crate::range::{MAX_COORDINATE, Point};
use crate::realign::greatest;
use core::ops::ControlFlow;

/// Two bodies that meet, and two of their primitives that meet.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct SceneHit {
    /// One of the bodies.
    pub a: BodyId,
    /// The other.
    pub b: BodyId,
    /// Their primitives, by index in the builder's input.
    pub pair: Pair,
}

/// The verdict of a scene query.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum SceneVerdict {
    /// Two bodies meet, or come within the margin of each other.
    Hit(SceneHit),
    /// No two tested bodies meet, or come within the margin.
    Free,
    /// The budget ran out before the verdict was certain.
    Unknown,
}

/// A verdict and its cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct SceneAnswer {
    /// The verdict.
    pub verdict: SceneVerdict,
    /// Number of pairs of bodies tested: those whose boxes were near each other.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: QueryStats,
}

impl SceneAnswer {
    /// Whether all tested pairs are certainly free. If the budget ran out, the absence of a hit does not mean free.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self.verdict, SceneVerdict::Free)
    }

    /// The bodies of a hit. `None` does not mean free: the budget may have run out before a hit was found.
    #[must_use]
    pub const fn hit(&self) -> Option<SceneHit> {
        match self.verdict {
            SceneVerdict::Hit(hit) => Some(hit),
            _ => None,
        }
    }
}

/// Bounds of the least distance between any two tested bodies: it lies in `lower ..= upper`.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SceneDistance {
    /// Lower bound, in the bodies' unit; the cutoff if no two are nearer.
    pub lower: f64,
    /// Upper bound. Infinite without a witness.
    pub upper: f64,
    /// Two bodies at distance `upper`.
    pub witness: Option<SceneWitness>,
    /// [`Completion::Complete`], or [`Completion::OutOfBudget`]: then the bounds are valid but may be loose.
    pub completion: Completion,
    /// Number of pairs of bodies tested.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: QueryStats,
}

/// Two bodies and their closest points.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SceneWitness {
    /// The bodies and their primitives.
    pub hit: SceneHit,
    /// The point of `a`'s primitive in the world, up to rounding. Ignores the body's radius.
    pub a: Point,
    /// The point of `b`'s primitive.
    pub b: Point,
}

/// Evaluates one of several expressions: for two trees of any primitives, for a tree and a cloud, for a shape and a
/// tree, for a shape and a cloud, or for two shapes.
macro_rules! with_trees {
    (
        ($a:expr, $b:expr), |$x:ident, $y:ident| $with:expr, |$tree:ident, $cloud:ident| $among:expr,
        |$shape:ident, $of:ident| $beside:expr, |$one:ident, $scan:ident| $in_scan:expr,
        |$p:ident, $q:ident| $both:expr
    ) => {
        match ($a, $b) {
            (BodyTree::Shape($p), BodyTree::Shape($q)) => $both,
            (BodyTree::Shape($shape), BodyTree::Shapes($of)) => $beside,
            (BodyTree::Shape($shape), BodyTree::Mesh($of)) => $beside,
            (BodyTree::Shape($shape), BodyTree::Spheres($of)) => $beside,
            (BodyTree::Shape($one), BodyTree::PointCloud($scan)) => $in_scan,
            (BodyTree::Shapes($x), BodyTree::Shapes($y)) => $with,
            (BodyTree::Shapes($x), BodyTree::Mesh($y)) => $with,
            (BodyTree::Shapes($x), BodyTree::Spheres($y)) => $with,
            (BodyTree::Mesh($x), BodyTree::Shapes($y)) => $with,
            (BodyTree::Spheres($x), BodyTree::Shapes($y)) => $with,
            (BodyTree::Shapes($tree), BodyTree::PointCloud($cloud)) => $among,
            (BodyTree::Mesh($x), BodyTree::Mesh($y)) => $with,
            (BodyTree::Mesh($x), BodyTree::Spheres($y)) => $with,
            (BodyTree::Spheres($x), BodyTree::Mesh($y)) => $with,
            (BodyTree::Spheres($x), BodyTree::Spheres($y)) => $with,
            (BodyTree::Mesh($tree), BodyTree::PointCloud($cloud)) => $among,
            (BodyTree::Spheres($tree), BodyTree::PointCloud($cloud)) => $among,
            _ => unreachable!("a shape is the first of a pair, a cloud the second, and both are borrowed"),
        }
    };
}

pub(super) use with_trees;

/// Two bodies to test, and their relative pose.
pub(super) struct AskedPair<'s, N> {
    /// Borrowed, never [`BodyTree::Shared`].
    pub(super) trees: (BodyTree<'s, N>, BodyTree<'s, N>),
    /// The pose of the first in the frame of the second.
    pub(super) relative: Relative,
    /// The sum of the bodies' radii.
    pub(super) radii: f64,
    /// The sum of the greatest radii of their primitives.
    round: f64,
    /// Largest absolute coordinate of the first.
    max_coordinate: f64,
}

impl<'s, N: Dop> AskedPair<'s, N> {
    /// The pair at the given world poses.
    pub(super) fn new([a, b]: [&'s Slot<'_, N>; 2], [world_a, world_b]: [&Pose; 2]) -> Self {
        let (Some(body_a), Some(body_b)) = (&a.body, &b.body) else {
            unreachable!("there is no box where there is no body")
        };
        let relative = b.relative(world_a, world_b);
        let mut max_coordinate = a.size.max_coordinate;
        if let BodyTree::Shape(shape) = &body_a.tree
            && let Core::HalfSpace { .. } = shape.core()
        {
            // The query compares the points of the half-space that are near the other body.
            max_coordinate += 2.0 * (b.size.max_coordinate + greatest(&relative.pose().translation()));
        }
        Self {
            trees: (body_a.tree.view(), body_b.tree.view()),
            relative,
            radii: body_a.radius + body_b.radius,
            round: a.size.greatest_radius + b.size.greatest_radius,
            max_coordinate,
        }
    }

    /// Upper bound, in the frame of the second, of a distance between primitives in the world.
    pub(super) fn padded(&self, distance: f64) -> f64 {
        self.relative.margin(distance, self.max_coordinate, self.round)
    }
}

impl<N: Lanes> AskedPair<'_, N> {
    fn ask_within(&self, query: &Query, margin: f64) -> Result<Answer, ToleranceError> {
        let (pose, margin) = (self.relative.pose(), self.padded(margin + self.radii));
        with_trees!(
            (&self.trees.0, &self.trees.1),
            |a, b| query.within(a, b, pose, margin),
            |tree, cloud| Ok(cloud.body_within(query, tree, pose, margin)),
            |shape, tree| query.within_shape(shape, tree, pose, margin),
            |shape, cloud| Ok(cloud.shape_within(query, &shape.moved(pose), margin)),
            |a, b| Ok(query.shapes_within(a, pose, b, margin))
        )
    }

    /// The distance of the primitives in the frame of the second, with the first at this pose there.
    pub(super) fn distance_at(
        &self,
        query: &Query,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, ToleranceError> {
        with_trees!(
            (&self.trees.0, &self.trees.1),
            |a, b| query.distance_up_to(a, b, pose, tolerance, cutoff),
            |tree, cloud| Ok(cloud.body_distance(query, tree, pose, checked(tolerance)?, cutoff)),
            |shape, tree| query.distance_shape(shape, tree, pose, tolerance, cutoff),
            |shape, cloud| Ok(cloud.shape_distance(query, &shape.moved(pose), checked(tolerance)?, cutoff)),
            |a, b| Ok(query.shapes_distance(a, pose, b, checked(tolerance)?, cutoff))
        )
    }
}

impl<'t, N: Lanes> Scene<'t, N> {
    /// Do any two tested bodies meet? Touching counts. Stops at the first pair found.
    ///
    /// Ignores the query's hint; its budget covers all pairs together.
    ///
    /// # Errors
    /// Those of [`Scene::within`], which do not occur at a margin of 0.
    pub fn collide(&self, query: &Query) -> Result<SceneAnswer, SceneError> {
        self.within(query, 0.0)
    }

    /// Do any two tested bodies come within `margin` of each other? `margin` is in the bodies' unit.
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

    /// Calls `visit` once for each tested pair of bodies that come within `margin` of each other, until it breaks.
    /// Returns how the search ended, the number of pairs tested, and their query statistics.
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

    /// The least distance between two tested bodies, up to `cutoff`. Zero if and only if two meet.
    ///
    /// `tolerance` and `cutoff` are those of [`Query::distance_up_to`]. The tolerance is relative to the distance
    /// between primitives, before the bodies' radii are subtracted.
    ///
    /// # Errors
    /// [`SceneError::Tolerance`] if the tolerance is negative, NaN or infinite, or the cutoff negative or NaN.
    pub fn clearance(&self, query: &Query, tolerance: f64, cutoff: f64) -> Result<SceneDistance, SceneError> {
        if cutoff.is_nan() || cutoff < 0.0 {
            return Err(SceneError::Tolerance(ToleranceError { given: cutoff }));
        }
        // Checked here too, since no pair may be near enough to reach the query.
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
                // 1e-6 covers the rounding of the `f32` depth.
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
                    // The untested pairs have no lower bound.
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

    pub(super) fn slots_of(&self, candidate: &NearPair) -> [&Slot<'t, N>; 2] {
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

    /// As `ask_within`, for bodies that may move: near a cap they are a hit, too. So if they are free, no point of
    /// either can get inside the other by moving at most the margin.
    pub(super) fn ask_within_reach(
        &self,
        query: &Query,
        candidate: &NearPair,
        margin: f64,
    ) -> Result<Answer, ToleranceError> {
        let mut answer = self.ask_within(query, candidate, margin)?;
        let slots @ [a, b] = self.slots_of(candidate);
        let caps = slots.map(|slot| slot.body.as_ref().and_then(|body| body.tree.caps()));
        if caps.iter().all(Option::is_none) {
            return Ok(answer);
        }
        let mut asked = AskedPair::new(slots, [&a.world, &b.world]);
        let (a, b) = asked.trees.clone();
        let [of_a, of_b] = caps;
        let pairs = [of_a.map(|caps| (caps, b)), of_b.map(|caps| (a, caps))];
        for trees in pairs.into_iter().flatten() {
            if answer.is_free() {
                asked.trees = trees;
                let near = asked.ask_within(&query.after(&answer.stats), margin)?;
                answer = Answer { stats: answer.stats.and(&near.stats), ..near };
            }
        }
        Ok(answer)
    }

    /// As `ask_within`, at other world poses.
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
        AskedPair::new(slots, worlds).ask_within(query, margin)
    }

    /// Bounds of the distance in the world, and the answer in the frame of the second body.
    pub(super) fn ask_distance(
        &self,
        query: &Query,
        candidate: &NearPair,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<(f64, f64, Distance), ToleranceError> {
        let slots @ [a, b] = self.slots_of(candidate);
        let asked = AskedPair::new(slots, [&a.world, &b.world]);
        let (pose, cutoff) = (asked.relative.pose(), asked.padded(cutoff + asked.radii));
        let answer = asked.distance_at(query, pose, tolerance, cutoff)?;
        // Largest difference between a distance in the frame of b and the same distance in the world.
        let off = |x: f64| asked.padded(x) - x;
        let lower = (answer.lower - off(answer.lower) - asked.radii).max(0.0);
        let upper = match answer.upper {
            // The bodies are beyond the cutoff, or meet.
            f64::INFINITY | 0.0 => answer.upper,
            upper => (upper + off(upper) - asked.radii).max(0.0),
        };
        Ok((lower, upper, answer))
    }
}
