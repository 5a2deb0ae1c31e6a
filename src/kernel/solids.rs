//! One sphere, capsule or cuboid against sixteen: the one definition of the arithmetic, for registers of any width.
//!
//! `f32` gives twice as many lanes per operation as `f64`. In exchange, pairs within a band of 2^-19 of the size of
//! the coordinates stay undecided, about one pair in 10^5.
//!
//! **Method.** Alternating projections, in coordinates along the half edges, give near points of the two cores; for
//! two segments, solving two linear equations does. Then the certificates of the scalar filter apply: points that are
//! near enough show that the shapes are within the margin. A sufficiently wide gap along the difference of the points,
//! or along a half edge of a cuboid, shows that they are not.
//!
//! **Errors.** Let u = 2^-24 and L the sum of both `size`. Rounding to `f32` moves points of the cores by at most u L.
//! * The coordinates along half edges are clamped, so they are exactly those of a point of the core. Computing the
//!   difference of two such points takes at most 9 roundings of terms whose magnitudes add up to at most L. With the
//!   rounding of the cores, the error is at most 11 u L.
//! * A gap along a vector n is a sum of at most 7 dot products: an error of at most (1 + 1 + 3 + 6) u |n| L.
//! * `SLACK` L, where `SLACK` is 32 u, covers these errors and the relative error of lengths, 5 u. Radii have a
//!   relative error of 3 u, and `FEW`, which is 16 u, covers it.
//! * Underflow: L is at least 2^-20, so slacks are at least 2^-39. Gaps along differences shorter than the slack are
//!   not used, and half edges are at least 2^-60 long, so that all products that are compared are normal.
//!
//! **Separating axes.** Two cuboids are also tested along all 15 axes of two rectangular boxes, in coordinates along
//! their edges. Let c be the sum of both `skew`. An exactly rectangular box has edges within 2.1 c of their length
//! from those of each cuboid, so gaps and overlaps, computed along a vector of length at most 1, have errors below (16
//! u + 8 c) L, and the support functions of cuboids and boxes differ by less than 4 c L. `DEEP` L + 8 c L covers both.
//! Axes `a x b` are not normalized: they are shorter than 1, so that gaps and overlaps along the unit vector are
//! larger. If all 15 overlaps exceed the slack, the Minkowski difference of the boxes contains a ball about the origin
//! whose radius exceeds the difference of the support functions, so the cuboids meet. The axis of two edges that are
//! parallel up to 2^-20 is left out: rotating one box by three such angles makes them parallel, so that their cross
//! product is no axis, and moves support functions by less than 2^-17 L, including the effect on the axes.
//!
//! If a core contains a ball of radius r, it contains all points within `SHRINK r` of the core shrunk by 1 - `SHRINK`.
//! So points of shrunk cuboids that are near enough show that cuboids without a radius meet.

use crate::exact::power_of_two;
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};

const SLACK: f32 = power_of_two(-19) as f32;
const FEW: f32 = power_of_two(-20) as f32;
const DEEP: f32 = power_of_two(-16) as f32;
/// Edges whose angle has at most this sine, computed to within 4 u, count as parallel.
const PARALLEL: f32 = power_of_two(-21) as f32;
const SHRINK: f32 = power_of_two(-10) as f32;
/// Rounds of projections for two cuboids, and for a segment and a cuboid.
const ROUNDS: usize = 4;

/// Some numbers in a register. A value exists only where a token proves the instruction set.
///
/// Comparisons are false for NaN. Operations are those of IEEE 754, each rounded; no fused multiply-add.
pub(super) trait Register: Copy {
    type Token: Copy;
    /// Numbers in a register, a divisor of 16.
    const LANES: usize;

    fn splat(token: Self::Token, x: f32) -> Self;
    /// Floats `LANES part ..`.
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

type RegisterVector<V> = [V; 3];

#[inline(always)]
fn dot<V: Register>(a: &RegisterVector<V>, b: &RegisterVector<V>) -> V {
    a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
}

#[inline(always)]
fn difference<V: Register>(a: &RegisterVector<V>, b: &RegisterVector<V>) -> RegisterVector<V> {
    [a[0].minus(b[0]), a[1].minus(b[1]), a[2].minus(b[2])]
}

#[inline(always)]
fn times<V: Register>(t: V, v: &RegisterVector<V>) -> RegisterVector<V> {
    [t.times(v[0]), t.times(v[1]), t.times(v[2])]
}

#[inline(always)]
fn plus<V: Register>(a: &RegisterVector<V>, b: &RegisterVector<V>) -> RegisterVector<V> {
    [a[0].plus(b[0]), a[1].plus(b[1]), a[2].plus(b[2])]
}

#[inline(always)]
fn splat<V: Register>(token: V::Token, v: &[f32; 3]) -> RegisterVector<V> {
    [V::splat(token, v[0]), V::splat(token, v[1]), V::splat(token, v[2])]
}

#[inline(always)]
fn load<V: Register>(token: V::Token, v: &[[f32; 16]; 3], part: usize) -> RegisterVector<V> {
    [V::load(token, &v[0], part), V::load(token, &v[1], part), V::load(token, &v[2], part)]
}

/// The lanes of `lanes` that `query` is certainly apart from, and those that it certainly meets.
#[inline(always)]
pub(super) fn decide<V: Register, const M: usize, const N: usize>(
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
#[expect(clippy::needless_range_loop, reason = "several arrays share the index")]
fn decide_part<V: Register, const M: usize, const N: usize>(
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

    let d: RegisterVector<V> = difference(&load(token, &lanes.centre, part), &splat(token, &query.centre));
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
    let (mut apart, mut within) = (0, 0);
    if M == 3 && N == 3 {
        let sizes = number(query.size).plus(V::load(token, &lanes.size, part));
        let skew = number(query.skew).plus(V::load(token, &lanes.skew, part));
        let slack = sizes.times(number(DEEP).plus(skew.times(number(8.0))));
        (apart, within) =
            axes(token, query, lanes, part, (&da, &db, &ab), (reach.times(number(1.0 + FEW)), slack));
        // The steps below decide only undecided lanes, so returning here does not change the result.
        if apart | within == u16::MAX >> (16 - V::LANES) {
            return Decided { apart, within };
        }
    }
    let open = !(apart | within);

    // The half edges of cuboids as axes.
    if M == 3 {
        for i in 0..M {
            let mut gap = da[i].magnitude().minus(number(query.extent[i]));
            for j in 0..N {
                gap = gap.minus(ab[i][j].magnitude());
            }
            apart |= gap.exceeds(far.times(number(query.length[i]))) & open;
        }
    }
    if N == 3 {
        for j in 0..N {
            let mut gap = db[j].magnitude().minus(V::load(token, &lanes.extent[j], part));
            for i in 0..M {
                gap = gap.minus(ab[i][j].magnitude());
            }
            apart |= gap.exceeds(far.times(V::load(token, &lanes.length[j], part))) & open;
        }
    }

    let (x, y) = near_points(token, query, lanes, part, (&da, &db, &ab));
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
    apart |= gap.exceeds(far.times(length)) & length.exceeds(slack) & open;
    within |= near.exceeds(length) & open;
    Decided { apart, within }
}

/// Coordinates of near points of the cores along the half edges of the query and of the lanes.
#[inline(always)]
fn near_points<V: Register, const M: usize, const N: usize>(
    token: V::Token,
    query: &Solid<M>,
    lanes: &SolidLanes<N>,
    part: usize,
    (da, db, ab): (&[V; M], &[V; N], &[[V; N]; M]),
) -> ([V; M], [V; N]) {
    let number = |x: f32| V::splat(token, x);
    let zero = number(0.0);
    let (mut x, mut y) = ([zero; M], [zero; N]);
    let limit = |edges: usize| number(if edges == 3 { 1.0 - SHRINK } else { 1.0 });
    let clamp = |t: V, edges: usize| t.greater(zero.minus(limit(edges))).lesser(limit(edges));
    if M == 1 && N == 1 {
        let g = splat::<V>(token, &query.half[0]);
        let h = load::<V>(token, &lanes.half[0], part);
        let (g, h) = (dot(&g, &g), dot(&h, &h));
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
    (x, y)
}

/// The lanes that one of the 15 axes separates, and the lanes that meet according to all axes.
#[inline(always)]
fn axes<V: Register, const M: usize, const N: usize>(
    token: V::Token,
    query: &Solid<M>,
    lanes: &SolidLanes<N>,
    part: usize,
    (da, db, ab): (&[V; M], &[V; N], &[[V; N]; M]),
    (reach, slack): (V, V),
) -> (u16, u16) {
    let zero = V::splat(token, 0.0);
    // Lengths of the half edges, d along their directions, and the cosines of the angles between them.
    let (mut p, mut q, mut t, mut w) = ([zero; 3], [zero; 3], [zero; 3], [zero; 3]);
    let (mut per, mut cosine, mut magnitude) = ([zero; 3], [[zero; 3]; 3], [[zero; 3]; 3]);
    for j in 0..N {
        q[j] = V::load(token, &lanes.length[j], part);
        per[j] = q[j].times(V::load(token, &lanes.inverse[j], part));
        w[j] = db[j].times(per[j]).magnitude();
    }
    for i in 0..M {
        p[i] = V::splat(token, query.length[i]);
        let ours = V::splat(token, query.length[i] * query.inverse[i]);
        t[i] = da[i].times(ours);
        for j in 0..N {
            cosine[i][j] = ab[i][j].times(ours.times(per[j]));
            magnitude[i][j] = cosine[i][j].magnitude();
        }
    }
    let far = reach.plus(slack);
    let below = zero.minus(slack);
    let (mut apart, mut within) = (0, u16::MAX >> (16 - V::LANES));
    let mut axis = |gap: V, is_parallel: u16| {
        apart |= gap.exceeds(far);
        within &= below.exceeds(gap) | is_parallel;
    };
    for i in 0..M {
        let spread = q[0].times(magnitude[i][0]).plus(q[1].times(magnitude[i][1]));
        axis(t[i].magnitude().minus(p[i].plus(spread.plus(q[2].times(magnitude[i][2])))), 0);
    }
    for j in 0..N {
        let spread = p[0].times(magnitude[0][j]).plus(p[1].times(magnitude[1][j]));
        axis(w[j].minus(q[j].plus(spread.plus(p[2].times(magnitude[2][j])))), 0);
    }
    let parallel = V::splat(token, PARALLEL);
    for i in 0..M {
        let (k, l) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..N {
            let (m, n) = ((j + 1) % 3, (j + 2) % 3);
            let along = t[l].times(cosine[k][j]).minus(t[k].times(cosine[l][j])).magnitude();
            let ours = p[k].times(magnitude[l][j]).plus(p[l].times(magnitude[k][j]));
            let theirs = q[m].times(magnitude[i][n]).plus(q[n].times(magnitude[i][m]));
            let is_parallel = parallel.exceeds(magnitude[k][j].greater(magnitude[l][j]));
            axis(along.minus(ours.plus(theirs)), is_parallel);
        }
    }
    (apart, within)
}

#[cfg(test)]
mod tests;
