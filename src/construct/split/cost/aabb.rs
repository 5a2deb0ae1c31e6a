//! Boxes, and what a box is expected to cost.

use crate::range::Point;

/// An axis-aligned box.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Aabb {
    low: Point,
    high: Point,
}

impl Aabb {
    /// The box of nothing: joins as the neutral element, has no measure.
    pub(in crate::construct) const EMPTY: Self =
        Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The box between two corners.
    pub(in crate::construct) const fn of((low, high): (Point, Point)) -> Self {
        Self { low, high }
    }

    /// The box of both. Minima and maxima do not depend on the order in which boxes are joined: no coordinate
    /// is NaN or -0. Comparisons are one instruction where [`f64::min`], which looks for NaN, is four.
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

/// How often a box is expected to meet what it is tested against, up to a factor.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::construct) enum Measure {
    /// The area: a ray's chance to meet a convex body (the surface area heuristic, Goldsmith & Salmon 1987).
    Area,
    /// The cube of the mean width: a bound of the chance to meet another body of its kind. By Blaschke's
    /// kinematic formula, motions that let two convex bodies meet have the measure `8 pi^2 (V + V') + 2
    /// pi (S M' + M S')`, with volume, area, and `M = 2 pi` times the mean width. For two alike that is
    /// of the third degree in their size, and by the isoperimetric inequalities no more than a multiple
    /// of `M^3`, which unlike `S M` also tells long segments from short ones.
    MeanWidth,
}

impl Measure {
    /// The measure of a box that is not empty. Finite: coordinates are below 2^300.
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
