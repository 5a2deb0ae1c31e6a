//! A pair of shapes and a margin.

use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::exact::aligned;

/// A pair of shapes and the margin to decide.
pub(super) struct PairAndMargin<'a> {
    pub(super) a: &'a Shape,
    pub(super) b: &'a Shape,
    pub(super) margin: f64,
    /// The sum of the radii and the margin.
    pub(super) reach: f64,
}

impl PairAndMargin<'_> {
    /// The verdict if both shapes are along the axes.
    #[inline(always)]
    pub(super) fn aligned(&self) -> Option<bool> {
        let are_aligned = aligned::may_be_aligned(&self.a.core) && aligned::may_be_aligned(&self.b.core);
        if are_aligned { aligned::decide(self.a, self.b, self.margin) } else { None }
    }
}
