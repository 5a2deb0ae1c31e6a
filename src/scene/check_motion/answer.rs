//! The answer of a motion query.

use crate::query::QueryStats;
use crate::scene::ask::SceneHit;

/// The verdict on a motion.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum MotionVerdict {
    /// No two tested bodies meet at any time from 0 to 1.
    Free,
    /// Two bodies meet at this time, which need not be the first.
    Hit {
        /// The bodies.
        hit: SceneHit,
        /// The time of the hit.
        time: f64,
    },
    /// No hit was found. No bodies meet before this interval of time, but within it they may.
    Unresolved {
        /// Start of the interval.
        from: f64,
        /// End of the interval: at most the resolution later, unless the budget or the memory ran out.
        to: f64,
    },
}

/// A verdict on a motion, and its cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct MotionAnswer {
    /// The verdict.
    pub verdict: MotionVerdict,
    /// Number of times at which the bodies were placed.
    pub times: u64,
    /// Number of pairs of bodies tested, counted once for each time.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: QueryStats,
}

impl MotionAnswer {
    pub(crate) fn new() -> Self {
        Self { verdict: MotionVerdict::Free, times: 0, pairs: 0, stats: QueryStats::default() }
    }

    /// Whether all tested pairs are certainly free along the whole motion.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self.verdict, MotionVerdict::Free)
    }
}
