//! The leaf of A that waits while B is descended: its primitives where the pose places them, and what is
//! computed from them once.

use super::Lanes;
use super::far::Axis;
use crate::exact::power_of_two;
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::node::{Child, Link, MAX_LEAF_SIZE};
use crate::pose::Pose;
use crate::primitive::{Primitive, radius_of};
use crate::range::Point;

const MANY: usize = MAX_LEAF_SIZE as usize;

/// A leaf of A at the pose.
#[derive(Debug)]
pub(super) struct LeafA<N: Lanes, P: Primitive> {
    leaf: Child,
    moved: [P::Item; MANY],
    /// Of [`LeafA::leaf`] if `is_bounded`; or `reach` is.
    planes: N::Planes,
    reach: f32,
    is_bounded: bool,
}

impl<N: Lanes, P: Primitive> LeafA<N, P> {
    pub(super) fn none() -> Self {
        let moved = [P::Item::default(); MANY];
        Self { leaf: Child::EMPTY, moved, planes: N::NO_PLANES, reach: 0.0, is_bounded: false }
    }

    /// Its primitives; none if `leaf` is not a leaf.
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

    /// B's planes are in another frame from here on.
    pub(super) const fn forget_planes(&mut self) {
        self.is_bounded = false;
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

    /// How far it reaches towards B, of bodies far apart.
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

/// No pair farther apart than this matters.
#[derive(Copy, Clone, Debug)]
pub(super) struct Threshold {
    /// In the bodies' unit.
    pub(super) distance: f64,
    /// As the bounds of volumes are, rounded up.
    pub(super) bound: f32,
    pub(super) ahead: Ahead,
}

impl Threshold {
    /// Tells pairs apart along the axis from one point to another: the closest ones of two primitives, where others are most
    /// often apart too.
    #[inline(always)]
    pub(super) fn look_along(&mut self, [p, q]: [Point; 2], reach: f64) {
        self.ahead = Ahead::new([p[0] - q[0], p[1] - q[1], p[2] - q[2]], self.distance, reach);
    }
}

/// Tells most pairs of primitives that are too far apart to matter by one axis: that of the best pair so far, or, in a search
/// for one within a margin, of the pair that was compared last.
#[derive(Copy, Clone, Debug)]
pub(super) struct Ahead {
    /// From B to A, not normalised.
    axis: Point,
    /// A is farther ahead of B along the axis than this: it does not matter. Infinite if the axis says
    /// nothing.
    limit: f64,
    /// Of the axis: by how much, times a radius, something round is nearer than its corners. At least.
    length: f64,
}

/// Axes whose square is above this lose nothing to underflow.
const SHORT: f64 = power_of_two(-800);

impl Ahead {
    pub(super) const NOTHING: Self = Self { axis: [0.0; 3], limit: f64::INFINITY, length: 0.0 };

    /// For pairs that do not matter if farther apart than `threshold`. `reach` bounds all coordinates.
    pub(super) fn new(axis: Point, threshold: f64, reach: f64) -> Self {
        let [x, y, z] = axis;
        let square = (x * x + y * y) + z * z;
        if square > SHORT {
            // Two products of axis and corner and their difference: 8 roundings of at most `reach` times the
            // axis's magnitudes. Radii take 4 more.
            let rounding = power_of_two(-49) * reach * ((x.abs() + y.abs()) + z.abs());
            let length = glam::DVec3::from_array(axis).length();
            let longer = 1.0 + power_of_two(-48);
            Self { axis, limit: (threshold * length + rounding) * longer, length: length * longer }
        } else {
            Self::NOTHING
        }
    }

    /// Whether the two are certainly farther apart than matters.
    #[inline(always)]
    pub(super) fn is_far<P: Primitive, Q: Primitive>(&self, a: &P::Item, b: &Q::Item) -> bool {
        let along = |p: Point| (self.axis[0] * p[0] + self.axis[1] * p[1]) + self.axis[2] * p[2];
        let least = |x: f64, y: f64| if x < y { x } else { y };
        let greatest = |x: f64, y: f64| if x > y { x } else { y };
        let low = P::corners(a).map(along).fold(f64::INFINITY, least);
        let high = Q::corners(b).map(along).fold(f64::NEG_INFINITY, greatest);
        if P::IS_ROUND || Q::IS_ROUND {
            let radii = radius_of::<P>(a) + radius_of::<Q>(b);
            return (low - high) - radii * self.length > self.limit;
        }
        low - high > self.limit
    }
}
