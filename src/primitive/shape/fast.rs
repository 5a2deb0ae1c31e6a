//! Whether two shapes are within a margin, decided in plain `f64` where its error bounds allow.
//!
//! Every verdict has a certificate, which is checked with a bound of its own rounding errors:
//! * **Within:** two points, one of each core, that are near enough; four differences of such points whose tetrahedron
//!   contains the origin; or overlaps along all 15 axes of two cuboids.
//! * **Apart:** a direction along which the gap between the cores is wide enough. Any direction gives a lower bound of
//!   the distance.
//!
//! Shapes along the coordinate axes are decided in integers instead ([`aligned`]), if the first certificates fail.
//!
//! How the points and directions are found needs no error analysis. In what follows, u = 2^-53, the origin is the
//! reference point of A's core (an end, the centre), and `size` is at least the norm of the difference of the
//! reference points plus, for each core, the greatest distance of its points from its reference point. It is computed
//! as sums of magnitudes; their relative errors are below 2^-48, which the constants include.
//!
//! **Products.** Coordinates are multiples of 2^-302 below 2^302, so that products of two differences neither underflow
//! nor overflow. Tests with products of more factors require `size` in 2^-100 .. 2^100. Then underflow adds at most
//! 2^-1000 to numbers that are compared with multiples of `size`^2 2^-90 or more.

mod axes;
mod bodies;
mod half_space;
mod margins;
mod pair_and_margin;
mod pairs;
mod round;
mod search;
mod simplex;
#[cfg(test)]
pub(crate) mod tests;

use self::bodies::{Segment, Supported, norm_1};
use self::margins::{FEW, compare};
use self::pair_and_margin::PairAndMargin;
use crate::exact::{power_of_two, two_sum};
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::primitive::shape::place::{InPlace, Placement};
use crate::range::Point;
use crate::vector::{difference, dot};

/// Whether two shapes are at most `margin` apart. `None` if the error bounds do not allow a decision, or for pairs of
/// kinds that this filter does not treat.
#[inline]
pub(crate) fn decide(a: &Shape, b: &Shape, margin: f64) -> Option<bool> {
    decide_placed(a, InPlace, b, margin)
}

/// [`decide`] of `a` where it is. At a pose, points, segments and cuboids are moved in registers: storing a moved shape
/// and reading it again would take longer than the test.
#[inline(always)]
pub(super) fn decide_placed<P: Placement>(a: &Shape, at: P, b: &Shape, margin: f64) -> Option<bool> {
    let reach = (a.radius + b.radius) + margin;
    if margin < 0.0 || margin.is_nan() {
        return None;
    }
    let asked = PairAndMargin { a, at, b, margin, reach };
    let certain = match (&a.core, &b.core) {
        (Core::Point(p), Core::Point(q)) => {
            let p = at.point(p);
            let d = difference(q, &p);
            compare_squares(dot(&d, &d), reach)
                .or_else(|| compare_on_axis(&p, q, [a.radius, b.radius, margin]))
        }
        (Core::Point(p), Core::Segment(s)) => from_point(&at.point(p), s, reach),
        (Core::Segment([p, q]), Core::Point(other)) => from_point(other, &[at.point(p), at.point(q)], reach),
        (Core::Segment([p, q]), Core::Segment(t)) => {
            let s = [at.point(p), at.point(q)];
            let d = difference(&t[0], &s[0]);
            search::segments(&Segment::new(&s, [0.0; 3]), &Segment::new(t, d), reach)
        }
        (Core::HalfSpace { .. }, _) | (_, Core::HalfSpace { .. }) => {
            at.with(a, |a| half_space::decide(a, b, reach))
        }
        _ => return pairs::decide(&asked),
    };
    certain.or_else(|| asked.aligned())
}

/// Whether the norm of a vector of exact differences, rounded once, is at most `reach`.
///
/// Every term of `square` is positive and the result of at most 6 roundings, and so is `reach * reach`; products do
/// not underflow or overflow except for reaches below 2^-500, whose square is far below that of any nonzero
/// difference.
#[inline]
fn compare_squares(square: f64, reach: f64) -> Option<bool> {
    let other = reach * reach;
    if square == 0.0 || square * (1.0 + FEW) < other {
        Some(true)
    } else if square > other * (1.0 + FEW) {
        Some(false)
    } else {
        None
    }
}

/// Two points on a line parallel to an axis, if the distance and the reach are sums without a rounding.
#[inline]
fn compare_on_axis(p: &Point, q: &Point, [r, s, margin]: [f64; 3]) -> Option<bool> {
    let [x, y, z] = [0, 1, 2].map(|k| two_sum(q[k], -p[k]));
    let (reach, rest) = two_sum(r, s);
    let is_exact = rest == 0.0 && margin == 0.0 && x.1 == 0.0 && y.1 == 0.0 && z.1 == 0.0;
    let is_on_axis = [x, y, z].iter().filter(|d| d.0 == 0.0).count() >= 2;
    (is_exact && is_on_axis).then(|| x.0.abs() + y.0.abs() + z.0.abs() <= reach)
}

/// A point against a segment.
///
/// The parameter of the nearest point is off by a relative 4 u of `|d| / |edge|` before it is clamped, so the computed
/// nearest point is within `8 u size` of the exact one, and `|n|` within 16 u size of the distance.
#[inline]
fn from_point(p: &Point, ends: &[Point; 2], reach: f64) -> Option<bool> {
    let (d, segment) = (difference(p, &ends[0]), Segment::new(ends, [0.0; 3]));
    let n = difference(&d, &segment.nearest(&d));
    let size = norm_1(&d) + segment.size();
    compare(dot(&n, &n), reach, size * power_of_two(-48))
}
