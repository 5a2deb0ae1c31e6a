//! Shapes along the coordinate axes whose gap is a sum of `f64` numbers without a rounding, such as boxes on a table:
//! faster than in integers.

use crate::exact::two_sum;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::Point;

/// Whether two shapes are at most `margin` apart, if all sums are exact and the gap is along one axis.
#[inline]
pub(super) fn decide(a: &Shape, b: &Shape, margin: f64) -> Option<bool> {
    let gap = match (&a.core, &b.core) {
        (Core::HalfSpace { normal, offset }, other) | (other, Core::HalfSpace { normal, offset }) => {
            height(normal, *offset, other)?
        }
        (Core::Cylinder { .. } | Core::Cone { .. }, _) | (_, Core::Cylinder { .. } | Core::Cone { .. }) => {
            return None;
        }
        (a, b) => gap(&intervals(a)?, &intervals(b)?)?,
    };
    Some(gap <= sum(sum(a.radius, b.radius)?, margin)?)
}

/// The sum, if it is exact.
#[inline(always)]
fn sum(x: f64, y: f64) -> Option<f64> {
    let (sum, rest) = two_sum(x, y);
    (rest == 0.0).then_some(sum)
}

/// The index of the only nonzero coordinate.
#[inline(always)]
fn only(v: &Point) -> Option<usize> {
    match v.map(|x| x != 0.0) {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    }
}

/// The lower and the upper ends of three intervals.
#[inline(always)]
fn intervals(core: &Core) -> Option<[Point; 2]> {
    match core {
        Core::Point(p) => Some([*p, *p]),
        Core::Segment([p, q]) => {
            let k = only(&[0, 1, 2].map(|k| f64::from(u8::from(p[k] != q[k]))))?;
            Some(if p[k] < q[k] { [*p, *q] } else { [*q, *p] })
        }
        Core::Cuboid { centre, half } => {
            let [mut low, mut high] = [*centre, *centre];
            let mut seen = 0;
            for edge in half {
                let k = only(edge)?;
                seen |= 1 << k;
                (low[k], high[k]) = (sum(centre[k], -edge[k].abs())?, sum(centre[k], edge[k].abs())?);
            }
            (seen == 7).then_some([low, high])
        }
        _ => None,
    }
}

/// The distance of two products of intervals, if at most one of the gaps is not 0.
#[inline(always)]
fn gap([low, high]: &[Point; 2], [from, to]: &[Point; 2]) -> Option<f64> {
    let mut found = 0.0;
    for k in 0..3 {
        let gap = if low[k] > to[k] {
            sum(low[k], -to[k])?
        } else if from[k] > high[k] {
            sum(from[k], -high[k])?
        } else {
            continue;
        };
        if found > 0.0 {
            return None;
        }
        found = gap;
    }
    Some(found)
}

/// The height of a core above the plane of a half-space whose normal is a power of two along an axis. Products with
/// the normal are exact then.
#[inline(always)]
fn height(normal: &Point, offset: f64, core: &Core) -> Option<f64> {
    let k = only(normal)?;
    let length = normal[k].abs();
    if length.to_bits() & ((1 << 52) - 1) != 0 {
        return None;
    }
    let up = |p: &Point| if normal[k] < 0.0 { -p[k] } else { p[k] };
    let least = |x: f64, y: f64| if x < y { x } else { y };
    // What a disc adds: nothing, or its radius.
    let disc = |axis: &Point, radius: f64| match (axis[k] == 0.0, only(axis) == Some(k)) {
        (true, _) => Some(radius),
        (_, true) => Some(0.0),
        _ => None,
    };
    let low = match core {
        Core::Point(p) => up(p),
        Core::Segment([p, q]) => least(up(p), up(q)),
        Core::Triangle([p, q, r]) => least(least(up(p), up(q)), up(r)),
        Core::Cuboid { centre, half: [x, y, z] } => {
            sum(up(centre), -sum(sum(x[k].abs(), y[k].abs())?, z[k].abs())?)?
        }
        Core::Cylinder { centre, half_axis, radius } => {
            sum(up(centre), -(half_axis[k].abs() + disc(half_axis, *radius)?))?
        }
        Core::Cone { base, axis, radius } => {
            let base = up(base);
            least(sum(base, -disc(axis, *radius)?)?, sum(base, up(axis))?)
        }
        Core::HalfSpace { .. } => return None,
    };
    sum(low, -offset / length)
}
