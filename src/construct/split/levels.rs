//! What all splitters by levels share: all nodes of a level are cut, each on its own, then their parts that
//! are no leaves are the next level. So nodes come out breadth-first, and a level is one parallel step.

use super::progress::{Observer, Progress};
use crate::construct::error::BuildError;
use crate::parallel;
use alloc::vec::Vec;
use core::ops::Range;

/// Where a node is in its tree.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Place {
    /// Among all nodes, breadth-first.
    pub(in crate::construct) node: usize,
    /// Levels from here to the deepest node that a tree may have, this one included.
    pub(in crate::construct) levels_left: usize,
}

/// A node to cut.
struct Job<'a, T> {
    place: Place,
    start: usize,
    items: &'a mut [T],
    ends: &'a mut [u32],
}

/// All nodes of one level.
pub(in crate::construct) struct Level<'a> {
    /// The items that each stands for.
    pub(in crate::construct) nodes: &'a [Range<usize>],
    /// Number of the first, breadth-first.
    pub(in crate::construct) first: usize,
    /// As in [`Place`].
    pub(in crate::construct) levels_left: usize,
}

/// Moves `items` into the order of the leaves and returns where the parts end, as [`super::Assignment`] wants
/// them.
///
/// `cut(scratch, place, items, ends)` moves the items of one node so that the parts of its lanes are
/// consecutive, and writes where each ends, from the node's first item.
pub(in crate::construct) fn split<T: Send, S: Default>(
    items: &mut [T],
    arity: usize,
    leaf_size: usize,
    observer: &mut Observer<'_>,
    cut: impl Fn(&mut S, Place, &mut [T], &mut [u32]) + Sync,
) -> Result<Vec<u32>, BuildError> {
    let total = items.len();
    let cut_level = |level: &Level<'_>, ends: &mut [u32]| {
        let mut jobs = Vec::with_capacity(level.nodes.len());
        let (mut rest, mut passed) = (&mut *items, 0);
        for (i, (range, ends)) in level.nodes.iter().zip(ends.chunks_exact_mut(arity)).enumerate() {
            let (_, from) = rest.split_at_mut(range.start - passed);
            let (items, after) = from.split_at_mut(range.len());
            (rest, passed) = (after, range.end);
            let place = Place { node: level.first + i, levels_left: level.levels_left };
            jobs.push(Job { place, start: range.start, items, ends });
        }
        parallel::for_each(jobs, |scratch: &mut S, job: Job<'_, T>| {
            cut(scratch, job.place, job.items, job.ends);
            job.ends.iter_mut().for_each(|end| *end += job.start as u32);
        });
        Ok(())
    };
    by_level(total, arity, leaf_size, observer, cut_level)
}

/// Where the parts of a tree over `total` items end. `cut(level, ends)` cuts all nodes of a level, and writes
/// where their parts end, from the first item of all.
pub(in crate::construct) fn by_level<E: From<BuildError>>(
    total: usize,
    arity: usize,
    leaf_size: usize,
    observer: &mut Observer<'_>,
    mut cut: impl FnMut(&Level<'_>, &mut [u32]) -> Result<(), E>,
) -> Result<Vec<u32>, E> {
    let mut ends: Vec<u32> = Vec::new();
    let mut level = Vec::new();
    if total > 0 {
        level.push(0..total);
    }
    let mut levels_left = crate::hierarchy::MAX_DEPTH;
    while !level.is_empty() {
        let first = ends.len();
        ends.resize(first + level.len() * arity, 0);
        cut(&Level { nodes: &level, first: first / arity, levels_left }, &mut ends[first..])?;
        let mut next = Vec::new();
        for (range, ends) in level.iter().zip(ends[first..].chunks_exact(arity)) {
            let mut start = range.start;
            for &end in ends {
                if end as usize - start > leaf_size {
                    next.push(start..end as usize);
                }
                start = end as usize;
            }
        }
        level = next;
        levels_left = levels_left.checked_sub(1).ok_or(BuildError::TooDeep)?;
        let waiting: usize = level.iter().map(ExactSizeIterator::len).sum();
        if observer(Progress { placed: total - waiting, total }).is_break() {
            return Err(BuildError::Cancelled.into());
        }
    }
    Ok(ends)
}
