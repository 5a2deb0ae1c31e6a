//! Penetration depths of single primitives.
//!
//! A translation that separates two bodies separates each primitive of one from each primitive of the other. So the
//! depth of any two primitives is a lower bound of the bodies' depth, whether or not these are solid. The depth of
//! spheres and shapes is known, since they are convex. A triangle has a depth in them, too, which is small for a small
//! triangle.

use crate::exact::power_of_two;
use crate::primitive::shape::{Core, Depth};
use crate::primitive::{Primitive, Shape, Shapes, radius_of};
use crate::query::entry::PrimitivePair;
use crate::range::Point;
use crate::vector::{difference, dot, unit};
use core::ops::ControlFlow;

/// The deepest pair of primitives offered so far, by their indices in leaf order.
#[derive(Copy, Clone, Debug)]
pub(super) struct DeepestPrimitives {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) depth: Depth,
    /// Number of depths that were computed.
    pub(super) computed: u64,
    offered: u32,
}

/// Maximum number of offers in a search that need not see all pairs.
const MOST_OFFERS: u32 = 256;

impl DeepestPrimitives {
    pub(super) const fn new() -> Self {
        Self {
            a: 0,
            b: 0,
            depth: Depth { lower: 0.0, upper: 0.0, direction: [0.0; 3] },
            computed: 0,
            offered: 0,
        }
    }

    /// Keeps two primitives, in one frame, if they are deeper in each other than the current pair.
    pub(super) fn offer<P: PrimitivePair<Q>, Q: Primitive>(
        &mut self,
        (a, item): (u32, &P::Item),
        (b, other): (u32, &Q::Item),
    ) {
        self.offered += 1;
        if at_most::<P, Q>(item, other) <= self.depth.lower {
            return;
        }
        self.computed += 1;
        let depth = P::depth(item, other);
        if depth.lower > self.depth.lower {
            (self.a, self.b, self.depth) = (a, b, depth);
        }
    }

    /// Breaks after [`MOST_OFFERS`].
    pub(super) const fn go_on(&self) -> ControlFlow<()> {
        if self.offered < MOST_OFFERS { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

/// A point that is likely to be inside the surface that a primitive belongs to: the primitive's nearest point to
/// `other`, moved by `share` times the depth along the depth's direction.
pub(super) fn beneath<P: Primitive>(other: &Point, item: &P::Item, depth: &Depth, share: f64) -> Option<Point>
where
    Shapes: PrimitivePair<P>,
{
    let point = Shape::unchecked(Core::Point(*other), 0.0);
    let nearest = <Shapes as PrimitivePair<P>>::nearer(&point, item, f64::INFINITY, NEAR, &mut 0)?;
    Some(core::array::from_fn(|i| nearest.b[i] + share * depth.lower * depth.direction[i]))
}

/// Tolerance of the nearest point of a surface.
const NEAR: f64 = power_of_two(-10);

/// The middle of a primitive's corners.
pub(super) fn middle<P: Primitive>(item: &P::Item) -> Point {
    let (sum, count) = P::corners(item).fold(([0.0; 3], 0.0), |(sum, count): (Point, f64), p| {
        (core::array::from_fn(|i| sum[i] + p[i]), count + 1.0)
    });
    sum.map(|x| x / count)
}

/// Upper bound of the depth: the length of a separating translation along the line through the middles, up to rounding.
fn at_most<P: Primitive, Q: Primitive>(a: &P::Item, b: &Q::Item) -> f64 {
    let Some(along) = unit(&difference(&middle::<P>(a), &middle::<Q>(b))) else { return f64::INFINITY };
    let lowest = P::corners(a).map(|p| dot(&along, &p)).fold(f64::INFINITY, f64::min);
    let highest = Q::corners(b).map(|p| dot(&along, &p)).fold(f64::NEG_INFINITY, f64::max);
    (highest + radius_of::<Q>(b)) - (lowest - radius_of::<P>(a))
}
