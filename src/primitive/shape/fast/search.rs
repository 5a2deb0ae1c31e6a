//! Near points of two cores, and the certificates that they give.

use super::bodies::{Segment, Supported, clamp, norm_1, plus};
use super::margins::{ERROR, FEW};
use super::pair_and_margin::PairAndMargin;
use super::simplex::{FilterSimplex, NearestPoint};
use crate::exact::power_of_two;
use crate::primitive::shape::place::Placement;
use crate::range::Point;
use crate::vector::{difference, dot};

/// How much cores are shrunk where only a common point shows that they meet.
const SHRINK: f64 = power_of_two(-9);
/// Rounds before the pair stays undecided.
const ROUNDS: usize = 20;
/// The square of a direction below which the square of a gap may underflow: a gap that decides is at least 2^-142 of
/// the direction.
const LEAST: f64 = power_of_two(-500);

/// The distance that a gap must exceed, and the errors it includes.
#[derive(Copy, Clone, Debug)]
struct GapThreshold {
    /// The distance that a gap must exceed.
    least: f64,
    size: f64,
    /// Bound of the error of the difference of two points.
    error: f64,
}

impl GapThreshold {
    /// `None` if `size` is out of the range of the error analysis.
    #[inline(always)]
    fn new(size: f64, reach: f64) -> Option<Self> {
        if !(size > power_of_two(-100) && size < power_of_two(100)) {
            return None;
        }
        let error = size * ERROR;
        Some(Self { least: reach * (1.0 + FEW) + error, size, error })
    }

    /// Whether the gap along `n`, whose square is `square`, separates the shapes.
    ///
    /// The gap is `n . at(B) - support(A, n) - support(B, -n)`, with an error of at most 64 u |n| size, which is part
    /// of the `error` in `least`. The comparison of squares is that of `gap` and `least |n|`.
    #[inline(always)]
    fn is_apart<A: Supported, B: Supported>(&self, a: &A, b: &B, n: &Point, square: f64) -> bool {
        self.separates((dot(n, b.at()) - a.support(n)) - b.support(&negative(n)), square)
    }

    /// Whether a gap along a direction of this square is wide enough.
    #[inline(always)]
    fn separates(&self, gap: f64, square: f64) -> bool {
        gap > 0.0 && gap * gap > (self.least * self.least) * (square * (1.0 + 4.0 * FEW)) && square > LEAST
    }
}

/// What both certificates compare with.
#[derive(Copy, Clone, Debug)]
struct Thresholds {
    gap: GapThreshold,
    /// The square of the distance between two computed points that shows that the shapes are within the margin;
    /// negative if there is none.
    near: f64,
    /// The same for points of the shrunk cores.
    near_of_shrunk: f64,
    /// The same for the reference points, about which the cores contain balls.
    near_of_balls: f64,
    /// The factor by which cores are shrunk.
    scale: f64,
}

impl Thresholds {
    /// A convex core that contains a ball of radius r contains all points at most `(1 - scale) r` from the core shrunk
    /// by `scale` about the centre of the ball.
    #[inline(always)]
    fn new(gap: GapThreshold, inner: f64, reach: f64) -> Self {
        let (scale, wider) = if reach < inner * (4.0 * SHRINK) {
            (1.0 - SHRINK, reach + inner * SHRINK)
        } else {
            (1.0, reach)
        };
        let near = |reach: f64| {
            let near = reach * (1.0 - FEW) - gap.error;
            if near > 0.0 { near * near } else { -1.0 }
        };
        let (near, near_of_shrunk, near_of_balls) = (near(reach), near(wider), near(reach + inner));
        Self { gap, near, near_of_shrunk, near_of_balls, scale }
    }

    /// The verdict of the difference `n` of a point of B and a point of A, with a limit `near` for such points.
    #[inline(always)]
    fn judge<A: Supported, B: Supported>(&self, a: &A, b: &B, n: &Point, near: f64) -> Option<bool> {
        let square = dot(n, n);
        if square <= near { Some(true) } else { self.gap.is_apart(a, b, n, square).then_some(false) }
    }
}

#[inline(always)]
fn negative(v: &Point) -> Point {
    [-v[0], -v[1], -v[2]]
}

/// A point, relative to the reference point of a core.
#[inline(always)]
pub(super) fn from_point<A: Supported>(p: &Point, a: &A, reach: f64) -> Option<bool> {
    let limits = Thresholds::new(GapThreshold::new(norm_1(p) + a.size(), reach)?, a.inner(), reach);
    let n = difference(p, &a.nearest_of(p, limits.scale));
    let square = dot(&n, &n);
    if square <= limits.near_of_shrunk {
        return Some(true);
    }
    limits.gap.separates(dot(&n, p) - a.support(&n), square).then_some(false)
}

/// Two segments: the nearest points of the lines, clamped (Ericson, *Real-Time Collision Detection*, 5.1.9).
#[inline(always)]
pub(super) fn segments(a: &Segment, b: &Segment, reach: f64) -> Option<bool> {
    let limits =
        Thresholds::new(GapThreshold::new(norm_1(&b.at) + (a.size() + b.size()), reach)?, 0.0, reach);
    let (p, q, mixed) = (dot(&a.edge, &b.at), dot(&b.edge, &b.at), dot(&a.edge, &b.edge));
    // The divisions do not wait for each other. Where one fails, NaN becomes 0, and the certificates judge any two
    // points.
    let (of_a, of_b) = (1.0 / a.square, 1.0 / b.square);
    let s = clamp((p * b.square - mixed * q) / (a.square * b.square - mixed * mixed), 0.0, 1.0);
    let t = clamp((mixed * s - q) * of_b, 0.0, 1.0);
    let s = clamp((mixed * t + p) * of_a, 0.0, 1.0);
    limits.judge(a, b, &difference(&b.point(t), &a.point(s)), limits.near)
}

/// Two cores. The reference point of A is the origin.
#[inline(always)]
pub(super) fn decide<A: Supported, B: Supported, P: Placement>(
    a: &A,
    b: &B,
    asked: &PairAndMargin<'_, P>,
) -> Option<bool> {
    decide_with(a, b, asked, |_| None)
}

/// [`decide`] with another filter before the search, which gets `size`.
#[inline(always)]
pub(super) fn decide_with<A: Supported, B: Supported, P: Placement>(
    a: &A,
    b: &B,
    asked: &PairAndMargin<'_, P>,
    filter: impl FnOnce(f64) -> Option<bool>,
) -> Option<bool> {
    let size = norm_1(b.at()) + (a.size() + b.size());
    let gap = GapThreshold::new(size, asked.reach)?;
    let square = dot(b.at(), b.at());
    if gap.is_apart(a, b, b.at(), square) {
        return Some(false);
    }
    let limits = Thresholds::new(gap, a.inner() + b.inner(), asked.reach);
    if square < limits.near_of_balls {
        return Some(true);
    }
    let certain = filter(size);
    if certain.is_some() {
        return certain;
    }
    let p = a.nearest_of(b.at(), limits.scale);
    let q = b.nearest_of(&p, limits.scale);
    let n = difference(&q, &p);
    if let Some(certain) = limits.judge(a, b, &n, limits.near_of_shrunk) {
        return Some(certain);
    }
    if let Some(certain) = asked.aligned() {
        return Some(certain);
    }
    let end = match search(a, b, &limits, &n, Some(&n)) {
        End::Flat => search(a, b, &limits, &n, None),
        end => end,
    };
    if let End::Certain(verdict) = end { Some(verdict) } else { None }
}

/// How a search ends.
enum End {
    Certain(bool),
    /// The distance is the reach, up to the error.
    TooClose,
    /// In a simplex that rounding makes useless.
    Flat,
}

/// Gilbert, Johnson and Keerthi's iteration on the differences of a point of B and a point of A. With a
/// difference `first` as a corner it takes two thirds of the time, but one pair in a few hundred ends in a flat
/// simplex.
#[inline(never)]
fn search<A: Supported, B: Supported>(
    a: &A,
    b: &B,
    limits: &Thresholds,
    from: &Point,
    first: Option<&Point>,
) -> End {
    let (mut point, mut direction) = (*from, *from);
    let mut simplex = first.map_or(FilterSimplex::EMPTY, FilterSimplex::new);
    for _ in 0..ROUNDS {
        let (p, q) = (a.farthest(&direction), b.farthest(&negative(&direction)));
        let w = plus(&difference(b.at(), &p), &q);
        // The gap is at most that of these two points.
        let (gap, square) = (dot(&direction, &w), dot(&direction, &direction));
        let may_be_apart = gap > 0.0 && gap * gap > (limits.gap.least * limits.gap.least) * square;
        if may_be_apart && limits.gap.is_apart(a, b, &direction, square) {
            return End::Certain(false);
        }
        // The distance is known to the error.
        let rest = dot(&direction, &point) - gap;
        if rest * rest <= (limits.gap.error * limits.gap.error) * square {
            return End::TooClose;
        }
        if !simplex.add(&w) {
            return End::Flat;
        }
        (point, direction) = match simplex.reduce(limits.gap.size, limits.gap.error) {
            NearestPoint::Inside => return End::Certain(true),
            NearestPoint::Unknown => return End::Flat,
            NearestPoint::At(point, direction) => (point, direction),
        };
        if dot(&point, &point) <= limits.near {
            return End::Certain(true);
        }
    }
    End::Flat
}
