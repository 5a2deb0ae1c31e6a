//! The direction sets of the k-DOPs, and the decomposition of any vector into their directions.
//!
//! A set has k directions with `n[2 i + 1] = -n[2 i]`: k / 2 slabs. Components are small integers and directions are
//! not normalised, so that `n . p` is exact in `f64` for `f32` coordinates of similar magnitude. Slabs are in the
//! order in which to test them: most of the pairs that any slab separates are separated by an axis.
//!
//! | k | directions, each with its antipode | faces |
//! |---|---|---|
//! | 6 | axes: (1,0,0), (0,1,0), (0,0,1) | 8 |
//! | 14 | axes, corners (1,±1,±1) | 24 |
//! | 18 | axes, edges (1,±1,0), (0,1,±1), (±1,0,1) | 32 |
//! | 26 | axes, edges, corners | 48 |
//! | 32 | axes, (1,1,1), and the cyclic shifts of (2,-1,-1), (1,1,0), (3,-2,1), (3,1,-2) | 60 |
//!
//! # Re-alignment
//!
//! The plane of a rotated body in direction n is at most `sum c[l] d[l]` where `u = transpose(M) n = sum c[l] n[l]`
//! and no c is negative ([`Directions::decompose`]). Any three directions around u are valid. Over all orientations
//! of a body its mean plane is proportional to the direction's length. So the best three on average minimise
//! `sum c[l] |n[l]|`, and those are the vertices of the face that u intersects in the convex hull of the *normalised*
//! directions. For all five sets this hull has only triangles, so the face is unique. `build.rs` computes it, and
//! proves that it is a centrally symmetric triangulation of the sphere. It also computes the grid from which the face
//! is found in 1.20 trials on average at k = 32. The other sets have the symmetry of the cube, and need no search
//! (`sectors`). Data for one k: 1 KB to 5.4 KB.
//!
//! Width of a body in direction n after re-alignment relative to its true width, averaged over uniform rotations of
//! body and pose and over the slabs (ball: 20 000 rays; others: 300 bodies, 4 poses each):
//!
//! | k | ball | cube | box 1 : 0.5 : 0.1 | triangle with normally distributed vertices |
//! |---|---|---|---|---|
//! | 6 | 1.499 | 1.504 | 1.691 | 1.980 |
//! | 14 | 1.167 | 1.177 | 1.251 | 1.406 |
//! | 18 | 1.128 | 1.138 | 1.199 | 1.313 |
//! | 26 | 1.088 | 1.095 | 1.139 | 1.228 |
//! | 32 | 1.068 | 1.075 | 1.111 | 1.188 |
//!
//! # The choice for k = 32
//!
//! Width for a ball; 1vs16 tests per query, geometric mean over 12 scenes of scanned meshes in random frames and over
//! 16 of machined parts and robot links in their own frames, 50 random poses per scene at a gap of 0.001 or 0.01 of
//! the diagonal (median-split trees of arity 16, one triangle per leaf); slabs tested until one separates, over all
//! separated pairs:
//!
//! | slabs | ball | scans | parts | slabs until separated: scans, parts |
//! |---|---|---|---|---|
//! | 13: k = 26, for comparison | 1.088 | 491 | 375 | 1.87, 1.71 |
//! | 26 and the cyclic shifts of (1,1,2) | 1.078 | 447 | 347 | 1.91, 1.75 |
//! | pentakis dodecahedron: (0,2,±3), (±1,0,3) cyclic, corners | 1.062 | 412 | 376 | 1.99, 2.13 |
//! | 16 found by annealing, axes fixed, components up to 4 | 1.069 | 424 | 361 | 1.97, 1.83 |
//! | chosen: the best 3-fold symmetric set with axes and components up to 3 | 1.068 | 415 | 364 | 1.98, 1.80 |
//!
//! The pentakis dodecahedron re-aligns best but lacks the axes, which parts with axis-parallel faces need, so it
//! separates late. Adding three slabs to k = 26 leaves its widest gaps open. The chosen set is within 5 % of the best
//! on both.

mod sectors;
mod slabs;
mod table;

use sectors::Float;
pub(crate) use sectors::greater;
use table::GRID_SIDE;
pub use table::{Face, SUPPORTED, Table, table};

/// A vector as a nonnegative combination of three directions: `u = sum weights[l] n[directions[l]]`.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Weights {
    /// The vertices of one hull face.
    pub directions: [u8; 3],
    /// Never negative.
    pub weights: [f64; 3],
}

/// The direction set with `K` directions.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Directions<const K: usize>;

/// Half the side of the grid, for `f64` arithmetic: cell indices are 0 to `2 * HALF_SIDE`.
const HALF_SIDE: f64 = (GRID_SIDE - 1) as f64 / 2.0;
/// Adding this to a number in 0..2^51 leaves it rounded to an integer in the low bits.
const INTEGER_BITS: f64 = (1_u64 << 52) as f64;

/// A weight this much below 0, relative to u, is rounding: u lies on the face's border.
const BORDER: f64 = 1.0 / (1_u64 << 50) as f64;

/// The build script proves that the walk from the grid's face takes at most 3 steps; rounding near borders may add
/// some.
const MAX_STEPS: usize = 8;

impl<const K: usize> Directions<K> {
    /// The directions and their triangulation.
    pub const TABLE: &'static Table = table(K);

    const SECTORS: sectors::Sectors = sectors::sectors(K);

    const FIRST_FACE: &'static Face = &Self::TABLE.faces[0];

    /// The directions in `f64`, for arithmetic.
    pub const VECTORS: [[f64; 3]; K] = {
        let mut vectors = [[0.0; 3]; K];
        let mut j = 0;
        while j < K {
            let n = Self::TABLE.vectors[j];
            vectors[j] = [n[0] as f64, n[1] as f64, n[2] as f64];
            j += 1;
        }
        vectors
    };

    /// The largest magnitude of a component of a direction.
    pub const MAX_COMPONENT: f64 = {
        let mut greatest = 0.0;
        let mut j = 0;
        while j < K {
            let [x, y, z] = Self::VECTORS[j];
            greatest = f64::max(greatest, f64::max(x.abs(), f64::max(y.abs(), z.abs())));
            j += 1;
        }
        greatest
    };

    /// The Euclidean length of each direction, rounded up: no plane of a point at distance r exceeds
    /// `LENGTHS[j] * r`.
    pub const LENGTHS: [f64; K] = {
        let mut lengths = [0.0; K];
        let mut j = 0;
        while j < K {
            lengths[j] = Self::TABLE.lengths[j];
            j += 1;
        }
        lengths
    };

    /// Number of slabs, pairs of opposite directions.
    pub const SLABS: usize = K / 2;

    /// Writes `u` as a nonnegative combination of the three vertices of the hull face that the ray along `u`
    /// intersects.
    ///
    /// The weights are never negative, so they can bound `u . x` for any input. The residual `u - sum c n` is
    /// below `2^-46 |u|` for a finite `u` whose components are not subnormal and whose sum does not overflow. For any
    /// other `u`, including zero and NaN, the result is a valid face with some weights.
    #[inline(always)]
    #[must_use]
    pub fn decompose(u: [f64; 3]) -> Weights {
        if sectors::applies(K) {
            let (weights, sector) = f64::split::<K>(u);
            let [a, b, c, _] = Self::SECTORS[f64::index(sector)];
            return Weights { directions: [a, b, c], weights };
        }
        Self::search(u)
    }

    /// The face of any u, by a walk from the face in the grid.
    #[inline(always)]
    fn search(u: [f64; 3]) -> Weights {
        let size = (u[0].abs() + u[1].abs()) + u[2].abs();
        let mut face = face_or(Self::TABLE, start(Self::TABLE, u, size), Self::FIRST_FACE);
        let mut c = face.weights(u);
        if !is_inside(c, size) {
            face = walk(Self::TABLE, face, u[0], u[1], u[2]);
            c = face.weights(u);
        }
        Weights { directions: face.directions, weights: c.map(|c| greater(c, 0.0)) }
    }
}

/// Walks from a face near `u` across the edge with the most negative weight, until no weight is negative.
///
/// Not inlined, or the compiler unrolls it into every caller. Takes scalars, or every caller must store `u` in
/// memory, which costs more than the walk.
#[inline(never)]
fn walk(table: &'static Table, near: &'static Face, x: f64, y: f64, z: f64) -> &'static Face {
    let u = [x, y, z];
    let size = (x.abs() + y.abs()) + z.abs();
    let mut face = near;
    for _ in 0..MAX_STEPS {
        let c = face.weights(u);
        if is_inside(c, size) {
            return face;
        }
        face = face_or(table, face.neighbours[least_corner(c)], near);
    }
    nearest_face(table, near, u)
}

/// The face whose least weight is greatest, which contains `u`, by exhaustive search.
#[cold]
fn nearest_face(table: &'static Table, any: &'static Face, u: [f64; 3]) -> &'static Face {
    let mut best = any;
    for face in table.faces {
        if least(face.weights(u)) > least(best.weights(u)) {
            best = face;
        }
    }
    best
}

/// The build script proves that all indices in a table are valid, so `other` is never used.
#[inline]
fn face_or(table: &'static Table, index: u8, other: &'static Face) -> &'static Face {
    table.faces.get(usize::from(index)).unwrap_or(other)
}

/// Whether the weights of a vector of this size show that the face contains it.
#[inline]
fn is_inside(c: [f64; 3], size: f64) -> bool {
    least(c) >= -BORDER * size
}

#[inline]
fn least(c: [f64; 3]) -> f64 {
    // Like `f64::min`, but one instruction on x86. `walk` handles NaN.
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    lesser(lesser(c[0], c[1]), c[2])
}

#[inline]
fn least_corner(c: [f64; 3]) -> usize {
    let l = if c[1] < c[0] { 1 } else { 0 };
    if c[2] < c[l] { 2 } else { l }
}

/// The face where the walk for `u` starts. The octahedral map flattens the upper half sphere to a square:
/// `(x + y, x - y) / (|x| + |y| + |z|)`; for the lower half, -u is looked up. One division, no branch.
#[inline]
fn start(table: &Table, u: [f64; 3], size: f64) -> u8 {
    let scale = HALF_SIDE.copysign(u[2]) / size;
    let cell = |x: f64| ((x * scale + HALF_SIDE) + INTEGER_BITS).to_bits() as usize & (GRID_SIDE - 1);
    let face = table.grid[cell(u[0] + u[1]) * GRID_SIDE + cell(u[0] - u[1])];
    face ^ u8::from(u[2].is_sign_negative())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The build script has the inverse of the map in `start`; a mismatch would only cost time.
    fn few_steps<const K: usize>() {
        let table = Directions::<K>::TABLE;
        let range = || (-9..=9_i32).map(|x| f64::from(x) / 9.0 + 0.01);
        for u in range().flat_map(|x| range().flat_map(move |y| range().map(move |z| [x, y, z]))) {
            let size = u[0].abs() + u[1].abs() + u[2].abs();
            let mut index = start(table, u, size);
            let mut steps = 0;
            loop {
                let face = table.faces[usize::from(index)];
                let c = face.weights(u);
                if is_inside(c, size) {
                    break;
                }
                index = face.neighbours[least_corner(c)];
                steps += 1;
                assert!(steps <= 3, "k = {K}: {u:?} is more than {steps} steps from the grid's start");
            }
        }
    }

    #[test]
    fn the_grid_starts_near_every_ray() {
        few_steps::<6>();
        few_steps::<14>();
        few_steps::<18>();
        few_steps::<26>();
        few_steps::<32>();
    }
}
