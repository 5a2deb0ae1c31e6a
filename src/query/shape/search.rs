//! The traversals of a tree by one shape.

use super::bounds::{ChildBounds, DopBounds, HalfSpaceBounds, Volume};
use crate::hierarchy::{BvhRef, MAX_DEPTH};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Link;
use crate::primitive::{Primitive, Separation, Shape, Shapes};
use crate::query::entry::{Completion, PrimitivePair, Query, QueryStats};
use crate::query::lanes::{Lanes, within_slabs};
use core::ops::ControlFlow;

/// The nearest primitive.
pub(super) struct NearestPrimitive {
    /// Lower bound of the distance: the cutoff if no primitive is nearer.
    pub(super) lower: f64,
    /// Its index in leaf order.
    pub(super) found: Option<(u32, Separation)>,
    pub(super) is_complete: bool,
}

impl Query {
    /// Calls `visit` with the index, in leaf order, of each primitive within `margin` of the shape, until it breaks.
    pub(super) fn for_each_near_shape<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        volume: &Volume,
        tree: &BvhRef<'_, N, Q>,
        margin: f64,
        stats: &mut QueryStats,
        visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
    ) -> Completion
    where
        Shapes: PrimitivePair<Q>,
    {
        on_isa!(self.isa(), kernel => kernel.run(
            #[inline(always)]
            || for_each_near(kernel, self.budget(), shape, volume, tree, margin, stats, visit),
        ))
    }

    /// The primitive of the tree that is nearest to the shape.
    pub(super) fn nearest_to_shape<N: Lanes, Q: Primitive>(
        &self,
        shape: &Shape,
        volume: &Volume,
        tree: &BvhRef<'_, N, Q>,
        limits: (f64, f64),
        stats: &mut QueryStats,
    ) -> NearestPrimitive
    where
        Shapes: PrimitivePair<Q>,
    {
        let budget = self.budget();
        match volume {
            Volume::Dop { body, reach } => on_isa!(self.isa(), kernel => kernel.run(
                #[inline(always)]
                || nearest(budget, shape, &DopBounds::new(shape, body, *reach), tree, limits, stats),
            )),
            Volume::HalfSpace { .. } => nearest(budget, shape, &HalfSpaceBounds(volume), tree, limits, stats),
        }
    }
}

#[inline(always)]
fn root<N: Lanes, Q: Primitive>(tree: &BvhRef<'_, N, Q>) -> Link {
    // The root of an empty tree refers to no node.
    if tree.is_empty() { Link::Empty } else { tree.header().root.link() }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, inlined")]
fn for_each_near<N: Lanes, Q: Primitive, E: Kernel>(
    kernel: E,
    budget: u64,
    shape: &Shape,
    volume: &Volume,
    tree: &BvhRef<'_, N, Q>,
    margin: f64,
    stats: &mut QueryStats,
    visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Completion
where
    Shapes: PrimitivePair<Q>,
{
    // Computed when first needed: most shapes that nothing is near do not need them.
    let mut slabs = None;
    let mut aimed = N::NO_AIMED;
    volume.aim::<N>(&mut aimed, shape, margin);
    // A node, and its children that are still to be visited.
    let mut path = [(0_u32, 0_u16); MAX_DEPTH];
    let (mut levels, mut next) = (0, root(tree));
    loop {
        match next {
            Link::Empty => {}
            Link::Inner(node) => {
                if stats.visits == budget {
                    return Completion::OutOfBudget;
                }
                stats.visits += 1;
                stats.kernels += 1;
                let children = &tree.nodes()[node as usize];
                let mut near = volume.near(kernel, children, &aimed, margin);
                if near != 0
                    && let Some(slabs) = slabs.get_or_insert_with(
                        #[inline(always)]
                        || volume.slabs::<N>(shape, margin),
                    )
                {
                    near = within_slabs(kernel, children, slabs, near);
                }
                path[levels] = (node, near);
                levels += 1;
            }
            Link::Leaf { .. } => {
                let probe = <Shapes as PrimitivePair<Q>>::probe(shape, margin);
                for index in next.primitives() {
                    stats.primitive_pairs += 1;
                    let item = tree.primitive(index);
                    let is_near = if margin > 0.0 {
                        <Shapes as PrimitivePair<Q>>::within(shape, &item, margin, &mut stats.exact_pairs)
                    } else {
                        <Shapes as PrimitivePair<Q>>::meets(&probe, &item, &mut stats.exact_pairs)
                    };
                    if is_near && visit(index).is_break() {
                        return Completion::Stopped;
                    }
                }
            }
        }
        loop {
            let Some(level) = levels.checked_sub(1) else { return Completion::Complete };
            let (node, near) = path[level];
            if near == 0 {
                levels = level;
                continue;
            }
            path[level].1 = near & (near - 1);
            next = tree.nodes()[node as usize].children()[near.trailing_zeros() as usize].link();
            break;
        }
    }
}

#[inline(always)]
fn nearest<N: Lanes, Q: Primitive, B: ChildBounds<N>>(
    budget: u64,
    shape: &Shape,
    bounds: &B,
    tree: &BvhRef<'_, N, Q>,
    (tolerance, cutoff): (f64, f64),
    stats: &mut QueryStats,
) -> NearestPrimitive
where
    Shapes: PrimitivePair<Q>,
{
    let mut path = [(0_u32, B::BLANK); MAX_DEPTH];
    let (mut levels, mut next) = (0, root(tree));
    let mut best = NearestPrimitive { lower: cutoff, found: None, is_complete: true };
    // Primitives with bounds above `most` cannot improve the answer by more than the tolerance.
    let (mut limit, mut most, mut dropped) = (cutoff, bounds.limit(cutoff), f64::INFINITY);
    loop {
        match next {
            Link::Empty => {}
            Link::Inner(node) => {
                if stats.visits == budget {
                    return NearestPrimitive { lower: 0.0, is_complete: false, ..best };
                }
                stats.visits += 1;
                path[levels] = (node, bounds.pending(&tree.nodes()[node as usize]));
                levels += 1;
            }
            Link::Leaf { .. } => {
                for index in next.primitives() {
                    stats.primitive_pairs += 1;
                    let (item, exact) = (tree.primitive(index), &mut stats.exact_pairs);
                    let found = <Shapes as PrimitivePair<Q>>::nearer(shape, &item, limit, tolerance, exact);
                    let Some(found) = found else { continue };
                    best.lower = best.lower.min(found.lower);
                    if best.found.is_none_or(|(_, nearest)| found.upper < nearest.upper)
                        && found.upper <= cutoff
                    {
                        (limit, best.found) = (found.upper.min(cutoff), Some((index, found)));
                        most = bounds.limit(limit / (1.0 + tolerance));
                        if found.upper == 0.0 {
                            return NearestPrimitive { lower: 0.0, ..best };
                        }
                    }
                }
            }
        }
        loop {
            let Some(level) = levels.checked_sub(1) else {
                return NearestPrimitive { lower: best.lower.min(bounds.distance(dropped)), ..best };
            };
            let (node, pending) = &mut path[level];
            let Some((lane, bound)) = bounds.take_nearest(pending) else {
                levels = level;
                continue;
            };
            if bound > most {
                // All other children of this node are at least as far.
                dropped = dropped.min(bound);
                levels = level;
                continue;
            }
            next = tree.nodes()[*node as usize].children()[lane].link();
            break;
        }
    }
}
