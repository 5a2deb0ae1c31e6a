//! The balanced split of the paper (section 3.1): at the median along the longest axis, until what is left fits in a
//! bucket. Sixteen parts of a node are four such splits.
//!
//! Parts are whole nodes where they can be, as in the trees of the other splitters: a full tree of m nodes has 1 + 15 m
//! buckets. So all nodes but one use every lane and all buckets but the last are as full as was asked for, which equal
//! halves would leave 75 % full in the mean.

use core::cmp::Ordering;

/// A point on its way to its bucket. Moved as a whole: an index to look it up by would miss the cache at each step.
#[derive(Copy, Clone, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Item {
    pub(super) point: [f32; 3],
    pub(super) index: u32,
}

/// Lanes of a node.
const ARITY: usize = 16;

/// Moves items to the parts of a node. `ends` count from the first item; a part is at most `bucket_size` items, or a
/// node. All parts but the last of all begin at multiples of `bucket_size`.
pub(super) fn cut(items: &mut [Item], bucket_size: usize, ends: &mut [u32; ARITY]) {
    cut_part(items, 0, bucket_size, ends);
}

fn cut_part(items: &mut [Item], start: usize, bucket_size: usize, ends: &mut [u32]) {
    let (count, lanes) = (items.len(), ends.len());
    if lanes == 1 || count <= bucket_size {
        ends.fill((start + count) as u32);
        if count <= bucket_size {
            // A bucket is a set: its order must not depend on how a selection algorithm moves things.
            items.sort_unstable_by_key(|item| item.index);
        }
        return;
    }
    let middle = left_size(count, lanes, bucket_size);
    if middle < count {
        let axis = longest_axis(items);
        items.select_nth_unstable_by(middle, |a, b| compare(a, b, axis));
    }
    let (left, right) = items.split_at_mut(middle);
    let (left_ends, right_ends) = ends.split_at_mut(lanes / 2);
    cut_part(left, start, bucket_size, left_ends);
    cut_part(right, start + middle, bucket_size, right_ends);
}

/// How many of `count` items go to the first half of `lanes` lanes: full buckets, in whole nodes if there are any.
fn left_size(count: usize, lanes: usize, bucket_size: usize) -> usize {
    let buckets = count.div_ceil(bucket_size);
    let left_lanes = lanes / 2;
    // A bucket in each lane, and the rest in whole nodes, each of which turns one bucket into sixteen.
    let nodes = buckets.saturating_sub(lanes).div_ceil(ARITY - 1);
    let left = if nodes == 0 { buckets * left_lanes / lanes } else { left_lanes + nodes / 2 * (ARITY - 1) };
    (left.max(1) * bucket_size).min(count)
}

/// The first of the longest, for the same answer everywhere.
fn longest_axis(items: &[Item]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for Item { point: p, .. } in items {
        for i in 0..3 {
            low[i] = if p[i] < low[i] { p[i] } else { low[i] };
            high[i] = if p[i] > high[i] { p[i] } else { high[i] };
        }
    }
    let extent = |i: usize| high[i] - low[i];
    let best = if extent(1) > extent(0) { 1 } else { 0 };
    if extent(2) > extent(best) { 2 } else { best }
}

/// A total order: points with the same coordinate go by their index.
fn compare(a: &Item, b: &Item, axis: usize) -> Ordering {
    a.point[axis].total_cmp(&b.point[axis]).then(a.index.cmp(&b.index))
}
