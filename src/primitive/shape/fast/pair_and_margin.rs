//! A pair of shapes and a margin.

use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::exact::aligned;
use crate::primitive::shape::place::Placement;

/// A pair of shapes and the margin to decide.
#[derive(Copy, Clone)]
pub(super) struct PairAndMargin<'a, P> {
    pub(super) a: &'a Shape,
    /// Where A is.
    pub(super) at: P,
    pub(super) b: &'a Shape,
    pub(super) margin: f64,
    /// The sum of the radii and the margin.
    pub(super) reach: f64,
}

impl<P: Placement> PairAndMargin<'_, P> {
    /// The verdict if both shapes are along the axes.
    #[inline(never)]
    pub(super) fn aligned(&self) -> Option<bool> {
        self.at.with(self.a, |a| aligned::decide(a, self.b, self.margin))
    }
}
