//! What is true of two shapes in one frame.
//!
//! PROVISIONAL: bounds in `f64` instead of the exact oracle. Judgements near contact are too close to call.

use super::gjk::bounds;
use simdop::primitive::shape::Shape;

/// Part of the names of the files of poses: verdicts of another truth are not read.
pub(super) const NAME: &str = "provisional";

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Judgement {
    Apart,
    Meets,
    TooCloseToCall,
}

/// Whether the distance of the shapes is at most the margin.
pub(super) fn meets(a: &Shape, b: &Shape, margin: f64) -> Judgement {
    let found = bounds(a, b);
    if found.lower > margin + found.rounding {
        Judgement::Apart
    } else if found.upper == 0.0 || found.upper < margin - found.rounding {
        Judgement::Meets
    } else {
        Judgement::TooCloseToCall
    }
}

/// Lower and upper bound of the distance.
pub(super) fn distance_interval(a: &Shape, b: &Shape) -> [f64; 2] {
    let found = bounds(a, b);
    [(found.lower - found.rounding).max(0.0), found.upper + found.rounding]
}
