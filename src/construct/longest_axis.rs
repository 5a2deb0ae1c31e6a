//! The two splitters by sorting: longest axis and extended longest axis (SIMDop paper, section IV-A, 1 and
//! 2).
//!
//! Both cut at positions that leave **full nodes**. A full tree of arity w with m nodes has 1 + (w - 1) m
//! leaves; so each lane gets a number of leaves of this form, as near to an equal share as that allows, and
//! at most one node of the tree has unused lanes. Cutting into equal shares instead leaves most nodes of the
//! last level with two lanes in use: about four times the bytes.

use super::{Assignment, BuildError, Observer, levels, parallel};
use crate::range::Point;
use alloc::vec::Vec;
use core::cmp::Ordering;

/// A primitive, as far as these splitters see it. Moved as a whole: an index to look it up by would miss the
/// cache at each step.
#[derive(Copy, Clone, Debug)]
pub(super) struct Item {
    pub(super) centroid: Point,
    pub(super) index: u32,
}

pub(super) fn assign(
    centroids: &[Point],
    halving: &Halving,
    observer: &mut Observer<'_>,
) -> Result<Assignment, BuildError> {
    let mut items: Vec<Item> =
        centroids.iter().zip(0..).map(|(&centroid, index)| Item { centroid, index }).collect();
    let cut = |(): &mut (), _, items: &mut [Item], ends: &mut [u32]| halving.cut_node(items, ends);
    let ends = levels::split(&mut items, halving.arity, halving.leaf_size, observer, cut)?;
    Ok(Assignment { order: items.iter().map(|item| item.index).collect(), ends })
}

/// A node of fewer primitives is cut by one thread: a join costs about a microsecond.
const JOIN_SIZE: usize = 4096;

/// Cuts nodes.
#[derive(Copy, Clone, Debug)]
pub(super) struct Halving {
    pub(super) arity: usize,
    pub(super) leaf_size: usize,
    /// Whether each half takes its own longest axis.
    pub(super) extended: bool,
}

impl Halving {
    /// Moves the items of a node to its lanes. Ends count from its first item.
    pub(super) fn cut_node(&self, items: &mut [Item], ends: &mut [u32]) {
        self.cut(items, 0, None, ends);
    }

    /// Cuts `items`, which begin at `start`, into a part for each of `ends`, along `axis` or the longest.
    fn cut(&self, items: &mut [Item], start: usize, axis: Option<usize>, ends: &mut [u32]) {
        let (count, lanes) = (items.len(), ends.len());
        if lanes == 1 || count <= self.leaf_size {
            // What fits in a leaf stays one: the other lanes are unused.
            ends.fill((start + count) as u32);
            if count <= self.leaf_size {
                // A leaf is a set: its order must not depend on how a selection algorithm moves things.
                items.sort_unstable_by_key(|item| item.index);
            }
            return;
        }
        let axis = axis.unwrap_or_else(|| longest_axis(items));
        let middle = self.left_size(count, lanes);
        if middle < count {
            items.select_nth_unstable_by(middle, |a, b| compare(a, b, axis));
        }
        let next_axis = if self.extended { None } else { Some(axis) };
        let (left, right) = items.split_at_mut(middle);
        let (left_ends, right_ends) = ends.split_at_mut(lanes / 2);
        let mut cut_left = || self.cut(left, start, next_axis, left_ends);
        let mut cut_right = || self.cut(right, start + middle, next_axis, right_ends);
        if count < JOIN_SIZE {
            cut_left();
            cut_right();
        } else {
            parallel::join(cut_left, cut_right);
        }
    }

    /// How many of `count` primitives go to the first half of `lanes` lanes.
    fn left_size(&self, count: usize, lanes: usize) -> usize {
        let leaves = count.div_ceil(self.leaf_size);
        let left_lanes = lanes / 2;
        // A leaf in each lane, and the rest in whole nodes, each of which turns one leaf into `arity`.
        let nodes = leaves.saturating_sub(lanes).div_ceil(self.arity - 1);
        let left =
            if nodes == 0 { leaves * left_lanes / lanes } else { left_lanes + nodes / 2 * (self.arity - 1) };
        (left.max(1) * self.leaf_size).min(count)
    }
}

fn longest_axis(part: &[Item]) -> usize {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for Item { centroid: p, .. } in part {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    let extent = |i: usize| high[i] - low[i];
    // The first of the longest, for the same answer everywhere.
    let best = if extent(1) > extent(0) { 1 } else { 0 };
    if extent(2) > extent(best) { 2 } else { best }
}

/// A total order: coincident centroids go by their index.
fn compare(a: &Item, b: &Item, axis: usize) -> Ordering {
    a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.index.cmp(&b.index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::ControlFlow;

    fn cut(centroids: &[Point], halving: &Halving) -> Assignment {
        assign(centroids, halving, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    /// Along a line every cut is by the same order: by place, and by index in one place.
    #[test]
    fn ties_go_by_index() {
        let place = |i: usize| (i * 7919 % 3001 % 20) as f64;
        let centroids: Vec<Point> = (0..3001).map(|i| [place(i), 0.0, 0.0]).collect();
        let mut want: Vec<u32> = (0..3001).collect();
        want.sort_by_key(|&i| (place(i as usize) as u32, i));
        for (arity, extended) in [(4, false), (4, true), (16, true)] {
            let got = cut(&centroids, &Halving { arity, leaf_size: 1, extended });
            assert_eq!(got.order, want, "arity {arity}, extended {extended}");
        }
    }

    #[test]
    fn leaves_are_in_the_order_of_their_indices() {
        let centroids: Vec<Point> = (0..3001).map(|i| [-f64::from(i), 0.0, 0.0]).collect();
        for (arity, leaf_size) in [(4, 3), (16, 5)] {
            let Assignment { order, ends } = cut(&centroids, &Halving { arity, leaf_size, extended: true });
            let mut nodes = alloc::vec![0];
            let mut leaves = 0;
            for (node, ends) in ends.chunks_exact(arity).enumerate() {
                let mut start = nodes[node];
                for end in ends.iter().map(|&end| end as usize) {
                    if end - start > leaf_size {
                        nodes.push(start);
                    } else {
                        assert!(order[start..end].is_sorted(), "{:?}", &order[start..end]);
                        leaves += usize::from(end > start + 1);
                    }
                    start = end;
                }
            }
            assert!(leaves > 500, "{leaves} leaves of more than one");
        }
    }
}
