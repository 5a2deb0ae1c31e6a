//! What a caller carries from one query to the next.

use super::{Lanes, Pair};
use crate::hierarchy::BvhRef;

/// The triangles that a query found, for the next query of the same bodies at a pose nearby to try first: those that met, or those that were closest.
///
/// A hint never changes a verdict, whatever bodies and poses it comes from: its triangles are tested as any others are. It changes which pair
/// a [`Verdict::Hit`](super::Verdict::Hit) names, the counters, and, where several pairs of triangles are equally close, which one witnesses a distance (its
/// bounds then differ by rounding).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub struct Hint(Option<Found>);

/// A pair of triangles, by their indices in leaf order.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Found {
    pub(super) a: u32,
    pub(super) b: u32,
}

impl Found {
    /// By their indices in the meshes.
    pub(super) fn pair<N: Lanes>(self, a: &BvhRef<'_, N>, b: &BvhRef<'_, N>) -> Pair {
        Pair { a: a.source(self.a), b: b.source(self.b) }
    }
}

impl Hint {
    /// Nothing to try first.
    pub const NONE: Self = Self(None);

    pub(super) const fn new(found: Found) -> Self {
        Self(Some(found))
    }

    /// The pair, if there are such triangles in bodies of so many.
    pub(super) fn pair(self, triangles_a: usize, triangles_b: usize) -> Option<Found> {
        self.0.filter(|found| (found.a as usize) < triangles_a && (found.b as usize) < triangles_b)
    }
}
