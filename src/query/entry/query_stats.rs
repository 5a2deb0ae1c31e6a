//! What a query counts, and what it may spend.

/// The work of a query: the same on every instruction set.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub struct QueryStats {
    /// Visits: pairs of nodes, or of a node and a leaf. The unit of the budget.
    pub visits: u64,
    /// Calls of overlap kernels, which test up to sixteen pairs of volumes each. A visit makes, at arity 16,
    /// * of two nodes: one of 16vs1, of A's children against the child of B that led there (for B's root:
    ///   against the hull of B). If some overlap it, and both nodes are of like width: one of 1vs16 for each
    ///   that does. If B's is much wider: one of 1vs16 for all of A. If A's is much wider: no other;
    /// * of a leaf of A and a node of B: one of 1vs16;
    /// * of a node of A and a leaf of B: one of 16vs1.
    ///
    /// At arity 4 they are calls of 4vs4: one for all of A's children instead of one for each, and against the
    /// children of B's root instead of their hull. A visit of a distance query counts as one. Re-alignments,
    /// slabs of leaves and the filter of triangles are no overlap kernels.
    ///
    /// A [penetration volume](crate::query::Query::penetration) by balls counts rows of balls, one against sixteen. A visit
    /// in which a node of A is opened makes one, of its children against the ball of B that led there, but not for B's
    /// root, which has none; and if both nodes are opened one for each child that meets it. A visit in which B's node alone
    /// is opened makes one. How much balls may share, which a search with a budget asks, is not counted.
    pub kernels: u64,
    /// Nodes of A whose children were turned into B's frame.
    pub realignments: u64,
    /// Pairs of primitives tested.
    pub primitive_pairs: u64,
    /// Of these, the ones that needed exact arithmetic.
    pub exact_pairs: u64,
}

impl QueryStats {
    /// The work of both.
    pub(crate) const fn and(&self, other: &Self) -> Self {
        Self {
            visits: self.visits + other.visits,
            kernels: self.kernels + other.kernels,
            realignments: self.realignments + other.realignments,
            primitive_pairs: self.primitive_pairs + other.primitive_pairs,
            exact_pairs: self.exact_pairs + other.exact_pairs,
        }
    }
}
