//! How far apart: within a margin or not, and the distance itself.

use super::nearest::Search;
use super::{Answer, Completion, Counters, Hint, Lanes, Pair, Pairwise, Query, Verdict};
use crate::hierarchy::AsBvh;
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::primitive::triangle::distance::TIGHT;
use crate::range::Point;
use core::fmt;

/// A margin or tolerance that is negative, infinite or NaN.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct ToleranceError {
    /// The value given.
    pub given: f64,
}

impl fmt::Display for ToleranceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a margin or tolerance of {}: must be finite and not negative", self.given)
    }
}

impl core::error::Error for ToleranceError {}

/// The closest primitives of two bodies, and their closest points.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Witness {
    /// The primitives.
    pub pair: Pair,
    /// The point of A, in B's frame, up to rounding of its coordinates.
    pub a: Point,
    /// The point of B, in B's frame.
    pub b: Point,
}

/// What a distance query found out: the distance of the bodies lies in `lower ..= upper`.
///
/// The bodies are free if `lower` is above 0, which `upper` says nothing of while the search is not complete:
/// [`Distance::verdict`] tells.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Distance {
    /// Lower bound, in the bodies' unit.
    pub lower: f64,
    /// Upper bound, in the bodies' unit: that of the witness. Zero if and only if the witness's primitives
    /// meet.
    pub upper: f64,
    /// Two primitives and points that are `upper` apart. `None` if a body is empty: its distance is
    /// infinite.
    pub witness: Option<Witness>,
    /// [`Completion::Complete`], or [`Completion::OutOfBudget`]: then the bounds are valid, and as far apart as they are.
    pub completion: Completion,
    /// The work.
    pub counters: Counters,
    /// The witness, for the next query to [try first](Query::with_hint).
    pub hint: Hint,
}

impl Distance {
    /// Do the bodies meet? Unknown only if the budget was spent before either bound could tell.
    pub fn verdict(&self) -> Verdict {
        match self.witness {
            Some(witness) if self.upper == 0.0 => Verdict::Hit(witness.pair),
            Some(_) if self.completion != Completion::Complete && self.lower == 0.0 => {
                Verdict::Unknown { lower: 0.0, upper: self.upper }
            }
            _ => Verdict::Free,
        }
    }
}

impl Query {
    /// Do the bodies come within `margin` (in their unit) of each other? [`Verdict::Hit`] names two
    /// primitives that do; [`Verdict::Free`] means that the bodies are farther apart than `margin`.
    ///
    /// Never falsely free. Exact for margin 0, where this is [`Query::collide`]. For others a pair is a hit
    /// if its distance, known to 2^-90 of the primitives' extent or 2^-50 of the distance, whichever is
    /// greater, is not certainly above the margin. Needles that almost touch are known less well: see
    /// [`crate::primitive::triangle::distance`].
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
        A::Primitive: Pairwise<B::Primitive>,
        B::Primitive: Pairwise<A::Primitive>,
    {
        Ok(self.first_pair(&a.as_bvh(), &b.as_bvh(), pose, checked(margin)?))
    }

    /// The distance of body `a`, placed by `pose` in the frame of body `b`, from `b`, and where they are
    /// closest. Zero if and only if they meet; the first common point ends it.
    ///
    /// With `tolerance` t the search ends when it has proved `upper <= (1 + t) lower`, up to rounding: 0.01
    /// is for "roughly how far", and 0 for what `f64` can hold (2^-42 relatively). A budget ends it with
    /// the bounds it then has.
    ///
    /// ```
    /// # use simdop::{construct::{Builder, Mesh}, isa::Isa, node::Node16, pose::Pose, query::Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build::<Node16<18>>(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let three_to_the_right = Pose::from_rows([[1.0, 0.0, 0.0, 3.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    /// let distance = Query::new(Isa::detect()).distance(&body.view(), &body.view(), &three_to_the_right, 0.0)?;
    /// assert!((distance.upper - 2.0).abs() < 1e-12 && distance.lower <= distance.upper);
    /// assert_eq!(distance.witness.map(|w| w.b), Some([1.0, 0.0, 0.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN.
    pub fn distance<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        tolerance: f64,
    ) -> Result<Distance, ToleranceError>
    where
        A::Node: Lanes,
        A::Primitive: Pairwise<B::Primitive>,
    {
        let (a, b) = (a.as_bvh(), b.as_bvh());
        let tolerance = checked(tolerance)?.max(TIGHT);
        if a.is_empty() || b.is_empty() {
            let (lower, upper) = (f64::INFINITY, f64::INFINITY);
            let counters = Counters::default();
            let completion = Completion::Complete;
            return Ok(Distance { lower, upper, witness: None, completion, counters, hint: self.hint });
        }
        Ok(on_isa!(self.isa, token => search(token, Search::new(token, a, b, pose, self, tolerance))))
    }
}

#[inline(always)]
fn search<N: Lanes, P: Pairwise<Q>, Q: Primitive, E: Kernel>(
    kernel: E,
    mut search: Search<'_, N, P, Q, E>,
) -> Distance {
    let completion = kernel.run(
        #[inline(always)]
        || search.run(),
    );
    let (best, counters) = (&search.best, search.counters);
    let [p, q] = best.points;
    let pair = best.found.pair(&search.a, &search.b);
    let witness = Some(Witness { pair, a: p, b: q });
    let hint = Hint::new(best.found);
    Distance { lower: best.lower, upper: best.upper, witness, completion, counters, hint }
}

fn checked(value: f64) -> Result<f64, ToleranceError> {
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(ToleranceError { given: value }) }
}
