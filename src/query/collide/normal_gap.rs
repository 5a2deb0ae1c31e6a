//! The test of two children by their normal slabs, which a long query makes before each visit.
//!
//! Child a of A has `low_a <= n_a . x <= high_a`, child b of B likewise with `n_b` and y; x and y are points in the
//! frames of the two trees. A point of A is at `y = rho M x + s` in B's frame, with the ratio rho of the units and the
//! shift s of the centres. Along `n_b`, with `u = transpose(M) n_b`, a covers
//!
//! ```text
//! rho u . x + n_b . s,      u = alpha n_a + r,      alpha = u . n_a / n_a . n_a
//! ```
//!
//! and so at most `alpha [low_a, high_a]` plus the support of its planes along r: a weighted sum of three planes, as in
//! re-alignment. r is small for patches that nearly touch, whose normals are nearly parallel: the bound is as thin as
//! both slabs. Along `v = M n_a` likewise: there a covers `rho [low_a, high_a] + v . s`, except for M's deviation from
//! a rotation, and b at most `beta [low_b, high_b]` plus its support along `v - beta n_b`.
//!
//! All computations are in `f64`, so a single pad for the whole query suffices. It is the sum of these, times 4096,
//! which bounds the magnitudes of n and v:
//!
//! * u, v, alpha, beta, r and its weights: `2^-44 (rho sum half_width_a + sum half_width_b)`;
//! * sums of planes, and slabs: `2^-44 (rho max_plane_a + max_plane_b + rho + 1)`;
//! * the frames' centres, moved corners: `2^-46 (coordinates)`;
//! * coordinates of moved corners that [`Pose::apply`] flushes to zero: `2^-250`;
//! * M is not a rotation, `v . M x = n_a . x + (transpose(M) M - 1) n_a . x`: `rho max abs(transpose(M) M - 1) sum
//!   half_width_a`.

use crate::exact::power_of_two;
use crate::frame::BodyBounds;
use crate::node::NormalSlab;
use crate::pose::Pose;
use crate::query::lanes::{AT_ONCE, Lanes};
use crate::range::{MIN_COORDINATE, Point};
use crate::realign::{F64_SLACK, coordinates, shift};

/// The data of a query that all of its pairs share.
#[derive(Copy, Clone, Debug)]
pub(super) struct NormalTest<'t> {
    pose: &'t Pose,
    /// The centre of A's frame, in B's frame.
    shift: Point,
    /// The unit of A's frame divided by that of B's.
    ratio: f64,
    pad: f64,
}

/// A child of a node and its normal slab.
#[derive(Copy, Clone, Debug)]
pub(super) struct NormalChild<'t, N> {
    pub(super) node: &'t N,
    pub(super) lane: usize,
    pub(super) slab: NormalSlab,
}

/// Bounds the sum of magnitudes of a direction, before and after a rotation by the pose.
const SUM: f64 = 4096.0;

impl<'t> NormalTest<'t> {
    #[inline(always)]
    pub(super) fn new(pose: &'t Pose, a: &BodyBounds, b: &BodyBounds, margin: f64) -> Self {
        let (m, scale) = (pose.rows(), b.frame.scale());
        let ratio = power_of_two(b.frame.exponent - a.frame.exponent);
        let shift = shift(pose, a, &b.frame).map(|x| x * scale);
        let mut skew = 0.0_f64;
        for i in 0..3 {
            for j in 0..3 {
                let dot = (m[0][i] * m[0][j] + m[1][i] * m[1][j]) + m[2][i] * m[2][j];
                skew = skew.max((dot - f64::from(u8::from(i == j))).abs());
            }
        }
        let coordinates = coordinates(pose, a, &b.frame);
        let inexact = ratio * ((a.width_sum() + f64::from(a.max_plane)) + 1.0)
            + ((b.width_sum() + f64::from(b.max_plane)) + 1.0);
        let pad = SUM
            * ((4.0 * F64_SLACK * inexact + (skew + F64_SLACK) * (ratio * a.width_sum()))
                + ((F64_SLACK * coordinates + MIN_COORDINATE) + margin) * scale);
        Self { pose, shift, ratio, pad }
    }

    /// Bit i: children a and b of pair i certainly do not meet, nor come within the margin.
    #[inline(always)]
    pub(super) fn apart<N: Lanes>(
        &self,
        a: &[NormalChild<'_, N>; AT_ONCE],
        b: &[NormalChild<'_, N>; AT_ONCE],
    ) -> u16 {
        let (m, shift) = (self.pose.rows(), &self.shift);
        // By columns, one pair a lane.
        let ([mut low_a, mut high_a], mut n_a) = ([[0.0; AT_ONCE]; 2], [[0.0; AT_ONCE]; 3]);
        let ([mut low_b, mut high_b], mut n_b) = ([[0.0; AT_ONCE]; 2], [[0.0; AT_ONCE]; 3]);
        for j in 0..AT_ONCE {
            [n_a[0][j], n_a[1][j], n_a[2][j]] = a[j].slab.normal();
            [n_b[0][j], n_b[1][j], n_b[2][j]] = b[j].slab.normal();
            [low_a[j], high_a[j]] = a[j].slab.ends();
            [low_b[j], high_b[j]] = b[j].slab.ends();
        }
        let (mut alpha, mut beta) = ([0.0; AT_ONCE], [0.0; AT_ONCE]);
        let (mut along_a, mut along_b) = ([0.0; AT_ONCE], [0.0; AT_ONCE]);
        let (mut rest_a, mut rest_b) = ([[0.0; AT_ONCE]; 3], [[0.0; AT_ONCE]; 3]);
        let dot = |p: &Point, q: &Point| (p[0] * q[0] + p[1] * q[1]) + p[2] * q[2];
        for j in 0..AT_ONCE {
            let (p, q) = ([n_a[0][j], n_a[1][j], n_a[2][j]], [n_b[0][j], n_b[1][j], n_b[2][j]]);
            let v = [dot(&m[0], &p), dot(&m[1], &p), dot(&m[2], &p)];
            let common = dot(&v, &q);
            (alpha[j], beta[j]) = (common / dot(&p, &p), common / dot(&q, &q));
            (along_a[j], along_b[j]) = (dot(&v, shift), dot(&q, shift));
            for i in 0..3 {
                let u = (m[0][i] * q[0] + m[1][i] * q[1]) + m[2][i] * q[2];
                rest_a[i][j] = u - alpha[j] * p[i];
                rest_b[i][j] = v[i] - beta[j] * q[i];
            }
        }
        let [low_r, high_r] = N::supports_of_children(a.map(|a| (a.node, a.lane)), &rest_a);
        let [low_s, high_s] = N::supports_of_children(b.map(|b| (b.node, b.lane)), &rest_b);
        let lesser = |x: f64, y: f64| if x < y { x } else { y };
        let greater = |x: f64, y: f64| if x > y { x } else { y };
        let mut apart = [0_u16; AT_ONCE];
        for j in 0..AT_ONCE {
            // An unbounded slab gives infinities of both signs or NaN, for which all comparisons are false.
            let (x, y) = (alpha[j] * low_a[j], alpha[j] * high_a[j]);
            let low = (self.ratio * (lesser(x, y) + low_r[j]) + along_b[j]) - self.pad;
            let high = (self.ratio * (greater(x, y) + high_r[j]) + along_b[j]) + self.pad;
            let by_b = (low > high_b[j]) | (high < low_b[j]);
            let (x, y) = (beta[j] * low_b[j], beta[j] * high_b[j]);
            let (below, above) = (lesser(x, y) + low_s[j], greater(x, y) + high_s[j]);
            let (low, high) = (self.ratio * low_a[j] + along_a[j], self.ratio * high_a[j] + along_a[j]);
            let by_a = (low - self.pad > above) | (high + self.pad < below);
            apart[j] = u16::from(by_a | by_b) << j;
        }
        apart.into_iter().fold(0, |all, bit| all | bit)
    }
}

#[cfg(test)]
#[cfg(feature = "alloc")]
mod tests;
