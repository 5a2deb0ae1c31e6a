//! Two shapes in one frame: do they meet or come within a margin, and what is their distance?
//!
//! A filter in plain `f64` decides most pairs, and certified bounds of the distance most others. The rest is decided
//! exactly, in integers, if the decision is the sign of a rational number: the table in [`super`] lists these pairs.
//! For other pairs the bounds decide, which are within 2^-40 of the size of the two: only a pair that is certainly
//! free is free.

use super::bounds::{Certified, bounds, bounds_placed};
use super::exact::{self, aligned};
use super::fast::{decide, decide_placed};
use crate::pose::Pose;
use crate::primitive::Separation;
use crate::primitive::shape::convex::Shape;
use crate::primitive::triangle::distance::TIGHT;
use crate::range::MIN_COORDINATE;

/// Whether two shapes have a common point. Touching counts.
#[must_use]
pub fn meets(a: &Shape, b: &Shape) -> bool {
    is_near(a, b, 0.0, &mut 0)
}

/// Whether two shapes are at most `margin` apart. A margin below 0 or NaN counts as 0, one above 0 and below
/// [`MIN_COORDINATE`] as [`MIN_COORDINATE`].
#[must_use]
pub fn is_within(a: &Shape, b: &Shape, margin: f64) -> bool {
    is_near(a, b, if margin > 0.0 { margin } else { 0.0 }, &mut 0)
}

/// Bounds of the distance between two shapes, and their closest points; `None` if the distance is certainly greater
/// than `limit`. The bounds differ by at most a relative `tolerance`, which is at least 2^-42, or by 2^-40 of the size
/// of the two. If the shapes meet, both points are within 2^-26 of the size of a common point.
#[must_use]
pub fn separation(a: &Shape, b: &Shape, limit: f64, tolerance: f64) -> Option<Separation> {
    nearer(a, b, limit, if tolerance > TIGHT { tolerance } else { TIGHT }, &mut 0)
}

/// [`is_within`]; `exact` grows by 1 if the filter did not decide.
#[inline]
pub(crate) fn is_near(a: &Shape, b: &Shape, margin: f64, exact: &mut u64) -> bool {
    match decide(a, b, margin) {
        Some(is_near) => is_near,
        None => is_near_surely(a, b, margin, exact),
    }
}

/// [`is_near`] of `a` at a pose.
#[inline(never)]
pub(crate) fn is_near_posed(a: &Shape, pose: &Pose, b: &Shape, margin: f64, exact: &mut u64) -> bool {
    match decide_placed(a, pose, b, margin) {
        Some(is_near) => is_near,
        None => is_near_surely(&a.moved(pose), b, margin, exact),
    }
}

#[cold]
#[inline(never)]
fn is_near_surely(a: &Shape, b: &Shape, margin: f64, exact: &mut u64) -> bool {
    *exact += 1;
    let margin = if margin > 0.0 && margin < MIN_COORDINATE { MIN_COORDINATE } else { margin };
    let Certified { lower, upper, .. } = bounds(a, b, margin, TIGHT);
    if lower > margin {
        return false;
    }
    // A lower bound of 0 proves nothing; an upper bound of 0 proves that they meet.
    upper == 0.0 || upper <= margin || exact::is_within(a, b, margin).unwrap_or(true)
}

/// [`separation`]; `exact` grows by 1 if the bounds did not decide whether the two meet.
#[inline]
pub(crate) fn nearer(
    a: &Shape,
    b: &Shape,
    limit: f64,
    tolerance: f64,
    exact: &mut u64,
) -> Option<Separation> {
    let found = bounds(a, b, limit, tolerance);
    decided(&found, limit, exact, || exactly_meets(a, b))
}

/// [`nearer`] for `a` at a pose.
#[inline(never)]
pub(crate) fn nearer_posed(
    a: &Shape,
    pose: &Pose,
    b: &Shape,
    limit: f64,
    tolerance: f64,
    exact: &mut u64,
) -> Option<Separation> {
    let found = bounds_placed(a, pose, b, limit, tolerance);
    decided(&found, limit, exact, || exactly_meets(&a.moved(pose), b))
}

#[inline(always)]
fn decided(
    found: &Certified,
    limit: f64,
    exact: &mut u64,
    meets: impl FnOnce() -> Option<bool>,
) -> Option<Separation> {
    if found.lower > limit {
        return None;
    }
    let (lower, upper) = if found.lower > 0.0 || found.upper == 0.0 {
        (found.lower, found.upper)
    } else {
        *exact += 1;
        // Apart by less than the bounds resolve.
        (0.0, if meets().unwrap_or(true) { 0.0 } else { found.upper.max(f64::MIN_POSITIVE) })
    };
    Some(Separation { lower, upper, a: found.a, b: found.b })
}

#[cold]
#[inline(never)]
fn exactly_meets(a: &Shape, b: &Shape) -> Option<bool> {
    aligned::decide(a, b, 0.0).or_else(|| exact::is_within(a, b, 0.0))
}

#[cfg(test)]
mod tests;
