//! All slabs at once, in columns: the vectorised set-up of a query.

use super::sectors::Float;
use super::{Directions, sectors};

impl<const K: usize> Directions<K> {
    /// [`Directions::SLABS`], padded to whole vectors of four `f64`, since a remainder would be computed one by one.
    /// The padding is zero.
    pub(crate) const COLUMNS: usize = Self::SLABS.next_multiple_of(4);

    /// The coordinates of each slab's direction, by axis.
    pub(crate) const SLAB_COLUMNS: [[f64; K]; 3] = {
        let mut columns = [[0.0; K]; 3];
        let mut s = 0;
        while s < Self::SLABS {
            let n = Self::VECTORS[2 * s];
            (columns[0][s], columns[1][s], columns[2][s]) = (n[0], n[1], n[2]);
            s += 1;
        }
        columns
    };

    /// [`Directions::LENGTHS`] in `f32`, rounded up once more.
    pub(crate) const SINGLE_LENGTHS: [f32; K] = {
        let mut lengths = [0.0; K];
        let mut j = 0;
        while j < K {
            let nearest = Self::LENGTHS[j] as f32;
            lengths[j] = if (nearest as f64) < Self::LENGTHS[j] { nearest.next_up() } else { nearest };
            j += 1;
        }
        lengths
    };

    /// The [`Directions::LENGTHS`] of each slab's direction.
    pub(crate) const SLAB_LENGTHS: [f64; K] = {
        let mut lengths = [0.0; K];
        let mut s = 0;
        while s < Self::SLABS {
            lengths[s] = Self::LENGTHS[2 * s];
            s += 1;
        }
        lengths
    };

    /// The sum of the absolute components of each slab's direction.
    pub(crate) const SLAB_SUMS: [f64; K] = {
        let mut sums = [0.0; K];
        let mut s = 0;
        while s < Self::SLABS {
            let n = Self::VECTORS[2 * s];
            sums[s] = n[0].abs() + n[1].abs() + n[2].abs();
            s += 1;
        }
        sums
    };

    /// [`Directions::SLABS`], padded to whole vectors of eight `f32`, or of four if eight do not fit.
    pub(crate) const SINGLE_COLUMNS: usize = {
        let columns = Self::SLABS.next_multiple_of(8);
        if columns <= K { columns } else { Self::COLUMNS }
    };

    /// [`Directions::SLAB_COLUMNS`] in `f32`, which represents these integers exactly.
    pub(crate) const SINGLE_SLAB_COLUMNS: [[f32; K]; 3] = {
        let mut columns = [[0.0; K]; 3];
        let mut s = 0;
        while s < Self::SLABS {
            let [x, y, z] = Self::TABLE.vectors[2 * s];
            (columns[0][s], columns[1][s], columns[2][s]) = (x as f32, y as f32, z as f32);
            s += 1;
        }
        columns
    };

    /// [`Directions::decompose`] of the first `count` columns of `u`, which are replaced by their weights. `columns`
    /// is `count` padded to whole vectors. Returns three directions for each.
    // In place, since the set-up takes the most stack of many queries.
    #[expect(
        clippy::needless_range_loop,
        reason = "one index into several columns, which are longer than the loop"
    )]
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    pub(crate) fn decompose_columns<T: Float, const W: usize>(
        u: &mut [[T; W]; 3],
        columns: usize,
        count: usize,
    ) -> [[u8; 4]; W] {
        let mut directions = [[0; 4]; W];
        if sectors::applies(K) {
            // Two loops: the first is vectorised, the table look-ups cannot be.
            let mut sectors = [T::NO_SECTOR; W];
            for s in 0..columns {
                let weights;
                (weights, sectors[s]) = T::split::<K>([u[0][s], u[1][s], u[2][s]]);
                for l in 0..3 {
                    u[l][s] = weights[l];
                }
            }
            for s in 0..count {
                directions[s] = Self::SECTORS[T::index(sectors[s])];
            }
            return directions;
        }
        for s in 0..count {
            let one = Self::search([u[0][s].to_f64(), u[1][s].to_f64(), u[2][s].to_f64()]);
            let [a, b, c] = one.directions;
            directions[s] = [a, b, c, 0];
            for l in 0..3 {
                u[l][s] = T::from_f64(one.weights[l]);
            }
        }
        directions
    }
}
