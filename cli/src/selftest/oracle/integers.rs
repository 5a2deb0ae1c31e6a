//! Floating-point numbers as integers, and vectors of them, for arithmetic without rounding.

use core::cmp::Ordering;
use dashu_int::IBig;

pub(super) type Exact = [IBig; 3];

/// Points as multiples of one power of two, the largest that divides all of their coordinates.
pub(super) fn integers<const N: usize>(points: [[f64; 3]; N]) -> [Exact; N] {
    let parts = points.map(|p| p.map(decoded));
    let exponents = parts.as_flattened().iter().filter(|(mantissa, _)| *mantissa != 0).map(|part| part.1);
    let least = exponents.min().unwrap_or(0);
    let whole = |(mantissa, exponent): (i64, i32)| {
        if mantissa == 0 { IBig::ZERO } else { IBig::from(mantissa) << (exponent - least) as usize }
    };
    parts.map(|p| p.map(whole))
}

/// `x = m 2^e`, with m odd or 0.
fn decoded(x: f64) -> (i64, i32) {
    assert!(x.is_finite(), "the bodies of the self-test are finite");
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (mantissa, exponent) =
        if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    let odd = mantissa >> zeros;
    (if x.is_sign_negative() { -odd } else { odd }, exponent + zeros as i32)
}

pub(super) fn difference(p: &Exact, q: &Exact) -> Exact {
    [&p[0] - &q[0], &p[1] - &q[1], &p[2] - &q[2]]
}

pub(super) fn cross(u: &Exact, v: &Exact) -> Exact {
    let minor = |i: usize, j: usize| &u[i] * &v[j] - &u[j] * &v[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

pub(super) fn dot(u: &Exact, v: &Exact) -> IBig {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

pub(super) fn sign(x: &IBig) -> Ordering {
    x.cmp(&IBig::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_multiples_of_one() {
        let [p, q] = integers([[0.75, -2.0, 0.0], [f64::MIN_POSITIVE, 5e-324, -5e-324]]);
        assert_eq!([&q[1], &q[2]], [&IBig::ONE, &-IBig::ONE]);
        assert_eq!(q[0], IBig::ONE << 52);
        assert_eq!(p, [IBig::from(3) << 1072, -(IBig::ONE << 1075), IBig::ZERO]);
        assert_eq!(integers([[6.0, -12.0, 0.0]]), [[IBig::from(3), IBig::from(-6), IBig::ZERO]]);
        assert_eq!(integers([[0.0; 3]]), [[IBig::ZERO, IBig::ZERO, IBig::ZERO]]);
    }
}
