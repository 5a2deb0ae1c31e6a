//! Exact arithmetic on floating-point numbers, as integers times powers of two; and keys, by their definition.

use core::cmp::Ordering;
use core::ops::{Add, Mul, Sub};
use dashu_int::IBig;

/// `mantissa * 2^exponent`: sums and products of finite floats without rounding.
#[derive(Clone, Debug)]
pub(crate) struct Dyadic {
    mantissa: IBig,
    exponent: i32,
}

impl Dyadic {
    pub(crate) fn zero() -> Self {
        Self { mantissa: IBig::from(0), exponent: 0 }
    }

    /// `2^exponent`.
    pub(crate) fn power_of_two(exponent: i32) -> Self {
        Self { mantissa: IBig::from(1), exponent }
    }

    pub(crate) fn abs(self) -> Self {
        if self < Self::zero() { Self::zero() - self } else { self }
    }

    /// The mantissas for the smallest of the exponents.
    pub(crate) fn integers<const N: usize>(numbers: [Self; N]) -> [IBig; N] {
        let least = numbers.iter().map(|x| x.exponent).min().unwrap_or(0);
        numbers.map(|x| x.mantissa << (x.exponent - least) as usize)
    }

    /// Both mantissas for the smaller exponent.
    fn aligned(self, other: Self) -> (IBig, IBig, i32) {
        let exponent = self.exponent.min(other.exponent);
        let raised = |x: Self| x.mantissa << (x.exponent - exponent) as usize;
        (raised(self), raised(other), exponent)
    }
}

impl From<f64> for Dyadic {
    fn from(x: f64) -> Self {
        assert!(x.is_finite(), "only finite numbers are dyadic");
        let bits = x.to_bits();
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
        let (magnitude, exponent) =
            if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        let mantissa = IBig::from(if x.is_sign_negative() { -magnitude } else { magnitude });
        // A common exponent of all zeros keeps sums short.
        Self { mantissa, exponent: if magnitude == 0 { 0 } else { exponent } }
    }
}

impl Add for Dyadic {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { mantissa: a + b, exponent }
    }
}

impl Sub for Dyadic {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { mantissa: a - b, exponent }
    }
}

impl Mul for Dyadic {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        let (a, b, _) = self.clone().aligned(other.clone());
        a.cmp(&b)
    }
}

/// `n . p`.
pub(crate) fn dot(n: [Dyadic; 3], p: [Dyadic; 3]) -> Dyadic {
    n.into_iter().zip(p).fold(Dyadic::zero(), |sum, (n, p)| sum + n * p)
}

/// `n . p` in `f64`.
pub(crate) fn dot_rounded(n: &[f64; 3], p: &[f64; 3]) -> f64 {
    (n[0] * p[0] + n[1] * p[1]) + n[2] * p[2]
}

fn sign(x: &Dyadic) -> i32 {
    match x.cmp(&Dyadic::zero()) {
        Ordering::Less => -1,
        Ordering::Equal => 0,
        Ordering::Greater => 1,
    }
}

/// The sign of the determinant of `p - o`, `q - o` and `r - s`.
pub(crate) fn sign_of_determinant(o: &[f64; 3], p: &[f64; 3], q: &[f64; 3], [r, s]: [&[f64; 3]; 2]) -> i32 {
    let rough: [[f64; 3]; 3] = [[p, o], [q, o], [r, s]].map(|[p, o]| core::array::from_fn(|i| p[i] - o[i]));
    let terms = |f: fn(f64) -> f64| {
        let [u, v, w] = rough.map(|v| v.map(f));
        (
            w,
            core::array::from_fn::<[f64; 2], 3, _>(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                [u[j] * v[k], u[k] * v[j]]
            }),
        )
    };
    let (w, minors) = terms(core::convert::identity);
    let determinant: f64 = (0..3).map(|i| w[i] * (minors[i][0] - minors[i][1])).sum();
    let (w, minors) = terms(f64::abs);
    let permanent: f64 = (0..3).map(|i| w[i] * (minors[i][0] + minors[i][1])).sum();
    if determinant.abs() > 1e-13 * permanent {
        return if determinant > 0.0 { 1 } else { -1 };
    }
    let exact = |p: &[f64; 3], o: &[f64; 3]| -> [Dyadic; 3] {
        core::array::from_fn(|i| Dyadic::from(p[i]) - Dyadic::from(o[i]))
    };
    let (u, v, w) = (exact(p, o), exact(q, o), exact(r, s));
    let minor = |j: usize, k: usize| u[j].clone() * v[k].clone() - u[k].clone() * v[j].clone();
    sign(&(w[0].clone() * minor(1, 2) + w[1].clone() * minor(2, 0) + w[2].clone() * minor(0, 1)))
}

/// Whether all points of one set lie before all of the other along `n` or `-n`, by more than `margin`.
/// Intervals that are far wider than the rounding errors decide most cases.
pub(crate) fn apart_along(n: &[f64; 3], one: &[[f64; 3]], other: &[[f64; 3]], margin: f64) -> bool {
    let reach = margin * dot_rounded(n, n).sqrt();
    let size =
        one.iter().chain(other).fold(reach, |size, p| size + dot_rounded(&n.map(f64::abs), &p.map(f64::abs)));
    let (mut before, mut after) = (f64::INFINITY, f64::INFINITY);
    for p in one {
        for q in other {
            let gap = dot_rounded(n, q) - dot_rounded(n, p);
            (before, after) = (before.min(gap), after.min(-gap));
        }
    }
    let gap = before.max(after);
    if (gap - reach).abs() > 64.0 * f64::EPSILON * size {
        return gap > reach;
    }
    let along = |p: &[f64; 3]| dot(n.map(Dyadic::from), p.map(Dyadic::from));
    let [one, other] = [one, other].map(|points| {
        let supports: Vec<Dyadic> = points.iter().map(along).collect();
        (supports.iter().min().unwrap().clone(), supports.into_iter().max().unwrap())
    });
    let gap = (other.0 - one.1).max(one.0 - other.1);
    let square = dot(n.map(Dyadic::from), n.map(Dyadic::from)) * Dyadic::from(margin) * Dyadic::from(margin);
    gap > Dyadic::zero() && gap.clone() * gap > square
}

/// The value of a code, independent of the library: the code plus half a step. NaN if the code is not a bound.
pub(crate) fn key_value(code: i16) -> f64 {
    match code {
        -32_766..=32_765 => 0.5 + f64::from(code),
        32_766 => f64::INFINITY,
        _ => f64::NAN,
    }
}

/// Whether `code` is `x` rounded up to a key: the key is at least `x`, and the next lower key is less.
pub(crate) fn is_rounded_up(code: i16, x: &Dyadic) -> bool {
    let value = Dyadic::from(key_value(code));
    value >= *x && value - Dyadic::from(1.0) < *x
}

/// Whether a code is that of the least half float not below x, and not of -0.
pub(crate) fn is_rounded_up_to_half(code: i16, x: &Dyadic) -> bool {
    let value = |code: i16| {
        let bits = if code < 0 { !code as u16 | 0x8000 } else { code as u16 };
        let (exponent, places) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
        let magnitude = if exponent == 0 {
            places * 2.0_f64.powi(-24)
        } else {
            (1024.0 + places) * 2.0_f64.powi(exponent - 25)
        };
        Dyadic::from(if code < 0 { -magnitude } else { magnitude })
    };
    let below = if code == 0 { -2 } else { code - 1 };
    code != -1 && value(code) >= *x && value(below) < *x
}

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (
        is_rounded_up,
        is_rounded_up_to_half,
        Dyadic::integers::<1>,
        Dyadic::power_of_two,
        Dyadic::abs,
        dot,
        dot_rounded,
        sign_of_determinant,
        apart_along,
    );
};
