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
use crate::query::lanes::{Along, Entry, Lanes, PrimitiveGaps, used_lanes};
use crate::range::Point;
use crate::realign::PrimitiveSlabs;
use crate::vector::{difference, dot, length};

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

/// Planes of a shape whose volume is a k-DOP, for lower bounds.
#[derive(Debug)]
pub(super) struct Gaps<N: Lanes> {
    planes: N::Planes,
    /// Gaps along the shape's own directions.
    own: Option<PrimitiveGaps>,
}

const fn has_directions(shape: &Shape) -> bool {
    matches!(shape.core(), Core::Cuboid { .. } | Core::Cylinder { .. } | Core::Cone { .. })
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
            Self::Dop { body, .. } if has_directions(shape) => {
                Some(N::primitive_slabs::<Shapes>(shape, margin, body, None))
            }
            _ => None,
        }
    }

    /// The data of the shape that [`Self::bounds`] needs.
    #[inline(always)]
    pub(super) fn gaps<N: Lanes>(&self, shape: &Shape) -> Gaps<N> {
        let Self::Dop { body, reach } = self else { return Gaps { planes: N::NO_PLANES, own: None } };
        let own = self.slabs::<N>(shape, 0.0).map(|slabs| PrimitiveGaps::new::<Shapes>(shape, slabs, 1.0));
        Gaps { planes: N::planes_of::<Shapes>(&body.frame, &[*shape], *reach), own }
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

    /// Lower bounds of the children, in the order of their distances; infinite for unused lanes.
    #[inline(always)]
    pub(super) fn bounds<N: Lanes>(&self, gaps: &Gaps<N>, node: &N) -> [f64; 16] {
        let mut bounds = [f64::INFINITY; 16];
        match self {
            Self::Dop { .. } => {
                let mut entries = node.gaps_of_planes(&gaps.planes, 1.0);
                if let Some(own) = &gaps.own {
                    node.raise(&mut entries, own);
                }
                for entry in entries {
                    if entry != Entry::NONE {
                        bounds[entry.lane()] = f64::from(entry.bound());
                    }
                }
            }
            Self::HalfSpace { .. } => {
                for (lane, child) in node.children().iter().enumerate() {
                    if *child != Child::EMPTY {
                        bounds[lane] = self.distance_of(node, lane);
                    }
                }
            }
        }
        bounds
    }

    /// The lower bound of the distance for one of [`Self::bounds`].
    #[inline(always)]
    pub(super) fn distance(&self, bound: f64) -> f64 {
        match self {
            Self::Dop { body, .. } if bound > 0.0 => libm::sqrt(bound) / body.frame.scale(),
            Self::Dop { .. } => 0.0,
            Self::HalfSpace { .. } => bound,
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
