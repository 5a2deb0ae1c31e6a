//! The work of a query, and the unit of its budget.

/// The work of a query: the same on every instruction set.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub struct QueryStats {
    /// Visits: pairs of nodes, or of a node and a leaf. The unit of the budget.
    pub visits: u64,
    /// Calls of overlap kernels, which test up to sixteen pairs of volumes each. At arity 16 a visit of
    ///
    /// * two nodes makes one call of 16vs1: A's children against the child of B that was followed (for B's root:
    ///   against the hull of B). If some overlap it and both nodes are of similar width, it makes one call of 1vs16 for
    ///   each that does. If B's is much wider, it makes one call of 1vs16 for all of A; if A's is much wider, no other
    ///   call;
    /// * a leaf of A and a node of B makes one call of 1vs16;
    /// * a node of A and a leaf of B makes one call of 16vs1.
    ///
    /// At arity 4 the calls are 4vs4: one for all of A's children instead of one for each, and against the children of
    /// B's root instead of their hull. A visit of a distance query counts as one. Re-alignments, primitive slabs and
    /// the filter of triangles are not counted.
    ///
    /// A [penetration query](crate::query::Query::penetration) with balls counts rows of balls, one against sixteen. A
    /// visit that opens a node of A counts one row for its children against the ball of B that was followed; B's root
    /// has no ball, and counts none. If both nodes are opened, each child that meets that ball counts one more row. A
    /// visit that opens only B's node counts one. The bounds of the shared volumes, which a search with a budget
    /// computes, are not counted.
    pub kernels: u64,
    /// Nodes of A whose children were rotated into B's frame.
    pub realignments: u64,
    /// Pairs of primitives tested.
    pub primitive_pairs: u64,
    /// Pairs among these that needed exact arithmetic.
    pub exact_pairs: u64,
}

impl QueryStats {
    /// The sum of both.
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
