//! Points, segments and cuboids against each other: by the coordinates of points in the directions of half edges.

use super::certified::Certified;
use super::goal::{COMFORTABLE, Target};
use super::newton::without;
use super::support::each;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot};

/// The most rounds of [`blocks`].
const ROUNDS: usize = 10;

/// How much blocks are shrunk to find a common point.
const SHRINK: f64 = power_of_two(-7);

#[inline(always)]
pub(super) fn half_of([p, q]: &[Point; 2]) -> [Point; 1] {
    [each(|k| 0.5 * (q[k] - p[k]))]
}

/// All sums of a centre and multiples of `half` by -1 to 1: a point, a segment, or a cuboid.
pub(super) struct Zonotope<'s, const N: usize> {
    /// The centre, or the end of a segment from which its half edge leads there.
    pub(super) origin: &'s Point,
    pub(super) half: &'s [Point; N],
}

impl<const N: usize> Zonotope<'_, N> {
    /// From the origin to the point with these coordinates.
    #[inline(always)]
    fn point(&self, x: &[f64; N]) -> Point {
        let mut p = if N == 1 { self.half[0] } else { [0.0; 3] };
        for i in 0..N {
            p = each(|k| p[k] + x[i] * self.half[i][k]);
        }
        p
    }

    /// The greatest product of a point, from the centre, with d.
    #[inline(always)]
    fn reach(&self, d: &Point) -> f64 {
        let mut sum = 0.0;
        for i in 0..N {
            sum += dot(&self.half[i], d).abs();
        }
        sum
    }

    /// Whether a ball of this radius about the point with these coordinates is certainly inside. The angles between the
    /// half edges of a cuboid are right ones within 1e-4, so its faces are nearer than its half edges are long by a
    /// factor of 1 - 4e-4 at most.
    #[inline(always)]
    fn has_ball(&self, x: &[f64; N], squares: &[f64; N], radius: f64) -> bool {
        let mut is_inside = N == 3;
        for i in 0..N {
            let room = 0.999 * (1.0 - x[i].abs());
            is_inside &= room * room * squares[i] > radius * radius;
        }
        is_inside
    }
}

/// Between `-most` and `most`.
#[inline(always)]
fn clamped(x: f64, most: f64) -> f64 {
    let x = if x > -most { x } else { -most };
    if x < most { x } else { most }
}

#[inline(always)]
fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// Two blocks, by their coordinates x and y.
///
/// Each round projects A's point to B and B's to A, up to rounding and the angles of the edges. Where both have a free
/// coordinate, a Newton step then minimises over the free coordinates of B, while A's point follows. Two cuboids start
/// from the features along the axis with the widest gap: where this gap is their distance, which it is unless a corner
/// or edge is nearest to an edge or a corner, they are the closest.
///
/// **Error.** The half edge of a segment is wrong by u of itself, its centre by as much, and `between` by three more
/// roundings of parts of S: 5u S. A point adds at most 5 roundings of each product, 9u S since the half edges together
/// are at most sqrt(3) times as long as a diagonal. With 3u for the norm that makes 17u S for an upper bound. For a
/// lower one, seven products with a vector d are wrong by 3u and summed by six additions: 9u sqrt(3) S, and the quotient
/// by |d| is wrong by 3u: 6u S. These and the 5u S of `between` are less than 27u S.
///
/// S is at most the root of three times the sum of the squares of its parts.
#[inline(always)]
pub(super) fn blocks<const N: usize, const M: usize>(
    a: &Zonotope<'_, N>,
    b: &Zonotope<'_, M>,
    goal: &Target,
) -> Option<Certified> {
    const SLACK: f64 = 32.0 * 0.5 * f64::EPSILON;
    let mut t = difference(a.origin, b.origin);
    if N == 1 {
        t = each(|k| t[k] + a.half[0][k]);
    }
    if M == 1 {
        t = each(|k| t[k] - b.half[0][k]);
    }
    let squares_a: [f64; N] = core::array::from_fn(|i| dot(&a.half[i], &a.half[i]));
    let squares_b: [f64; M] = core::array::from_fn(|j| dot(&b.half[j], &b.half[j]));
    let mut total = dot(&t, &t);
    for i in 0..N {
        total += squares_a[i];
    }
    for j in 0..M {
        total += squares_b[j];
    }
    if !COMFORTABLE.contains(&total) {
        return None;
    }
    let slack = SLACK * libm::sqrt(3.0 * total);
    let inverse_a = squares_a.map(inverse);
    let inverse_b = squares_b.map(inverse);
    let of_t_a: [f64; N] = core::array::from_fn(|i| dot(&a.half[i], &t));
    let of_t_b: [f64; M] = core::array::from_fn(|j| dot(&b.half[j], &t));
    let mixed: [[f64; M]; N] =
        core::array::from_fn(|i| core::array::from_fn(|j| dot(&a.half[i], &b.half[j])));

    // A's nearest point to the centre of B, and unclamped coordinates of the nearest points.
    let mut y = [0.0; M];
    let mut p: [f64; N] = core::array::from_fn(|i| -of_t_a[i] * inverse_a[i]);
    let mut x = p.map(|p| clamped(p, 1.0));
    // Points that are not near the boundary show that cores meet.
    let (mut most, mut is_apart) = (1.0, false);
    let origins = difference(a.origin, b.origin);
    if N == 3 && M == 3 {
        match widest(&squares_a, &squares_b, &of_t_a, &of_t_b, &mixed) {
            WidestAxis::None => most = 1.0 - SHRINK,
            WidestAxis::A(i) => {
                let sign = 1.0_f64.copysign(of_t_a[i]);
                y = core::array::from_fn(|j| sign.copysign(sign * mixed[i][j]));
                x = core::array::from_fn(|i| {
                    let mut q = -of_t_a[i];
                    for j in 0..M {
                        q += mixed[i][j] * y[j];
                    }
                    clamped(q * inverse_a[i], most)
                });
            }
            WidestAxis::B(j) => {
                let sign = 1.0_f64.copysign(of_t_b[j]);
                x = core::array::from_fn(|i| 1.0_f64.copysign(-sign * mixed[i][j]));
                y = core::array::from_fn(|j| {
                    let mut q = of_t_b[j];
                    for i in 0..N {
                        q += mixed[i][j] * x[i];
                    }
                    clamped(q * inverse_b[j], most)
                });
            }
            WidestAxis::Edges(i, j) => {
                let normal = cross(&a.half[i], &b.half[j]);
                let sign = 1.0_f64.copysign(dot(&normal, &t));
                x = core::array::from_fn(|i| 1.0_f64.copysign(-sign * dot(&normal, &a.half[i])));
                y = core::array::from_fn(|j| 1.0_f64.copysign(sign * dot(&normal, &b.half[j])));
                (x[i], y[j]) = (0.0, 0.0);
                let (mut of_a, mut of_b) = (-of_t_a[i], of_t_b[j]);
                for k in 0..3 {
                    of_a += mixed[i][k] * y[k];
                    of_b += mixed[k][j] * x[k];
                }
                let share = mixed[i][j] * inverse_a[i];
                y[j] = clamped((of_b + share * of_a) / (squares_b[j] - share * mixed[i][j]), most);
                x[i] = clamped((of_a + mixed[i][j] * y[j]) * inverse_a[i], most);
                y[j] = clamped((of_b + mixed[i][j] * x[i]) * inverse_b[j], most);
            }
        }
    }
    for round in 0..ROUNDS {
        let is_start = N == 3 && M == 3 && round == 0;
        for _ in 0..if is_start {
            0
        } else if round == 0 {
            2
        } else {
            1
        } {
            for j in 0..M {
                let mut q = of_t_b[j];
                for i in 0..N {
                    q += mixed[i][j] * x[i];
                }
                y[j] = clamped(q * inverse_b[j], most);
            }
            for i in 0..N {
                let mut q = -of_t_a[i];
                for j in 0..M {
                    q += mixed[i][j] * y[j];
                }
                p[i] = q * inverse_a[i];
                x[i] = clamped(p[i], most);
            }
            if N == 0 {
                break;
            }
        }
        if !is_start && x.iter().any(|x| x.abs() < most) && y.iter().any(|y| y.abs() < most) {
            let (mut h, mut s) = ([[0.0; M]; M], [0.0; M]);
            for j in 0..M {
                let mut slope = of_t_b[j] - squares_b[j] * y[j];
                for i in 0..N {
                    slope += mixed[i][j] * x[i];
                }
                let is_free = y[j].abs() < most || slope * y[j] < 0.0;
                if !is_free {
                    continue;
                }
                s[j] = slope;
                h[j][j] = squares_b[j];
                for i in 0..N {
                    let share = if p[i].abs() < most { mixed[i][j] * inverse_a[i] } else { 0.0 };
                    for k in 0..=j {
                        h[j][k] -= share * mixed[i][k];
                    }
                }
            }
            solve(&mut h, &mut s, &squares_b);
            for j in 0..M {
                y[j] = clamped(y[j] + s[j], most);
            }
            for i in 0..N {
                let mut q = -of_t_a[i];
                for j in 0..M {
                    q += mixed[i][j] * y[j];
                }
                p[i] = q * inverse_a[i];
                x[i] = clamped(p[i], most);
            }
        }
        let (of_a, of_b) = (a.point(&x), b.point(&y));
        let between: Point = each(|k| origins[k] + (of_a[k] - of_b[k]));
        let at: Point = each(|k| a.origin[k] + of_a[k]);
        let square = dot(&between, &between);
        let length = libm::sqrt(square);
        let upper = length + slack;
        if upper <= goal.less {
            return Some(goal.bounds(0.0, upper, &at, &between, length));
        }
        let gap = |d: &Point, length: f64| (dot(d, &t) - (a.reach(d) + b.reach(d))) / length - slack;
        let lower = if square > f64::MIN_POSITIVE { gap(&between, length) } else { 0.0 };
        if lower <= 0.0 {
            if b.has_ball(&y, &squares_b, upper) {
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if a.has_ball(&x, &squares_a, upper) {
                let at = difference(&at, &between);
                return Some(goal.bounds(0.0, 0.0, &at, &[0.0; 3], 0.0));
            }
            if round > 0 && !is_apart {
                most = 1.0 - SHRINK;
            }
            continue;
        }
        (is_apart, most) = (true, 1.0);
        if goal.is_met(lower, upper, slack) {
            return Some(goal.bounds(lower, upper, &at, &between, length));
        }
        // Of points that are near, their difference does not tell which ways are barred.
        if upper - lower < 1e-3 * upper {
            let d = perpendicular(a, &x, b, &y, &between);
            let square = dot(&d, &d);
            if square > f64::MIN_POSITIVE {
                let lower = gap(&d, libm::sqrt(square));
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

/// A vector along d that is perpendicular to edges of which the points are not ends: the cross product of two of them,
/// or d without its part along the only one.
#[inline(always)]
fn perpendicular<const N: usize, const M: usize>(
    a: &Zonotope<'_, N>,
    x: &[f64; N],
    b: &Zonotope<'_, M>,
    y: &[f64; M],
    d: &Point,
) -> Point {
    let (mut edges, mut len) = ([[0.0; 3]; 6], 0);
    let free = x.iter().zip(a.half).chain(y.iter().zip(b.half)).filter(|(x, _)| x.abs() < 1.0);
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

/// Solves h s = s for a symmetric h, of which only the lower triangle is used, without unknowns that depend on those
/// before: their pivots are below a small share of `squares`.
#[inline(always)]
fn solve<const M: usize>(h: &mut [[f64; M]; M], s: &mut [f64; M], squares: &[f64; M]) {
    // L of `L D L^T`, and the reciprocals of D.
    let mut pivots = [0.0; M];
    for j in 0..M {
        let mut d = h[j][j];
        for k in 0..j {
            for m in 0..k {
                h[j][k] -= h[j][m] * h[k][m];
            }
            // L D, until the row is complete.
            let l = h[j][k] * pivots[k];
            d -= h[j][k] * l;
            s[j] -= l * s[k];
        }
        for k in 0..j {
            h[j][k] *= pivots[k];
        }
        pivots[j] = if d > 1e-8 * squares[j] { 1.0 / d } else { 0.0 };
    }
    for j in (0..M).rev() {
        s[j] *= pivots[j];
        for k in j + 1..M {
            s[j] -= h[k][j] * s[k];
        }
    }
}

/// The axis of two cuboids along which they are farthest apart.
enum WidestAxis {
    /// They overlap along all.
    None,
    A(usize),
    B(usize),
    Edges(usize, usize),
}

/// The axis with the widest gap, up to rounding and the angles of the edges, of the half edges of two cuboids and the
/// cross products of two of them (Gottschalk, Lin and Manocha 1996).
#[inline(always)]
fn widest<const N: usize, const M: usize>(
    squares_a: &[f64; N],
    squares_b: &[f64; M],
    of_t_a: &[f64; N],
    of_t_b: &[f64; M],
    mixed: &[[f64; M]; N],
) -> WidestAxis {
    let (a, b) = (squares_a.map(libm::sqrt), squares_b.map(libm::sqrt));
    let (inverse_a, inverse_b) = (a.map(inverse), b.map(inverse));
    let cosines: [[f64; M]; N] =
        core::array::from_fn(|i| core::array::from_fn(|j| mixed[i][j] * (inverse_a[i] * inverse_b[j])));
    let (mut best, mut axis) = (0.0, WidestAxis::None);
    for i in 0..N {
        let mut gap = of_t_a[i].abs() * inverse_a[i] - a[i];
        for j in 0..M {
            gap -= b[j] * cosines[i][j].abs();
        }
        if gap > best {
            (best, axis) = (gap, WidestAxis::A(i));
        }
    }
    for j in 0..M {
        let mut gap = of_t_b[j].abs() * inverse_b[j] - b[j];
        for i in 0..N {
            gap -= a[i] * cosines[i][j].abs();
        }
        if gap > best {
            (best, axis) = (gap, WidestAxis::B(j));
        }
    }
    let mut best = best * best;
    for i in 0..N {
        let (k, l) = ((i + 1) % N, (i + 2) % N);
        let (near, far) = (of_t_a[k] * inverse_a[k], of_t_a[l] * inverse_a[l]);
        for j in 0..M {
            let (m, n) = ((j + 1) % M, (j + 2) % M);
            let (u, v) = (cosines[k][j], cosines[l][j]);
            let reach_a = a[k] * v.abs() + a[l] * u.abs();
            let reach_b = b[m] * cosines[i][n].abs() + b[n] * cosines[i][m].abs();
            let gap = (far * u - near * v).abs() - (reach_a + reach_b);
            let square = 1.0 - cosines[i][j] * cosines[i][j];
            // Edges that are about parallel have no axis.
            if gap > 0.0 && square > 1e-6 && gap * gap > best * square {
                (best, axis) = (gap * gap / square, WidestAxis::Edges(i, j));
            }
        }
    }
    axis
}
