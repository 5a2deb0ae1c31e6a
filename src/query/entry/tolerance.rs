//! Margins and tolerances.

use core::fmt;

/// A margin or tolerance that is negative, infinite or NaN.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct ToleranceError {
    /// The value given.
    pub given: f64,
}

impl fmt::Display for ToleranceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a margin or tolerance of {}: must be finite and not negative", self.given)
    }
}

impl core::error::Error for ToleranceError {}

pub(crate) fn checked(value: f64) -> Result<f64, ToleranceError> {
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(ToleranceError { given: value }) }
}
