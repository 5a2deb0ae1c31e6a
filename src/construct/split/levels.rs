//! Splitting level by level: all nodes of a level are cut independently, then those parts that are not leaves form the
//! next level. So nodes are in breadth-first order, and a level is one parallel step.

use super::progress::{Observer, Progress};
use crate::construct::error::BuildError;
use crate::parallel;
use alloc::vec::Vec;
use core::ops::Range;

/// The position of a node in its tree.
#[derive(Copy, Clone, Debug)]
pub(in crate::construct) struct Place {
    /// Index in breadth-first order.
    pub(in crate::construct) node: usize,
    /// Number of levels from here to the maximum depth of a tree, this one included.
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
    /// The range of items of each node.
    pub(in crate::construct) nodes: &'a [Range<usize>],
    /// Index of the first node in breadth-first order.
    pub(in crate::construct) first: usize,
    /// As in [`Place`].
    pub(in crate::construct) levels_left: usize,
}

/// Moves `items` into leaf order and returns the ends of the parts, as in [`super::Assignment`].
///
/// `cut(scratch, place, items, ends)` moves the items of one node so that the parts of its lanes are consecutive, and
/// writes the ends of the parts, counted from the node's first item.
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

/// The ends of the parts of a tree over `total` items. `cut(level, ends)` cuts all nodes of a level, and writes the
/// ends of their parts, counted from the first of all items.
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
