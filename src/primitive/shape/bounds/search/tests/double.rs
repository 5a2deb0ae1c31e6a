//! Numbers of 106 bits.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum of two numbers.
#[derive(Copy, Clone, Debug, PartialEq, PartialOrd)]
pub(crate) struct Double(pub(crate) f64, f64);

pub(crate) type Vector = [Double; 3];

pub(crate) const ZERO: Double = Double(0.0, 0.0);

impl From<f64> for Double {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

fn sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let t = s - a;
    Double(s, (a - (s - t)) + (b - t))
}

impl Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (s, t) = (sum(self.0, b.0), sum(self.1, b.1));
        let s = sum(s.0, s.1 + t.0);
        sum(s.0, s.1 + t.1)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = self.0 * b.0;
        let split = |x: f64| {
            let c = x * 134_217_729.0;
            (c - (c - x), x - (c - (c - x)))
        };
        let ((h, l), (m, n)) = (split(self.0), split(b.0));
        let e = ((h * m - p) + h * n + l * m) + l * n;
        sum(p, e + (self.0 * b.1 + self.1 * b.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let q = Self::from(self.0 / b.0);
        let r = self - q * b;
        let q = q + Self::from(r.0 / b.0);
        let r = self - q * b;
        q + Self::from(r.0 / b.0)
    }
}

impl Double {
    pub(crate) fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return ZERO;
        }
        let r = Self::from(self.0.sqrt());
        let half = Self::from(0.5);
        let r = half * (r + self / r);
        half * (r + self / r)
    }

    pub(crate) fn clamp(self, low: f64, high: f64) -> Self {
        if self < Self::from(low) {
            Self::from(low)
        } else if self > Self::from(high) {
            Self::from(high)
        } else {
            self
        }
    }

    pub(crate) fn least(self, b: Self) -> Self {
        if b < self { b } else { self }
    }
}

pub(crate) fn exact(p: &[f64; 3]) -> Vector {
    p.map(Double::from)
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn minus(a: &Vector, b: &Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn along(a: &Vector, t: Double, b: &Vector) -> Vector {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

pub(crate) fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: &Vector) -> Double {
    // Scaled, so that no square is lost.
    let most = a[0].0.abs().max(a[1].0.abs()).max(a[2].0.abs());
    if most == 0.0 {
        return ZERO;
    }
    let scale = Double::from(most);
    let a = a.map(|x| x / scale);
    scale * dot(&a, &a).sqrt()
}
