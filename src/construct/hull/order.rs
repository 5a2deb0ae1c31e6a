//! The order in which points are inserted.

use crate::random::SplitMix64;
use crate::range::Point;

/// Fewer points are not sorted: sorting is for the cache.
const FEW: usize = 1024;

/// A pseudorandom permutation in rounds, each twice as long as all before it and sorted along a curve, so that a point
/// is near the one before it (Amenta, Choi and Rote, *Incremental constructions con BRIO*, 2003).
pub(super) fn reorder(points: &mut [Point]) {
    shuffle(points);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &*points {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    let mut end = points.len();
    while end > FEW {
        let start = end / 2;
        points[start..end].sort_by_cached_key(|p| {
            let cell = |i: usize| ((p[i] - low[i]) / (high[i] - low[i]) * 1023.0) as u32;
            spread(cell(0)) << 2 | spread(cell(1)) << 1 | spread(cell(2))
        });
        end = start;
    }
}

/// Ten bits, each in every third place.
fn spread(x: u32) -> u32 {
    (0..10).fold(0, |sum, bit| sum | (x >> bit & 1) << (3 * bit))
}

/// A permutation that depends only on the number of points (Fisher and Yates).
fn shuffle(points: &mut [Point]) {
    let mut random = SplitMix64(0);
    for last in (1..points.len()).rev() {
        points.swap(last, random.below(last + 1));
    }
}
