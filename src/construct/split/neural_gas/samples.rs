//! Quantised points of a tree and of a node.

use crate::range::Point;
use alloc::vec::Vec;

/// Points and weights of a tree, quantised once.
pub(in crate::construct) struct Samples<'a> {
    points: &'a [Point],
    positions: Vec<[u32; 3]>,
    /// At least 1; or none at all, if all weigh the same.
    weights: Vec<u32>,
}

impl<'a> Samples<'a> {
    /// Quantises finite `points`, at most [`crate::node::Child::MAX_PRIMITIVES`]. Weights must not be negative; without
    /// weights all are equal.
    ///
    /// Each step is one correctly rounded operation and monotone, so the integers are the same on every
    /// machine.
    pub(in crate::construct) fn new(points: &'a [Point], weights: Option<&[f64]>) -> Self {
        const TOP: f64 = u32::MAX as f64;
        let corner = |fold: fn(f64, f64) -> f64, from: f64| -> Point {
            points.iter().fold([from; 3], |m, p| core::array::from_fn(|i| fold(m[i], p[i])))
        };
        let (low, high) = (corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY));
        let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let scale = if extent > 0.0 { TOP / extent } else { 0.0 };
        // A cast to an integer saturates, so rounding cannot exceed the range.
        let quantise = |p: &Point| core::array::from_fn(|i| ((p[i] - low[i]) * scale) as u32);
        let heaviest = weights.into_iter().flatten().fold(0.0, |m: f64, w| m.max(*w));
        let weigh = |w: &f64| if heaviest > 0.0 { ((w / heaviest * TOP) as u32).max(1) } else { 1 };
        Self {
            points,
            positions: points.iter().map(quantise).collect(),
            weights: weights.into_iter().flatten().map(weigh).collect(),
        }
    }

    pub(in crate::construct) fn len(&self) -> usize {
        self.points.len()
    }

    /// The quantised positions.
    #[cfg(feature = "gpu")]
    pub(in crate::construct) fn positions(&self) -> &[[u32; 3]] {
        &self.positions
    }

    /// At least 1; or none at all, if all weigh the same.
    #[cfg(feature = "gpu")]
    pub(in crate::construct) fn weights(&self) -> &[u32] {
        &self.weights
    }

    /// The box and the greatest weight of a node's primitives.
    pub(in crate::construct) fn bounds(&self, part: &[u32]) -> SampleBox {
        let mut bounds = SampleBox { low: [u32::MAX; 3], high: [0; 3], heaviest: 1 };
        for &index in part {
            let p = &self.positions[index as usize];
            bounds.low = core::array::from_fn(|i| bounds.low[i].min(p[i]));
            bounds.high = core::array::from_fn(|i| bounds.high[i].max(p[i]));
            bounds.heaviest = bounds.heaviest.max(self.weights.get(index as usize).copied().unwrap_or(1));
        }
        bounds
    }

    /// The point in full precision.
    pub(in crate::construct) fn point(&self, index: u32) -> Point {
        self.points[index as usize]
    }
}

/// Bits of a local coordinate: the sum of three squared differences fits in 32 bits.
pub(in crate::construct) const LOCAL_BITS: u32 = 15;

/// Largest number of bits of a weight, and of the sum of the weights of a node: with 12 bits of h and 15 of a
/// coordinate, products are below 2^64.
pub(in crate::construct) const WEIGHT_BITS: u32 = 13;
pub(in crate::construct) const WEIGHT_SUM_BITS: u32 = 37;

/// Nodes with a smaller box, in units of the root's box over 2^32, are not clustered.
pub(in crate::construct) const MIN_EXTENT: u32 = 1 << 8;

/// Points per block.
pub(in crate::construct) const BLOCK: usize = 8;

/// The box of a node's positions, and its largest weight.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::construct) struct SampleBox {
    pub(in crate::construct) low: [u32; 3],
    pub(in crate::construct) high: [u32; 3],
    /// 1 if all are equal.
    pub(in crate::construct) heaviest: u32,
}

/// Converts positions and weights to those of a node.
struct Grid {
    low: [u32; 3],
    shift: u32,
    extent: [u16; 3],
    weight_shift: u32,
}

impl Grid {
    /// `None` if the quantised positions hardly distinguish the primitives.
    fn of(bounds: &SampleBox, count: usize) -> Option<Self> {
        let size: [u32; 3] = core::array::from_fn(|i| bounds.high[i] - bounds.low[i]);
        let longest = size.into_iter().fold(0, u32::max);
        let shift = (u32::BITS - longest.leading_zeros()).saturating_sub(LOCAL_BITS);
        (longest >= MIN_EXTENT).then(|| Self {
            low: bounds.low,
            shift,
            extent: size.map(|size| (size >> shift) as u16),
            weight_shift: weight_shift(count, bounds.heaviest),
        })
    }
}

/// The primitives of one node, in its order, each list padded to whole blocks.
#[derive(Default)]
pub(in crate::construct) struct Cluster {
    len: usize,
    extent: [u16; 3],
    coordinates: [Vec<u16>; 3],
    /// Empty if all weights are 1.
    weights: Vec<u16>,
}

/// Up to [`BLOCK`] primitives.
pub(in crate::construct) struct Block<'a> {
    pub(in crate::construct) coordinates: [&'a [u16; BLOCK]; 3],
    /// `None` if all weights are 1.
    pub(in crate::construct) weights: Option<&'a [u16; BLOCK]>,
    /// Number of primitives; the rest is padding.
    pub(in crate::construct) len: usize,
}

impl Cluster {
    /// Loads the primitives of `part`. False if the quantised positions hardly distinguish them.
    pub(in crate::construct) fn local_coordinates(&mut self, samples: &Samples<'_>, part: &[u32]) -> bool {
        let Some(frame) = Grid::of(&samples.bounds(part), part.len()) else { return false };
        let positions = || part.iter().map(|&index| &samples.positions[index as usize]);
        self.len = part.len();
        self.extent = frame.extent;
        for (i, list) in self.coordinates.iter_mut().enumerate() {
            list.clear();
            list.extend(positions().map(|p| ((p[i] - frame.low[i]) >> frame.shift) as u16));
            list.resize(part.len().next_multiple_of(BLOCK), 0);
        }
        self.weights.clear();
        if !samples.weights.is_empty() {
            let weights = part.iter().map(|&index| samples.weights[index as usize]);
            self.weights.extend(weights.map(|w| (w >> frame.weight_shift).max(1) as u16));
            self.weights.resize(part.len().next_multiple_of(BLOCK), 0);
        }
        true
    }

    pub(in crate::construct) fn extent(&self) -> [u16; 3] {
        self.extent
    }

    pub(in crate::construct) fn block_count(&self) -> usize {
        self.len.div_ceil(BLOCK)
    }

    pub(in crate::construct) fn is_weighted(&self) -> bool {
        !self.weights.is_empty()
    }

    #[inline]
    pub(in crate::construct) fn block(&self, index: usize) -> Block<'_> {
        let [x, y, z] = &self.coordinates;
        Block {
            coordinates: [&x.as_chunks().0[index], &y.as_chunks().0[index], &z.as_chunks().0[index]],
            weights: self.weights.as_chunks().0.get(index),
            len: (self.len - index * BLOCK).min(BLOCK),
        }
    }
}

/// The right shift of a node's weights, such that they and their sum fit in their bits.
fn weight_shift(count: usize, heaviest: u32) -> u32 {
    let count_bits = usize::BITS - count.leading_zeros();
    let bits = WEIGHT_BITS.min(WEIGHT_SUM_BITS - count_bits);
    (u32::BITS - heaviest.leading_zeros()).saturating_sub(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of h v x stay below 2^64 for any number of primitives in a tree, and any weights.
    #[test]
    fn weights_leave_room_for_their_sum() {
        for count in [1_u64, 2, 1000, (1 << 24) - 1, 1 << 24, crate::node::Child::MAX_PRIMITIVES.into()] {
            for heaviest in [1, 2, (1 << 13) - 1, 1 << 13, u32::MAX] {
                let weight = u64::from(heaviest >> weight_shift(count as usize, heaviest)).max(1);
                assert!(weight < 1 << WEIGHT_BITS);
                let sum = u128::from(count * weight) * ((1 << 12) - 1);
                assert!(sum * ((1 << 15) - 1) + sum / 2 < 1 << 64, "{count} of {heaviest}");
                let all_bits_used = count >= 1 << 24 || heaviest >> 12 == 0 || weight >> 12 == 1;
                assert!(all_bits_used, "{count} of {heaviest}: {weight}");
            }
        }
    }

    #[test]
    fn positions_fill_their_range() {
        let points = [[-1.0, 5.0, 0.0], [1.0, 5.0, 0.25], [0.0, 5.5, 0.0]];
        let samples = Samples::new(&points, Some(&[0.0, 2.0, 1.0]));
        assert_eq!(
            samples.positions,
            [[0, 0, 0], [u32::MAX, 0, u32::MAX / 8], [u32::MAX / 2, u32::MAX / 4, 0]]
        );
        assert_eq!(samples.weights, [1, u32::MAX, u32::MAX / 2]);
        let mut cluster = Cluster::default();
        assert!(cluster.local_coordinates(&samples, &[0, 1, 2]));
        let block = cluster.block(0);
        assert_eq!(
            block.coordinates.map(|c| [c[0], c[1], c[2]]),
            [[0, 32767, 16383], [0, 0, 8191], [0, 4095, 0]]
        );
        assert_eq!((block.len, block.weights), (3, Some(&[1, 8191, 4095, 0, 0, 0, 0, 0])));
        assert!(!cluster.local_coordinates(&samples, &[1, 1]), "one place");
    }

    #[test]
    fn one_place_and_no_weight_are_no_problem() {
        let samples = Samples::new(&[[3.0; 3]; 2], Some(&[0.0; 2]));
        assert_eq!((samples.positions, samples.weights), (alloc::vec![[0; 3]; 2], alloc::vec![1; 2]));
        assert_eq!(Samples::new(&[], None).len(), 0);
    }
}
