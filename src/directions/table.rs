//! The tables that `build.rs` generates.

/// The values of k that have direction sets.
pub const SUPPORTED: [usize; 5] = [6, 14, 18, 26, 32];

/// A triangle of the hull of the directions.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Face {
    /// Its vertices, as indices into [`Table::vectors`].
    pub directions: [u8; 3],
    /// The inverse of the matrix whose columns are the vertices: row `l` times u is the weight of `directions[l]`.
    pub inverse: [[f64; 3]; 3],
    /// `neighbours[l]` is the face across the edge opposite `directions[l]`, where that vertex's weight is negative.
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
    /// Face `f ^ 1` is the antipode of face `f`: the same vertices, each `^ 1`, in the same order.
    pub faces: &'static [Face],
    /// For each cell of the upper half sphere under the octahedral map, a face in or near it (see
    /// [`Directions::decompose`](super::Directions::decompose)).
    pub grid: &'static [u8; GRID_CELLS],
}

/// The table for k directions. In a `const`, an unsupported k fails to compile.
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

const GRID_CELLS: usize = GRID_SIDE * GRID_SIDE;
const _: () = assert!(GRID_SIDE.is_power_of_two(), "indices are masked");

use generated::GRID_SIDE as SIDE;

/// Cells along one side of the grid, a power of two: indices are masked.
pub(super) const GRID_SIDE: usize = SIDE;

mod generated {
    use super::{Face, Table};
    include!(concat!(env!("OUT_DIR"), "/directions.rs"));
}
