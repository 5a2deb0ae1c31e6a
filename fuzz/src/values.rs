//! Values of codes, independent of the library.

use crate::support::dyadic::key_value;
use half::f16;
use simdop::low_level::key::Storage;

/// The value of a code in steps. NaN if a code of fixed point is not a bound, or that of a half float not a number.
pub fn value<S: Storage>(code: i16) -> f64 {
    if S::IS_HALF { half_of(code).into() } else { key_value(code) }
}

/// The half float with an ordered code.
pub fn half_of(code: i16) -> f16 {
    f16::from_bits(if code < 0 { 0x8000 | (!code as u16) } else { code as u16 })
}

/// Whether a code can be a plane of a body: -0 cannot.
pub fn is_plane<S: Storage>(code: i16) -> bool {
    value::<S>(code).is_finite() && !(S::IS_HALF && code == -1)
}

/// Whether a code is the lowest bound that is not below `x`: infinity for `x` above all planes, the lowest plane for
/// `x` below all.
pub fn is_rounded_up<S: Storage>(code: i16, x: f64) -> bool {
    if code == S::INFINITY {
        return x > value::<S>(S::GREATEST);
    }
    let lower = if S::IS_HALF && code == 0 { -2 } else { code.wrapping_sub(1) };
    let is_least = code == !S::GREATEST || value::<S>(lower) < x;
    is_plane::<S>(code) && value::<S>(code) >= x && is_least
}

/// Whether a code is what kernels may round a rotated plane to.
pub fn is_around<S: Storage>(code: i16, x: f32) -> bool {
    let exact = f64::from(x);
    if x.is_nan() {
        return code == S::INFINITY;
    }
    if S::IS_HALF {
        // -0 stands for negative numbers.
        return is_rounded_up::<S>(code, exact)
            || code == -1 && x.is_sign_negative() && is_rounded_up::<S>(0, exact);
    }
    // One step higher if the number is itself a bound and the key of that bound is odd.
    is_rounded_up::<S>(code, exact) || code % 2 == 0 && value::<S>(code - 1) == exact
}
