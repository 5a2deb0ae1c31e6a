//! Exact signs of determinants of coordinates, for predicates whose filters cannot decide.
//!
//! A determinant is a sum of products of three coordinates. The positive products are added up in one integer and the
//! negative ones in another; comparing the two gives the sign.
//!
//! Coordinates are in [range](crate::range): zero or from 2^-250 to 2^302. Then a coordinate, or a difference of two
//! that is exact in `f64`, is zero or from 2^-302 to 2^303, that is `m 2^e` for an integer m below 2^53 and an
//! exponent e from -354 to 251. So each product is an integer below 2^159, times a power of two from 2^-1062 to
//! 2^753.

use super::two_sum;
use crate::range::Point;

/// The exponent of the unit of the sums: that of the least product.
const UNIT: i32 = 3 * -354;

/// The exponent of the greatest product, relative to the unit.
const GREATEST: i32 = 3 * 251 - UNIT;

/// Words for a sum of 24 of the greatest products.
const WORDS: usize = (GREATEST as usize + 159 + 5).div_ceil(64);

/// The sums of the positive and of the negative products, least significant word first.
struct Products([[u64; WORDS]; 2]);

/// For each product of a determinant, the column for each of the three rows, and whether it is subtracted.
const TERMS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], false),
    ([1, 2, 0], false),
    ([2, 0, 1], false),
    ([0, 2, 1], true),
    ([1, 0, 2], true),
    ([2, 1, 0], true),
];

/// The side of the plane through three points that `p` is on: -1, 0 or 1, positive where the three are
/// counterclockwise.
#[cold]
#[inline(never)]
pub(crate) fn side([a, b, c]: &[Point; 3], p: &Point) -> i8 {
    let mut points = [*a, *b, *c, *p];
    for k in 0..3 {
        move_to_first(&mut points, k);
    }
    let [a, b, c, p] = &points;
    let mut products = Products::NONE;
    // Expand along the column of ones of the 4x4 determinant.
    for (rows, is_subtracted) in
        [([b, c, p], false), ([a, c, p], true), ([a, b, p], false), ([a, b, c], true)]
    {
        products.add_determinant(rows, is_subtracted);
    }
    products.sign()
}

/// Translates the points along an axis so that the first is at zero, if all differences are exact in `f64`. They
/// usually are for points that are near each other or on a grid. Fewer products are nonzero then.
fn move_to_first(points: &mut [Point; 4], axis: usize) {
    let first = points[0][axis];
    let mut moved = [0.0; 4];
    for (moved, point) in moved.iter_mut().zip(&*points) {
        let error;
        (*moved, error) = two_sum(point[axis], -first);
        if error != 0.0 {
            return;
        }
    }
    for (point, moved) in points.iter_mut().zip(moved) {
        point[axis] = moved;
    }
}

/// The sign of the area of a triangle in the plane, positive when counterclockwise: -1, 0 or 1.
pub(crate) fn area(corners: [[f64; 2]; 3]) -> i8 {
    let corners = corners.map(|[x, y]| [x, y, 0.0]);
    let [x, y, _] = corners[0];
    side(&corners, &[x, y, 1.0])
}

impl Products {
    const NONE: Self = Self([[0; WORDS]; 2]);

    #[inline(never)]
    fn add_determinant(&mut self, rows: [&Point; 3], is_subtracted: bool) {
        if rows.iter().any(|row| row.iter().all(|x| is_zero(*x))) {
            return;
        }
        for ([i, j, k], is_odd) in TERMS {
            self.add([rows[0][i], rows[1][j], rows[2][k]], is_odd != is_subtracted);
        }
    }

    /// Adds or subtracts a product.
    fn add(&mut self, factors: [f64; 3], is_subtracted: bool) {
        if factors.iter().any(|x| is_zero(*x)) {
            return;
        }
        let [(x, e), (y, f), (z, g)] = factors.map(parts);
        let is_negative =
            factors.iter().fold(is_subtracted, |sign, factor| sign != factor.is_sign_negative());
        // Clamped for numbers out of range, for which any sign will do.
        let shift = (e + f + g - UNIT).clamp(0, GREATEST) as usize;
        let (first, bits) = (shift / 64, shift % 64);
        let pair = u128::from(x) * u128::from(y);
        let low = u128::from(pair as u64) * u128::from(z);
        let high = (pair >> 64) * u128::from(z) + (low >> 64);
        let product = [0, low as u64, high as u64, (high >> 64) as u64, 0];
        let words: [u64; 4] =
            core::array::from_fn(|i| product[i + 1] << bits | product[i] >> 1 >> (63 - bits));
        let (_, sum) = self.0[usize::from(is_negative)].split_at_mut(first);
        let mut carry = false;
        for (word, more) in sum.iter_mut().zip(words) {
            let (half, over) = word.overflowing_add(more);
            let (whole, over_again) = half.overflowing_add(u64::from(carry));
            (*word, carry) = (whole, over | over_again);
        }
        for word in sum.iter_mut().skip(words.len()) {
            if !carry {
                break;
            }
            (*word, carry) = word.overflowing_add(1);
        }
    }

    fn sign(&self) -> i8 {
        let [plus, minus] = &self.0;
        plus.iter().rev().cmp(minus.iter().rev()) as i8
    }
}

fn is_zero(x: f64) -> bool {
    x.to_bits() << 1 == 0
}

/// The integer m below 2^53 and the exponent e such that a normal number has the magnitude m 2^e.
fn parts(x: f64) -> (u64, i32) {
    let bits = x.to_bits();
    (bits & ((1 << 52) - 1) | 1 << 52, (bits >> 52 & 0x7ff) as i32 - 1075)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::power_of_two;
    use crate::range::MIN_COORDINATE;
    use crate::rng::Rng;
    use dashu_int::IBig;

    /// A coordinate as a multiple of 2^-302.
    fn integer(x: f64) -> IBig {
        if x == 0.0 {
            return IBig::ZERO;
        }
        let (m, e) = parts(x);
        let magnitude = IBig::from(m) << (e + 302) as usize;
        if x < 0.0 { -magnitude } else { magnitude }
    }

    fn expected(t: &[Point; 3], p: &Point) -> i8 {
        let [origin, rest @ ..] = [t[0], t[1], t[2], *p].map(|point| point.map(integer));
        let [u, v, w]: [[IBig; 3]; 3] = rest.map(|point| [0, 1, 2].map(|k| &point[k] - &origin[k]));
        let minor = |i: usize, j: usize| &u[i] * &v[j] - &u[j] * &v[i];
        let sum = minor(1, 2) * &w[0] + minor(2, 0) * &w[1] + minor(0, 1) * &w[2];
        i8::from(sum > IBig::ZERO) - i8::from(sum < IBig::ZERO)
    }

    /// Points with small integer coordinates in a common plane. Each axis is scaled by a power of two, which keeps
    /// them coplanar.
    fn in_a_plane(rng: &mut Rng) -> [Point; 4] {
        let mut small = |reach: i64| [0; 3].map(|_| rng.int(-reach, reach) as f64);
        let (origin, u, v) = (small(1000), small(1000), small(1000));
        let like = rng.below(2) == 0;
        let first = rng.int(-250, 280) as i32;
        let scales = [0, 1, 2].map(|k| {
            let other = rng.int(-250, 280) as i32;
            power_of_two(if like || k == 0 { first } else { other })
        });
        [0; 4].map(|_| {
            let (i, j) = (rng.int(-9, 9) as f64, rng.int(-9, 9) as f64);
            [0, 1, 2].map(|k| (origin[k] + i * u[k] + j * v[k]) * scales[k])
        })
    }

    /// The next coordinate in range; for zero, the smallest.
    fn beside(x: f64) -> f64 {
        let next = x.next_up();
        if next.abs() < MIN_COORDINATE { if x < 0.0 { 0.0 } else { MIN_COORDINATE } } else { next }
    }

    /// Coordinates over the whole range, of points in a plane and one ulp off it, with and without exact differences
    /// in `f64`.
    #[test]
    fn sides_are_those_of_integers() {
        let mut rng = Rng::new(302);
        let mut counts = [[0; 3]; 5];
        for i in 0..50_000 {
            let mut points = in_a_plane(&mut rng);
            let kind = i % counts.len();
            let whole = |rng: &mut Rng| (rng.u64() >> 11) as f64 + 1.0;
            match kind {
                0 => {}
                1 => {
                    let x = &mut points[rng.below(4) as usize][rng.below(3) as usize];
                    *x = beside(*x);
                }
                // Rounded: an odd factor makes each coordinate use all bits.
                2 => points = points.map(|point| point.map(|x| x * (1.0 + 123.0 * f64::EPSILON))),
                // Differences as small as possible, of several sizes.
                3 => {
                    points = points.map(|point| {
                        point.map(|_| MIN_COORDINATE * (1.0 + rng.below(9) as f64 * f64::EPSILON))
                    });
                }
                // Arbitrary numbers.
                _ => {
                    points = points.map(|point| {
                        point.map(|_| whole(&mut rng) * power_of_two(rng.int(-250, 248) as i32))
                    });
                }
            }
            let [a, b, c, p] = points;
            let side = side(&[a, b, c], &p);
            assert_eq!(side, expected(&[a, b, c], &p), "{points:?}");
            counts[kind][(side + 1) as usize] += 1;
            let flat = [a, b, c].map(|[x, y, _]| [x, y]);
            let over = [[a[0], a[1], 0.0], [b[0], b[1], 0.0], [c[0], c[1], 0.0]];
            assert_eq!(area(flat), expected(&over, &[a[0], a[1], 1.0]), "{flat:?}");
        }
        let [plane, beside_it, rounded, tiny, any] = counts;
        assert_eq!([plane[0], plane[2]], [0, 0], "what is in a plane is on no side of it");
        for (name, [below, on, above]) in [("beside", beside_it), ("rounded", rounded), ("tiny", tiny)] {
            assert!(below > 1000 && on > 100 && above > 1000, "{name}: {below} {on} {above}");
        }
        assert!(any[0] > 1000 && any[2] > 1000, "{any:?}");
    }

    /// Sums whose words are often all ones, so that carries propagate far.
    #[test]
    fn sums_are_those_of_integers() {
        let mut rng = Rng::new(304);
        let value = |words: &[u64; WORDS]| {
            words.iter().rev().fold(IBig::ZERO, |sum, word| (sum << 64) + IBig::from(*word))
        };
        for _ in 0..20_000 {
            let mut products = Products::NONE;
            for word in products.0.as_flattened_mut() {
                *word = *rng.pick(&[0, u64::MAX, u64::MAX - 1, 1 << 63]);
            }
            // Leave room for another product.
            products.0.iter_mut().for_each(|words| words[WORDS - 1] = 0);
            let before = products.0.each_ref().map(value);
            let factors = [0; 3].map(|_| {
                let x = (rng.u64() >> 11) as f64 + 1.0;
                x * power_of_two(rng.int(-302, 248) as i32) * if rng.below(2) == 0 { 1.0 } else { -1.0 }
            });
            let is_subtracted = rng.below(2) == 0;
            products.add(factors, is_subtracted);
            let product = factors.iter().fold(IBig::from(1_u8), |product, x| {
                let (m, e) = parts(*x);
                (product * IBig::from(m)) << (e + 354) as usize
            });
            let is_negative = factors.iter().filter(|x| **x < 0.0).count() % 2 == 1;
            let mut after = before;
            after[usize::from(is_negative != is_subtracted)] += product;
            assert_eq!(products.0.each_ref().map(value), after, "{factors:?}");
            let sign = i8::from(after[0] > after[1]) - i8::from(after[0] < after[1]);
            assert_eq!(products.sign(), sign);
        }
    }

    /// Numbers out of range must not panic.
    #[test]
    fn numbers_out_of_range_are_no_panic() {
        let numbers = [0.0, 5e-324, 1e-300, 1.0, -1e300, f64::MAX, f64::NEG_INFINITY, f64::NAN];
        let mut rng = Rng::new(303);
        for _ in 0..20_000 {
            let [a, b, c, p]: [Point; 4] = [[0; 3]; 4].map(|point| point.map(|_| *rng.pick(&numbers)));
            assert!((-1..=1).contains(&side(&[a, b, c], &p)));
        }
    }
}
