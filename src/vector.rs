//! Vectors of three numbers, where the order of the operations is part of what is promised: in `f64` every machine rounds alike.

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

/// Two products and their difference along each axis.
#[inline(always)]
pub(crate) fn cross<T: Copy + Sub<Output = T> + Mul<Output = T>>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The root of [`dot`] of a vector and itself.
#[inline(always)]
pub(crate) fn length(a: &[f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}
