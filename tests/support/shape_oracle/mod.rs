//! An oracle for the distance of two shapes. It shares neither code nor method with the library's pair functions: it
//! reads the numbers of two shapes and computes in integers of any size.
//!
//! All numbers of a pair become integers by one power of two. Let `reach` be the sum of both radii and of a margin: two
//! shapes are within the margin if and only if their cores are at most `reach` apart.
//!
//!  cores | method of the decision |
//! ---|---|
//!  half-space, any | the lowest point in closed form; a sign with at most two square roots ([`half_space`]) |
//!  polytope, polytope | least norm of the differences of points, by simplices of corners in integers ([`nearest`]) |
//!  point, cylinder or cone | the distance in closed form, as above ([`round`]) |
//!  polytope, cylinder or cone, without reach | whether one of finitely many rational points is in both ([`round`]) |
//!  any other with a cylinder or cone | bounds of the distance that are refined to 2^-64 of the size ([`nearest`]) |
//!
//! The last may be [`Judgement::TooCloseToCall`]; all others are exact. For speed, bounds in `f64` that are far wider
//! than the rounding errors come first ([`rough`]).

mod body;
mod half_space;
mod nearest;
mod numbers;
mod rough;
mod round;
mod simplex;

use self::body::{Body, Pair};
use self::half_space::{half_space_bounds, half_spaces_reach};
use self::nearest::{refine, square_of_distance};
use self::numbers::{integer, least_exponent, over_down, over_up, root_down, root_up, scaled};
use self::rough::Rough;
use dashu_int::IBig;
use dashu_int::ops::BitTest;
use simdop::primitive::shape::{Core, Shape};

/// The oracle's judgement of a pair and a margin.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Judgement {
    /// The distance is greater than the margin.
    Apart,
    /// The distance is at most the margin.
    Meets,
    /// The difference of the distance and the margin is below 2^-60 of the size, and the cores are not polytopes.
    TooCloseToCall,
}

/// Certain bounds of a distance, in units of 2^exponent. Zero is the distance of all shapes that meet.
#[derive(Clone, Debug)]
pub(crate) struct Interval {
    pub(crate) lower: IBig,
    pub(crate) upper: IBig,
    pub(crate) exponent: i32,
    /// The pair's size is about 2^size units.
    pub(crate) size: usize,
}

/// Bits of a pair's size where the result is rounded.
const PRECISION: usize = 168;

/// Bits of a pair's size to which bounds are refined.
const RESOLVED: usize = 64;

/// Whether the distance of two shapes is at most `margin`, which is not negative.
pub(crate) fn meets(a: &Shape, b: &Shape, margin: f64) -> Judgement {
    judge(a, b, margin, RESOLVED)
}

/// [`meets`] for pairs that are too close for it: with bounds to 2^-240 of the size.
pub(crate) fn meets_finely(a: &Shape, b: &Shape, margin: f64) -> Judgement {
    judge(a, b, margin, 240)
}

/// The judgement by bounds that are refined to 2^-`resolved` of the size.
fn judge(a: &Shape, b: &Shape, margin: f64, resolved: usize) -> Judgement {
    let exact = |is_within: bool| if is_within { Judgement::Meets } else { Judgement::Apart };
    let mut pair = Pair::new(a, b, margin, 0);
    if let Some(is_within) = half_spaces_reach(&pair) {
        return exact(is_within);
    }
    let rough = Rough::new(&pair);
    if let Some(is_within) = rough.is_within(&pair.reach, pair.bits) {
        return exact(is_within);
    }
    match (&pair.a, &pair.b) {
        (Body::Hull(p), Body::Hull(q)) => {
            let (numerator, denominator) = square_of_distance(p, q, &rough.corners);
            return exact(numerator <= &pair.reach * &pair.reach * denominator);
        }
        (Body::Hull(hull), Body::Round(round)) | (Body::Round(round), Body::Hull(hull)) => {
            // Also a segment or triangle that is a point.
            let point = &hull.corners[0];
            if hull.corners.iter().all(|corner| corner == point) {
                return exact(round.reaches_point(point, &pair.reach));
            }
            if pair.reach == IBig::ZERO {
                return exact(round.meets_hull(hull));
            }
        }
        _ => {}
    }
    let precision = resolved + (PRECISION - RESOLVED);
    if pair.bits < precision {
        pair = Pair::new(a, b, margin, precision);
    }
    let (reach, least) = (pair.reach.clone(), IBig::ONE << (pair.bits - resolved));
    let is_enough = |lower: &IBig, upper: &IBig| *lower > reach || *upper <= reach || upper - lower <= least;
    let bounds = refine(&pair, &rough.directions, is_enough);
    if bounds.lower > reach {
        Judgement::Apart
    } else if bounds.meets || bounds.upper <= reach {
        Judgement::Meets
    } else {
        Judgement::TooCloseToCall
    }
}

/// Certain bounds of the distance of two shapes, at most 2^-60 of the pair's size apart. The size is that of the
/// distance and of both cores.
pub(crate) fn distance_interval(a: &Shape, b: &Shape) -> Interval {
    let pair = Pair::new(a, b, 0.0, PRECISION);
    let (lower, upper) = match (&pair.a, &pair.b) {
        (Body::HalfSpace(_), _) | (_, Body::HalfSpace(_)) => half_space_bounds(&pair),
        (Body::Hull(p), Body::Hull(q)) => {
            let (numerator, denominator) = square_of_distance(p, q, &[[0, 0]]);
            (root_down(&over_down(&numerator, &denominator)), root_up(&over_up(&numerator, &denominator)))
        }
        _ => {
            let least = IBig::ONE << (pair.bits - RESOLVED);
            let rough = Rough::new(&pair);
            let bounds = refine(&pair, &rough.directions, |lower, upper| upper - lower <= least);
            (bounds.lower, bounds.upper)
        }
    };
    let rest = |x: IBig| (x - &pair.reach).max(IBig::ZERO);
    let size = pair.bits.max(upper.bit_len());
    Interval { lower: rest(lower), upper: rest(upper), exponent: pair.exponent, size }
}

/// The distance of two shapes, up to about 1e-13 of the pair's size.
pub(crate) fn estimate(a: &Shape, b: &Shape) -> f64 {
    let pair = Pair::new(a, b, 0.0, 64);
    if half_spaces_reach(&pair).is_some() {
        return scaled(&(half_space_bounds(&pair).0 - &pair.reach), pair.exponent).max(0.0);
    }
    let unit = 2_f64.powi(pair.bits as i32 + pair.exponent);
    (Rough::new(&pair).estimate * unit - scaled(&pair.reach, pair.exponent)).max(0.0)
}

/// Whether [`meets`] is exact, so never [`Judgement::TooCloseToCall`].
pub(crate) fn is_rational(a: &Shape, b: &Shape, margin: f64) -> bool {
    let has_reach = a.radius() + b.radius() + margin > 0.0;
    let is_round = |shape: &Shape| matches!(shape.core(), Core::Cylinder { .. } | Core::Cone { .. });
    let is = |kind: fn(&Core) -> bool| kind(a.core()) || kind(b.core());
    is(|core| matches!(core, Core::HalfSpace { .. }))
        || match (is_round(a), is_round(b)) {
            (false, false) => true,
            (true, true) => false,
            _ => is(|core| matches!(core, Core::Point(_))) || !has_reach,
        }
}

impl Interval {
    /// Whether the bounds are at most 2^-60 of the size apart.
    pub(crate) fn is_narrow(&self) -> bool {
        &self.upper - &self.lower <= IBig::ONE << (self.size - 60)
    }

    /// The judgement of a margin by the bounds.
    pub(crate) fn judge(&self, margin: f64) -> Judgement {
        // In units that make the margin an integer.
        let exponent = least_exponent([margin]).unwrap_or(self.exponent).min(self.exponent);
        let more = (self.exponent - exponent) as usize;
        let margin = integer(margin, exponent);
        if &self.lower << more > margin {
            Judgement::Apart
        } else if &self.upper << more <= margin {
            Judgement::Meets
        } else {
            Judgement::TooCloseToCall
        }
    }

    /// The size, up to a factor of 4.
    pub(crate) fn size(&self) -> f64 {
        2_f64.powi(self.exponent + self.size as i32)
    }

    /// The bounds in `f64`, rounded outwards.
    pub(crate) fn to_f64(&self) -> (f64, f64) {
        let by = 4.0 * f64::EPSILON;
        (scaled(&self.lower, self.exponent) * (1.0 - by), scaled(&self.upper, self.exponent) * (1.0 + by))
    }
}

/// Uses every entry point once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (meets, meets_finely, distance_interval, estimate, is_rational);
    let _ = (Interval::is_narrow, Interval::judge, Interval::size, Interval::to_f64);
};
