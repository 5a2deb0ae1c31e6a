//! The result of a distance query.

#[cfg(doc)]
use crate::query::Query;
use crate::query::entry::{Completion, Hint, Pair, QueryStats, Verdict};
use crate::range::Point;

/// The closest primitives of two bodies, and their closest points. If one body is inside a solid: a primitive of the
/// part that is inside and one of the solid's, and as both points a corner of the former, which is in both bodies.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Witness {
    /// The primitives.
    pub pair: Pair,
    /// The point of A, in B's frame, up to rounding of its coordinates.
    pub a: Point,
    /// The point of B, in B's frame.
    pub b: Point,
}

/// The result of a distance query: the distance of the bodies lies in `lower ..= upper`.
///
/// The bodies are free if `lower` is above 0. If the search is not complete, a positive `upper` does not imply that:
/// use [`Distance::verdict`].
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Distance {
    /// Lower bound, in the bodies' unit.
    pub lower: f64,
    /// Upper bound, in the bodies' unit: the distance of the witness. Zero if and only if the witness's primitives
    /// meet, or one body is inside the other, which is [solid](crate::construct::Builder::solid).
    pub upper: f64,
    /// Two primitives, and points of them that are `upper` apart. `None`, with an infinite `upper`, if a body is empty,
    /// or no two primitives nearer than the cutoff were found.
    pub witness: Option<Witness>,
    /// [`Completion::Complete`], or [`Completion::OutOfBudget`]: then the bounds are valid but may differ by more than
    /// the tolerance.
    pub completion: Completion,
    /// The work of the query.
    pub stats: QueryStats,
    /// The witness, or if one body is inside a solid, the closest primitives of the two surfaces, for the next query to
    /// [try first](Query::with_hint).
    pub hint: Hint,
}

impl Distance {
    /// Whether the bodies meet. Unknown only if the budget was spent before either bound could decide.
    pub fn verdict(&self) -> Verdict {
        match self.witness {
            Some(witness) if self.upper == 0.0 => Verdict::Hit(witness.pair),
            _ if self.completion != Completion::Complete && self.lower == 0.0 => {
                Verdict::Unknown { lower: 0.0, upper: self.upper }
            }
            _ => Verdict::Free,
        }
    }
}
