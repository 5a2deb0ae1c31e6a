//! Culls pairs of primitives by one axis, along which they are certainly farther apart than the query's threshold.

use crate::exact::power_of_two;
use crate::isa::Scalar;
use crate::primitive::{Primitive, radius_of};
use crate::query::entry::PrimitivePair;
use crate::range::Point;

/// A cheap test of two primitives before they are compared.
pub(in crate::query) trait LookAhead: Copy {
    /// Culls nothing.
    const NOTHING: Self;

    /// Whether the two are certainly farther apart than the threshold.
    fn is_far<P: Primitive, Q: Primitive>(&self, a: &P::Item, b: &Q::Item) -> bool;

    /// Sets the axis to the line through the closest points of two primitives, since it separates most other pairs,
    /// too. Pairs that are farther apart than `threshold` may be culled. `reach` bounds all coordinates.
    fn look_along(&mut self, closest: [Point; 2], threshold: f64, reach: f64);
}

/// Without a margin the exact test is as fast as a cull.
impl LookAhead for () {
    const NOTHING: Self = ();

    #[inline(always)]
    fn is_far<P: Primitive, Q: Primitive>(&self, _: &P::Item, _: &Q::Item) -> bool {
        false
    }

    #[inline(always)]
    fn look_along(&mut self, _: [Point; 2], _: f64, _: f64) {}
}

/// Culls most pairs of primitives by one axis: that of the best pair so far, or with a margin, of the pair compared
/// last.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) struct Ahead {
    /// From B to A, not normalised.
    axis: Point,
    /// Pairs with a gap above this along the axis are culled. Infinite if there is no axis.
    limit: f64,
    /// Upper bound of the axis's length: a radius extends this many times as far along the axis.
    length: f64,
}

/// The squared length of an axis above this loses nothing to underflow.
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
            // Two products of axis and corner and their difference: 8 roundings of at most `reach` times the axis's
            // magnitudes. Radii take 4 more.
            let rounding = power_of_two(-49) * reach * ((x.abs() + y.abs()) + z.abs());
            let length = glam::DVec3::from_array(axis).length();
            let longer = 1.0 + power_of_two(-48);
            Self { axis, limit: (threshold * length + rounding) * longer, length: length * longer }
        } else {
            Self::NOTHING
        };
    }
}

/// Whether a primitive of the query's A and one of its B are at most the margin apart. If not, their closest points
/// give the next axis, unless `reach` is 0.
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

// Not inlined: it would enlarge the caller's stack frame.
#[inline(never)]
fn look_between<P: PrimitivePair<Q>, Q: Primitive, L: LookAhead>(
    a: &P::Item,
    b: &Q::Item,
    (margin, reach, ahead): (f64, f64, &mut L),
    exact: &mut u64,
) {
    if let Some(pair) = P::nearer_on(Scalar::new(), a, b, f64::INFINITY, 1.0, exact) {
        ahead.look_along([pair.a, pair.b], margin, reach);
    }
}
