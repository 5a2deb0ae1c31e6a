//! Re-alignment: bounds the planes of a rotated body from its planes alone, without its vertices.
//!
//! Body A stands at pose (M, t) in the frame of body B, so its planes must be rotated before they can be compared with
//! B's. For a direction n of B and a point x of A
//!
//! ```text
//! n . (M x + t) = u . x + n . t,     u = transpose(M) n = sum of three c_l n_l,  c_l >= 0
//!              <= sum c_l d_l(A) + n . t                                          (weak duality of linear programming)
//! ```
//!
//! The three directions are the corners of the face that the ray u pierces in the hull of the directions. They depend
//! on the rotation alone. A query computes them once; then a plane costs three multiplications and three additions, for
//! 16 children at once.
//!
//! **Why rounding cannot lose a collision.** All computations are in `f32`, except for the vector s between the centres
//! of the frames, so that a core without `f64` need not emulate it for every plane. `offset` includes a pad for each
//! rounded quantity, once for all nodes. With `e = 2^-24`, `|n|` the sum of magnitudes of a direction's components, `S
//! = max |s|` in the frame, and `rho` the ratio of the units:
//!
//! | rounded | error, at most | pad |
//! |---|---|---|
//! | M, and u (1) | `4.1 e abs(n)` in each component of u | `16 e abs(n) rho sum half_width`, also for (2) |
//! | the weights c (2) | `6.1 e abs(n)` in each component of `sum c n_l` | |
//! | s to `f32`, and n . s | `4.1 e abs(n) S` | `16 e (sum c max_plane + abs(n) S)`, also for (3) |
//! | products and sums of codes, and the offset (3) | `12.3 e (sum c max_plane)`, `3.1 e abs(n) S` | |
//! | s in `f64`; the moved corners in the leaf test | `2^-48 abs(n) (coordinates)` | `2^-46 abs(n) (coordinates)` |
//! | moved coordinates that [`Pose::apply`] flushes to zero | `2^-250 abs(n)` | the same |
//! | numbers below the normal range of `f32` (4) | `2^-84` | `2^-80` |
//! | sums that could overflow an `f32` (5) | | the plane is unbounded |
//!
//! 1. Four roundings of a sum of magnitudes below `1.0002 abs(n)`.
//! 2. Six roundings of at most `max abs(u)`. For k = 32 the weights are computed in `f64` and then rounded:
//!    `sum c <= 1.2 abs(n)`, times the greatest component, 3.
//! 3. Including the half step that is added to each code: it is at most `max_plane`.
//! 4. And all planes of a body 2^100 times smaller than the other ([`crate::query`]).
//! 5. Of bodies 2^100 times larger than the other.
//!
//! The pad is a sum of products of numbers that are not negative. So one factor covers its own roundings, each of which
//! is `e` of a partial result. For a body of B's size, the pad is a twentieth of a step. The rotated plane is then
//! rounded to a key; for half floats upwards, by up to 2^-10 of it.
//!
//! **Radii.** A pose moves the corners of a primitive, but everything within its radius of them keeps its shape. The
//! planes bound `u . x + |u| r`, which is less than `u . x + |n| r` if M makes vectors shorter, as an accepted matrix
//! may by 1e-4. So `shrinkage` moves the planes of bodies with radii farther out.

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
use crate::key::{Fixed, Key, Storage};
use crate::pose::Pose;
use crate::primitive::{Primitive, radius_of};
use crate::range::{MIN_COORDINATE, Point};
use crate::vector::difference;
use core::marker::PhantomData;

/// Maps the planes of every node of one body into another body's frame, at one pose.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Realignment<const K: usize, S = Fixed> {
    /// Three planes for each slab: plane `2s`, rotated, is `(w[0] d[p[0]] + w[1] d[p[1]]) + w[2] d[p[2]] + offset[2s]`
    /// with `p = sources[s]` and `w[l] = weights[l][s]`. Plane `2s + 1` takes the opposite planes, `p ^ 1`, with the
    /// same weights. Only the first half of the array is used, and three bytes of each entry; the fourth makes an entry
    /// one 32-bit load.
    pub sources: [[u8; 4]; K],
    /// The weights of each slab, not negative. Only the first half of each array is used.
    pub weights: [[f32; K]; 3],
    /// Translation plus pad of each plane.
    pub offset: [f32; K],
    storage: PhantomData<S>,
}

/// Bounds five roundings of `f32`, with room for the rounding of the pad itself.
pub(crate) const GAMMA_5: f64 = 5.25 * power_of_two(-24);

/// Bounds a few dozen roundings of `f64` in a sum of magnitudes: each is 2^-53 of a partial sum.
pub(crate) const F64_SLACK: f64 = power_of_two(-46);

/// Covers the rounding of the pad to `f32`, which can be far greater than the error it pads.
const ITS_OWN_ROUNDING: f64 = 1.0 + power_of_two(-23);

/// Covers the roundings of a pad that is computed in `f32`.
const ITS_OWN_ROUNDINGS: f32 = 1.0 + power_of_two(-16) as f32;

/// Residual of a direction's weights, relative to the components of the direction.
const RESIDUAL: f32 = power_of_two(-20) as f32;

/// Rounding of the sum that gives a rotated plane, relative to the magnitudes in it.
const ROUNDINGS: f32 = power_of_two(-20) as f32;

/// Slightly more than half of a last place of `f32`.
pub(crate) const HALF_PLACE: f64 = 1.0625 * power_of_two(-24);

/// Exceeds the loss of weights and products below the normal range of `f32`.
pub(crate) const UNDERFLOW: f64 = power_of_two(-130);

/// The same for a set-up in `f32`, where it must be a normal number.
const UNDERFLOW_OF_SINGLES: f32 = power_of_two(-80) as f32;

/// Sums of magnitudes below this cannot overflow an `f32`. Beyond it a product could become -infinity, which is not a
/// bound, so such a plane is unbounded instead.
const MAX_REACH: f32 = power_of_two(126) as f32;

impl<const K: usize, S: Storage> Realignment<K, S> {
    /// Initial value, to be overwritten.
    pub(crate) const UNSET: Self =
        Self { sources: [[0; 4]; K], weights: [[0.0; K]; 3], offset: [0.0; K], storage: PhantomData };

    /// A map with these numbers, for tests of kernels: the fields say what they are.
    #[inline]
    #[must_use]
    pub const fn from_parts(sources: [[u8; 4]; K], weights: [[f32; K]; 3], offset: [f32; K]) -> Self {
        Self { sources, weights, offset, storage: PhantomData }
    }

    /// The map for a body with bounds `a`, posed in the frame `b`.
    #[inline(always)]
    #[must_use]
    pub fn new(pose: &Pose, a: &BodyBounds, b: &Frame) -> Self {
        let mut map = Self::UNSET;
        map.set(pose, a, b);
        map
    }

    /// [`Self::new`] in place: returning the value copied it, which took as much stack again.
    // Inlined into the query, so that it is compiled for the query's instruction set.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "several columns share the index")]
    pub(crate) fn set(&mut self, pose: &Pose, a: &BodyBounds, b: &Frame) {
        let rows = pose.rows();
        // Loops instead of `map`, which is not always inlined.
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
            // The amount by which planes exceed their numbers.
            let pad = S::OFFSET * weight_sum + pad;
            offsets[s] = if is_bounded { [tau + pad, pad - tau] } else { [f32::INFINITY; 2] };
        }
        // Not element by element: for nine of them, the compiler emitted vector stores and loads that stalled on each
        // other.
        self.offset.copy_from_slice(&offsets.as_flattened()[..K]);
    }

    /// Moves every plane out by `margin`, in units of the frame: the rotated planes then contain everything within
    /// `margin` of the body. A few more of the last places of both terms cover the rounding of the larger offset and of
    /// the sums that contain it.
    #[inline(always)]
    pub fn widen(&mut self, margin: f64) {
        let margin = round_up_f32(margin);
        for (offset, length) in self.offset.iter_mut().zip(Directions::<K>::SINGLE_LENGTHS) {
            let reach = length * margin;
            *offset += (reach + ROUNDINGS * reach) + ROUNDINGS * offset.abs();
        }
    }

    /// The planes and weights whose weighted sum, plus the offset, is the rotated plane `j`.
    #[inline]
    #[must_use]
    pub fn terms(&self, j: usize) -> [(usize, f32); 3] {
        let sources = &self.sources[j / 2];
        core::array::from_fn(|l| (usize::from(sources[l]) ^ (j & 1), self.weights[l][j / 2]))
    }

    /// The rotated plane `j`, from the codes of a body's planes, as an `f32` sum. It is already a bound.
    #[inline]
    #[must_use]
    pub fn sum(&self, j: usize, code: impl Fn(usize) -> i16) -> f32 {
        let terms = self.terms(j);
        let term = |l: usize| terms[l].1 * S::number(code(terms[l].0));
        ((term(0) + term(1)) + term(2)) + self.offset[j]
    }

    /// The rotated plane `j`, from the codes of a body's planes: the specification of the kernels, operation by
    /// operation. An unbounded plane, and a weight or offset beyond `f32`, give [`Key::INFINITY`].
    #[inline]
    #[must_use]
    pub fn plane(&self, j: usize, code: impl Fn(usize) -> i16) -> Key<S> {
        Key::around(self.sum(j, code))
    }
}

/// The centre of A's frame at the pose, relative to the centre of B's, up to rounding in `f64`.
#[inline(always)]
pub(crate) fn shift(pose: &Pose, a: &BodyBounds, b: &Frame) -> Point {
    difference(&pose.unflushed_called(&a.frame.centre), &b.centre)
}

/// The magnitude to which the roundings of moved corners and centres are relative.
#[inline(always)]
pub(crate) fn coordinates(pose: &Pose, a: &BodyBounds, b: &Frame) -> f64 {
    // A row's magnitudes sum to at most 4, for the image; once more for the centre.
    (8.0 * a.max_coordinate + greatest(&pose.translation())) + greatest(&b.centre)
}

/// The rounding error in `f64` of the vector of a moved corner from the centre of its own body, along an axis of length
/// 1, if [`shift`] is the vector between the centres. In the bodies' unit.
#[inline(always)]
pub(crate) fn slack_of_shift(pose: &Pose, a: &BodyBounds, b: &Frame) -> f64 {
    // The magnitudes of a unit axis sum to at most sqrt(3).
    2.0 * (F64_SLACK * coordinates(pose, a, b) + MIN_COORDINATE)
}

/// The amount by which a margin must grow if A's primitives have radii, and volumes of A are compared after rotation by
/// M: at least as much as M shortens or lengthens any of the radii. No radius exceeds half of the body's width.
#[inline(always)]
pub(crate) fn shrinkage<P: Primitive>(pose: &Pose, a: &BodyBounds) -> f64 {
    if !P::IS_ROUND {
        return 0.0;
    }
    let [x, y, z] = a.half_width;
    pose.skew() * (f64::from(x.min(y).min(z)) / a.frame.scale())
}

/// The planes, in frame `b`, of everything within `margin` of moved primitives. Each is an upper bound of the exact
/// support, rounded up: tighter than the re-aligned planes of the leaf that contains them.
// Loops instead of `array::from_fn`, which is not always inlined.
#[inline(always)]
#[must_use]
pub(crate) fn planes_of<P: Primitive, const K: usize, S: Storage>(
    b: &Frame,
    items: impl Iterator<Item = P::Item>,
    margin: f64,
) -> [Key<S>; K] {
    let Supports { least, greatest, size } = Supports::<K>::of::<P>(b, items);
    let scale = b.scale();
    // By columns of slabs, which compile to vector instructions.
    let mut slabs = [[Key::<S>::LOWEST; 2]; K];
    // Not hoisted: otherwise terms that depend on the margin alone were computed and stored at the start of each query.
    let margin = core::hint::black_box(margin);
    for s in 0..Directions::<K>::COLUMNS {
        slabs[s] = planes_of_slab::<K, S>(s, [least[s], greatest[s]], size, margin, scale);
    }
    let mut planes = [Key::<S>::LOWEST; K];
    planes.copy_from_slice(&slabs.as_flattened()[..K]);
    planes
}

/// The two planes of a slab from the least and the greatest support; `size` is the largest magnitude of a coordinate.
#[inline(always)]
fn planes_of_slab<const K: usize, S: Storage>(
    s: usize,
    [least, greatest]: [f64; 2],
    size: f64,
    margin: f64,
    scale: f64,
) -> [Key<S>; 2] {
    let pad = F64_SLACK * Directions::<K>::SLAB_SUMS[s] * size;
    let reach = (1.0 + F64_SLACK) * Directions::<K>::SLAB_LENGTHS[s] * margin;
    let pads = pad + reach;
    [Key::above((pads + greatest) * scale), Key::above((pads - least) * scale)]
}

/// Supports of primitives, relative to the centre of a frame, up to rounding in `f64`.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Supports<const K: usize> {
    /// The least for each slab. Only the first half of the array is used.
    pub(crate) least: [f64; K],
    /// The greatest.
    pub(crate) greatest: [f64; K],
    /// The largest magnitude of a coordinate, including the frame's centre.
    pub(crate) size: f64,
}

impl<const K: usize> Supports<K> {
    // By columns of slabs. With the two planes of a slab side by side, in a loop in steps of two, LLVM 22.1 emitted
    // AVX-512 code that lost supports.
    #[inline(always)]
    pub(crate) fn of<P: Primitive>(b: &Frame, items: impl Iterator<Item = P::Item>) -> Self {
        Self::of_slabs::<P>(
            b,
            items,
            #[inline(always)]
            |_| true,
        )
    }

    /// Computes only the wanted slabs.
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
