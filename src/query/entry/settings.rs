//! The settings of a query.

use super::{Answer, Hint, QueryStats, Verdict};
use crate::isa::Isa;

/// The settings of a query; the methods run queries.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Query {
    isa: Isa,
    budget: u64,
    pub(in crate::query) hint: Hint,
}

impl Query {
    /// A query on instruction set `isa`, without a budget.
    #[must_use]
    pub const fn new(isa: Isa) -> Self {
        Self { isa, budget: u64::MAX, hint: Hint::NONE }
    }

    /// Sets the budget: a query gives up after `visits` visits (see [`QueryStats::visits`]).
    #[must_use]
    pub const fn with_budget(self, visits: u64) -> Self {
        Self { budget: visits, ..self }
    }

    pub(crate) const fn isa(&self) -> Isa {
        self.isa
    }

    /// Sets the hint: a query first tests what an earlier query of the same bodies found, for coherent motion. See
    /// [`Hint`].
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query, query::Hint};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let query = Query::new(Isa::detect());
    /// let mut hint = Hint::NONE;
    /// for x in [0.5, 0.51, 0.52] {
    ///     let pose = Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    ///     let answer = query.with_hint(hint).collide(&body.view(), &body.view(), &pose);
    ///     assert!(answer.hit().is_some());
    ///     hint = answer.hint;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn with_hint(self, hint: Hint) -> Self {
        Self { hint, ..self }
    }

    /// The answer "free", found without any work.
    #[inline(always)]
    pub(in crate::query) fn free(&self) -> Answer {
        Answer { verdict: Verdict::Free, stats: QueryStats::default(), hint: self.hint }
    }

    /// The maximum number of visits.
    pub(crate) const fn budget(&self) -> u64 {
        self.budget
    }

    /// The query with the rest of its budget after some work.
    pub(crate) const fn after(&self, work: &QueryStats) -> Self {
        self.with_budget(self.budget - work.visits)
    }
}
