//! One sphere, capsule or cuboid against sixteen: the one definition of the arithmetic, for registers of any width.
//!
//! `f32`, not `f64`: twice the lanes for each operation. The certainty lost is a band of 2^-19 of the size of the
//! coordinates, in which about one pair in 10^5 is.
//!
//! **Method.** Near points of the two cores by alternating projections, in the coordinates along the half edges. For
//! two segments, one step of the solution of the two equations. Then the certificates of the scalar filter: points that
//! are near enough show that the shapes are within the margin; a gap along the difference of the points, along the line
//! of centres or a half edge of a cuboid that is wide enough shows that they are not.
//!
//! **Errors.** Let u = 2^-24 and L the sum of both `size`. Rounding to `f32` moves points of the cores by at most u L.
//! * The coordinates along half edges are clamped, so exactly those of a point of the core. To compute the difference
//!   of two such points takes at most 9 roundings of terms whose magnitudes add up to at most L: with the above, an
//!   error of at most 11 u L.
//! * A gap along a vector n is a sum of at most 7 dot products: an error of at most (1 + 1 + 3 + 6) u |n| L.
//! * `SLACK` L, where `SLACK` is 32 u, covers these, and relative errors of the lengths, of 5 u. Radii have a relative
//!   error of 3 u, and `FEW`, which is 16 u, covers it.
//! * Underflow: L is at least 2^-20, so slacks are at least 2^-39. Gaps along differences shorter than the slack are
//!   not used, and half edges are at least 2^-60 long, so that all products that are compared are normal.
//!
//! A core that contains a ball of radius r contains all points at most `SHRINK r` from the core shrunk by 1 - `SHRINK`:
//! so points of shrunk cuboids that are near enough show that cuboids without a radius meet.

use crate::exact::power_of_two;
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};

const SLACK: f32 = power_of_two(-19) as f32;
const FEW: f32 = power_of_two(-20) as f32;
const SHRINK: f32 = power_of_two(-10) as f32;
/// Rounds of projections of two cuboids, and of a segment and a cuboid.
const ROUNDS: usize = 4;

/// Some numbers in a register. A value exists only where a token proves the instruction set.
///
/// Comparisons are false for NaN. Operations are those of IEEE 754, each rounded; no fused multiply-add.
pub(super) trait Wide: Copy {
    type Token: Copy;
    /// Numbers in a register, a divisor of 16.
    const LANES: usize;

    fn splat(token: Self::Token, x: f32) -> Self;
    /// Lanes `LANES part ..`.
    fn load(token: Self::Token, numbers: &[f32; 16], part: usize) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn magnitude(self) -> Self;
    fn root(self) -> Self;
    /// The second unless the first is greater.
    fn greater(self, other: Self) -> Self;
    /// The second unless the first is less.
    fn lesser(self, other: Self) -> Self;
    /// Bit i: lane i of the first is greater.
    fn exceeds(self, other: Self) -> u16;
}

type Vector<V> = [V; 3];

#[inline(always)]
fn dot<V: Wide>(a: &Vector<V>, b: &Vector<V>) -> V {
    a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
}

#[inline(always)]
fn difference<V: Wide>(a: &Vector<V>, b: &Vector<V>) -> Vector<V> {
    [a[0].minus(b[0]), a[1].minus(b[1]), a[2].minus(b[2])]
}

#[inline(always)]
fn times<V: Wide>(t: V, v: &Vector<V>) -> Vector<V> {
    [t.times(v[0]), t.times(v[1]), t.times(v[2])]
}

#[inline(always)]
fn plus<V: Wide>(a: &Vector<V>, b: &Vector<V>) -> Vector<V> {
    [a[0].plus(b[0]), a[1].plus(b[1]), a[2].plus(b[2])]
}

#[inline(always)]
fn splat<V: Wide>(token: V::Token, v: &[f32; 3]) -> Vector<V> {
    [V::splat(token, v[0]), V::splat(token, v[1]), V::splat(token, v[2])]
}

#[inline(always)]
fn load<V: Wide>(token: V::Token, v: &[[f32; 16]; 3], part: usize) -> Vector<V> {
    [V::load(token, &v[0], part), V::load(token, &v[1], part), V::load(token, &v[2], part)]
}

/// The lanes of `lanes` that `query` is certainly apart from, and those that it certainly meets.
#[inline(always)]
pub(super) fn decide<V: Wide, const M: usize, const N: usize>(
    token: V::Token,
    query: &Solid<M>,
    lanes: &SolidLanes<N>,
) -> Decided {
    let mut decided = Decided::default();
    for part in 0..16 / V::LANES {
        let some = decide_part::<V, M, N>(token, query, lanes, part);
        decided.apart |= some.apart << (part * V::LANES);
        decided.within |= some.within << (part * V::LANES);
    }
    Decided { apart: decided.apart | !lanes.used, within: decided.within & lanes.used }
}

#[inline(always)]
fn decide_part<V: Wide, const M: usize, const N: usize>(
    token: V::Token,
    query: &Solid<M>,
    lanes: &SolidLanes<N>,
    part: usize,
) -> Decided {
    let number = |x: f32| V::splat(token, x);
    let (zero, slack) = (number(0.0), number(query.size).plus(V::load(token, &lanes.size, part)));
    let slack = slack.times(number(SLACK));
    let reach = number(query.radius).plus(V::load(token, &lanes.radius, part));
    let far = reach.times(number(1.0 + FEW)).plus(slack);
    let inner = number(query.inner).plus(V::load(token, &lanes.inner, part));
    let near = reach.plus(inner.times(number(SHRINK))).times(number(1.0 - FEW)).minus(slack);

    let d: Vector<V> = difference(&load(token, &lanes.centre, part), &splat(token, &query.centre));
    if M == 0 && N == 0 {
        let distance = dot(&d, &d).root();
        return Decided { apart: distance.exceeds(far), within: near.exceeds(distance) };
    }

    // Dot products of the half edges a of the query and b of the lanes with each other and with d.
    let (mut a, mut b) = ([[zero; 3]; M], [[zero; 3]; N]);
    let (mut da, mut db, mut ab) = ([zero; M], [zero; N], [[zero; N]; M]);
    for i in 0..M {
        a[i] = splat(token, &query.half[i]);
        da[i] = dot(&d, &a[i]);
    }
    for j in 0..N {
        b[j] = load(token, &lanes.half[j], part);
        db[j] = dot(&d, &b[j]);
    }
    for i in 0..M {
        for j in 0..N {
            ab[i][j] = dot(&a[i], &b[j]);
        }
    }
    let mut apart = 0;

    // The half edges of cuboids as axes.
    if M == 3 {
        for i in 0..M {
            let mut gap = da[i].magnitude().minus(number(query.extent[i]));
            for j in 0..N {
                gap = gap.minus(ab[i][j].magnitude());
            }
            apart |= gap.exceeds(far.times(number(query.length[i])));
        }
    }
    if N == 3 {
        for j in 0..N {
            let mut gap = db[j].magnitude().minus(V::load(token, &lanes.extent[j], part));
            for i in 0..M {
                gap = gap.minus(ab[i][j].magnitude());
            }
            apart |= gap.exceeds(far.times(V::load(token, &lanes.length[j], part)));
        }
    }

    // Near points, x along a and y along b.
    let (mut x, mut y) = ([zero; M], [zero; N]);
    let limit = |edges: usize| number(if edges == 3 { 1.0 - SHRINK } else { 1.0 });
    let clamp = |t: V, edges: usize| t.greater(zero.minus(limit(edges))).lesser(limit(edges));
    if M == 1 && N == 1 {
        let (g, h) = (dot(&a[0], &a[0]), dot(&b[0], &b[0]));
        let determinant = g.times(h).minus(ab[0][0].times(ab[0][0]));
        x[0] = clamp(da[0].times(h).minus(ab[0][0].times(db[0])).over(determinant), M);
    } else {
        for i in 0..M {
            x[i] = clamp(da[i].times(number(query.inverse[i])), M);
        }
    }
    let rounds = if M == 0 || N == 0 || M + N == 2 { 1 } else { ROUNDS };
    for _ in 0..rounds {
        for j in 0..N {
            let mut along = zero.minus(db[j]);
            for i in 0..M {
                along = along.plus(x[i].times(ab[i][j]));
            }
            y[j] = clamp(along.times(V::load(token, &lanes.inverse[j], part)), N);
        }
        for i in 0..M {
            let mut along = da[i];
            for j in 0..N {
                along = along.plus(y[j].times(ab[i][j]));
            }
            x[i] = clamp(along.times(number(query.inverse[i])), M);
        }
    }

    let mut n = d;
    for j in 0..N {
        n = plus(&n, &times(y[j], &b[j]));
    }
    for i in 0..M {
        n = difference(&n, &times(x[i], &a[i]));
    }
    let length = dot(&n, &n).root();
    let mut gap = dot(&n, &d);
    for i in 0..M {
        gap = gap.minus(dot(&n, &a[i]).magnitude());
    }
    for j in 0..N {
        gap = gap.minus(dot(&n, &b[j]).magnitude());
    }
    apart |= gap.exceeds(far.times(length)) & length.exceeds(slack);
    Decided { apart, within: near.exceeds(length) }
}

#[cfg(test)]
mod tests;
