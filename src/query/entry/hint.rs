//! Temporal coherence: the state that a caller passes from one query to the next.

use super::Pair;
use crate::hierarchy::BvhRef;
use crate::node::Node;
use crate::primitive::Primitive;

/// The primitives that a query found: those that met, or were closest. The next query of the same bodies at a nearby
/// pose tries them first.
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

    /// The hint as an integer, for foreign interfaces: `u64::MAX` for none.
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        match self.0 {
            Some(Found { a, b }) => (b as u64) << 32 | a as u64,
            None => u64::MAX,
        }
    }

    /// From the result of [`Hint::to_bits`]. Any other number acts like a hint from other bodies.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        if bits == u64::MAX {
            return Self::NONE;
        }
        Self(Some(Found { a: bits as u32, b: (bits >> 32) as u32 }))
    }

    pub(in crate::query) const fn new(found: Found) -> Self {
        Self(Some(found))
    }

    /// The pair, if both indices are in range for bodies of `count_a` and `count_b` primitives.
    pub(in crate::query) fn pair(self, count_a: usize, count_b: usize) -> Option<Found> {
        self.0.filter(|found| (found.a as usize) < count_a && (found.b as usize) < count_b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hint_survives_as_an_integer() {
        let pairs = [(0, 0), (7, u32::MAX), (u32::MAX, 7)].map(|(a, b)| Hint::new(Found { a, b }));
        for hint in pairs.into_iter().chain([Hint::NONE]) {
            assert_eq!(Hint::from_bits(hint.to_bits()), hint);
        }
        assert!(Hint::from_bits(u64::MAX - 1).pair(10, 10).is_none());
    }
}
