//! Integers by degree, their vectors, and comparisons with square roots.
//!
//! Lengths are multiples of 2^-302. Differences of points are below 2^307, since the corners of a cuboid, sums of four
//! numbers, are below 2^305; sums of radii and a margin are below 2^311. So an integer of degree one has at most 613
//! bits, one of degree d has 613 d and a few for its number of terms, and 640 d are enough.

use crate::exact::wide::Wide;

pub(super) type Degree1 = Wide<10>;
pub(super) type Degree2 = Wide<20>;
pub(super) type Degree3 = Wide<30>;
pub(super) type Degree4 = Wide<40>;
pub(super) type Degree6 = Wide<60>;
pub(super) type Degree7 = Wide<70>;
pub(super) type Degree8 = Wide<80>;
pub(super) type Degree10 = Wide<100>;
pub(super) type Degree12 = Wide<120>;

/// The number 1, as a factor.
pub(super) fn one() -> Degree1 {
    Degree1::new(1.0, 0)
}

/// The dot product, in a width that must have room for it.
#[inline(never)]
pub(super) fn dot<const M: usize, const N: usize, const R: usize>(
    u: &[Wide<M>; 3],
    v: &[Wide<N>; 3],
) -> Wide<R> {
    let mut sum = Wide::<R>::ZERO;
    for k in 0..3 {
        sum = sum.plus(&u[k].times(&v[k]));
    }
    sum
}

/// `x u - y v`, in a width that must have room for it. Not inlined: its temporaries would enlarge the stack frames of
/// its callers.
#[inline(never)]
pub(super) fn minor<const L: usize, const M: usize, const N: usize, const O: usize, const R: usize>(
    x: &Wide<L>,
    u: &Wide<M>,
    y: &Wide<N>,
    v: &Wide<O>,
) -> Wide<R> {
    let product: Wide<R> = x.times(u);
    product.minus(&y.times(v))
}

/// The cross product, in a width that must have room for it.
#[inline(never)]
pub(super) fn cross<const M: usize, const N: usize, const R: usize>(
    u: &[Wide<M>; 3],
    v: &[Wide<N>; 3],
) -> [Wide<R>; 3] {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        minor(&u[i], &v[j], &u[j], &v[i])
    })
}

#[inline(never)]
pub(super) fn difference<const L: usize>(u: &[Wide<L>; 3], v: &[Wide<L>; 3]) -> [Wide<L>; 3] {
    [0, 1, 2].map(|k| u[k].minus(&v[k]))
}

pub(super) fn is_zero<const L: usize>(u: &[Wide<L>; 3]) -> bool {
    u.iter().all(|x| x.sign() == 0)
}

#[inline(never)]
pub(super) fn negative<const L: usize>(x: &Wide<L>) -> Wide<L> {
    Wide::ZERO.minus(x)
}

#[inline(never)]
pub(super) fn twice<const L: usize>(x: &Wide<L>) -> Wide<L> {
    x.plus(x)
}

/// `x <= y`
#[inline(never)]
pub(super) fn is_at_most<const L: usize>(x: &Wide<L>, y: &Wide<L>) -> bool {
    x.minus(y).sign() <= 0
}

/// `x <= sqrt(numerator / denominator)`, for a positive denominator and a numerator that is not negative.
#[inline(never)]
pub(super) fn is_at_most_root<const L: usize, const M: usize, const N: usize>(
    x: &Wide<L>,
    numerator: &Wide<N>,
    denominator: &Wide<M>,
) -> bool {
    x.sign() <= 0 || excess_of_square(x, numerator, denominator) <= 0
}

/// `x >= sqrt(numerator / denominator)`, for a positive denominator and a numerator that is not negative.
#[inline(never)]
pub(super) fn is_at_least_root<const L: usize, const M: usize, const N: usize>(
    x: &Wide<L>,
    numerator: &Wide<N>,
    denominator: &Wide<M>,
) -> bool {
    x.sign() >= 0 && excess_of_square(x, numerator, denominator) >= 0
}

/// The sign of `x^2 denominator - numerator`.
fn excess_of_square<const L: usize, const M: usize, const N: usize>(
    x: &Wide<L>,
    numerator: &Wide<N>,
    denominator: &Wide<M>,
) -> i32 {
    let square: Wide<N> = x.times(x);
    minor::<N, M, N, 10, N>(&square, denominator, numerator, &one()).sign()
}
