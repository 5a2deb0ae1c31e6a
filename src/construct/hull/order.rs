//! The order in which points are inserted.

use crate::range::Point;

/// Points that are not sorted: their numbers are for the cache.
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

/// A permutation that depends on the number of points only (Fisher and Yates, by `SplitMix64`).
fn shuffle(points: &mut [Point]) {
    let mut state = 0_u64;
    for last in (1..points.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let random = u128::from(z ^ (z >> 31));
        points.swap(last, ((random * (last as u128 + 1)) >> 64) as usize);
    }
}
