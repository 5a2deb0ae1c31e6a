//! Vectors of three numbers. The order of operations is part of the specification: in `f64` every machine gives the
//! same bits.

use core::ops::{Add, Mul, Sub};

/// `(a0 b0 + a1 b1) + a2 b2`.
#[inline(always)]
pub(crate) fn dot<T: Copy + Add<Output = T> + Mul<Output = T>>(a: &[T; 3], b: &[T; 3]) -> T {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// `a - b`.
#[inline(always)]
pub(crate) fn difference<T: Copy + Sub<Output = T>>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The cross product: per axis, two products and their difference.
#[inline(always)]
pub(crate) fn cross<T: Copy + Sub<Output = T> + Mul<Output = T>>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The square root, correctly rounded.
///
/// With `std`, the compiler encodes the instruction for the kernel around it. `libm` has it as inline assembly in the
/// encoding of SSE, which stalls Intel's processors while AVX registers are in use.
#[inline(always)]
pub(crate) fn sqrt(x: f64) -> f64 {
    #[cfg(feature = "std")]
    {
        x.sqrt()
    }
    #[cfg(not(feature = "std"))]
    {
        libm::sqrt(x)
    }
}

/// [`sqrt`] in single precision.
#[inline(always)]
pub(crate) fn sqrt_f32(x: f32) -> f32 {
    #[cfg(feature = "std")]
    {
        x.sqrt()
    }
    #[cfg(not(feature = "std"))]
    {
        libm::sqrtf(x)
    }
}

/// The unit vector along a direction; `None` if the direction is zero or not finite.
pub(crate) fn unit(direction: &[f64; 3]) -> Option<[f64; 3]> {
    let greatest = direction.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !(greatest > 0.0 && greatest.is_finite()) || direction.iter().any(|x| x.is_nan()) {
        return None;
    }
    let scaled = direction.map(|x| x / greatest);
    let length = length(&scaled);
    Some(scaled.map(|x| x / length))
}

/// The square root of [`dot`] of a vector with itself.
#[inline(always)]
pub(crate) fn length(a: &[f64; 3]) -> f64 {
    sqrt(dot(a, a))
}
