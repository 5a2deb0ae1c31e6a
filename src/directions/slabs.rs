//! All slabs at once, by columns: what the set-up of a query computes in vector instructions.

use super::{Directions, sectors};

/// The [`super::Weights`] of a vector for each slab, by column: the first half of each array is used.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Decomposition<const K: usize> {
    pub(crate) directions: [[u8; 3]; K],
    pub(crate) weights: [[f64; K]; 3],
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

    /// [`Directions::decompose`] of a vector for each slab.
    #[expect(clippy::needless_range_loop, reason = "several columns share the index, of which half is used")]
    #[inline(always)]
    pub(crate) fn decompose_slabs(u: &[[f64; K]; 3]) -> Decomposition<K> {
        let mut found = Decomposition { directions: [[0; 3]; K], weights: [[0.0; K]; 3] };
        if sectors::applies(K) {
            // Two loops: the first is compiled to vector instructions, looking up tables is not.
            let mut sectors = [0; K];
            for s in 0..Self::COLUMNS {
                let weights;
                (weights, sectors[s]) = sectors::split::<K>([u[0][s], u[1][s], u[2][s]]);
                for l in 0..3 {
                    found.weights[l][s] = weights[l];
                }
            }
            for s in 0..Self::SLABS {
                found.directions[s] = Self::SECTORS[sectors[s] as usize & 127];
            }
            return found;
        }
        for s in 0..Self::SLABS {
            let one = Self::search([u[0][s], u[1][s], u[2][s]]);
            found.directions[s] = one.directions;
            for l in 0..3 {
                found.weights[l][s] = one.weights[l];
            }
        }
        found
    }
}
