//! The volume of a shape in the frame of a tree, and lower bounds of its distance from a node's children.
//!
//! The k-DOP of a large or flat cuboid that is rotated against the tree contains much besides the cuboid. So cuboids,
//! cylinders and cones also have slabs along their own directions ([`crate::realign::primitive_slabs`]).

use crate::exact::power_of_two;
use crate::frame::BodyBounds;
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::Child;
use crate::primitive::shape::{Core, hull_of};
use crate::primitive::{Primitive, Shape, Shapes};
use crate::query::lanes::{Along, Entries, Entry, Lanes, PrimitiveGaps, least, remove, used_lanes};
use crate::range::Point;
use crate::realign::PrimitiveSlabs;
use crate::vector::{difference, dot, length, sqrt};

/// A shape that is farther from the centre of a tree than this many of the tree's radii is bounded along one axis.
const FAR: f64 = power_of_two(11);
/// So is a shape that is larger than this many of the tree's radii.
const LARGE: f64 = power_of_two(40);
/// Allowance for roundings in `f64`, relative to the coordinates.
const ROUNDING: f64 = power_of_two(-45);

/// The volume of a shape.
#[derive(Debug)]
pub(super) enum Volume {
    /// Its k-DOP in the frame of a tree.
    Dop {
        body: BodyBounds,
        /// Bounds the coordinates of both.
        reach: f64,
    },
    /// The half-space of all points whose product with the axis is at most `end`, relative to the centre of the tree.
    HalfSpace {
        /// Supports of the tree's volumes along the opposite axis, in the unit of the tree's frame.
        opposite: Along,
        /// In the bodies' unit, rounded up.
        end: f64,
        scale: f64,
    },
}

/// Lower bounds of the distances of a node's children.
pub(super) trait ChildBounds<N> {
    /// The bounds of the children of a node that are still to be visited.
    type Pending: Copy;
    /// Initial value, to be overwritten.
    const BLANK: Self::Pending;

    fn pending(&self, node: &N) -> Self::Pending;

    /// Takes the nearest of the children: its lane and its bound. `None` if none is left.
    fn take_nearest(&self, pending: &mut Self::Pending) -> Option<(usize, f64)>;

    /// Children whose bounds are greater are farther than `distance`, which is not negative.
    fn limit(&self, distance: f64) -> f64;

    /// The lower bound of a distance, from a bound.
    fn distance(&self, bound: f64) -> f64;
}

/// Those of a shape whose volume is a k-DOP.
#[derive(Debug)]
pub(super) struct DopBounds<N: Lanes> {
    planes: N::Planes,
    /// Gaps along the shape's own directions.
    own: Option<PrimitiveGaps>,
    scale: f64,
}

/// Those of a half-space, from its volume.
#[derive(Debug)]
pub(super) struct HalfSpaceBounds<'v>(pub(super) &'v Volume);

const fn has_directions(shape: &Shape) -> bool {
    matches!(shape.core(), Core::Cuboid { .. } | Core::Cylinder { .. } | Core::Cone { .. })
}

/// The slabs of everything within a margin of a shape along its own directions, if it has any.
#[inline(always)]
fn own_slabs<N: Lanes>(shape: &Shape, margin: f64, body: &BodyBounds) -> Option<PrimitiveSlabs> {
    has_directions(shape).then(
        #[inline(always)]
        || N::primitive_slabs::<Shapes>(shape, margin, body, None),
    )
}

impl Volume {
    pub(super) fn of<N: Lanes, Q: Primitive>(shape: &Shape, tree: &BvhRef<'_, N, Q>) -> Self {
        let bounds = tree.extent();
        let centre = bounds.frame.centre;
        if let Core::HalfSpace { normal, offset } = *shape.core() {
            let long = length(&normal);
            let axis = normal.map(|x| x / long);
            let size = offset.abs() + shape.radius() + bounds.max_coordinate;
            let end = (offset / long + shape.radius()) - dot(&axis, &centre);
            return Self::half_space::<N>(&axis, end + ROUNDING * size, &bounds);
        }
        let (corners, radius) = hull_of(shape);
        let first = Shapes::point(shape);
        let (mut size, mut reach) = (radius, radius);
        for p in corners.clone() {
            size = size.max(p[0].abs().max(p[1].abs()).max(p[2].abs()) + radius);
            reach = reach.max(length(&difference(&p, &first)) + radius);
        }
        let away = difference(&centre, &first);
        let distance = length(&away);
        if distance > FAR * bounds.radius + reach || reach > LARGE * bounds.radius {
            if distance <= reach {
                // The tree is a point compared with the shape, which may surround it.
                return Self::half_space::<N>(&[1.0, 0.0, 0.0], f64::INFINITY, &bounds);
            }
            let axis = away.map(|x| x / distance);
            let support =
                corners.map(|p| dot(&axis, &difference(&p, &centre))).fold(f64::NEG_INFINITY, f64::max);
            let end = (support + radius) + ROUNDING * (size + bounds.max_coordinate);
            return Self::half_space::<N>(&axis, end, &bounds);
        }
        Self::Dop { body: bounds, reach: size + bounds.max_coordinate }
    }

    fn half_space<N: Lanes>(axis: &Point, end: f64, bounds: &BodyBounds) -> Self {
        let opposite = N::along(axis.map(|x| -x), bounds, bounds.frame.exponent);
        Self::HalfSpace { opposite, end, scale: bounds.frame.scale() }
    }

    /// The planes of everything within a margin of the shape, for the kernels. Not used by half-spaces.
    #[inline(always)]
    pub(super) fn aim<N: Lanes>(&self, aimed: &mut N::Aimed, shape: &Shape, margin: f64) {
        if let Self::Dop { body, .. } = self {
            N::aim::<Shapes>(aimed, &body.frame, core::iter::once(*shape), margin);
        }
    }

    /// The slabs of everything within a margin of the shape along its own directions, if it has any.
    #[inline(always)]
    pub(super) fn slabs<N: Lanes>(&self, shape: &Shape, margin: f64) -> Option<PrimitiveSlabs> {
        match self {
            Self::Dop { body, .. } => own_slabs::<N>(shape, margin, body),
            Self::HalfSpace { .. } => None,
        }
    }

    /// The children that may be within the margin for which the volume was aimed.
    #[inline(always)]
    pub(super) fn near<N: Lanes, E: Kernel>(
        &self,
        kernel: E,
        node: &N,
        aimed: &N::Aimed,
        margin: f64,
    ) -> u16 {
        match self {
            Self::Dop { .. } => node.overlap_aimed(kernel, aimed),
            Self::HalfSpace { .. } => {
                let mut near = used_lanes(node.children());
                for lane in 0..N::ARITY {
                    if near >> lane & 1 != 0 && self.distance_of(node, lane) > margin {
                        near &= !(1 << lane);
                    }
                }
                near
            }
        }
    }

    /// Lower bound of the distance of child `lane` from a half-space.
    fn distance_of<N: Lanes>(&self, node: &N, lane: usize) -> f64 {
        let Self::HalfSpace { opposite, end, scale } = self else { return 0.0 };
        let nearest = -f64::from(node.reach_along(opposite, lane)) / scale;
        // The rounding of this sum is relative to the two numbers, which may have any size.
        let gap = (nearest - end) - ROUNDING * (nearest.abs() + end.abs());
        if gap > 0.0 { gap } else { 0.0 }
    }

    /// An upper bound of the distance of the shape from some primitive.
    #[cold]
    pub(super) fn farthest<N: Lanes, Q: Primitive>(&self, shape: &Shape, tree: &BvhRef<'_, N, Q>) -> f64 {
        if shape.is_half_space() || tree.is_empty() {
            return f64::INFINITY;
        }
        let between = difference(&Q::point(&tree.primitive(0)), &Shapes::point(shape));
        length(&between) * (1.0 + 8.0 * f64::EPSILON)
    }
}

impl<N: Lanes> DopBounds<N> {
    /// The bodies' unit and bounds of their coordinates are those of [`Volume::Dop`].
    #[inline(always)]
    pub(super) fn new(shape: &Shape, body: &BodyBounds, reach: f64) -> Self {
        let own =
            own_slabs::<N>(shape, 0.0, body).map(|slabs| PrimitiveGaps::new::<Shapes>(shape, slabs, 1.0));
        let planes = N::planes_of::<Shapes>(&body.frame, &[*shape], reach);
        Self { planes, own, scale: body.frame.scale() }
    }
}

impl<N: Lanes> ChildBounds<N> for DopBounds<N> {
    type Pending = Entries;
    const BLANK: Entries = [Entry::ZEROS; 16];

    #[inline(always)]
    fn pending(&self, node: &N) -> Entries {
        let mut entries = node.gaps_of_planes(&self.planes, 1.0);
        if let Some(own) = &self.own {
            node.raise(&mut entries, own);
        }
        entries
    }

    #[inline(always)]
    fn take_nearest(&self, pending: &mut Entries) -> Option<(usize, f64)> {
        let nearest = least(pending);
        if nearest == Entry::NONE {
            return None;
        }
        remove(pending, nearest);
        Some((nearest.lane(), f64::from(nearest.bound())))
    }

    // Bounds are squares in the unit of the frame, or negative. Comparing them takes no root, for which the next step
    // would have to wait.
    #[inline(always)]
    fn limit(&self, distance: f64) -> f64 {
        let scaled = distance * self.scale;
        (scaled * scaled) * (1.0 + power_of_two(-48))
    }

    #[inline(always)]
    fn distance(&self, bound: f64) -> f64 {
        if bound > 0.0 { sqrt(bound) / self.scale } else { 0.0 }
    }
}

impl<N: Lanes> ChildBounds<N> for HalfSpaceBounds<'_> {
    type Pending = [f64; 16];
    const BLANK: [f64; 16] = [0.0; 16];

    fn pending(&self, node: &N) -> [f64; 16] {
        let mut bounds = [f64::INFINITY; 16];
        for (lane, child) in node.children().iter().enumerate() {
            if *child != Child::EMPTY {
                bounds[lane] = self.0.distance_of(node, lane);
            }
        }
        bounds
    }

    fn take_nearest(&self, pending: &mut [f64; 16]) -> Option<(usize, f64)> {
        let lane = (1..16).fold(0, |least, lane| if pending[lane] < pending[least] { lane } else { least });
        let nearest = core::mem::replace(&mut pending[lane], f64::INFINITY);
        (nearest < f64::INFINITY).then_some((lane, nearest))
    }

    fn limit(&self, distance: f64) -> f64 {
        distance
    }

    fn distance(&self, bound: f64) -> f64 {
        bound
    }
}
