//! The result of a depth query.

use crate::query::entry::{Completion, QueryStats};
use crate::range::Point;

/// The budget is spent.
#[derive(Copy, Clone, Debug)]
pub(super) struct OutOfBudget;

/// The penetration depth of two bodies, the length of the shortest translation of A after which they are apart or
/// touch, lies in `lower ..= upper`.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct DepthInterval {
    /// Lower bound, in the bodies' unit: [`Query::collide`](crate::query::Query::collide) finds the bodies to meet
    /// after every shorter translation. Zero if the bodies are free, or if their interiors are unknown.
    pub lower: f64,
    /// Upper bound: the length of the translation, rounded up. Zero if and only if the bodies are free. Infinite if the
    /// budget was spent before any translation was found.
    pub upper: f64,
    /// After this translation, in B's frame and added to the pose's translation,
    /// [`Query::collide`](crate::query::Query::collide) finds the bodies to be free. Zero if the bodies are free, or if
    /// the budget was spent before any was found.
    pub translation: Point,
    /// [`Completion::OutOfBudget`] if the search was cut short. The bounds are valid in either case.
    pub completion: Completion,
    /// The work: the sum over all queries, one visit for each pair of balls that was opened, and one for every sixteen
    /// forbidden balls that directions were tested against.
    pub stats: QueryStats,
}
