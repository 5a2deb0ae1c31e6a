//! True answers for two shapes in one frame, by the exact oracle of the tests.

use crate::shape_oracle;
pub(super) use crate::shape_oracle::Judgement;
use simdop::primitive::shape::Shape;

/// Part of the names of pose files, so that verdicts of another oracle are not read.
pub(super) const NAME: &str = "exact";

/// Whether the distance of the shapes is at most the margin.
pub(super) fn meets(a: &Shape, b: &Shape, margin: f64) -> Judgement {
    shape_oracle::meets(a, b, margin)
}

/// Lower and upper bound of the distance.
pub(super) fn distance_interval(a: &Shape, b: &Shape) -> [f64; 2] {
    let (lower, upper) = shape_oracle::distance_interval(a, b).to_f64();
    [lower, upper]
}
