//! Primitive slabs: directions along which a primitive is thinner than any k-DOP.
//!
//! The k-DOP of a large triangle is fat, and a small body beside the triangle lies inside it. So while a leaf of one
//! tree is paired with a node of the other, the plane of the leaf's triangle and the planes through its edges cull the
//! node's children. This is done in the frame of the node's own tree, where its planes are tight. In coordinates of the
//! node's body, a direction u is the sum of three `c_l n_l` with `c_l >= 0`, as in re-alignment ([`super`]), so for a
//! child with planes d
//!
//! ```text
//! u . x <= sum c_l d_l            -u . x <= sum c_l d_opposite(l)
//! ```
//!
//! A child is culled if either bound stays short of the interval that the primitive covers along the same direction,
//! after the interval is widened for all roundings:
//!
//! | rounded | pad |
//! |---|---|
//! | the weights c, to `f32` | `2^-24 sum c sum half_width`, times the greatest component of a direction |
//! | the computation of u and c, in `f64` | `2^-45 abs(n) sum half_width` |
//! | the interval, the frame's moved centre, moved corners, in `f64` | `2^-46 abs(n) (coordinates)` |
//! | coordinates of moved corners that [`Pose::apply`] flushes to zero | `2^-250 abs(n)` |
//! | products and sums of codes, in `f32` | `gamma_5 sum c (max_plane + 1/2)`, plus 2^-130 for underflow |
//!
//! The direction itself needs no pad: any vector is valid, since both bodies are measured along the same one.

use super::{F64_SLACK, GAMMA_5, HALF_PLACE, ITS_OWN_ROUNDING, UNDERFLOW, greatest};
use crate::directions::Directions;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::BodyBounds;
use crate::key::Storage;
use crate::pose::Pose;
use crate::primitive::{OWN_DIRECTIONS, Primitive, radius_of};
use crate::range::MIN_COORDINATE;

/// A direction and the interval that a primitive covers along it, for comparison with the planes of another tree, all
/// of one storage.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct PrimitiveSlab {
    /// The three planes whose weighted sum bounds a child along the direction. The opposite planes, `p ^ 1`, with the
    /// same weights bound it in the opposite direction.
    pub sources: [u8; 3],
    /// The weights, not negative.
    pub weights: [f32; 3],
    /// A child is beyond the slab if the first sum is below the first limit, or the second below the second.
    pub limits: [f32; 2],
}

impl PrimitiveSlab {
    /// No child is beyond it.
    pub const EVERYWHERE: Self = Self { sources: [0; 3], weights: [0.0; 3], limits: [f32::NEG_INFINITY; 2] };

    /// Whether a child with these codes lies beyond the slab, on either side: the specification of the kernels,
    /// operation by operation. Unspecified for an unused lane.
    #[inline]
    #[must_use]
    pub fn is_beyond<S: Storage>(&self, code: impl Fn(usize) -> i16) -> bool {
        let sum = |side: usize| {
            let term = |l: usize| self.weights[l] * S::number(code(usize::from(self.sources[l]) ^ side));
            (term(0) + term(1)) + term(2)
        };
        sum(0) < self.limits[0] || sum(1) < self.limits[1]
    }
}

/// Directions whose sum of magnitudes is outside these limits are not used.
const SHORTEST: f64 = power_of_two(-10);
const LONGEST: f64 = power_of_two(10);

/// The primitive slabs of one primitive, in the order in which to try them.
pub type PrimitiveSlabs = [PrimitiveSlab; OWN_DIRECTIONS];

/// The slabs of everything within `margin` of a primitive, for the nodes of a body with bounds `body`.
///
/// If the body is A, `pose` is its pose and the primitive is in the coordinates into which `pose` maps. If the body is
/// B, there is no pose and the primitive is in the body's own coordinates.
// Inlined into the query, so that it is compiled for the query's instruction set.
#[inline(always)]
#[must_use]
pub fn primitive_slabs<P: Primitive, const K: usize, S: Storage>(
    item: &P::Item,
    margin: f64,
    body: &BodyBounds,
    pose: Option<&Pose>,
) -> PrimitiveSlabs {
    let c = body.frame.centre;
    let margin = margin + radius_of::<P>(item);
    let mut size = 0.0_f64;
    for p in P::corners(item) {
        size = size.max(greatest(&p));
    }
    // By columns, one direction per lane.
    let n = P::own_directions(item);
    let (mut u, mut origin, mut coordinates) = (n, c, size + greatest(&c));
    if let Some(pose) = pose {
        let (m, t) = (pose.rows(), pose.translation());
        origin = pose.unflushed_called(&c);
        // A row's magnitudes sum to at most 4, for the image; once more for the centre.
        coordinates = (8.0 * body.max_coordinate + greatest(&t)) + size;
        for i in 0..3 {
            for s in 0..OWN_DIRECTIONS {
                u[i][s] = (m[0][i] * n[0][s] + m[1][i] * n[1][s]) + m[2][i] * n[2][s];
            }
        }
    }
    let sources = Directions::<K>::decompose_columns(&mut u, OWN_DIRECTIONS, OWN_DIRECTIONS);
    let (mut low, mut high) = ([f64::INFINITY; OWN_DIRECTIONS], [f64::NEG_INFINITY; OWN_DIRECTIONS]);
    for p in P::corners(item) {
        let d = [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
        for s in 0..OWN_DIRECTIONS {
            let along = (n[0][s] * d[0] + n[1][s] * d[1]) + n[2][s] * d[2];
            low[s] = if along < low[s] { along } else { low[s] };
            high[s] = if along > high[s] { along } else { high[s] };
        }
    }
    let scale = body.frame.scale();
    let width_sum = body.width_sum();
    let per_weight = HALF_PLACE * (Directions::<K>::MAX_COMPONENT * width_sum)
        + GAMMA_5 * (f64::from(body.max_plane) + 0.5);
    // The sum of magnitudes is at least the length, which scales the margin.
    let per_length =
        2.0 * F64_SLACK * width_sum + ((F64_SLACK * coordinates + MIN_COORDINATE) + margin) * scale;
    let mut slabs = [PrimitiveSlab::EVERYWHERE; OWN_DIRECTIONS];
    let mut weights = [[0.0_f32; OWN_DIRECTIONS]; 3];
    let mut limits = [[0.0_f32; OWN_DIRECTIONS]; 2];
    for s in 0..OWN_DIRECTIONS {
        let length = (n[0][s].abs() + n[1][s].abs()) + n[2][s].abs();
        let w = [u[0][s] as f32, u[1][s] as f32, u[2][s] as f32];
        let weight_sum = (f64::from(w[0]) + f64::from(w[1])) + f64::from(w[2]);
        let pad = ((weight_sum * per_weight + length * per_length) + UNDERFLOW) * ITS_OWN_ROUNDING;
        // The amount by which planes exceed their numbers.
        let pad = pad + f64::from(S::OFFSET) * weight_sum;
        // A vector that is zero or not finite is not a direction; weights of a vector whose length is far from 1 could
        // overflow an `f32`.
        let pad = if length > SHORTEST && length < LONGEST { pad } else { f64::INFINITY };
        (weights[0][s], weights[1][s], weights[2][s]) = (w[0], w[1], w[2]);
        (limits[0][s], limits[1][s]) =
            (-round_up_f32(pad - low[s] * scale), -round_up_f32(pad + high[s] * scale));
    }
    for (s, slab) in slabs.iter_mut().enumerate() {
        let [p, q, r, _] = sources[s];
        *slab = PrimitiveSlab {
            sources: [p, q, r],
            weights: [weights[0][s], weights[1][s], weights[2][s]],
            limits: [limits[0][s], limits[1][s]],
        };
    }
    slabs
}
