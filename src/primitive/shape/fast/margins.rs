//! Allowances for rounding.

use crate::exact::power_of_two;

/// Bound of the error of the computed difference of two certified points, relative to `size`: see [`bodies`].
pub(super) const ERROR: f64 = power_of_two(-42);

/// More than the relative error of a few dozen operations on positive numbers.
pub(super) const FEW: f64 = power_of_two(-47);
