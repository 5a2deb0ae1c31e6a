//! Points as 32-bit integers: for cores without `f64`, which multiply integers in one cycle.
//!
//! A step of the lattice is 2^-25 of the bodies' largest coordinate, or a little more. This is a hundred times as fine
//! as `f32`, and the difference of two points is exact. A result on the lattice is certain only with a pad for the
//! distance from the exact points, which [`Pose::apply`] moves in `f64`. On each axis, a coordinate is off by less
//! than this many steps:
//!
//! | source | a point that a pose moves | another point |
//! |---|---|---|
//! | coordinates, truncated; a row's sum of magnitudes is at most sqrt(3) (1 + 1e-4) | 1.733 | 1 |
//! | entries of the matrix, truncated at 2^-30, times three coordinates below 2^25 steps | 0.094 | |
//! | the sum of the products, truncated | 1 | |
//! | the translation, truncated | 1 | |
//! | roundings of the moved point, 2^-48 of 2^28 steps; flushed coordinates, 2^-250 of 2^126 steps, at most | 2^-19 | |
//! | total, below | [`OFF_MOVED`] | [`OFF_STILL`] |

use crate::pose::Pose;
use crate::range::Point;

/// Three corners, in steps.
pub type LatticeCorners = [[i32; 3]; 3];

/// Upper bound, in steps, of the error of a moved point's coordinate.
pub(crate) const OFF_MOVED: i32 = 4;
/// The same for a point that is not moved.
pub(crate) const OFF_STILL: i32 = 1;

/// A lattice for two bodies at a relative pose, in the coordinates of the body that is not moved.
#[derive(Copy, Clone, Debug)]
pub struct Lattice {
    /// There are `2^exponent` steps in the bodies' unit.
    pub(crate) exponent: i32,
    /// `2^exponent`, for coordinates in `f32`.
    scale: f32,
    /// The matrix of the pose, times 2^30.
    rows: [[i32; 3]; 3],
    translation: [i32; 3],
}

/// Binary logarithm of an upper bound of the coordinates before a pose moves them, in steps.
const BITS: i32 = 26;

impl Lattice {
    /// For a body that `pose` moves and one that it does not, from their largest coordinates. `None` if the scale is
    /// out of the range of `f32`.
    #[inline(never)]
    pub(crate) fn new(pose: &Pose, moved: f64, still: f64) -> Option<Self> {
        let translation = pose.translation();
        // The moved coordinates count twice.
        let mut top = (logarithm(moved) + 1).max(logarithm(still));
        for x in translation {
            top = top.max(logarithm(x));
        }
        let exponent = BITS - top;
        if !(-126..=126).contains(&exponent) {
            return None;
        }
        let rows = pose.rows();
        let mut lattice = Self {
            exponent,
            scale: f32::from_bits(((exponent + 127) as u32) << 23),
            rows: [[0; 3]; 3],
            translation: [0; 3],
        };
        for i in 0..3 {
            let [x, y, z] = rows[i];
            lattice.rows[i] = [steps(x, 30), steps(y, 30), steps(z, 30)];
            lattice.translation[i] = steps(translation[i], exponent);
        }
        Some(lattice)
    }

    /// A point whose coordinates are stored in single precision.
    #[inline(always)]
    pub(crate) fn single(&self, p: &[f32; 3]) -> [i32; 3] {
        // Scaled by a power of two, so exact but for the truncation to whole steps.
        [(p[0] * self.scale) as i32, (p[1] * self.scale) as i32, (p[2] * self.scale) as i32]
    }

    #[inline(always)]
    pub(crate) fn double(&self, p: &Point) -> [i32; 3] {
        still(p, self.exponent)
    }

    /// Applies the pose. The result is below 2^28 steps: sqrt(3) times less than 2^25 each, plus 2^26.
    #[inline(always)]
    pub(crate) fn moved(&self, p: [i32; 3]) -> [i32; 3] {
        let along = |i: usize| {
            let product = |j: usize| i64::from(self.rows[i][j]) * i64::from(p[j]);
            // Below 2^63 for every p.
            let sum = product(0) + product(1) + product(2);
            ((sum >> 30) as i32).wrapping_add(self.translation[i])
        };
        [along(0), along(1), along(2)]
    }
}

/// The least e such that 2^e exceeds the magnitude.
pub(crate) fn logarithm(x: f64) -> i32 {
    (x.to_bits() >> 52 & 0x7ff) as i32 - 1022
}

/// `x 2^exponent`, below 2^31, truncated towards zero.
fn steps(x: f64, exponent: i32) -> i32 {
    let bits = x.to_bits();
    // The first 32 digits: truncation drops those after them in any case.
    let digits = 1 << 31 | (bits >> 21) as u32;
    let right = 1054 - (bits >> 52 & 0x7ff) as i32 - exponent;
    let magnitude = digits.checked_shr(right as u32).unwrap_or(0) as i32;
    if bits >> 63 == 0 { magnitude } else { magnitude.wrapping_neg() }
}

/// A point that is not moved, such as a frame's centre, in steps of a lattice with `2^exponent` steps to the unit.
pub(crate) fn still(p: &Point, exponent: i32) -> [i32; 3] {
    [steps(p[0], exponent), steps(p[1], exponent), steps(p[2], exponent)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn points_are_off_by_no_more_than_they_say() {
        let mut rng = Rng::new(1733);
        for round in 0..20_000 {
            let (size, away) = (rng.range(0.5, 2.0), rng.range(0.0, 40.0));
            let unit = [1.0, 1e-9, 1e9, 1e30][round % 4];
            let axis = [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0)];
            let length = crate::vector::length(&axis);
            let turn = Pose::turn(&axis.map(|x| x / length), rng.range(-3.2, 3.2));
            let pose = turn.shifted(&[0, 1, 2].map(|_| rng.range(-away, away) * unit));
            let most = size * unit;
            let p: Point = [0, 1, 2].map(|_| f64::from((rng.range(-size, size) * unit) as f32));
            let lattice = Lattice::new(&pose, most, most).unwrap();
            let single = lattice.single(&p.map(|x| x as f32));
            assert_eq!(single, lattice.double(&p));
            let unit = crate::exact::power_of_two(lattice.exponent);
            let off = |x: f64, steps: i32| (x * unit - f64::from(steps)).abs();
            let (image, moved) = (pose.apply(p), lattice.moved(single));
            for i in 0..3 {
                assert!(off(p[i], single[i]) < f64::from(OFF_STILL));
                assert!(off(image[i], moved[i]) < f64::from(OFF_MOVED));
                assert!(moved[i].unsigned_abs() < 1 << 28);
            }
        }
    }

    #[test]
    fn steps_are_cut_off() {
        for (x, exponent, expected) in [
            (1.0, 0, 1),
            (-1.5, 1, -3),
            (-1.99, 0, -1),
            (0.0, 126, 0),
            (-0.0, 0, 0),
            (1e-300, 126, 0),
            (1.5, 30, 3 << 29),
            (2_147_483_647.5, 0, i32::MAX),
            (f64::MAX, -1000, 16_777_215),
        ] {
            assert_eq!(steps(x, exponent), expected, "{x:e} {exponent}");
        }
    }
}
