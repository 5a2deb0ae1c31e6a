//! The leaf of A that is pending while B is traversed: its moved primitives, and data computed from them once.

use super::axis::Axis;
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::node::{Child, Link, MAX_LEAF_SIZE};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::lanes::Lanes;
use crate::query::setup::{Ahead, LookAhead};
use crate::range::Point;

const MANY: usize = MAX_LEAF_SIZE as usize;

/// A leaf of A, moved by the pose.
#[derive(Debug)]
pub(super) struct LeafA<N: Lanes, P: Primitive> {
    leaf: Child,
    moved: [P::Item; MANY],
    /// Planes of [`LeafA::leaf`], valid if `is_bounded`. For bodies far apart, `reach` is valid instead.
    planes: N::Planes,
    reach: f32,
    is_bounded: bool,
}

impl<N: Lanes, P: Primitive> LeafA<N, P> {
    pub(super) fn none() -> Self {
        let moved = [P::Item::default(); MANY];
        Self { leaf: Child::EMPTY, moved, planes: N::NO_PLANES, reach: 0.0, is_bounded: false }
    }

    /// The leaf's moved primitives; none if `leaf` is not a leaf.
    #[inline(always)]
    pub(super) fn items(&mut self, a: &BvhRef<'_, N, P>, pose: &Pose, leaf: Child) -> &[P::Item] {
        let Link::Leaf { first, count } = leaf.link() else { return &[] };
        if self.leaf != leaf {
            for (item, index) in self.moved.iter_mut().zip(first..first + count) {
                *item = P::moved(&a.primitive(index), pose);
            }
            (self.leaf, self.is_bounded) = (leaf, false);
        }
        &self.moved[..count as usize]
    }

    /// Its planes in B's frame. `reach` bounds all coordinates.
    #[inline(always)]
    pub(super) fn planes(
        &mut self,
        a: &BvhRef<'_, N, P>,
        b: &Frame,
        pose: &Pose,
        leaf: Child,
        reach: f64,
    ) -> &N::Planes {
        let _ = self.items(a, pose, leaf);
        if !self.is_bounded
            && let Link::Leaf { count, .. } = leaf.link()
        {
            self.planes = N::planes_of::<P>(b, &self.moved[..count as usize], reach);
            self.is_bounded = true;
        }
        &self.planes
    }

    /// Its support towards B, for bodies far apart.
    #[inline(always)]
    pub(super) fn reach(
        &mut self,
        a: &BvhRef<'_, N, P>,
        b: &Frame,
        pose: &Pose,
        leaf: Child,
        line: &Axis,
    ) -> f32 {
        let _ = self.items(a, pose, leaf);
        if !self.is_bounded
            && let Link::Leaf { count, .. } = leaf.link()
        {
            self.reach = line.reach::<P>(b, &self.moved[..count as usize]);
            self.is_bounded = true;
        }
        self.reach
    }
}

/// Pairs that are farther apart than this are dropped.
#[derive(Copy, Clone, Debug)]
pub(super) struct Threshold {
    /// In the bodies' unit.
    pub(super) distance: f64,
    /// The same as a bound of volumes, rounded up.
    pub(super) bound: f32,
    pub(super) ahead: Ahead,
}

impl Threshold {
    /// [`LookAhead::look_along`], with this threshold.
    #[inline(always)]
    pub(super) fn look_along(&mut self, closest: [Point; 2], reach: f64) {
        self.ahead.look_along(closest, self.distance, reach);
    }
}
