//! Re-alignment: the planes of a turned body, without touching its vertices (DESIGN 5).
//!
//! Body A stands at pose (M, t) in the frame of body B, so its planes must be turned before they can be
//! compared with B's. For a direction n of B and a point x of A
//!
//! ```text
//! n . (M x + t) = u . x + n . t,     u = transpose(M) n = sum of three c_l n_l,  c_l >= 0
//!              <= sum c_l d_l(A) + n . t                                          (weak duality of linear programming)
//! ```
//!
//! The three directions are the corners of the face that the ray u pierces in the hull of the directions.
//! They depend on the rotation alone: they are found once a query, and then cost three multiplications and
//! three additions a plane, for 16 children at once.
//!
//! **Why no rounding can lose a collision.** All of it is in `f32`, but for the way s between the centres of the
//! frames, so that a core without `f64` does not emulate it for every plane. Every quantity that was rounded is paid
//! for in `offset`, once, for all nodes. With `e = 2^-24`, `|n|` the sum of magnitudes of a direction's components,
//! `S = max |s|` in the frame, and `rho` the ratio of the units:
//!
//! | what was rounded | at most | the pad |
//! |---|---|---|
//! | M, and u: four roundings of a sum of magnitudes below `1.0002 abs(n)` | `4.1 e abs(n)` of each component of u | `16 e abs(n) rho sum half_width` for both |
//! | the weights c: six roundings of at most `max abs(u)`; for k = 32 they are computed in `f64` and then rounded, `sum c <= 1.2 abs(n)`, times the greatest component, 3 | `6.1 e abs(n)` of each component of `sum c n_l` | |
//! | s to `f32`, and n . s | `4.1 e abs(n) S` | `16 e (sum c max_plane + abs(n) S)` for both |
//! | products and sums of codes, and the offset, with the half step that each code stands for besides: `max_plane` is at least as much | `12.3 e (sum c max_plane)`, `3.1 e abs(n) S` | |
//! | s in `f64`; the moved corners that the leaf test decides on | `2^-48 abs(n) (coordinates)` | `2^-46 abs(n) (coordinates)` |
//! | coordinates of moved corners that [`Pose::apply`] flushes to zero | `2^-250 abs(n)` | the same |
//! | what is too small for a normal `f32`, and all planes of a body 2^100 times smaller ([`crate::query`]) | `2^-84` | `2^-80` |
//! | sums that could overflow an `f32`, of bodies 2^100 times larger than the other | | the plane is unbounded |
//!
//! and the pad is a sum of products of numbers that are not negative, so that its own roundings, each `e` of a partial
//! result, are paid for by one factor: a twentieth of a step for a body like B. The turned plane is then rounded to a key.
//!
//! **Radii.** A pose moves the corners of a primitive; everything within its radius of them keeps its shape. Its
//! planes bound `u . x + |u| r`, which is less than `u . x + |n| r` where M makes vectors shorter, as an accepted
//! matrix may by 1e-4. So the planes of bodies with radii are moved out by `shrinkage` besides.

mod ball;
mod inverse;
mod on_lattice;
mod primitive_slab;
mod ray;

pub(crate) use ball::BallMap;
pub use inverse::InversePose;
pub(crate) use on_lattice::{ALL, planes_on_lattice, some_planes_of};
pub use primitive_slab::{PrimitiveSlab, PrimitiveSlabs, primitive_slabs};
pub(crate) use ray::Ray;

use crate::directions::{Directions, greater};
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::{BodyBounds, Frame};
use crate::key::Key;
use crate::pose::Pose;
use crate::primitive::{Primitive, radius_of};
use crate::range::{MIN_COORDINATE, Point};
use crate::vector::difference;

/// How the planes of every node of one body turn into another body's frame, at one pose.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Realignment<const K: usize> {
    /// Three planes for each slab: plane `2s` turned is `(w[0] d[p[0]] + w[1] d[p[1]]) + w[2] d[p[2]] +
    /// offset[2s]` with `p = sources[s]`, `w[l] = weights[l][s]`. Plane `2s + 1` takes their opposites, `p ^
    /// 1`, at the same weights. The first half of the array is used, and of each entry three: four bytes are moved at
    /// once.
    pub sources: [[u8; 4]; K],
    /// The weights of each slab, not negative. The first half of each array is used.
    pub weights: [[f32; K]; 3],
    /// Translation and pad of each plane.
    pub offset: [f32; K],
}

/// Bounds five roundings of `f32`, with room for the rounding of the pad itself.
pub(crate) const GAMMA_5: f64 = 5.25 * power_of_two(-24);

/// Bounds the few dozen roundings of `f64` in a sum of magnitudes: each is 2^-53 of a partial sum.
pub(crate) const F64_SLACK: f64 = power_of_two(-46);

/// Pays for the pad's own rounding to `f32`: it can be far greater than what it pads.
const ITS_OWN_ROUNDING: f64 = 1.0 + power_of_two(-23);

/// Those of a pad that is computed in `f32`.
const ITS_OWN_ROUNDINGS: f32 = 1.0 + power_of_two(-16) as f32;

/// Of the weights of a direction, in components of that direction.
const RESIDUAL: f32 = power_of_two(-20) as f32;

/// Of the sum that a turned plane is, of the magnitudes in it.
const ROUNDINGS: f32 = power_of_two(-20) as f32;

/// A bit more than half of a last place of `f32`.
pub(crate) const HALF_PLACE: f64 = 1.0625 * power_of_two(-24);

/// More than what weights and products lose that are too small for a normal `f32`.
pub(crate) const UNDERFLOW: f64 = power_of_two(-130);

/// The same in a set-up in `f32`, where it is a normal number.
const UNDERFLOW_OF_SINGLES: f32 = power_of_two(-80) as f32;

/// Sums of magnitudes below this cannot overflow an `f32`. Beyond it a product could become -infinity, which
/// bounds nothing: such a plane is unbounded instead.
const MAX_REACH: f32 = power_of_two(126) as f32;

impl<const K: usize> Realignment<K> {
    /// To be overwritten.
    pub(crate) const UNSET: Self = Self { sources: [[0; 4]; K], weights: [[0.0; K]; 3], offset: [0.0; K] };

    /// The map for a body of extent `a`, posed in the frame `b`.
    #[inline(always)]
    #[must_use]
    pub fn new(pose: &Pose, a: &BodyBounds, b: &Frame) -> Self {
        let mut map = Self::UNSET;
        map.set(pose, a, b);
        map
    }

    /// [`Self::new`] in place: as a result it was copied, and took as much stack once more.
    // Part of the query that it begins, so that it is compiled for the query's instruction set.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "several columns share the index")]
    pub(crate) fn set(&mut self, pose: &Pose, a: &BodyBounds, b: &Frame) {
        let rows = pose.rows();
        // Loops, not `map`, which is not always inlined.
        let mut m = [[0.0_f32; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] = rows[i][j] as f32;
            }
        }
        let ratio = power_of_two(b.exponent - a.frame.exponent) as f32;
        let [x, y, z] = a.half_width;
        let scale = b.scale();
        let [s0, s1, s2] = shift(pose, a, b);
        let shift = [(s0 * scale) as f32, (s1 * scale) as f32, (s2 * scale) as f32];
        let away = greater(greater(shift[0].abs(), shift[1].abs()), shift[2].abs());
        let slack = (F64_SLACK * (scale * coordinates(pose, a, b)) + MIN_COORDINATE * scale) as f32;
        let per_length = (RESIDUAL * (ratio * ((x + y) + z)) + ROUNDINGS * away) + slack;
        let per_weight = ROUNDINGS * a.max_plane;

        let [nx, ny, nz] = &Directions::<K>::SINGLE_SLAB_COLUMNS;
        let (slabs, columns) = (Directions::<K>::SLABS, Directions::<K>::SINGLE_COLUMNS);
        for i in 0..3 {
            for s in 0..columns {
                self.weights[i][s] = (m[0][i] * nx[s] + m[1][i] * ny[s]) + m[2][i] * nz[s];
            }
        }
        self.sources = Directions::<K>::decompose_columns(&mut self.weights, columns, slabs);
        let mut offsets = [[0.0_f32; 2]; K];
        for s in 0..columns {
            let length = nx[s].abs() + ny[s].abs() + nz[s].abs();
            let [c0, c1, c2] = &mut self.weights;
            (c0[s], c1[s], c2[s]) = (ratio * c0[s], ratio * c1[s], ratio * c2[s]);
            let weight_sum = (c0[s] + c1[s]) + c2[s];
            let tau = (nx[s] * shift[0] + ny[s] * shift[1]) + nz[s] * shift[2];
            let reach = weight_sum * a.max_plane + length * away;
            let pad =
                ((weight_sum * per_weight + length * per_length) + UNDERFLOW_OF_SINGLES) * ITS_OWN_ROUNDINGS;
            let is_bounded = reach < MAX_REACH;
            // Codes stand for half a step more.
            let pad = 0.5 * weight_sum + pad;
            offsets[s] = if is_bounded { [tau + pad, pad - tau] } else { [f32::INFINITY; 2] };
        }
        // Not one by one: of nine, the compiler stored and loaded some as vectors that had to wait for each other.
        self.offset.copy_from_slice(&offsets.as_flattened()[..K]);
    }

    /// Moves every plane out by `margin`, in units of the frame: turned planes then hold everything within it
    /// of the body. The roundings of the longer offset, and of the sums it is in, are paid for by a few more of the last
    /// places of both terms.
    #[inline(always)]
    pub fn widen(&mut self, margin: f64) {
        let margin = round_up_f32(margin);
        for (offset, length) in self.offset.iter_mut().zip(Directions::<K>::SINGLE_LENGTHS) {
            let reach = length * margin;
            *offset += (reach + ROUNDINGS * reach) + ROUNDINGS * offset.abs();
        }
    }

    /// What plane `j` turned is the sum of, but for the offset: planes and their weights.
    #[inline]
    #[must_use]
    pub fn terms(&self, j: usize) -> [(usize, f32); 3] {
        let sources = &self.sources[j / 2];
        core::array::from_fn(|l| (usize::from(sources[l]) ^ (j & 1), self.weights[l][j / 2]))
    }

    /// Plane `j` turned, from the codes of a body's planes, as the sum in `f32` that it is: already a bound.
    #[inline]
    #[must_use]
    pub fn sum(&self, j: usize, code: impl Fn(usize) -> i16) -> f32 {
        let terms = self.terms(j);
        let term = |l: usize| terms[l].1 * f32::from(code(terms[l].0));
        ((term(0) + term(1)) + term(2)) + self.offset[j]
    }

    /// Plane `j` turned, from the codes of a body's planes: the specification that the kernels follow,
    /// operation by operation. An unbounded plane, and a weight or offset beyond `f32`, give
    /// [`Key::INFINITY`].
    #[inline]
    #[must_use]
    pub fn plane(&self, j: usize, code: impl Fn(usize) -> i16) -> Key {
        Key::around(self.sum(j, code))
    }
}

/// Where the pose puts the centre of A's frame, from the centre of B's, up to rounding in `f64`.
#[inline(always)]
pub(crate) fn shift(pose: &Pose, a: &BodyBounds, b: &Frame) -> Point {
    difference(&pose.unflushed_called(&a.frame.centre), &b.centre)
}

/// What the roundings of moved corners and centres are relative to.
#[inline(always)]
pub(crate) fn coordinates(pose: &Pose, a: &BodyBounds, b: &Frame) -> f64 {
    // 4 >= sum of a row's magnitudes, for the image; once more for the centre.
    (8.0 * a.max_coordinate + greatest(&pose.translation())) + greatest(&b.centre)
}

/// What is lost along an axis of length 1 by rounding in `f64`, in the bodies' unit: of a moved corner's way from
/// the centre of its own body, when the way between the centres is [`shift`].
#[inline(always)]
pub(crate) fn slack_of_shift(pose: &Pose, a: &BodyBounds, b: &Frame) -> f64 {
    // The sum of the axis's magnitudes is at most the root of 3.
    2.0 * (F64_SLACK * coordinates(pose, a, b) + MIN_COORDINATE)
}

/// What a margin has to grow by where volumes of A are compared as M turns them, if A's primitives have radii: by at
/// least as much as M makes any of these radii shorter or longer. No radius is above half of the body's width.
#[inline(always)]
pub(crate) fn shrinkage<P: Primitive>(pose: &Pose, a: &BodyBounds) -> f64 {
    if !P::IS_ROUND {
        return 0.0;
    }
    let [x, y, z] = a.half_width;
    pose.skew() * (f64::from(x.min(y).min(z)) / a.frame.scale())
}

/// The planes of everything within `margin` of moved primitives in frame `b`, each an upper bound of the
/// exact support, rounded up: tighter than the re-aligned planes of the leaf that holds them.
// Loops, not `array::from_fn`, which is not always inlined.
#[inline(always)]
#[must_use]
pub(crate) fn planes_of<P: Primitive, const K: usize>(
    b: &Frame,
    items: impl Iterator<Item = P::Item>,
    margin: f64,
) -> [Key; K] {
    let Supports { least, greatest, size } = Supports::<K>::of::<P>(b, items);
    let scale = b.scale();
    // By columns of slabs, which are compiled to vector instructions.
    let mut slabs = [[Key::LOWEST; 2]; K];
    // Kept where it is: what the margin alone decides was computed, and stored, at the beginning of each query.
    let margin = core::hint::black_box(margin);
    for s in 0..Directions::<K>::COLUMNS {
        slabs[s] = planes_of_slab::<K>(s, [least[s], greatest[s]], size, margin, scale);
    }
    let mut planes = [Key::LOWEST; K];
    planes.copy_from_slice(&slabs.as_flattened()[..K]);
    planes
}

/// The two planes of a slab from the least and the greatest support, by the largest magnitude of a coordinate.
#[inline(always)]
fn planes_of_slab<const K: usize>(
    s: usize,
    [least, greatest]: [f64; 2],
    size: f64,
    margin: f64,
    scale: f64,
) -> [Key; 2] {
    let pad = F64_SLACK * Directions::<K>::SLAB_SUMS[s] * size;
    let reach = (1.0 + F64_SLACK) * Directions::<K>::SLAB_LENGTHS[s] * margin;
    let pads = pad + reach;
    [Key::above((pads + greatest) * scale), Key::above((pads - least) * scale)]
}

/// Supports of some primitives, relative to the centre of a frame, up to rounding in `f64`.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Supports<const K: usize> {
    /// The least for each slab. The first half of the array is used.
    pub(crate) least: [f64; K],
    /// The greatest.
    pub(crate) greatest: [f64; K],
    /// The largest magnitude of a coordinate, the frame's centre included.
    pub(crate) size: f64,
}

impl<const K: usize> Supports<K> {
    // By columns of slabs. With the two planes of a slab side by side, a loop in steps of two, LLVM 22.1 gave
    // code for AVX-512 that lost supports.
    #[inline(always)]
    pub(crate) fn of<P: Primitive>(b: &Frame, items: impl Iterator<Item = P::Item>) -> Self {
        Self::of_slabs::<P>(
            b,
            items,
            #[inline(always)]
            |_| true,
        )
    }

    /// Of those slabs that are wanted.
    #[inline(always)]
    fn of_slabs<P: Primitive>(
        b: &Frame,
        items: impl Iterator<Item = P::Item>,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Self {
        let [nx, ny, nz] = &Directions::<K>::SLAB_COLUMNS;
        let mut found =
            Self { least: [f64::INFINITY; K], greatest: [f64::NEG_INFINITY; K], size: greatest(&b.centre) };
        for item in items {
            let radius = radius_of::<P>(&item);
            for p in P::corners(&item) {
                let d = [p[0] - b.centre[0], p[1] - b.centre[1], p[2] - b.centre[2]];
                found.size = found.size.max(greatest(&p));
                if P::IS_ROUND {
                    found.size = found.size.max(greatest(&p) + radius);
                }
                for s in 0..Directions::<K>::COLUMNS {
                    if !is_wanted(s) {
                        continue;
                    }
                    let support = (nx[s] * d[0] + ny[s] * d[1]) + nz[s] * d[2];
                    let (mut low, mut high) = (support, support);
                    if P::IS_ROUND {
                        let reach = Directions::<K>::SLAB_LENGTHS[s] * radius;
                        (low, high) = (support - reach, support + reach);
                    }
                    let (least, greatest) = (found.least[s], found.greatest[s]);
                    found.least[s] = if low < least { low } else { least };
                    found.greatest[s] = if high > greatest { high } else { greatest };
                }
            }
        }
        found
    }
}

/// The greatest magnitude of a coordinate.
#[inline(always)]
pub(crate) fn greatest(p: &Point) -> f64 {
    greater(greater(p[0].abs(), p[1].abs()), p[2].abs())
}
