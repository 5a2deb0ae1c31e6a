//! All slabs at once, by columns: what the set-up of a query computes in vector instructions.

use super::{Directions, sectors};

/// The [`super::Weights`] of several vectors, by column.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Decomposition<const W: usize> {
    pub(crate) directions: [[u8; 3]; W],
    pub(crate) weights: [[f64; W]; 3],
}

impl<const K: usize> Directions<K> {
    /// [`Directions::SLABS`], filled up to whole vectors of four `f64`: a remainder would be computed one by
    /// one. What is beyond the slabs is zero.
    pub(crate) const COLUMNS: usize = Self::SLABS.next_multiple_of(4);

    /// The coordinates of each slab's direction, by column.
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

    /// [`Directions::LENGTHS`] of each slab's direction.
    pub(crate) const SLAB_LENGTHS: [f64; K] = {
        let mut lengths = [0.0; K];
        let mut s = 0;
        while s < Self::SLABS {
            lengths[s] = Self::LENGTHS[2 * s];
            s += 1;
        }
        lengths
    };

    /// [`Directions::decompose`] of a vector for each slab: the first half of each array.
    #[inline(always)]
    pub(crate) fn decompose_slabs(u: &[[f64; K]; 3]) -> Decomposition<K> {
        Self::decompose_columns(u, Self::COLUMNS, Self::SLABS)
    }

    /// [`Directions::decompose`] of the first `count` columns; `columns` is as many, filled up to whole
    /// vectors.
    #[expect(
        clippy::needless_range_loop,
        reason = "several columns share the index, not all of which is used"
    )]
    #[inline(always)]
    pub(crate) fn decompose_columns<const W: usize>(
        u: &[[f64; W]; 3],
        columns: usize,
        count: usize,
    ) -> Decomposition<W> {
        let mut found = Decomposition { directions: [[0; 3]; W], weights: [[0.0; W]; 3] };
        if sectors::applies(K) {
            // Two loops: the first is compiled to vector instructions, looking up tables is not.
            let mut sectors = [0; W];
            for s in 0..columns {
                let weights;
                (weights, sectors[s]) = sectors::split::<K>([u[0][s], u[1][s], u[2][s]]);
                for l in 0..3 {
                    found.weights[l][s] = weights[l];
                }
            }
            for s in 0..count {
                found.directions[s] = Self::SECTORS[sectors[s] as usize & 127];
            }
            return found;
        }
        for s in 0..count {
            let one = Self::search([u[0][s], u[1][s], u[2][s]]);
            found.directions[s] = one.directions;
            for l in 0..3 {
                found.weights[l][s] = one.weights[l];
            }
        }
        found
    }
}
