//! Cuts a node repeatedly, until there is a part for each lane.

use super::cut::{Buffers, CutFinder, Share, Shares};
use super::plan::{AXES, Plan, Primitives};
use super::refine::refine;
use crate::construct::error::BuildError;
use crate::construct::split::assignment::Assignment;
use crate::construct::split::levels::{self, Place};
use crate::construct::split::longest_axis::Item;
use crate::construct::split::progress::Observer;
use crate::halving::Halving;
use crate::hierarchy::MAX_DEPTH;
use alloc::vec::Vec;

pub(in crate::construct) fn assign(
    primitives: Primitives<'_>,
    plan: Plan,
    observer: &mut Observer<'_>,
) -> Result<Assignment, BuildError> {
    assign_within(primitives, plan, MAX_DEPTH, observer)
}

/// At most `max_depth` levels of nodes, which must suffice for a balanced tree.
fn assign_within(
    primitives: Primitives<'_>,
    plan: Plan,
    max_depth: usize,
    observer: &mut Observer<'_>,
) -> Result<Assignment, BuildError> {
    let mut order: Vec<u32> = (0..primitives.boxes.len() as u32).collect();
    let cut = |buffers: &mut Buffers, place: Place, items: &mut [u32], ends: &mut [u32]| {
        let finder = CutFinder::new(primitives, plan.measure, core::mem::take(buffers));
        let mut widener = Widener { finder, primitives, plan };
        let mut lanes = Vec::with_capacity(plan.arity);
        widener.node(items, place.levels_left - 1 - (MAX_DEPTH - max_depth), &mut lanes);
        ends.copy_from_slice(&lanes);
        *buffers = widener.finder.buffers;
        let mut start = 0;
        for end in lanes.into_iter().map(|end| end as usize) {
            if end - start <= plan.leaf_size {
                // A leaf is a set: its order must not depend on the selection algorithm.
                items[start..end].sort_unstable();
            }
            start = end;
        }
    };
    let ends = levels::split(&mut order, plan.arity, plan.leaf_size, observer, cut)?;
    Ok(Assignment { order, ends })
}

/// Cuts that leave full nodes below a number of lanes.
struct LaneShares {
    total: usize,
    lanes: usize,
    leaf_size: usize,
    arity: usize,
}

impl Shares for LaneShares {
    fn exactly(&self, count: usize) -> Option<Share> {
        let (lanes, step) = (self.lanes, self.arity - 1);
        let leaves = self.total.div_ceil(self.leaf_size);
        let left = count / self.leaf_size;
        if !count.is_multiple_of(self.leaf_size) || left == 0 || left >= leaves {
            return None;
        }
        if leaves <= lanes {
            return Some(Share { count, lanes: [left, lanes - left] });
        }
        // Each full node turns one leaf into `arity`, so l lanes have l + (arity - 1) m leaves below them. Only one l
        // is possible.
        let left_lanes = (left - 1) % step + 1;
        if left_lanes >= lanes || leaves - left < lanes - left_lanes {
            return None;
        }
        let share = Share { count, lanes: [left_lanes, lanes - left_lanes] };
        // Leaves per lane within a factor of two of the mean, or as near to it as full nodes permit.
        let near = |leaves_here: usize, lanes_here: usize| {
            let (here, mean) = (leaves_here * lanes, lanes_here * leaves);
            here <= 2 * mean && mean <= 2 * here || here.abs_diff(mean) <= step * lanes
        };
        (near(left, share.lanes[0]) && near(leaves - left, share.lanes[1])).then_some(share)
    }

    fn near(&self, count: usize) -> impl Iterator<Item = Share> {
        let (step, leaves) = (self.arity - 1, count / self.leaf_size);
        (1..self.lanes).filter_map(move |lanes| {
            let nodes = (leaves.saturating_sub(lanes) + step / 2) / step;
            self.exactly((lanes + nodes * step) * self.leaf_size)
        })
    }
}

struct Widener<'a> {
    finder: CutFinder<'a>,
    primitives: Primitives<'a>,
    plan: Plan,
}

impl Widener<'_> {
    /// Writes the ends of a node's lanes to `ends`, counted from its first item. At most `levels` levels may follow
    /// below it.
    fn node(&mut self, items: &mut [u32], levels: usize, ends: &mut Vec<u32>) {
        let Plan { arity, leaf_size, passes, .. } = self.plan;
        self.cut(items, 0, arity, ends);
        if passes > 0 && (items.len() > arity || leaf_size > 1) {
            refine(&mut self.finder, self.plan, items, ends);
        }
        // The capacity of a full tree of this many levels. If a part exceeds it, halving is used, which always fits.
        let capacity = leaf_size.saturating_mul(arity.saturating_pow(levels as u32));
        let starts = core::iter::once(0).chain(ends.iter().map(|&end| end as usize));
        if starts.zip(&*ends).any(|(start, &end)| end as usize - start > capacity) {
            ends.clear();
            self.halve(items, 0, arity, ends);
        }
    }

    /// Appends the ends of `lanes` parts of `items`, counted from `start`. Recurses at most once per lane.
    fn cut(&mut self, items: &mut [u32], start: usize, lanes: usize, ends: &mut Vec<u32>) {
        let Plan { arity, leaf_size, .. } = self.plan;
        let total = items.len();
        if lanes == 1 || total <= leaf_size {
            ends.extend(core::iter::repeat_n((start + total) as u32, lanes));
            return;
        }
        if leaf_size == 1 && total <= lanes {
            // One primitive per lane: there is no choice.
            items.sort_unstable();
            ends.extend((1..=lanes).map(|lane| (start + lane.min(total)) as u32));
            return;
        }
        let shares = LaneShares { total, lanes, leaf_size, arity };
        let Some(cut) = self.finder.best(items, &AXES, &shares, f64::INFINITY) else {
            // All centroids coincide, so bins cannot separate them.
            return self.halve(items, start, lanes, ends);
        };
        self.finder.apply(items, &cut);
        let Share { count, lanes: [left_lanes, right_lanes] } = cut.share;
        let (left, right) = items.split_at_mut(count);
        self.cut(left, start, left_lanes, ends);
        self.cut(right, start + count, right_lanes, ends);
    }

    fn halve(&self, items: &mut [u32], start: usize, lanes: usize, ends: &mut Vec<u32>) {
        let Plan { arity, leaf_size, .. } = self.plan;
        let item = |&mut index: &mut u32| Item { centroid: self.primitives.centroids[index as usize], index };
        let mut halved: Vec<Item> = items.iter_mut().map(item).collect();
        let from = ends.len();
        ends.resize(from + lanes, 0);
        Halving { arity, leaf_size, extended: true }.cut_node(&mut halved, &mut ends[from..]);
        ends[from..].iter_mut().for_each(|end| *end += start as u32);
        items.iter_mut().zip(halved).for_each(|(to, item)| *to = item.index);
    }
}

#[cfg(test)]
mod tests {
    use super::super::aabb::{Aabb, Measure};
    use super::*;
    use crate::range::Point;
    use core::ops::ControlFlow;

    /// Each box twice as far out and twice as large as the last: whatever is cut off first, most of the rest is in one
    /// place.
    fn growing(n: usize) -> Vec<Aabb> {
        let at =
            |i: usize| (0..i % 900).fold(1.0, |x: f64, _| 2.0 * x) * f64::from_bits(0x3d30_0000_0000_0000);
        (0..n).map(|i| Aabb::of(([at(i), 0.0, 0.0], [1.5 * at(i), 0.0, 0.5 * at(i)]))).collect()
    }

    /// Levels of nodes.
    fn depth(assignment: &Assignment, arity: usize, leaf_size: u32) -> usize {
        let mut levels = alloc::vec![(0, 1)];
        for (node, ends) in assignment.ends.chunks_exact(arity).enumerate() {
            let (mut start, level) = levels[node];
            for &end in ends {
                if end - start > leaf_size {
                    levels.push((start, level + 1));
                }
                start = end;
            }
        }
        levels.iter().map(|l| l.1).max().unwrap_or(0)
    }

    #[test]
    fn no_tree_is_deeper_than_the_limit() {
        for (arity, leaf_size, count, balanced) in [(4, 1, 256, 4), (4, 3, 192, 3), (16, 1, 256, 2)] {
            let boxes = growing(count);
            let centroids: Vec<Point> = boxes.iter().map(Aabb::centre).collect();
            let primitives = Primitives { boxes: &boxes, centroids: &centroids };
            let plan = Plan { arity, leaf_size, measure: Measure::MeanWidth, passes: 2 };
            let levels = |limit| {
                let assignment = assign_within(primitives, plan, limit, &mut |_| ControlFlow::Continue(()));
                depth(&assignment.unwrap(), arity, leaf_size as u32)
            };
            assert!(levels(MAX_DEPTH) > balanced, "arity {arity}: left alone, it is deeper");
            for limit in balanced..balanced + 3 {
                assert!(levels(limit) <= limit, "arity {arity} leaf {leaf_size} limit {limit}");
            }
        }
    }

    #[test]
    fn shares_leave_full_nodes() {
        for (total, lanes, leaf_size, arity) in
            [(3250, 16, 1, 16), (1000, 5, 2, 16), (77, 3, 1, 4), (12, 4, 5, 4)]
        {
            let shares = LaneShares { total, lanes, leaf_size, arity };
            let mut found = 0;
            for count in 0..=total {
                if let Some(Share { count: n, lanes: [left, right] }) = shares.exactly(count) {
                    assert_eq!((n, left + right), (count, lanes));
                    let leaves = count / leaf_size;
                    assert!(left >= 1 && right >= 1 && leaves * leaf_size == count);
                    assert!(leaves == left || leaves > left && (leaves - left).is_multiple_of(arity - 1));
                    assert!(
                        (total - count).div_ceil(leaf_size) >= right.min(total.div_ceil(leaf_size) - leaves)
                    );
                    found += 1;
                }
                for share in shares.near(count) {
                    assert_eq!(shares.exactly(share.count), Some(share));
                    assert!(share.count.abs_diff(count) <= arity * leaf_size, "{share:?} for {count}");
                }
            }
            assert!(found > 0, "{total} in {lanes} lanes");
        }
    }
}
