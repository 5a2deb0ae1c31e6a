//! Integers in units of a power of two, vectors of them, and exact signs of sums with square roots.

use core::cmp::Ordering;

use dashu_int::IBig;
use dashu_int::ops::{BitTest, SquareRoot};

pub(crate) type Vector = [IBig; 3];

/// `x = m 2^e` with m odd, or both zero.
pub(crate) fn parts(x: f64) -> (i64, i32) {
    assert!(x.is_finite(), "the oracle knows finite numbers only");
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let m = if field == 0 { fraction } else { fraction | 1 << 52 };
    if m == 0 {
        return (0, 0);
    }
    let zeros = m.trailing_zeros();
    (if x < 0.0 { -(m >> zeros) } else { m >> zeros }, field.max(1) - 1075 + zeros as i32)
}

/// The least exponent of nonzero numbers as [`parts`] writes them, if any is nonzero.
pub(crate) fn least_exponent(numbers: impl IntoIterator<Item = f64>) -> Option<i32> {
    numbers.into_iter().filter(|x| *x != 0.0).map(|x| parts(x).1).min()
}

/// `x / 2^exponent`, which must be an integer.
pub(crate) fn integer(x: f64, exponent: i32) -> IBig {
    let (m, e) = parts(x);
    if m == 0 { IBig::ZERO } else { IBig::from(m) << (e - exponent) as usize }
}

pub(crate) fn add(u: &Vector, v: &Vector) -> Vector {
    core::array::from_fn(|k| &u[k] + &v[k])
}

pub(crate) fn sub(u: &Vector, v: &Vector) -> Vector {
    core::array::from_fn(|k| &u[k] - &v[k])
}

pub(crate) fn times(u: &Vector, by: &IBig) -> Vector {
    core::array::from_fn(|k| &u[k] * by)
}

pub(crate) fn negated(u: &Vector) -> Vector {
    core::array::from_fn(|k| -&u[k])
}

pub(crate) fn dot(u: &Vector, v: &Vector) -> IBig {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

pub(crate) fn square(u: &Vector) -> IBig {
    dot(u, u)
}

pub(crate) fn cross(u: &Vector, v: &Vector) -> Vector {
    let minor = |k: usize, l: usize| &u[k] * &v[l] - &u[l] * &v[k];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

pub(crate) fn is_zero(u: &Vector) -> bool {
    u.iter().all(|x| *x == IBig::ZERO)
}

pub(crate) fn sign(x: &IBig) -> Ordering {
    x.cmp(&IBig::ZERO)
}

/// The largest number of bits of a component.
pub(crate) fn bits(u: &Vector) -> usize {
    u.iter().map(BitTest::bit_len).max().unwrap_or(0)
}

/// A multiple of `u` by a power of two, rounded, with components of at most `most` bits. Zero only if `u` is.
pub(crate) fn shortened(u: &Vector, most: usize) -> Vector {
    let excess = bits(u).saturating_sub(most);
    if excess == 0 { u.clone() } else { core::array::from_fn(|k| &u[k] >> excess) }
}

/// The square root of a number that is not negative, rounded down.
pub(crate) fn root_down(x: &IBig) -> IBig {
    IBig::from(x.sqrt())
}

/// The square root of a number that is not negative, rounded up.
pub(crate) fn root_up(x: &IBig) -> IBig {
    let root = root_down(x);
    if &root * &root == *x { root } else { root + 1 }
}

/// The quotient by a positive number, rounded down.
pub(crate) fn over_down(x: &IBig, by: &IBig) -> IBig {
    let quotient = x / by;
    if &quotient * by > *x { quotient - 1 } else { quotient }
}

/// The quotient by a positive number, rounded up.
pub(crate) fn over_up(x: &IBig, by: &IBig) -> IBig {
    -over_down(&-x, by)
}

/// The sign of `a + b sqrt(p)`.
pub(crate) fn sign_with_root(a: &IBig, b: &IBig, p: &IBig) -> Ordering {
    let (first, second) = (sign(a), if *p == IBig::ZERO { Ordering::Equal } else { sign(b) });
    match second {
        Ordering::Equal => first,
        _ if first == second || first == Ordering::Equal => second,
        Ordering::Greater => (b * b * p).cmp(&(a * a)),
        Ordering::Less => (a * a).cmp(&(b * b * p)),
    }
}

/// The sign of `a + b sqrt(p) + c sqrt(q)`.
pub(crate) fn sign_with_roots(a: &IBig, (b, p): (&IBig, &IBig), (c, q): (&IBig, &IBig)) -> Ordering {
    let (x, y) = (b * b * p, c * c * q);
    // b sqrt(p) + c sqrt(q) has the sign of the term with the larger square.
    let roots = match (sign(b), sign(c)) {
        (i, j) if i == j => i,
        (i, Ordering::Equal) => i,
        (Ordering::Equal, j) => j,
        (i, j) => match x.cmp(&y) {
            Ordering::Greater => i,
            Ordering::Less => j,
            Ordering::Equal => Ordering::Equal,
        },
    };
    let roots = if x == IBig::ZERO && y == IBig::ZERO { Ordering::Equal } else { roots };
    let first = sign(a);
    match roots {
        Ordering::Equal => first,
        _ if first == roots || first == Ordering::Equal => roots,
        // Opposite signs: compare the square of the roots' sum, x + y + 2 b c sqrt(p q), with that of a.
        _ => {
            let order = sign_with_root(&(x + y - a * a), &(b * c * 2), &(p * q));
            if roots == Ordering::Greater { order } else { order.reverse() }
        }
    }
}

/// `x / 2^bits`, up to rounding.
pub(crate) fn to_f64(x: &IBig, bits: usize) -> f64 {
    // Only the leading bits: larger numbers overflow.
    let excess = bits.saturating_sub(200);
    leading(x, excess) * 2_f64.powi(-((bits - excess) as i32))
}

/// `x 2^exponent`, up to rounding.
pub(crate) fn scaled(x: &IBig, exponent: i32) -> f64 {
    let excess = x.bit_len().saturating_sub(64);
    leading(x, excess) * 2_f64.powi(exponent + excess as i32)
}

/// `x / 2^excess`. Does not copy the number if there is nothing to drop.
fn leading(x: &IBig, excess: usize) -> f64 {
    if excess == 0 { x.to_f64().value() } else { (x >> excess).to_f64().value() }
}

#[test]
fn signs_of_roots() {
    let n = |x: i64| IBig::from(x);
    for a in -8..=8_i64 {
        for b in -3..=3_i64 {
            for p in [0, 1, 2, 4, 9] {
                for c in -3..=3_i64 {
                    for q in [0, 1, 3, 4, 8] {
                        let value = a as f64 + b as f64 * (p as f64).sqrt() + c as f64 * (q as f64).sqrt();
                        let value = if value.abs() < 1e-12 { 0.0 } else { value };
                        let got = sign_with_roots(&n(a), (&n(b), &n(p)), (&n(c), &n(q)));
                        assert_eq!(Some(got), value.partial_cmp(&0.0), "{a} + {b} sqrt {p} + {c} sqrt {q}");
                    }
                }
            }
        }
    }
    assert_eq!((over_down(&n(-7), &n(2)), over_up(&n(-7), &n(2))), (n(-4), n(-3)));
    assert_eq!((root_down(&n(8)), root_up(&n(8)), root_up(&n(9))), (n(2), n(3), n(3)));
    assert_eq!((n(-7) >> 1_usize, to_f64(&n(-7), 1)), (n(-4), -3.5));
}
