//! Shapes along the coordinate axes, such as objects on a shelf, decided exactly: in `f64` if no sum is rounded, else
//! in integers of 128 bits.
//!
//! Bodies that touch are usually aligned, and their numbers are multiples of a unit that is not too small. Then
//! points, segments and cuboids are products of three intervals. Cylinders are products of a disc and an interval, and
//! the sections of a cone are discs that shrink from its base to its tip. All comparisons are of degree two.
//!
//! **Magnitudes.** Numbers are below 2^59 units, ends of intervals below 2^60, points of discs and sums of radii and a
//! reach below 2^61, and gaps below 2^62. So products are below 2^124, and sums of three below 2^126.

use crate::exact::power_of_two;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::{MIN_COORDINATE, Point};

mod sums;

/// The exponent of the greatest number, in units.
const BITS: i32 = 58;

/// Whether two shapes are at most `margin` apart. `None` if they are not along the axes, if a number is not a multiple
/// of 2^-59 of the greatest, or if a comparison is of a higher degree. Decides only hits of pairs without an exact
/// test.
#[inline(never)]
pub(in crate::primitive::shape) fn decide(a: &Shape, b: &Shape, margin: f64) -> Option<bool> {
    if margin > 0.0 && margin < MIN_COORDINATE {
        return None;
    }
    sums::decide(a, b, margin).or_else(|| in_integers(a, b, margin))
}

#[inline(always)]
fn in_integers(a: &Shape, b: &Shape, margin: f64) -> Option<bool> {
    if !(may_be_aligned(&a.core) && may_be_aligned(&b.core)) {
        return None;
    }
    let of_reach = bits(a.radius).max(bits(b.radius)).max(bits(margin));
    let exponent = (greatest(&a.core).max(greatest(&b.core)).max(of_reach) >> 52) as i32 - 1023;
    if !(-300..=310).contains(&exponent) {
        return None;
    }
    let units = Units(power_of_two(BITS - exponent));
    let sum = units.of(a.radius)? + units.of(b.radius)? + units.of(margin)?;
    match (&a.core, &b.core) {
        (Core::HalfSpace { normal, offset }, other) | (other, Core::HalfSpace { normal, offset }) => {
            above(&units, normal, *offset, &AlignedSolid::new(other, &units)?, sum)
        }
        (a, b) => pair(&AlignedSolid::new(a, &units)?, &AlignedSolid::new(b, &units)?, sum),
    }
}

/// Whether a core may be along the axes, judged by its first vector. Half-spaces are checked later.
#[inline(always)]
fn may_be_aligned(core: &Core) -> bool {
    let is_along = |v: &Point| u8::from(v[0] == 0.0) + u8::from(v[1] == 0.0) + u8::from(v[2] == 0.0) == 2;
    match core {
        Core::Point(_) | Core::Segment(_) | Core::HalfSpace { .. } => true,
        Core::Triangle(_) => false,
        Core::Cuboid { half, .. } => is_along(&half[0]) && is_along(&half[1]),
        Core::Cylinder { half_axis: axis, .. } | Core::Cone { axis, .. } => is_along(axis),
    }
}

/// The bits of a number, which are ordered by magnitude.
#[inline(always)]
const fn bits(x: f64) -> u64 {
    x.to_bits() & !(1 << 63)
}

/// The greatest magnitude of a length, in [`bits`].
#[inline(always)]
fn greatest(core: &Core) -> u64 {
    let of = |v: &Point| bits(v[0]).max(bits(v[1])).max(bits(v[2]));
    match core {
        Core::Point(p) => of(p),
        Core::Segment([p, q]) => of(p).max(of(q)),
        Core::Triangle([p, q, r]) => of(p).max(of(q)).max(of(r)),
        Core::Cuboid { centre, half: [x, y, z] } => of(centre).max(of(x)).max(of(y).max(of(z))),
        Core::Cylinder { centre, half_axis: axis, radius } | Core::Cone { base: centre, axis, radius } => {
            of(centre).max(of(axis)).max(bits(*radius))
        }
        // The normal is at least 1/4 long, so the distance of the plane is at most four times the offset.
        Core::HalfSpace { offset, .. } => bits(4.0 * offset),
    }
}

/// How many units a length of 1 has.
struct Units(f64);

impl Units {
    /// `None` if the number is not a multiple of the unit.
    #[inline(always)]
    fn of(&self, x: f64) -> Option<i64> {
        let scaled = x * self.0;
        let whole = scaled as i64;
        (whole as f64 == scaled).then_some(whole)
    }

    fn of_point(&self, p: &Point) -> Option<[i64; 3]> {
        Some([self.of(p[0])?, self.of(p[1])?, self.of(p[2])?])
    }
}

/// The product of three intervals; of a round solid, two of them are the coordinates of its axis.
#[derive(Copy, Clone, Debug)]
struct AlignedSolid {
    low: [i64; 3],
    high: [i64; 3],
    round: Option<RoundSolid>,
}

/// A disc, moved along an axis or shrunk to a tip.
#[derive(Copy, Clone, Debug)]
struct RoundSolid {
    axis: usize,
    radius: i64,
    tip: Tip,
}

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Tip {
    /// A cylinder has no tip.
    None,
    High,
    Low,
}

/// The index of the only nonzero coordinate.
fn only(v: &[i64; 3]) -> Option<usize> {
    match v.map(|x| x != 0) {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    }
}

impl AlignedSolid {
    #[inline(always)]
    fn new(core: &Core, units: &Units) -> Option<Self> {
        match core {
            Core::Point(p) => Some(Self::of_point(units.of_point(p)?)),
            Core::Segment([p, q]) => {
                let (p, q) = (units.of_point(p)?, units.of_point(q)?);
                let is_longer = [0, 1, 2].map(|k| p[k] != q[k]);
                if is_longer.iter().filter(|is| **is).count() > 1 {
                    return None;
                }
                let (low, high) = ([0, 1, 2].map(|k| p[k].min(q[k])), [0, 1, 2].map(|k| p[k].max(q[k])));
                Some(Self { low, high, round: None })
            }
            Core::Cuboid { centre, half } => {
                let mut solid = Self::of_point(units.of_point(centre)?);
                let mut seen = 0;
                for edge in half {
                    let edge = units.of_point(edge)?;
                    let k = only(&edge)?;
                    seen |= 1 << k;
                    solid.low[k] -= edge[k].abs();
                    solid.high[k] += edge[k].abs();
                }
                (seen == 7).then_some(solid)
            }
            Core::Cylinder { centre, half_axis, radius } => {
                let (mut solid, half) = (Self::of_point(units.of_point(centre)?), units.of_point(half_axis)?);
                let axis = only(&half)?;
                solid.low[axis] -= half[axis].abs();
                solid.high[axis] += half[axis].abs();
                Some(Self {
                    round: Some(RoundSolid { axis, radius: units.of(*radius)?, tip: Tip::None }),
                    ..solid
                })
            }
            Core::Cone { base, axis, radius } => {
                let (mut solid, along) = (Self::of_point(units.of_point(base)?), units.of_point(axis)?);
                let axis = only(&along)?;
                let end = solid.low[axis] + along[axis];
                let tip = if along[axis] > 0 { Tip::High } else { Tip::Low };
                *(if tip == Tip::High { &mut solid.high[axis] } else { &mut solid.low[axis] }) = end;
                Some(Self { round: Some(RoundSolid { axis, radius: units.of(*radius)?, tip }), ..solid })
            }
            Core::Triangle(_) | Core::HalfSpace { .. } => None,
        }
    }

    const fn of_point(p: [i64; 3]) -> Self {
        Self { low: p, high: p, round: None }
    }

    /// The gap between two intervals.
    #[inline(always)]
    fn gap(&self, other: &Self, k: usize) -> i64 {
        (self.low[k] - other.high[k]).max(other.low[k] - self.high[k]).max(0)
    }

    /// The least coordinate of the solid, or the greatest, negated.
    fn least(&self, k: usize, is_negated: bool) -> i64 {
        let at = if is_negated { -self.high[k] } else { self.low[k] };
        match &self.round {
            Some(round) if round.axis != k => at - round.radius,
            _ => at,
        }
    }

    /// A few points of a round solid: the middles and the extreme points of its discs, or of a disc half way up.
    fn points(&self, round: &RoundSolid) -> [[i64; 3]; 6] {
        let (k, r) = (round.axis, round.radius);
        let [mut low, mut high, mut middle] = [self.low; 3];
        high[k] = self.high[k];
        low[k] = self.low[k];
        middle[k] = match round.tip {
            Tip::None => self.low[k] + (self.high[k] - self.low[k]) / 2,
            Tip::High => self.low[k],
            Tip::Low => self.high[k],
        };
        let beside = |axis: usize, by: i64| {
            let mut p = middle;
            p[axis] += by;
            p
        };
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        [low, high, beside(i, r), beside(i, -r), beside(j, r), beside(j, -r)]
    }
}

fn square(x: i64) -> i128 {
    i128::from(x) * i128::from(x)
}

fn product(x: i64, y: i64) -> i128 {
    i128::from(x) * i128::from(y)
}

/// Above the plane of a half-space, whose normal has to be a power of two along an axis.
fn above(units: &Units, normal: &Point, offset: f64, other: &AlignedSolid, reach: i64) -> Option<bool> {
    let k = only(&normal.map(|x| i64::from(x != 0.0)))?;
    let length = normal[k].abs();
    if length.to_bits() & ((1 << 52) - 1) != 0 {
        return None;
    }
    let height = units.of(offset / length)?;
    Some(other.least(k, normal[k] < 0.0) <= height + reach)
}

fn pair(a: &AlignedSolid, b: &AlignedSolid, reach: i64) -> Option<bool> {
    match (&a.round, &b.round) {
        (None, None) => {
            let square_of_gap = (square(a.gap(b, 0)) + square(a.gap(b, 1))) + square(a.gap(b, 2));
            Some(square_of_gap <= square(reach))
        }
        (None, Some(round)) => block_and_round(a, b, round, reach),
        (Some(round), None) => block_and_round(b, a, round, reach),
        (Some(r), Some(s)) => {
            let is_hit = match (r.tip == Tip::None, s.tip == Tip::None) {
                (true, true) => cylinders(a, r, b, s, reach),
                (true, false) => have_common_point(b, s, a, r),
                _ => have_common_point(a, r, b, s),
            };
            is_hit.then_some(true)
        }
    }
}

/// A product of intervals and a round solid. The formulas give the exact distance; but if the first has a width and
/// the reach is not 0, only hits are decided.
#[inline(always)]
fn block_and_round(
    block: &AlignedSolid,
    solid: &AlignedSolid,
    round: &RoundSolid,
    reach: i64,
) -> Option<bool> {
    let k = round.axis;
    let (gi, gj) = (block.gap(solid, (k + 1) % 3), block.gap(solid, (k + 2) % 3));
    // From the axis: the square, and the distance itself if it is along a coordinate axis.
    let out_square = square(gi) + square(gj);
    let out = (gi == 0 || gj == 0).then_some(gi + gj);
    let r = round.radius;
    let is_near = match round.tip {
        Tip::None => {
            let gap = block.gap(solid, k);
            if gap == 0 {
                out_square <= square(r + reach)
            } else if out_square <= square(r) {
                gap <= reach
            } else {
                square(out? - r) + square(gap) <= square(reach)
            }
        }
        tip => {
            let height = solid.high[k] - solid.low[k];
            // The interval above the base.
            let (low, high) = if tip == Tip::High {
                (block.low[k] - solid.low[k], block.high[k] - solid.low[k])
            } else {
                (solid.high[k] - block.high[k], solid.high[k] - block.low[k])
            };
            if high < 0 {
                if out_square <= square(r) {
                    -high <= reach
                } else {
                    square(out? - r) + square(high) <= square(reach)
                }
            } else if low <= 0 {
                // The section at the base is the widest.
                out_square <= square(r + reach)
            } else if out_square == 0 {
                low - height <= reach
            } else if reach == 0 {
                low <= height && product(height, out?) <= product(r, height - low)
            } else {
                return None;
            }
        }
    };
    let is_exact = reach == 0 || block.low == block.high;
    (is_near || is_exact).then_some(is_near)
}

/// Whether two cylinders certainly are within the reach.
#[inline(never)]
fn cylinders(a: &AlignedSolid, r: &RoundSolid, b: &AlignedSolid, s: &RoundSolid, reach: i64) -> bool {
    let (k, m) = (r.axis, s.axis);
    if k == m {
        let across = square(a.gap(b, (k + 1) % 3)) + square(a.gap(b, (k + 2) % 3));
        let (gap, sum) = (a.gap(b, k), r.radius + s.radius);
        return gap == 0 && across <= square(sum + reach) || gap <= reach && across <= square(sum);
    }
    // At right angles. Along the axis of each, the disc of the other covers the gap, which shortens its chord along the
    // third axis. The squares of half the chords:
    let (u, v) = (square(r.radius) - square(a.gap(b, m)), square(s.radius) - square(a.gap(b, k)));
    let across = a.gap(b, 3 - k - m);
    if u < 0 || v < 0 {
        return false;
    }
    let of_both = |rest: i64, other: i128| rest <= 0 || square(rest) <= other;
    square(across) <= u + v
        || a.gap(b, m) == 0 && of_both(across - r.radius, v)
        || a.gap(b, k) == 0 && of_both(across - s.radius, u)
}

/// Whether a few points show that two round solids meet.
#[inline(never)]
fn have_common_point(a: &AlignedSolid, r: &RoundSolid, b: &AlignedSolid, s: &RoundSolid) -> bool {
    let is_in = |p: &[i64; 3], solid: &AlignedSolid, round: &RoundSolid| {
        block_and_round(&AlignedSolid::of_point(*p), solid, round, 0) == Some(true)
    };
    a.points(r).iter().any(|p| is_in(p, b, s)) || b.points(s).iter().any(|p| is_in(p, a, r))
}
