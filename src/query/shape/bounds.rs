//! The volume of a shape in the frame of a tree, and lower bounds of its distance from a node's children.

use crate::exact::power_of_two;
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::Child;
use crate::primitive::shape::{Core, hull_of};
use crate::primitive::{Primitive, Shape, Shapes};
use crate::query::lanes::{Along, Lanes, used_lanes};
use crate::range::Point;
use crate::vector::{difference, dot, length};

/// A shape that is farther from the centre of a tree than this many of the tree's radii is bounded along one axis.
const FAR: f64 = power_of_two(11);
/// A shape that is larger than this many of the tree's radii, likewise.
const LARGE: f64 = power_of_two(40);
/// Allowance for roundings in `f64`, relative to the coordinates.
const ROUNDING: f64 = power_of_two(-45);

/// What bounds a shape.
#[derive(Debug)]
pub(super) enum Volume<N: Lanes> {
    /// Its k-DOP.
    Dop {
        /// As `f32`, for distances.
        planes: N::Planes,
        frame: Frame,
    },
    /// The half-space of all points whose product with the axis is at most `end`, relative to the centre of the tree.
    HalfSpace {
        /// Supports of the tree's volumes along the opposite axis, in the unit of its frame.
        opposite: Along,
        /// In the bodies' unit, rounded up.
        end: f64,
        scale: f64,
    },
}

impl<N: Lanes> Volume<N> {
    pub(super) const fn is_half_space(shape: &Shape) -> bool {
        matches!(shape.core(), Core::HalfSpace { .. })
    }

    pub(super) fn of<Q: Primitive>(shape: &Shape, tree: &BvhRef<'_, N, Q>) -> Self {
        let bounds = tree.extent();
        let centre = bounds.frame.centre;
        if let Core::HalfSpace { normal, offset } = *shape.core() {
            let long = length(&normal);
            let axis = normal.map(|x| x / long);
            let size = offset.abs() + shape.radius() + bounds.max_coordinate;
            let end = (offset / long + shape.radius()) - dot(&axis, &centre);
            return Self::half_space(&axis, end + ROUNDING * size, &bounds);
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
                // The tree is a point beside the shape, which may be all around it.
                return Self::half_space(&[1.0, 0.0, 0.0], f64::INFINITY, &bounds);
            }
            let axis = away.map(|x| x / distance);
            let support =
                corners.map(|p| dot(&axis, &difference(&p, &centre))).fold(f64::NEG_INFINITY, f64::max);
            let end = (support + radius) + ROUNDING * (size + bounds.max_coordinate);
            return Self::half_space(&axis, end, &bounds);
        }
        let planes = N::planes_of::<Shapes>(&bounds.frame, &[*shape], size + bounds.max_coordinate);
        Self::Dop { planes, frame: bounds.frame }
    }

    fn half_space(axis: &Point, end: f64, bounds: &BodyBounds) -> Self {
        let opposite = N::along(axis.map(|x| -x), bounds, bounds.frame.exponent);
        Self::HalfSpace { opposite, end, scale: bounds.frame.scale() }
    }

    /// The planes of everything within a margin of the shape, for the kernels. Not used by half-spaces.
    #[inline(always)]
    pub(super) fn aim(&self, aimed: &mut N::Aimed, shape: &Shape, margin: f64) {
        if let Self::Dop { frame, .. } = self {
            N::aim::<Shapes>(aimed, frame, core::iter::once(*shape), margin);
        }
    }

    /// The children that may be within the margin for which the volume was aimed.
    #[inline(always)]
    pub(super) fn near<E: Kernel>(&self, kernel: E, node: &N, aimed: &N::Aimed, margin: f64) -> u16 {
        match self {
            Self::Dop { .. } => node.overlap_aimed(kernel, aimed),
            Self::HalfSpace { .. } => {
                let mut near = used_lanes(node.children());
                for lane in 0..N::ARITY {
                    if near >> lane & 1 != 0 && self.distance_of(node, lane, 0.0) > margin {
                        near &= !(1 << lane);
                    }
                }
                near
            }
        }
    }

    /// Lower bounds of the distances of the children; infinite for unused lanes.
    #[inline(always)]
    pub(super) fn distances(&self, node: &N) -> [f64; 16] {
        let mut distances = [f64::INFINITY; 16];
        match self {
            Self::Dop { planes, frame } => {
                for entry in node.gaps_of_planes(planes, 1.0) {
                    if entry != crate::query::lanes::Entry::NONE {
                        let square = f64::from(entry.bound());
                        distances[entry.lane()] =
                            if square > 0.0 { libm::sqrt(square) / frame.scale() } else { 0.0 };
                    }
                }
            }
            Self::HalfSpace { .. } => {
                for (lane, child) in node.children().iter().enumerate() {
                    if *child != Child::EMPTY {
                        distances[lane] = self.distance_of(node, lane, 0.0);
                    }
                }
            }
        }
        distances
    }

    /// Lower bound of the distance of child `lane` from a half-space.
    fn distance_of(&self, node: &N, lane: usize, least: f64) -> f64 {
        let Self::HalfSpace { opposite, end, scale } = self else { return least };
        let nearest = -f64::from(node.reach_along(opposite, lane)) / scale;
        // The sum of two numbers of any size: its rounding is relative to them.
        let gap = (nearest - end) - ROUNDING * (nearest.abs() + end.abs());
        if gap > least { gap } else { least }
    }

    /// An upper bound of the distance of the shape from some primitive.
    #[cold]
    pub(super) fn farthest<Q: Primitive>(&self, shape: &Shape, tree: &BvhRef<'_, N, Q>) -> f64 {
        if Self::is_half_space(shape) || tree.is_empty() {
            return f64::INFINITY;
        }
        let between = difference(&Q::point(&tree.primitive(0)), &Shapes::point(shape));
        length(&between) * (1.0 + 8.0 * f64::EPSILON)
    }
}
