//! Positions of the prototypes.

use super::sums::Sums;

/// One prototype for each lane, in local coordinates.
pub(in crate::construct) struct Prototypes<const N: usize> {
    pub(in crate::construct) coordinates: [[u16; N]; 3],
}

impl<const N: usize> Prototypes<N> {
    /// Pseudo-random positions in the node's box, from the seed and the node's number.
    pub(in crate::construct) fn start(extent: [u16; 3], seed: u32, node: u32) -> Self {
        let at = |axis: usize, lane: usize| {
            let number = (node.wrapping_mul(N as u32).wrapping_add(lane as u32)).wrapping_mul(3);
            let random = scramble(scramble(number.wrapping_add(axis as u32)) ^ scramble(!seed));
            ((u64::from(random) * (u64::from(extent[axis]) + 1)) >> 32) as u16
        };
        Self { coordinates: core::array::from_fn(|axis| core::array::from_fn(|lane| at(axis, lane))) }
    }

    /// Moves each prototype to its mean, rounded half up; one without contributions stays. Returns whether any moved:
    /// one step of a coordinate is more than 1e-5 of the node's box, the threshold of the paper.
    pub(in crate::construct) fn update(&mut self, sums: &Sums<N>) -> bool {
        let mut moved = false;
        for (coordinates, moments) in self.coordinates.iter_mut().zip(&sums.moments) {
            for lane in 0..N {
                let weight = sums.weight[lane];
                let mean = (moments[lane] + weight / 2).checked_div(weight);
                let mean = mean.map_or(coordinates[lane], |mean| mean as u16);
                moved |= mean != coordinates[lane];
                coordinates[lane] = mean;
            }
        }
        moved
    }
}

/// The finaliser of `MurmurHash3` (Appleby): every bit of the input changes every bit of the result with probability
/// 1/2.
fn scramble(number: u32) -> u32 {
    let mut x = number;
    x = (x ^ x >> 16).wrapping_mul(0x85eb_ca6b);
    x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    x ^ x >> 16
}
