//! Normal slabs: a slab of a volume along a direction of its own, thinner than any of its k-DOP's slabs.
//!
//! The k-DOP of a smooth patch is as thick as the patch's width times its tilt against the nearest direction; the slab
//! along the patch's mean normal is only as thick as the patch is curved. Near contact, such slabs separate two patches
//! that k-DOPs do not.

use crate::exact::power_of_two;
#[cfg(feature = "alloc")]
use crate::key::{Half, Storage};
use crate::range::Point;

/// The slab of a child along a direction of its own, in 64 bits.
///
/// | bits | meaning |
/// |---|---|
/// | 11..0, 23..12 | x and y of the direction n, signed |
/// | 39..24 | thickness, in lengths of 4096 units of the frame: a non-negative half-precision float |
/// | 63..40 | low end, in lengths of 8 units of the frame, signed |
///
/// The third coordinate of n is not negative, and `|x| + |y| + z` = 2047: n is an exact vector of integers, not of unit
/// length. All points p of the child obey `low <= n . (p - centre) * 2^exponent <= high`.
#[derive(Copy, Clone, PartialEq, Eq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct NormalSlab(u64);

/// The sum of the magnitudes of a direction's coordinates.
const NORMAL_SUM: f64 = 2047.0;

/// The step of the low end.
const LOW_STEP: f64 = 8.0;
/// The unit of thicknesses.
const THICKNESS_UNIT: f64 = 4096.0;
/// The bits of an infinite half-precision float.
const INFINITE: u64 = 0x7c00;
/// The reciprocal of the length of a normal must be finite.
#[cfg(feature = "alloc")]
const SHORTEST: f64 = power_of_two(-1000);
/// The low end has 24 bits.
#[cfg(feature = "alloc")]
const LOW_LIMIT: f64 = ((1 << 23) - 1) as f64;

impl NormalSlab {
    /// Contains everything: its thickness is infinite. Also used for unused lanes.
    pub const EVERYWHERE: Self = Self(INFINITE << 24);

    /// The direction n.
    #[inline(always)]
    #[must_use]
    pub const fn normal(self) -> Point {
        let x = ((self.0 << 52) as i64 >> 52) as f64;
        let y = ((self.0 << 40) as i64 >> 52) as f64;
        [x, y, (NORMAL_SUM - x.abs()) - y.abs()]
    }

    /// The low and the high end, in the frame's unit times the sum of magnitudes of n. Exact; infinite if the thickness
    /// is.
    #[inline(always)]
    #[must_use]
    pub const fn ends(self) -> [f64; 2] {
        // The fields of a half-precision float, moved into place, give its value times 2^-1008.
        let half = (self.0 >> 24) & 0xffff;
        let thickness = f64::from_bits(half << 42) * (THICKNESS_UNIT * power_of_two(1008));
        if half == INFINITE {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let low = (self.0 as i64 >> 40) as f64 * LOW_STEP;
        [low, low + thickness]
    }

    /// Whether the bits are a valid slab.
    #[must_use]
    pub fn is_valid(self) -> bool {
        let [x, y, z] = self.normal();
        let thickness = (self.0 >> 24) & 0xffff;
        x.abs() + y.abs() <= NORMAL_SUM && z >= 0.0 && thickness <= INFINITE
    }

    /// The slab along a direction near `normal`, of any length and either sign. `extent` returns the ends along the
    /// chosen direction, with an error below [`NormalSlab::EXTENT_ERROR`].
    #[cfg(feature = "alloc")]
    pub(crate) fn new(normal: Point, extent: impl FnOnce(Point) -> (f64, f64)) -> Self {
        let [x, y, z] = normal;
        let sum = (x.abs() + y.abs()) + z.abs();
        if !(sum > SHORTEST && sum < f64::INFINITY) {
            return Self::EVERYWHERE;
        }
        let scale = NORMAL_SUM / if z < 0.0 { -sum } else { sum };
        // Rounded by adding a half and truncating; any direction near the given one will do.
        let nearest = |x: f64| (x * scale + if x * scale < 0.0 { -0.5 } else { 0.5 }) as i64;
        let x = nearest(x);
        let rest = NORMAL_SUM as i64 - x.abs();
        let y = nearest(y).clamp(-rest, rest);
        let direction = Self((x as u64 & 0xfff) | (y as u64 & 0xfff) << 12);
        let (low, high) = extent(direction.normal());
        let steps = (low - Self::EXTENT_ERROR) * (1.0 / LOW_STEP);
        if steps.is_nan() || steps.abs() >= LOW_LIMIT {
            return Self::EVERYWHERE;
        }
        let steps = steps as i64 - i64::from(((steps as i64) as f64) > steps);
        let thickness = ((high + Self::EXTENT_ERROR) - steps as f64 * LOW_STEP) * (1.0 / THICKNESS_UNIT);
        if thickness.is_nan() || thickness < 0.0 {
            return Self::EVERYWHERE;
        }
        Self(direction.0 | (Half::round_up(thickness) as u64) << 24 | (steps as u64) << 40)
    }

    /// The maximum error of the ends that a slab is made from: far less than a step.
    #[cfg(feature = "alloc")]
    pub(crate) const EXTENT_ERROR: f64 = 1.0 / (1_u64 << 22) as f64;
}

#[cfg(test)]
#[cfg(feature = "alloc")]
mod tests {
    use super::*;

    #[test]
    fn a_slab_holds_its_direction_and_ends() {
        let normals: [Point; 7] = [
            [1.0, 0.0, 0.0],
            [-1.0, 1e-3, 0.0],
            [0.0, 0.0, -7.0],
            [1e-200, -2e-200, 3e-200],
            [-0.5, 0.5, -1e-17],
            [1e300, 1e300, -1e300],
            [-3.0, -4.0, 5.0],
        ];
        for normal in normals {
            for (low, high) in [(0.0, 0.0), (-12.34, 56.78), (2e7, 2.01e7), (-6e7, -5.9e7), (-5e7, 5e7)] {
                let slab = NormalSlab::new(normal, |_| (low, high));
                let n = slab.normal();
                assert_eq!(n.iter().map(|x| x.abs()).sum::<f64>(), NORMAL_SUM);
                let ends = slab.ends();
                assert!(slab.is_valid() && ends[0] <= low && ends[1] >= high, "{slab:?}");
                assert!(low - ends[0] < 1.01 * LOW_STEP, "{low}");
                assert!(ends[1] - high < LOW_STEP * 1.01 + (high - low) * 2e-3 + 1e-6, "{high}");
                let dot: f64 = n.iter().zip(normal).map(|(a, b)| a * (b / 1e150)).sum::<f64>().abs();
                let lengths =
                    [n, normal.map(|x| x / 1e150)].map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
                if lengths[1] > 1e-140 {
                    assert!(dot > (1.0 - 1e-6) * lengths[0] * lengths[1], "{normal:?} {n:?}");
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_held_is_everywhere() {
        let all = NormalSlab::EVERYWHERE;
        assert!(all.is_valid());
        assert_eq!(all.ends(), [f64::NEG_INFINITY, f64::INFINITY]);
        assert_eq!(NormalSlab::new([0.0; 3], |_| (0.0, 1.0)), all);
        assert_eq!(NormalSlab::new([f64::NAN, 1.0, 0.0], |_| (0.0, 1.0)), all);
        assert_eq!(NormalSlab::new([1.0, 0.0, 0.0], |_| (-1e8, 1e8)), all, "beyond 24 bits");
        assert_eq!(NormalSlab::new([1.0, 0.0, 0.0], |_| (100.0, 0.0)), all, "upside down");
        assert_eq!(NormalSlab::new([1.0, 0.0, 0.0], |_| (f64::NAN, 0.0)), all);
        assert!(!NormalSlab(u64::MAX).is_valid());
    }

    #[test]
    fn ends_hold_extents_that_are_rounded() {
        // More than five roundings of 2^-53 of 2047 * 2^15, the error of the sums of a construction.
        let wrong = power_of_two(-24);
        for steps in [-8_000_000.0, -1.0, 0.0, 1.0, 12_345.0] {
            for thickness in [0.0, 128.0, 4096.0, 12_288.0] {
                // Ends that a slab can hold exactly, with the error of rounded sums.
                let (low, high) = (steps * LOW_STEP, steps * LOW_STEP + thickness);
                let ends = NormalSlab::new([1.0, 2.0, 3.0], |_| (low, high)).ends();
                assert!(ends[0] <= low - wrong && ends[1] >= high + wrong, "{low} {high}: {ends:?}");
            }
        }
    }
}
