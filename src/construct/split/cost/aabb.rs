//! Boxes and their expected cost.

use crate::range::Point;

/// An axis-aligned box.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Aabb {
    low: Point,
    high: Point,
}

impl Aabb {
    /// The empty box: the neutral element of joins, without a measure.
    pub(in crate::construct) const EMPTY: Self =
        Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The box between two corners.
    pub(in crate::construct) const fn of((low, high): (Point, Point)) -> Self {
        Self { low, high }
    }

    /// The box around both. Minima and maxima do not depend on the order of joins, since no coordinate is NaN or -0. A
    /// comparison is one instruction; [`f64::min`], which handles NaN, is four.
    pub(in crate::construct) fn join(&self, other: &Self) -> Self {
        Self {
            low: core::array::from_fn(
                |i| if other.low[i] < self.low[i] { other.low[i] } else { self.low[i] },
            ),
            high: core::array::from_fn(|i| {
                if other.high[i] > self.high[i] { other.high[i] } else { self.high[i] }
            }),
        }
    }

    pub(in crate::construct) fn centre(&self) -> Point {
        core::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    pub(super) fn touches(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    fn widths(&self) -> Point {
        core::array::from_fn(|i| self.high[i] - self.low[i])
    }
}

/// How often a box is expected to meet another body, up to a constant factor.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::construct) enum Measure {
    /// The area: proportional to the probability that a ray meets a convex body (the surface area heuristic, Goldsmith
    /// & Salmon 1987).
    Area,
    /// The cube of the mean width: a bound of the probability to meet another body of its kind. By Blaschke's kinematic
    /// formula, the motions at which two convex bodies meet have the measure `8 pi^2 (V + V') + 2 pi (S M' + M S')`,
    /// with volume, area, and `M = 2 pi` times the mean width. For two equal bodies that is of degree three in their
    /// size, and by the isoperimetric inequalities at most a multiple of `M^3`, which unlike `S M` also distinguishes
    /// long segments from short ones.
    MeanWidth,
}

impl Measure {
    /// The measure of a non-empty box. Finite: coordinates are below 2^300.
    pub(super) fn of(self, bounds: &Aabb) -> f64 {
        let [x, y, z] = bounds.widths();
        match self {
            Self::Area => (x * y + y * z) + z * x,
            Self::MeanWidth => {
                let sum = (x + y) + z;
                sum * sum * sum
            }
        }
    }
}
