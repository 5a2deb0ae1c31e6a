//! A subtree for each detail of a body.
//!
//! To a splitter, a cluster of primitives that are tiny beside their body is all in one place: it shares it out among lanes as
//! it comes, together with what lies around it. So such clusters are found before, each is split on its own, and stands for one
//! item, as large as its box, in what is left. Then a query gets to it by one link, and there into a frame of its own
//! ([`super::details`]).

use super::cost::Aabb;
use super::details::STEPS;
use super::{Assignment, BuildError, Observer, Progress};
use crate::hierarchy::MAX_DEPTH;
use crate::range::Point;
use alloc::collections::VecDeque;
use alloc::vec::Vec;

/// What a splitter splits.
pub(super) struct Items {
    pub(super) boxes: Vec<Aabb>,
    /// None if all weigh the same.
    pub(super) weights: Option<Vec<f64>>,
}

/// A frame has about so many steps across a body.
const STEPS_ACROSS: f64 = 65536.0;
/// What is nearer to each other than this many steps, about, may be in one cluster.
const CELL: f64 = 16.0;
/// A cluster has at least so many primitives,
const LEAST: usize = 64;
/// and is so many times narrower than the body, or more: else its frame would hardly be finer.
const NARROWER: f64 = 16.0;
/// Details of details, and so on, at most.
const NESTED: usize = 8;

impl Items {
    pub(super) fn centroids(&self) -> Vec<Point> {
        self.boxes.iter().map(Aabb::centre).collect()
    }

    /// Some of them.
    fn some(&self, of: &[u32]) -> Self {
        let weights =
            self.weights.as_ref().map(|weights| of.iter().map(|&item| weights[item as usize]).collect());
        Self { boxes: of.iter().map(|&item| self.boxes[item as usize]).collect(), weights }
    }

    /// All of them as one.
    fn as_one(&self) -> (Aabb, f64) {
        let around = self.boxes.iter().fold(Aabb::EMPTY, |all, one| all.join(one));
        (around, self.weights.as_ref().map_or(1.0, |weights| weights.iter().sum()))
    }
}

/// Splits, with a subtree for each detail.
pub(super) fn assign<E: From<BuildError>>(
    items: &Items,
    arity: usize,
    has_details: bool,
    observer: &mut Observer<'_>,
    split: &mut dyn FnMut(&Items, &mut Observer<'_>) -> Result<Assignment, E>,
) -> Result<Assignment, E> {
    let nested = if has_details { NESTED } else { 0 };
    // A tree that turns out too deep is begun anew.
    let mut most = 0;
    let mut observer = |progress: Progress| {
        most = most.max(progress.placed);
        observer(Progress { placed: most, ..progress })
    };
    match graft(items, arity, nested, &mut observer, split)? {
        Some(grafted) => Ok(grafted),
        None => split(items, &mut observer),
    }
}

/// `None` if there are no details, or the tree would be too deep.
fn graft<E: From<BuildError>>(
    items: &Items,
    arity: usize,
    nested: usize,
    observer: &mut Observer<'_>,
    split: &mut dyn FnMut(&Items, &mut Observer<'_>) -> Result<Assignment, E>,
) -> Result<Option<Assignment>, E> {
    let details = if nested == 0 { Vec::new() } else { details_of(&items.boxes) };
    if details.is_empty() {
        return Ok(None);
    }
    let mut is_in_detail = alloc::vec![false; items.boxes.len()];
    details.iter().flatten().for_each(|&item| is_in_detail[item as usize] = true);
    let rest: Vec<u32> = (0..items.boxes.len() as u32).filter(|&item| !is_in_detail[item as usize]).collect();
    let mut top = items.some(&rest);
    let (total, mut placed) = (items.boxes.len(), 0);
    let mut parts = Vec::with_capacity(details.len());
    for detail in details {
        let own = items.some(&detail);
        let (around, weight) = own.as_one();
        top.boxes.push(around);
        top.weights.as_mut().into_iter().for_each(|weights| weights.push(weight));
        let before = placed;
        let mut observer =
            |progress: Progress| observer(Progress { placed: before + progress.placed, total });
        let mut shape = match graft(&own, arity, nested - 1, &mut observer, split)? {
            Some(shape) => shape,
            None => split(&own, &mut observer)?,
        };
        placed += detail.len();
        shape.order.iter_mut().for_each(|item| *item = detail[*item as usize]);
        parts.push(shape);
    }
    let mut observer =
        |progress: Progress| observer(Progress { placed: placed + progress.placed.min(rest.len()), total });
    let top = split(&top, &mut observer)?;
    Ok(joined(&top, &rest, &parts, arity))
}

/// A node that is to come: of which tree, where the order of that begins, where the node's own range does in it, its level.
struct Upcoming {
    tree: usize,
    base: u32,
    node: usize,
    start: u32,
    level: usize,
}

/// A tree over what is left and then the details, with the trees of these. `None` if it is too deep.
fn joined(top: &Assignment, rest: &[u32], parts: &[Assignment], arity: usize) -> Option<Assignment> {
    // Number 0 is the top, then come those of the details.
    let part_of = |item: u32| (item as usize + 1).checked_sub(rest.len()).filter(|part| *part > 0);
    let mut order = Vec::new();
    // Where each of the top's items begins, and where all end.
    let mut starts = Vec::with_capacity(top.order.len() + 1);
    for &item in &top.order {
        starts.push(order.len() as u32);
        match part_of(item) {
            Some(part) => order.extend_from_slice(&parts[part - 1].order),
            None => order.push(rest[item as usize]),
        }
    }
    starts.push(order.len() as u32);
    let trees = core::iter::once(top).chain(parts);
    let trees: Vec<_> = trees.map(|shape| (shape, first_children(shape, arity))).collect();
    let mut ends = Vec::new();
    let mut waiting = VecDeque::from([Upcoming { tree: 0, base: 0, node: 0, start: 0, level: 1 }]);
    while let Some(Upcoming { tree, base, node, mut start, level }) = waiting.pop_front() {
        if level > MAX_DEPTH {
            return None;
        }
        let (shape, first_children) = &trees[tree];
        let (mut next, level) = (first_children[node], level + 1);
        for &end in &shape.ends[node * arity..][..arity] {
            if end - start > 1 {
                waiting.push_back(Upcoming { tree, base, node: next, start, level });
                next += 1;
            } else if tree == 0
                && end > start
                && let Some(part) = part_of(top.order[start as usize])
            {
                waiting.push_back(Upcoming {
                    tree: part,
                    base: starts[start as usize],
                    node: 0,
                    start: 0,
                    level,
                });
            }
            start = end;
            ends.push(if tree == 0 { starts[end as usize] } else { base + end });
        }
    }
    Some(Assignment { order, ends })
}

/// For each node of a tree whose leaves hold an item each, the first node below it, if there is one.
fn first_children(shape: &Assignment, arity: usize) -> Vec<usize> {
    let (mut next, mut starts) = (1, VecDeque::from([0]));
    let children = |ends: &[u32]| {
        let first = next;
        let mut start = starts.pop_front().unwrap_or(0);
        for &end in ends {
            if end - start > 1 {
                starts.push_back(start);
                next += 1;
            }
            start = end;
        }
        first
    };
    shape.ends.chunks_exact(arity).map(children).collect()
}

/// Clusters of primitives that are tiny beside the body, by their boxes: ascending items of each, by the first.
fn details_of(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let whole = boxes.iter().fold(Aabb::EMPTY, |all, one| all.join(one));
    let (side, low) = (whole.side(), whole.low());
    let step = side / STEPS_ACROSS;
    let is_tiny = |item: &Aabb| item.side() < STEPS as f64 * step;
    let tiny = || (0_u32..).zip(boxes).filter(|(_, item)| is_tiny(item));
    if tiny().count() < LEAST {
        return Vec::new();
    }
    let place = |item: &Aabb| {
        let p: Point = item.centre();
        core::array::from_fn(|i| ((p[i] - low[i]) / (CELL * step)) as u32 + 1)
    };
    let mut placed: Vec<([u32; 3], u32)> = tiny().map(|(index, item)| (place(item), index)).collect();
    placed.sort_unstable();
    let mut cells: Vec<[u32; 3]> = placed.iter().map(|&(cell, _)| cell).collect();
    cells.dedup();
    let clusters = clusters(&cells);
    let cluster_at = |cell: &[u32; 3]| cells.binary_search(cell).ok().map(|index| clusters[index] as usize);
    // By the first cell of each cluster.
    let mut around = alloc::vec![(Aabb::EMPTY, 0); cells.len()];
    let mut cluster_of = alloc::vec![None; boxes.len()];
    for (cell, index) in placed {
        let Some(cluster) = cluster_at(&cell) else { continue };
        let (aabb, count) = &mut around[cluster];
        (*aabb, *count) = (aabb.join(&boxes[index as usize]), *count + 1);
        cluster_of[index as usize] = Some(cluster);
    }
    let is_detail = |&cluster: &usize| {
        let (around, count) = around[cluster];
        let steps = around.side() / step;
        let is_fine = steps * steps < (STEPS * STEPS) as f64 * count as f64;
        is_fine && count >= LEAST && NARROWER * around.side() <= side
    };
    let mut items_of = alloc::vec![Vec::new(); cells.len()];
    for ((index, item), cluster) in (0_u32..).zip(boxes).zip(&cluster_of) {
        // What is a bit larger belongs to the cluster that it is beside, what is larger still to that which it is inside of.
        let belongs = |&cluster: &usize| item.side() < CELL * step || around[cluster].0.holds(item);
        let holder = || cluster_at(&place(item)).filter(belongs);
        if let Some(cluster) = cluster.or_else(holder).filter(is_detail) {
            items_of[cluster].push(index);
        }
    }
    items_of.retain(|items| !items.is_empty());
    items_of.sort_unstable();
    items_of
}

/// For each of some cells, ascending, the first that it hangs together with by neighbours.
fn clusters(cells: &[[u32; 3]]) -> Vec<u32> {
    fn root(parents: &mut [u32], mut cell: u32) -> u32 {
        while parents[cell as usize] != cell {
            let above = parents[parents[cell as usize] as usize];
            parents[cell as usize] = above;
            cell = above;
        }
        cell
    }
    let mut parents: Vec<u32> = (0..cells.len() as u32).collect();
    for (index, &[x, y, z]) in (0_u32..).zip(cells) {
        // Those before it: others find it.
        for neighbour in 0..13 {
            let cell = [x + neighbour / 9 - 1, y + neighbour / 3 % 3 - 1, z + neighbour % 3 - 1];
            let Ok(other) = cells.binary_search(&cell) else { continue };
            let [one, other] = [index, other as u32].map(|cell| root(&mut parents, cell));
            // The first is the root.
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    (0..cells.len() as u32).map(|cell| root(&mut parents, cell)).collect()
}

#[cfg(test)]
mod tests;
