//! Points, segments and cuboids against each other, by their coordinates along half edges.

use super::products::{BlockPlaces, EdgeProducts, Zonotope};
use super::widest::WidestAxis;
use crate::exact::power_of_two;
use crate::primitive::shape::bounds::certified::Certified;
use crate::primitive::shape::bounds::goal::{COMFORTABLE, Target};
use crate::primitive::shape::bounds::newton::without;
use crate::primitive::shape::bounds::support::each;
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

/// Maximum number of rounds of [`blocks`].
const ROUNDS: usize = 10;

/// Blocks that touch are apart once one is shrunk: their points stop at some distance. Then the next distance exceeds
/// this share of the last one.
const STALLED: f64 = 0.9;

/// The bounds of the coordinates of blocks that are not shrunk.
const WHOLE: [f64; 2] = [1.0; 2];

/// How much a block is shrunk to find a common point.
const SHRINK: f64 = power_of_two(-7);

/// Bounds of the distance between two blocks, from the coordinates x and y of their points.
///
/// Each round projects A's point to B and B's to A, up to rounding and the angles of the edges. Where both have a free
/// coordinate, a Newton step then minimises over the free coordinates of B, while A's point follows. Two cuboids start
/// from the features along the axis with the widest gap. If this gap is their distance, these features are the
/// closest. It is, unless the closest features are two corners, or a corner and an edge. Two segments start from their
/// closest points.
///
/// **Error.** The half edge of a segment is wrong by u of itself, its centre by as much, and `between` by three more
/// roundings of parts of S: 5u S. A point adds at most 5 roundings of each product: 9u S, since the half edges together
/// are at most sqrt(3) times as long as a diagonal. With 3u for the norm that makes 17u S for an upper bound. For a
/// lower one, seven products with a vector d are wrong by 3u and summed by six additions: 9u sqrt(3) S. The quotient by
/// |d| is wrong by 3u: 6u S. These and the 5u S of `between` are less than 27u S.
///
/// S is at most the root of three times the sum of the squares of its parts.
#[inline(always)]
pub(super) fn blocks<const N: usize, const M: usize>(
    a: &Zonotope<'_, N>,
    b: &Zonotope<'_, M>,
    goal: &Target,
) -> Option<Certified> {
    const SLACK: f64 = 32.0 * 0.5 * f64::EPSILON;
    let products = EdgeProducts::new(a, b);
    let total = products.total();
    if !COMFORTABLE.contains(&total) {
        return None;
    }
    let slack = SLACK * sqrt(3.0 * total);
    let (t, origins) = (products.between, difference(a.origin, b.origin));
    let axis = if N == 3 && M == 3 { Some(products.widest()) } else { None };
    // Points away from the boundary can prove that the cores meet.
    let mut most = if let Some(WidestAxis::None) = axis { products.shrunk(SHRINK) } else { WHOLE };
    let (mut is_apart, mut last) = (false, f64::INFINITY);
    let (mut places, is_guess) = match axis {
        Some(axis) => (products.on_axis(a, b, &axis), false),
        None if N == 1 && M == 1 => (products.on_lines(), false),
        None => (products.near_centre(), true),
    };
    for round in 0..ROUNDS {
        if is_guess || round > 0 {
            products.project(&mut places, most);
            if N > 0 && round == 0 {
                products.project(&mut places, most);
            }
            products.step(&mut places, most);
        }
        let (of_a, of_b) = (a.point(&places.x), b.point(&places.y));
        let between: Point = each(|k| origins[k] + (of_a[k] - of_b[k]));
        let at: Point = each(|k| a.origin[k] + of_a[k]);
        let square = dot(&between, &between);
        let length = sqrt(square);
        let upper = length + slack;
        if upper <= goal.less {
            return Some(goal.bounds(0.0, upper, &at, &between, length));
        }
        let gap = |d: &Point, length: f64| (dot(d, &t) - (a.reach(d) + b.reach(d))) / length - slack;
        let lower = if square > f64::MIN_POSITIVE { gap(&between, length) } else { 0.0 };
        if lower <= 0.0 {
            if b.has_ball(&places.y, &products.squares_b, upper) {
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if a.has_ball(&places.x, &products.squares_a, upper) {
                let at = difference(&at, &between);
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if round > 0 && !is_apart {
                if most != WHOLE && length > STALLED * last {
                    return None;
                }
                (most, last) = (products.shrunk(SHRINK), length);
            }
            continue;
        }
        (is_apart, most) = (true, WHOLE);
        if goal.is_met(lower, upper, slack) {
            return Some(goal.bounds(lower, upper, &at, &between, length));
        }
        // The difference of points that nearly touch does not tell which edges limit them.
        if upper - lower < 1e-3 * upper {
            let d = perpendicular(a, b, &places, &between);
            let square = dot(&d, &d);
            if square > f64::MIN_POSITIVE {
                let lower = gap(&d, sqrt(square));
                if goal.is_met(lower, upper, slack) {
                    return Some(goal.bounds(lower, upper, &at, &between, length));
                }
            }
        }
        if N == 0 {
            return None;
        }
    }
    None
}

/// A vector near d that is perpendicular to the edges along which the points can move both ways: the cross product of
/// two of them, or d without its component along the only one.
#[inline(always)]
fn perpendicular<const N: usize, const M: usize>(
    a: &Zonotope<'_, N>,
    b: &Zonotope<'_, M>,
    places: &BlockPlaces<N, M>,
    d: &Point,
) -> Point {
    let (mut edges, mut len) = ([[0.0; 3]; 6], 0);
    let all = places.x.iter().zip(a.half).chain(places.y.iter().zip(b.half));
    let free = all.filter(|(x, _)| x.abs() < 1.0);
    for (_, edge) in free {
        edges[len] = *edge;
        len += 1;
    }
    for i in 1..len {
        for j in 0..i {
            let (u, v) = (&edges[i], &edges[j]);
            let normal = cross(u, v);
            if dot(&normal, &normal) > 1e-10 * (dot(u, u) * dot(v, v)) {
                let sign = 1.0_f64.copysign(dot(&normal, d));
                return each(|k| sign * normal[k]);
            }
        }
    }
    if len > 0 { without(d, &edges[0]) } else { *d }
}
