//! Splitting a set at medians along its longest axis, recursively, until there is a part for each lane of a node.
//!
//! Splits leave **full nodes**. A full tree of arity w with m nodes has 1 + (w - 1) m leaves. So each lane gets a
//! number of leaves of this form, as near to an equal share as possible, and at most one node of the tree has unused
//! lanes. Equal shares instead would leave most nodes of the last level with two used lanes: about four times the
//! bytes.

use crate::parallel;
use core::cmp::Ordering;

/// An item to split: a position and a unique index.
pub(crate) trait Located: Copy + Send {
    /// The type of coordinates. Points in `f32` are compared in `f32`, since `f64` takes half as long again.
    type Number: Coordinate;

    fn place(&self) -> [Self::Number; 3];
    fn index(&self) -> u32;
}

/// A coordinate, which must be finite.
pub(crate) trait Coordinate: Copy + PartialOrd + core::ops::Sub<Output = Self> {
    /// As `f64::total_cmp`.
    fn order(&self, other: &Self) -> Ordering;
}

impl Coordinate for f32 {
    #[inline(always)]
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl Coordinate for f64 {
    #[inline(always)]
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// Nodes with fewer primitives are split on one thread: a join costs about a microsecond.
const JOIN_SIZE: usize = 4096;

/// Splits nodes.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Halving {
    pub(crate) arity: usize,
    pub(crate) leaf_size: usize,
    /// Whether each half is split along its own longest axis.
    pub(crate) extended: bool,
}

impl Halving {
    /// Reorders the items of a node by lane. `ends` are relative to its first item.
    pub(crate) fn cut_node<T: Located>(&self, items: &mut [T], ends: &mut [u32]) {
        self.cut(items, 0, None, ends);
    }

    /// Splits `items`, which begin at `start`, into a part for each of `ends`, along `axis` or the longest one.
    fn cut<T: Located>(&self, items: &mut [T], start: usize, axis: Option<usize>, ends: &mut [u32]) {
        let (count, lanes) = (items.len(), ends.len());
        if lanes == 1 || count <= self.leaf_size {
            // A set that fits a leaf stays whole: the other lanes are unused.
            ends.fill((start + count) as u32);
            if count <= self.leaf_size {
                // Sort, so that the order does not depend on the selection algorithm.
                items.sort_unstable_by_key(T::index);
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
        // One leaf in each lane, and the rest in whole nodes, each of which replaces one leaf by `arity`.
        let nodes = leaves.saturating_sub(lanes).div_ceil(self.arity - 1);
        let left =
            if nodes == 0 { leaves * left_lanes / lanes } else { left_lanes + nodes / 2 * (self.arity - 1) };
        (left.max(1) * self.leaf_size).min(count)
    }
}

fn longest_axis<T: Located>(part: &[T]) -> usize {
    let Some(first) = part.first() else { return 0 };
    let (mut low, mut high) = (first.place(), first.place());
    for item in part {
        let place = item.place();
        for i in 0..3 {
            low[i] = if place[i] < low[i] { place[i] } else { low[i] };
            high[i] = if place[i] > high[i] { place[i] } else { high[i] };
        }
    }
    let extent = |i: usize| high[i] - low[i];
    // The first of equals, for the same result on every machine.
    let best = if extent(1) > extent(0) { 1 } else { 0 };
    if extent(2) > extent(best) { 2 } else { best }
}

/// A total order: equal positions are ordered by index.
#[inline(always)]
fn compare<T: Located>(a: &T, b: &T, axis: usize) -> Ordering {
    a.place()[axis].order(&b.place()[axis]).then(a.index().cmp(&b.index()))
}
