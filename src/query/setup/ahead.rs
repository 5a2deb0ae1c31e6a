//! An axis along which primitives are told apart that are farther from each other than matters.

use crate::exact::power_of_two;
use crate::primitive::{Primitive, radius_of};
use crate::query::entry::PrimitivePair;
use crate::range::Point;

/// What is asked of two primitives before they are compared.
pub(in crate::query) trait LookAhead: Copy {
    /// Tells none apart.
    const NOTHING: Self;

    /// Whether the two are certainly farther apart than matters.
    fn is_far<P: Primitive, Q: Primitive>(&self, a: &P::Item, b: &Q::Item) -> bool;

    /// From now on along the axis from one point to another: the closest ones of two primitives, where others are most often apart
    /// too. Pairs that are farther apart than `threshold` do not matter. `reach` bounds all coordinates.
    fn look_along(&mut self, closest: [Point; 2], threshold: f64, reach: f64);
}

/// Primitives that have to touch are compared as fast.
impl LookAhead for () {
    const NOTHING: Self = ();

    #[inline(always)]
    fn is_far<P: Primitive, Q: Primitive>(&self, _: &P::Item, _: &Q::Item) -> bool {
        false
    }

    #[inline(always)]
    fn look_along(&mut self, _: [Point; 2], _: f64, _: f64) {}
}

/// Tells most pairs of primitives that are too far apart to matter by one axis: that of the best pair so far, or, where one within a
/// margin is looked for, of the pair that was compared last.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) struct Ahead {
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

impl LookAhead for Ahead {
    const NOTHING: Self = Self { axis: [0.0; 3], limit: f64::INFINITY, length: 0.0 };

    #[inline(always)]
    fn is_far<P: Primitive, Q: Primitive>(&self, a: &P::Item, b: &Q::Item) -> bool {
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

    fn look_along(&mut self, [p, q]: [Point; 2], threshold: f64, reach: f64) {
        let axis = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let [x, y, z] = axis;
        let square = (x * x + y * y) + z * z;
        *self = if square > SHORT {
            // Two products of axis and corner and their difference: 8 roundings of at most `reach` times the
            // axis's magnitudes. Radii take 4 more.
            let rounding = power_of_two(-49) * reach * ((x.abs() + y.abs()) + z.abs());
            let length = glam::DVec3::from_array(axis).length();
            let longer = 1.0 + power_of_two(-48);
            Self { axis, limit: (threshold * length + rounding) * longer, length: length * longer }
        } else {
            Self::NOTHING
        };
    }
}

/// Whether a primitive of the query's A and one of its B are at most the margin apart. If not, others are from now on told apart along
/// the axis of their closest points, unless `reach` is 0.
#[inline(always)]
pub(in crate::query) fn is_near<P: PrimitivePair<Q>, Q: Primitive, L: LookAhead>(
    a: &P::Item,
    b: &Q::Item,
    (margin, reach, ahead): (f64, f64, &mut L),
    exact: &mut u64,
) -> bool {
    let is_near = P::within(a, b, margin, exact);
    if !is_near && reach > 0.0 {
        look_between::<P, Q, L>(a, b, (margin, reach, ahead), exact);
    }
    is_near
}

// Not a part of its caller, of whose stack it would take more.
#[inline(never)]
fn look_between<P: PrimitivePair<Q>, Q: Primitive, L: LookAhead>(
    a: &P::Item,
    b: &Q::Item,
    (margin, reach, ahead): (f64, f64, &mut L),
    exact: &mut u64,
) {
    if let Some(pair) = P::nearer(a, b, f64::INFINITY, 1.0, exact) {
        ahead.look_along([pair.a, pair.b], margin, reach);
    }
}
