//! Allowances for rounding.

use crate::exact::power_of_two;

/// Bound of the error of the computed difference of two certified points, relative to `size`: see [`bodies`].
pub(super) const ERROR: f64 = power_of_two(-42);

/// More than the relative error of a few dozen operations on positive numbers.
pub(super) const FEW: f64 = power_of_two(-47);

/// Compares the root of a computed `square` with `reach`, where the root's error is at most `error` plus a few
/// relative roundings.
#[inline]
pub(super) fn compare(square: f64, reach: f64, error: f64) -> Option<bool> {
    let (inner, outer) = (reach - error, reach + error);
    if inner > 0.0 && square * (1.0 + FEW) < inner * inner {
        Some(true)
    } else if square > outer * outer * (1.0 + FEW) {
        Some(false)
    } else {
        None
    }
}
