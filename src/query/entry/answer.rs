//! The results of queries.

#[cfg(doc)]
use super::Query;
use super::{Hint, Pair, QueryStats};

/// The verdict of a query.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum Verdict {
    /// The bodies meet, or come within the margin of each other, and these primitives do. Or a part of one body is
    /// inside the other, which is [solid](crate::construct::Builder::solid): then one is a primitive of that part. The
    /// other is a primitive of the solid: among those that a ray from a corner of the former crosses, the one with the
    /// lowest index.
    Hit(Pair),
    /// No primitive of A meets one of B, or comes within the margin of one, and no body has a part inside a solid.
    Free,
    /// The budget was spent before the answer was known. The distance of the bodies, 0 if they meet, lies in
    /// `lower ..= upper`.
    Unknown {
        /// Lower bound of the distance, in the bodies' unit: zero, since pending volumes overlap.
        lower: f64,
        /// Upper bound of the distance, in the bodies' unit: the distance of two points in pending volumes.
        upper: f64,
    },
}

impl Verdict {
    /// Whether the bodies are certainly free: apart, or farther apart than the margin. A planner must test this, not
    /// the absence of a hit: with a budget, a query without a hit need not be free.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }

    /// The primitives of a hit. `None` does not mean free, since the budget may have been spent before a hit was found:
    /// see [`Verdict::is_free`].
    #[must_use]
    pub const fn hit(&self) -> Option<Pair> {
        match self {
            Self::Hit(pair) => Some(*pair),
            _ => None,
        }
    }
}

/// A verdict and its cost.
///
/// There is no `is_hit`, whose negation would read as "free" where the verdict is [`Verdict::Unknown`]: use
/// [`Answer::is_free`], or match the verdict.
///
/// ```
/// # use simdop::{Builder, Isa, Mesh, Pose, Query};
/// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
/// let query = Query::new(Isa::detect());
/// let in_contact = query.collide(&body.view(), &body.view(), &Pose::IDENTITY);
/// assert!(!in_contact.is_free() && in_contact.hit().is_some());
/// let unknown = query.with_budget(0).collide(&body.view(), &body.view(), &Pose::IDENTITY);
/// assert!(!unknown.is_free() && unknown.hit().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// The work of the query.
    pub stats: QueryStats,
    /// The primitives that met, for the next query to [try first](Query::with_hint). If no primitives met, even if a
    /// body is inside a solid: the hint of this query.
    pub hint: Hint,
}

impl Answer {
    /// [`Verdict::is_free`] of the verdict.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        self.verdict.is_free()
    }

    /// [`Verdict::hit`] of the verdict.
    #[must_use]
    pub const fn hit(&self) -> Option<Pair> {
        self.verdict.hit()
    }
}

/// How an enumeration ended.
#[must_use = "pairs are missing unless the enumeration is complete"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Completion {
    /// Every pair was visited.
    Complete,
    /// The visitor stopped it.
    Stopped,
    /// The budget was spent.
    OutOfBudget,
}
