//! The required accuracy of bounds.

use super::certified::Certified;
use super::support::each;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::difference;

/// The range of squared sizes in which no product of four lengths overflows, or underflows by more than a slack.
pub(super) const COMFORTABLE: core::ops::RangeInclusive<f64> = power_of_two(-200)..=power_of_two(200);

/// The required accuracy of bounds.
pub(super) struct Target {
    pub(super) radii: [f64; 2],
    /// The sum of the radii, rounded down and up.
    pub(super) less: f64,
    pub(super) more: f64,
    /// A search ends once the cores are certainly farther apart.
    pub(super) limit: f64,
    pub(super) tolerance: f64,
}

impl Target {
    #[inline(always)]
    pub(super) fn new(a: f64, b: f64, limit: f64, tolerance: f64) -> Self {
        let sum = a + b;
        let (less, more) = (sum * (1.0 - f64::EPSILON), sum * (1.0 + f64::EPSILON));
        let limit = (limit + more) * (1.0 + 8.0 * f64::EPSILON);
        Self { radii: [a, b], less, more, limit, tolerance }
    }

    /// Whether bounds of the distance between the cores suffice.
    #[inline(always)]
    pub(super) fn is_met(&self, lower: f64, upper: f64, slack: f64) -> bool {
        let width = upper - lower;
        width <= self.tolerance * (lower - self.more)
            || width <= 2.5 * slack
            || lower > self.limit
            || upper <= self.less
    }

    /// Converts bounds for the cores to bounds for the shapes. `a` is A's closest point, and `between` the vector from
    /// B's closest point to it, of this length.
    #[inline(always)]
    pub(super) fn bounds(
        &self,
        lower: f64,
        upper: f64,
        a: &Point,
        between: &Point,
        length: f64,
    ) -> Certified {
        let (wide, narrow) = (1.0 + 2.0 * f64::EPSILON, 1.0 - 2.0 * f64::EPSILON);
        let meets = upper <= self.less;
        let upper = if meets { 0.0 } else { (upper - self.less) * wide };
        let lower = lower - self.more;
        let lower = if lower > 0.0 { lower * narrow } else { 0.0 };
        // Shapes that meet share the point that divides the vector in the ratio of their radii.
        let whole = if meets { self.radii[0] + self.radii[1] } else { length };
        let unit = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        let (s, t) = (self.radii[0] * unit, self.radii[1] * unit);
        let b = difference(a, between);
        Certified { lower, upper, a: each(|k| a[k] - s * between[k]), b: each(|k| b[k] + t * between[k]) }
    }

    /// The bounds of a length with this error, or `None` if it is too large.
    #[inline(always)]
    pub(super) fn bounds_of_length(
        &self,
        a: &Point,
        between: &Point,
        length: f64,
        slack: f64,
    ) -> Option<Certified> {
        let (lower, upper) = (length - slack, length + slack);
        // If cores touch up to the slack, only a search can tell whether they meet.
        (lower > 0.0 || upper <= self.less).then(|| self.bounds(lower, upper, a, between, length))
    }
}
