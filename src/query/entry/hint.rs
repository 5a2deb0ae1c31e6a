//! Temporal coherence: what a caller carries from one query to the next.

use super::Pair;
use crate::hierarchy::BvhRef;
use crate::node::Node;
use crate::primitive::Primitive;

/// The primitives that a query found, for the next query of the same bodies at a nearby pose to try first: those that
/// met, or those that were closest.
///
/// A hint never changes a verdict, whatever bodies and poses it comes from: its primitives are tested like any others.
/// It changes which pair a [`Verdict::Hit`](super::Verdict::Hit) names, the query statistics, and, where several pairs
/// of primitives are equally close, which one witnesses a distance (its bounds then differ by rounding).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub struct Hint(Option<Found>);

/// A pair of primitives, by their indices in leaf order.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::query) struct Found {
    pub(in crate::query) a: u32,
    pub(in crate::query) b: u32,
}

impl Found {
    /// The pair by source indices.
    pub(in crate::query) fn pair<N: Node, P: Primitive, Q: Primitive>(
        self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
    ) -> Pair {
        Pair { a: a.source(self.a), b: b.source(self.b) }
    }
}

impl Hint {
    /// No hint.
    pub const NONE: Self = Self(None);

    pub(in crate::query) const fn new(found: Found) -> Self {
        Self(Some(found))
    }

    /// The pair, if both indices are in range for bodies of `count_a` and `count_b` primitives.
    pub(in crate::query) fn pair(self, count_a: usize, count_b: usize) -> Option<Found> {
        self.0.filter(|found| (found.a as usize) < count_a && (found.b as usize) < count_b)
    }
}
