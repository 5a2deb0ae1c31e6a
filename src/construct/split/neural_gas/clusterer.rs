//! Cuts one node at a time: by clustering, or by axes where that fails.

use super::accumulate::{accumulate, nearest};
use super::balance::{self, Balance};
use super::prototypes::Prototypes;
use super::samples::{Cluster, Samples};
use super::schedule::schedule;
use crate::construct::error::BuildError;
use crate::construct::split::assignment::Assignment;
use crate::construct::split::levels;
use crate::construct::split::longest_axis::Item;
use crate::construct::split::progress::Observer;
use crate::halving::Halving;
use alloc::vec::Vec;

/// The shape of a tree over samples. `halving` has the arity and leaf size, and cuts nodes where clustering fails.
pub(in crate::construct) fn assign(
    samples: &Samples<'_>,
    halving: &Halving,
    seed: u32,
    observer: &mut Observer<'_>,
) -> Result<Assignment, BuildError> {
    match halving.arity {
        4 => Clusterer::<4>::new(samples, halving, seed).assign(observer),
        16 => Clusterer::<16>::new(samples, halving, seed).assign(observer),
        arity => unreachable!("nodes have 4 or 16 lanes, not {arity}"),
    }
}

/// Cuts nodes of `N` lanes.
pub(in crate::construct) struct Clusterer<'a, const N: usize> {
    pub(in crate::construct) samples: &'a Samples<'a>,
    pub(in crate::construct) halving: &'a Halving,
    pub(in crate::construct) seed: u32,
    /// h of each rank, step by step.
    pub(in crate::construct) schedule: Vec<[u16; N]>,
}

/// The memory of a thread, reused for the next node.
#[derive(Default)]
struct Scratch<const N: usize> {
    cluster: Cluster,
    balance: Balance<N>,
    lanes: Vec<u8>,
    sorted: Vec<u32>,
}

impl<'a, const N: usize> Clusterer<'a, N> {
    pub(in crate::construct) fn new(samples: &'a Samples<'a>, halving: &'a Halving, seed: u32) -> Self {
        Self { samples, halving, seed, schedule: schedule() }
    }

    fn assign(&self, observer: &mut Observer<'_>) -> Result<Assignment, BuildError> {
        let mut order: Vec<u32> = (0..self.samples.len() as u32).collect();
        let cut = |scratch: &mut Scratch<N>, place, part: &mut [u32], ends: &mut [u32]| {
            self.cut(scratch, place, part, ends);
        };
        let ends = levels::split(&mut order, N, self.halving.leaf_size, observer, cut)?;
        Ok(Assignment { order, ends })
    }

    fn cut(&self, scratch: &mut Scratch<N>, place: levels::Place, part: &mut [u32], ends: &mut [u32]) {
        if part.len() <= N {
            // One primitive per lane.
            ends.iter_mut().zip(1..).for_each(|(end, i)| *end = (part.len() as u32).min(i));
        } else if self.is_too_deep(place.levels_left, part.len())
            || !self.cluster(scratch, place.node, part, ends)
        {
            self.cut_by_axes(part, ends);
        }
    }

    /// Clusters a node. Returns whether it was split.
    fn cluster(&self, scratch: &mut Scratch<N>, node: usize, part: &mut [u32], ends: &mut [u32]) -> bool {
        let Scratch { cluster, balance, lanes, sorted } = scratch;
        if !cluster.local_coordinates(self.samples, part) {
            return false;
        }
        let mut prototypes = Prototypes::<N>::start(cluster.extent(), self.seed, node as u32);
        settle(cluster, &mut prototypes, &self.schedule);
        let mut sizes = nearest(cluster, &prototypes, lanes);
        if part.len() <= balance::MAX_SIZE {
            balance.balance(cluster, &prototypes, self.halving.leaf_size, lanes, &mut sizes);
        }
        if sizes.contains(&(part.len() as u32)) {
            return false;
        }
        sort_by_lane(part, lanes, &sizes, sorted, ends);
        true
    }

    pub(in crate::construct) fn cut_by_axes(&self, part: &mut [u32], ends: &mut [u32]) {
        let item = |&index: &u32| Item { centroid: self.samples.point(index), index };
        let mut items: Vec<Item> = part.iter().map(item).collect();
        self.halving.cut_node(&mut items, ends);
        part.iter_mut().zip(&items).for_each(|(index, item)| *index = item.index);
        let mut start = 0;
        for &end in &*ends {
            // As after clustering: the order of a part must not depend on the selection algorithm.
            part[start..end as usize].sort_unstable();
            start = end as usize;
        }
    }

    /// Whether only balanced cuts keep a branch over `count` primitives within the remaining levels.
    pub(in crate::construct) fn is_too_deep(&self, levels_left: usize, count: usize) -> bool {
        levels_left <= self.levels_needed(count) + 1
    }

    /// Levels of a balanced tree over `count` primitives.
    fn levels_needed(&self, count: usize) -> usize {
        let (mut levels, mut room) = (0, self.halving.leaf_size);
        while room < count {
            (levels, room) = (levels + 1, room * N);
        }
        levels
    }
}

/// Moves prototypes step by step, until none moves.
pub(in crate::construct) fn settle<const N: usize>(
    cluster: &Cluster,
    prototypes: &mut Prototypes<N>,
    schedule: &[[u16; N]],
) {
    for h in schedule {
        let sums = accumulate(cluster, prototypes, h);
        if !prototypes.update(&sums) {
            break;
        }
    }
}

/// Stable sort of the primitives by lane; writes the ends of the lanes.
pub(in crate::construct) fn sort_by_lane<const N: usize>(
    part: &mut [u32],
    lanes: &[u8],
    sizes: &[u32; N],
    sorted: &mut Vec<u32>,
    ends: &mut [u32],
) {
    let (mut next, mut end) = ([0; N], 0);
    for lane in 0..N {
        next[lane] = end as usize;
        end += sizes[lane];
        ends[lane] = end;
    }
    sorted.clear();
    sorted.resize(part.len(), 0);
    for (&index, &lane) in part.iter().zip(lanes) {
        let place = &mut next[usize::from(lane)];
        sorted[*place] = index;
        *place += 1;
    }
    part.copy_from_slice(sorted);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point twice as far out as the last: one cluster is all points near the middle.
    #[test]
    fn a_node_with_no_level_to_spare_is_balanced() {
        const COUNT: u32 = 256;
        let points: Vec<[f64; 3]> =
            (0..COUNT).map(|i| [f64::from(1 << (i % 20)), f64::from(i) / 256.0, 0.0]).collect();
        let samples = Samples::new(&points, None);
        let halving = Halving { arity: 4, leaf_size: 1, extended: true };
        let clusterer = Clusterer::<4>::new(&samples, &halving, 0);
        let largest = |levels_left| {
            let (mut part, mut ends) = ((0..COUNT).collect::<Vec<_>>(), [0; 4]);
            clusterer.cut(
                &mut Scratch::default(),
                levels::Place { node: 0, levels_left },
                &mut part,
                &mut ends,
            );
            let starts = core::iter::once(0).chain(ends);
            starts.zip(ends).map(|(start, end)| end - start).max().unwrap()
        };
        assert_eq!(clusterer.levels_needed(COUNT as usize), 4);
        assert!(largest(20) > 64, "left alone, a lane gets more than its share");
        assert_eq!([4, 5].map(largest), [64; 2]);
    }
}
