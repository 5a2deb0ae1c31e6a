//! Direction sets.

/// Direction sets exist for these k.
pub const SUPPORTED: [usize; 5] = [6, 14, 18, 26, 32];

/// A triangle of the hull of the directions.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Face {
    /// Its corners, as indices into [`Table::vectors`].
    pub directions: [u8; 3],
    /// The inverse of the matrix whose columns are the corners: row `l` times u is the weight of `directions[l]`.
    pub inverse: [[f64; 3]; 3],
    /// `neighbours[l]` is the face across the edge opposite `directions[l]`: where that corner's weight is negative.
    pub neighbours: [u8; 3],
}

impl Face {
    /// The c with `u = sum c[l] n[directions[l]]`, up to rounding. All are positive inside the face's cone.
    #[inline]
    #[must_use]
    pub fn weights(&self, u: [f64; 3]) -> [f64; 3] {
        self.inverse.map(|row| (row[0] * u[0] + row[1] * u[1]) + row[2] * u[2])
    }
}

/// The directions of one k and the triangulation of the sphere by them.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Table {
    /// `vectors[2 * i + 1] = -vectors[2 * i]` is slab i.
    pub vectors: &'static [[i8; 3]],
    /// The Euclidean length of each direction, rounded up.
    pub lengths: &'static [f64],
    /// Face `f ^ 1` is the antipode of face `f`: the same corners, each `^ 1`, in the same order.
    pub faces: &'static [Face],
    /// A face in or near each cell of the upper half sphere, under the octahedral map (see [`Directions::decompose`]).
    pub grid: &'static [u8; GRID_CELLS],
}

/// The table for k directions; in a `const` an unsupported k fails to compile.
///
/// # Panics
/// If `k` is not in [`SUPPORTED`].
#[must_use]
pub const fn table(k: usize) -> &'static Table {
    match k {
        6 => &generated::TABLE_6,
        14 => &generated::TABLE_14,
        18 => &generated::TABLE_18,
        26 => &generated::TABLE_26,
        32 => &generated::TABLE_32,
        _ => panic!("a direction set has k = 6, 14, 18, 26 or 32"),
    }
}

/// A vector as a sum of at most three directions, none of them backwards: `u = sum weights[l] n[directions[l]]`.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Weights {
    /// Three directions that are the corners of one hull face.
    pub directions: [u8; 3],
    /// Never negative.
    pub weights: [f64; 3],
}

/// The direction set with `K` directions.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Directions<const K: usize>;

/// Cells along one side of the grid, as `f64` arithmetic sees them: indices are 0 to `2 * HALF_SIDE`.
const HALF_SIDE: f64 = (GRID_SIDE - 1) as f64 / 2.0;
const GRID_CELLS: usize = GRID_SIDE * GRID_SIDE;
const _: () = assert!(GRID_SIDE.is_power_of_two(), "indices are masked");

/// Added to a number in 0..2^51, leaves it rounded to an integer in the low bits.
const INTEGER_BITS: f64 = (1_u64 << 52) as f64;

/// A weight this much below 0, relative to u, is rounding: u lies on the face's border.
const BORDER: f64 = 1.0 / (1_u64 << 50) as f64;

/// The build script proves that the grid starts at most 3 steps away; rounding near borders may add some.
const MAX_STEPS: usize = 8;

impl<const K: usize> Directions<K> {
    /// The directions and their triangulation.
    pub const TABLE: &'static Table = table(K);

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

    /// The Euclidean length of each direction, rounded up: no plane of a point at distance r exceeds `LENGTHS[j] * r`.
    pub const LENGTHS: [f64; K] = {
        let mut lengths = [0.0; K];
        let mut j = 0;
        while j < K {
            lengths[j] = Self::TABLE.lengths[j];
            j += 1;
        }
        lengths
    };

    /// Slabs, pairs of opposite directions.
    pub const SLABS: usize = K / 2;

    /// Writes `u` as a sum of the three corners of the hull face that the ray along `u` pierces.
    ///
    /// The weights are never negative, so a caller may bound `u . x` by them for whatever it gets; what they miss,
    /// `u - sum c n`, is below `2^-48 |u|` for a finite `u` whose components neither overflow when added nor are
    /// subnormal. For any other `u`, zero and NaN included, the answer is a valid face with some weights.
    #[inline]
    #[must_use]
    pub fn decompose(u: [f64; 3]) -> Weights {
        let size = (u[0].abs() + u[1].abs()) + u[2].abs();
        let mut face = face_or_first(Self::TABLE, start(Self::TABLE, u, size));
        let mut c = face.weights(u);
        if !is_inside(c, size) {
            face = walk(Self::TABLE, face, u[0], u[1], u[2]);
            c = face.weights(u);
        }
        Weights { directions: face.directions, weights: c.map(|c| greater(c, 0.0)) }
    }
}

/// From a face near `u`, across the edge that `u` is furthest behind, until none is behind.
///
/// Out of line, or the compiler unrolls it into every caller; in scalars, or `u` must lie in memory in every caller,
/// which costs more than the walk.
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
        let l = if c[1] < c[0] { 1 } else { 0 };
        let l = if c[2] < c[l] { 2 } else { l };
        face = face_or_first(table, face.neighbours[l]);
    }
    nearest_face(table, u)
}

/// The face whose least weight is greatest: the one that holds `u`, found without walking.
#[cold]
fn nearest_face(table: &'static Table, u: [f64; 3]) -> &'static Face {
    let mut best = face_or_first(table, 0);
    for face in table.faces {
        if least(face.weights(u)) > least(best.weights(u)) {
            best = face;
        }
    }
    best
}

/// The build script proves every index valid; the check is free beside the branch-free rest.
#[inline]
fn face_or_first(table: &'static Table, index: u8) -> &'static Face {
    table.faces.get(usize::from(index)).unwrap_or(&table.faces[0])
}

/// Whether the weights of a vector of this size are those of a face that holds it.
#[inline]
fn is_inside(c: [f64; 3], size: f64) -> bool {
    least(c) >= -BORDER * size
}

#[inline]
fn least(c: [f64; 3]) -> f64 {
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    lesser(lesser(c[0], c[1]), c[2])
}

/// Like [`f64::max`] without its care for NaN, which doubles the instructions; 0 for a NaN `a`, if `b` is 0.
#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Where the walk to the face of `u` begins. The octahedral map flattens the upper half sphere to a square:
/// `(x + y, x - y) / (|x| + |y| + |z|)`; the lower half is looked up at -u. One division, no branch.
#[inline]
fn start(table: &Table, u: [f64; 3], size: f64) -> u8 {
    let scale = HALF_SIDE.copysign(u[2]) / size;
    let cell = |x: f64| ((x * scale + HALF_SIDE) + INTEGER_BITS).to_bits() as usize & (GRID_SIDE - 1);
    let face = table.grid[cell(u[0] + u[1]) * GRID_SIDE + cell(u[0] - u[1])];
    face ^ u8::from(u[2].is_sign_negative())
}

use generated::GRID_SIDE;

mod generated {
    use super::{Face, Table};
    include!(concat!(env!("OUT_DIR"), "/directions.rs"));
}
