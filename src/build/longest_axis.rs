//! The two splitters by sorting: longest axis and extended longest axis (SIMDop paper, section IV-A, 1 and 2).
//!
//! Both cut at positions that leave **full nodes**. A full tree of arity w with m nodes has 1 + (w - 1) m leaves; so each lane
//! gets a number of leaves of this form, as near to an equal share as that allows, and at most one node of the tree has
//! unused lanes. Cutting into equal shares instead leaves most nodes of the last level with two lanes in use: about four times
//! the bytes.

use super::{Assignment, Splitter};
use crate::frame::Point;
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::ops::Range;

/// A part of the order that is still to be cut into lanes.
#[derive(Clone, Debug)]
struct Part {
    range: Range<usize>,
    lanes: usize,
}

pub(super) fn assign(centroids: &[Point], arity: usize, leaf_size: usize, splitter: Splitter) -> Assignment {
    let mut order: Vec<u32> = (0..centroids.len() as u32).collect();
    let mut ends = Vec::new();
    let mut nodes = VecDeque::new();
    if !order.is_empty() {
        nodes.push_back(0..order.len());
    }
    let cutter = Cutter { centroids, arity, leaf_size, extended: splitter == Splitter::ExtendedLongestAxis };
    while let Some(range) = nodes.pop_front() {
        let from = ends.len();
        cutter.cut(&mut order, Part { range: range.clone(), lanes: arity }, None, &mut ends);
        let mut start = range.start;
        for &end in &ends[from..] {
            let end = end as usize;
            if end - start > leaf_size {
                nodes.push_back(start..end);
            } else {
                // A leaf is a set: its order must not depend on how a selection algorithm moves things.
                order[start..end].sort_unstable();
            }
            start = end;
        }
    }
    Assignment { order, ends }
}

/// Cuts `part` by halves for `lanes` lanes of a node. Appends where they end, counted from `start` before the part.
pub(super) fn halve(
    centroids: &[Point],
    (arity, leaf_size): (usize, usize),
    part: &mut [u32],
    start: usize,
    lanes: usize,
    ends: &mut Vec<u32>,
) {
    let cutter = Cutter { centroids, arity, leaf_size, extended: true };
    let from = ends.len();
    cutter.cut(part, Part { range: 0..part.len(), lanes }, None, ends);
    ends[from..].iter_mut().for_each(|end| *end += start as u32);
}

struct Cutter<'a> {
    centroids: &'a [Point],
    arity: usize,
    leaf_size: usize,
    extended: bool,
}

impl Cutter<'_> {
    /// Appends the ends of `part.lanes` parts of the range, along `axis` or the longest.
    fn cut(&self, order: &mut [u32], part: Part, axis: Option<usize>, ends: &mut Vec<u32>) {
        let Part { range, lanes } = part;
        if lanes == 1 || range.len() <= self.leaf_size {
            // What fits in a leaf stays one: the other lanes are unused.
            ends.extend(core::iter::repeat_n(range.end as u32, lanes));
            return;
        }
        let axis = axis.unwrap_or_else(|| self.longest_axis(&order[range.clone()]));
        let middle = range.start + self.left_size(range.len(), lanes);
        if middle < range.end {
            let by_axis = |a: &u32, b: &u32| self.compare(*a, *b, axis);
            order[range.clone()].select_nth_unstable_by(middle - range.start, by_axis);
        }
        let next_axis = if self.extended { None } else { Some(axis) };
        let halves = [(range.start..middle, lanes / 2), (middle..range.end, lanes - lanes / 2)];
        for (range, lanes) in halves {
            self.cut(order, Part { range, lanes }, next_axis, ends);
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

    fn longest_axis(&self, part: &[u32]) -> usize {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for &index in part {
            let p = &self.centroids[index as usize];
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
    fn compare(&self, a: u32, b: u32, axis: usize) -> Ordering {
        let key = |i: u32| self.centroids[i as usize][axis];
        key(a).total_cmp(&key(b)).then(a.cmp(&b))
    }
}
