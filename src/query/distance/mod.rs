//! Distance queries: whether two bodies are within a margin, and their distance.

mod answer;
mod axis;
mod bounds;
mod frontier;
mod leaf;
mod search;
mod steps;

pub use answer::{Distance, Witness};
pub use frontier::DISTANCE_STACK_BYTES;

use super::containment::Containment;
use super::entry::{
    Answer, Completion, Found, Hint, PrimitivePair, Query, QueryStats, ToleranceError, Verdict, checked,
};
use super::lanes::Lanes;
use super::setup::{Within, are_apart};
use crate::hierarchy::{AsBvh, BvhRef, with_bvhs};
use crate::isa::on_isa;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::primitive::triangle::distance::TIGHT;
use search::{Goal, Outcome, search};

impl Query {
    /// Do the bodies come within `margin` (in their unit) of each other? [`Verdict::Hit`] names two primitives that do,
    /// or as in [`Query::collide`], two primitives of bodies one of which is inside the other; [`Verdict::Free`] means
    /// that the bodies are farther apart than `margin`.
    ///
    /// Never falsely free. Exact for margin 0, where this is [`Query::collide`]. For other margins, a pair is a hit
    /// unless its distance is certainly above the margin. The distance is known to 2^-90 of the primitives' extent or
    /// 2^-50 of itself, whichever is greater, and less precisely for needles that almost touch: see
    /// [`crate::primitive::triangle::distance`].
    ///
    /// A margin may have any size. Above three tenths of the smaller body's radius, the query switches from widened
    /// volumes to the search for the nearest primitives after at most 4 visits, or 24 for bodies of at most 1,024
    /// primitives.
    ///
    /// # Errors
    /// [`ToleranceError`] if `margin` is negative, infinite or NaN.
    pub fn within<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        margin: f64,
    ) -> Result<Answer, ToleranceError>
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
    {
        let margin = checked(margin)?;
        if are_apart(a.header(), b.header(), pose, margin) {
            return Ok(self.free());
        }
        Ok(with_bvhs(a, b, |a, b| {
            let mut answer = self.near_surfaces(a, b, pose, margin);
            self.add_inside(&mut answer, a, b, pose);
            answer
        }))
    }

    /// [`Query::within`] for the primitives alone.
    fn near_surfaces<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        margin: f64,
    ) -> Answer {
        let smaller = a.header().radius.min(b.header().radius);
        let is_small = margin <= SMALL * smaller || a.is_empty() || b.is_empty();
        if margin > LARGE * smaller && !is_small {
            return self.first_near(*a, *b, pose, margin);
        }
        let few = if is_small {
            self.budget()
        } else if a.len().max(b.len()) <= COARSE {
            self.budget().min(FEW_OF_COARSE)
        } else {
            self.budget().min(FEW)
        };
        let answer = self.with_budget(few).first_pair(a, b, pose, Within::new(margin, a, b, pose));
        if few == self.budget() || !matches!(answer.verdict, Verdict::Unknown { .. }) {
            return answer;
        }
        let rest = self.with_budget(self.budget() - few).first_near(*a, *b, pose, margin);
        Answer { stats: answer.stats.and(&rest.stats), ..rest }
    }

    /// The distance of body `a`, placed by `pose` in the frame of body `b`, from `b`, and the closest points. Zero if
    /// and only if they meet, or one is inside the other, which is [solid](crate::construct::Builder::solid). The
    /// search ends at the first common point.
    ///
    /// With `tolerance` t the search ends when it has proved `upper <= (1 + t) lower`, up to rounding: 0.01 gives a
    /// rough distance, and 0 the precision of `f64` (a relative 2^-42). A budget ends the search with the bounds found
    /// so far. Bodies may be any distance apart, and differ in size by any factor.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let three_to_the_right = Pose::from_rows([[1.0, 0.0, 0.0, 3.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    /// let distance = Query::new(Isa::detect()).distance(&body.view(), &body.view(), &three_to_the_right, 0.0)?;
    /// assert!((distance.upper - 2.0).abs() < 1e-12 && distance.lower <= distance.upper);
    /// assert_eq!(distance.witness.map(|w| w.b), Some([1.0, 0.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN.
    #[inline]
    pub fn distance<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        tolerance: f64,
    ) -> Result<Distance, ToleranceError>
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
    {
        self.distance_up_to(a, b, pose, tolerance, f64::INFINITY)
    }

    /// [`Query::distance`] for bodies nearer than `cutoff`, in their unit. For other bodies the result is only that
    /// they are at least that far apart: `lower` is at least the cutoff, `upper` is infinite and there is no witness.
    /// If the distance equals the cutoff, up to the tolerance, either answer is possible.
    ///
    /// Use it to find the nearest of many bodies: with the least `upper` so far as the cutoff, the query abandons
    /// farther bodies after a few visits, most of them before the first.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let (query, mut nearest) = (Query::new(Isa::detect()), (f64::INFINITY, None));
    /// for x in [7.0, 3.0, 5.0] {
    ///     let pose = Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    ///     let found = query.distance_up_to(&body, &body, &pose, 0.01, nearest.0)?;
    ///     if found.witness.is_some() {
    ///         nearest = (found.upper, Some(x));
    ///     }
    /// }
    /// assert!(nearest.1 == Some(3.0) && (nearest.0 - 2.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN, or `cutoff` negative or NaN.
    pub fn distance_up_to<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, ToleranceError>
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
    {
        let tolerance = checked(tolerance)?.max(TIGHT);
        // Above zero, so that bodies that touch are nearer.
        let cutoff = if cutoff == f64::INFINITY { cutoff } else { checked(cutoff)?.max(f64::MIN_POSITIVE) };
        let is_empty = a.header().primitive_count == 0 || b.header().primitive_count == 0;
        if is_empty || are_apart(a.header(), b.header(), pose, cutoff) {
            return Ok(Distance {
                lower: if is_empty { f64::INFINITY } else { cutoff },
                upper: f64::INFINITY,
                witness: None,
                completion: Completion::Complete,
                stats: QueryStats::default(),
                hint: self.hint,
            });
        }
        let (a, b) = (a.as_bvh(), b.as_bvh());
        let Outcome { completion, best, stats, .. } =
            self.search(a, b, pose, Goal::Distance { tolerance, cutoff });
        let [p, q] = best.points;
        let found = best.upper.is_finite().then_some(best.found);
        let witness = found.map(|found| Witness { pair: found.pair(&a, &b), a: p, b: q });
        let hint = found.map_or(self.hint, Hint::new);
        let found = Distance { lower: best.lower, upper: best.upper, witness, completion, stats, hint };
        Ok(self.or_none(found, &a, &b, pose))
    }

    /// The distance of two surfaces, for bodies that may be solid: 0 if one is inside the other.
    #[inline(always)]
    fn or_none<N: Lanes, P: PrimitivePair<Q>, Q: Primitive>(
        &self,
        surfaces: Distance,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) -> Distance {
        if !(a.is_solid() || b.is_solid()) || surfaces.upper == 0.0 {
            return surfaces;
        }
        let mut stats = surfaces.stats;
        match self.place(a, b, pose, &mut stats) {
            Containment::Outside if a.has_caps() || b.has_caps() => {
                self.or_none_on_caps(Distance { stats, ..surfaces }, a, b, pose)
            }
            Containment::Outside => Distance { stats, ..surfaces },
            Containment::Inside { found, point } => Distance {
                lower: 0.0,
                upper: 0.0,
                witness: Some(Witness { pair: found.pair(a, b), a: point, b: point }),
                completion: Completion::Complete,
                stats,
                hint: surfaces.hint,
            },
            Containment::OutOfBudget { .. } => {
                Distance { lower: 0.0, completion: Completion::OutOfBudget, stats, ..surfaces }
            }
        }
    }

    /// The distance of two bodies, neither of which is inside the other: 0 if one meets a cap of the other.
    #[cold]
    #[inline(never)]
    fn or_none_on_caps<N: Lanes, P: PrimitivePair<Q>, Q: Primitive>(
        &self,
        surfaces: Distance,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) -> Distance {
        let query = self.with_hint(Hint::NONE);
        let goal = Goal::Distance { tolerance: TIGHT, cutoff: f64::MIN_POSITIVE };
        let mut stats = surfaces.stats;
        // A primitive beside the cap represents it.
        let of_b = b.caps().map(|caps| {
            let outcome = query.after(&stats).search(*a, caps, pose, goal);
            stats = stats.and(&outcome.stats);
            let Found { a, b } = outcome.best.found;
            (Found { a, b: caps.source(b) }, outcome)
        });
        let is_decided = |(_, outcome): &(Found, Outcome)| {
            outcome.best.upper == 0.0 || outcome.completion != Completion::Complete
        };
        let of_a = || {
            a.caps().map(|caps| {
                let outcome = query.after(&stats).search(caps, *b, pose, goal);
                stats = stats.and(&outcome.stats);
                let Found { a, b } = outcome.best.found;
                (Found { a: caps.source(a), b }, outcome)
            })
        };
        match of_b.filter(is_decided).or_else(of_a).filter(is_decided) {
            Some((found, Outcome { best, .. })) if best.upper == 0.0 => {
                let [p, q] = best.points;
                Distance {
                    lower: 0.0,
                    upper: 0.0,
                    witness: Some(Witness { pair: found.pair(a, b), a: p, b: q }),
                    completion: Completion::Complete,
                    stats,
                    hint: surfaces.hint,
                }
            }
            Some(_) => Distance { lower: 0.0, completion: Completion::OutOfBudget, stats, ..surfaces },
            None => Distance { stats, ..surfaces },
        }
    }

    /// [`Query::within`] for bodies that are not empty, and small compared with the margin: nearly all k-DOPs widened
    /// by the margin would overlap.
    fn first_near<N: Lanes, P: PrimitivePair<Q>, Q: Primitive>(
        &self,
        a: BvhRef<'_, N, P>,
        b: BvhRef<'_, N, Q>,
        pose: &Pose,
        margin: f64,
    ) -> Answer {
        let Outcome { completion, best, hit, stats } = self.search(a, b, pose, Goal::Within { margin });
        let verdict = match (hit, completion) {
            (Some(found), _) => Verdict::Hit(found.pair(&a, &b)),
            (None, Completion::Complete) => Verdict::Free,
            (None, _) => Verdict::Unknown { lower: best.lower, upper: best.upper },
        };
        Answer { verdict, stats, hint: hit.map_or(self.hint, Hint::new) }
    }

    fn search<N: Lanes, P: PrimitivePair<Q>, Q: Primitive>(
        &self,
        a: BvhRef<'_, N, P>,
        b: BvhRef<'_, N, Q>,
        pose: &Pose,
        goal: Goal,
    ) -> Outcome {
        on_isa!(self.isa(), token => search(token, a, b, pose, self, goal))
    }
}

/// Volumes widened by a margin overlap far more often than they are within it, and the more so the larger the margin.
/// Up to this fraction of the smaller body's radius, the query uses them nevertheless.
const SMALL: f64 = 0.3;
/// Above this multiple of the radius, widened volumes cull almost nothing.
const LARGE: f64 = 3.0;
/// In between, the number of visits with widened volumes before the search for the nearest primitives begins: undecided
/// pairs would take far more.
const FEW: u64 = 4;
/// The same for bodies of at most [`COARSE`] primitives: it decides most of these queries.
const FEW_OF_COARSE: u64 = 24;
const COARSE: usize = 1024;
