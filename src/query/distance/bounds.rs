//! Lower bounds of the distances between volumes: along all directions if the bodies are near, or along one line
//! ([`Axis`]) if they are far apart.
//!
//! Bounds are `f32` in the order of the distances: squared distances for near bodies, and for far ones, distances
//! relative to that of the centres. The unit is that of the larger body's frame.

use super::axis::Axis;
use super::steps;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::{BodyBounds, Frame};
use crate::hierarchy::BvhRef;
use crate::kernel::Kernel;
use crate::node::{Child, Link};
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::entry::QueryStats;
use crate::query::lanes::{Lanes, growth};
use crate::realign::shrinkage;
use crate::vector::sqrt;

/// Number of nodes of A whose rotated planes are kept: the last on each level, modulo this number.
const KEPT: usize = 4;

/// Exceeds the loss of squares that are too small for a normal `f32`.
const UNDERFLOW: f64 = power_of_two(-140);

/// The bounds of a query.
#[derive(Debug)]
pub(super) enum Bounds<'t, N: Lanes> {
    Near(Near<'t, N>),
    Far(Axis),
}

/// The map that rotates A's planes into B's frame, and the planes that it rotated last.
#[derive(Debug)]
pub(super) struct Near<'t, N: Lanes> {
    map: N::Map,
    /// B's frame, with the exponent of the unit.
    pub(super) frame: Frame,
    /// Converts B's planes to the unit.
    pub(super) growth: f32,
    turned: &'t mut Kept<N>,
}

/// The planes of the nodes of A that were rotated last, one for each level.
pub(super) type Kept<N> = [(Child, <N as Lanes>::PlaneRows); KEPT];

/// Bodies are of different size if the radius of one is above this multiple of the other's.
const UNLIKE: f64 = 4.0;

/// Factors that convert the widths of volumes of A and of B to a common unit. Zero for bodies of similar size, whose
/// volumes need not be compared.
#[inline(always)]
pub(super) fn growths(a: &BodyBounds, b: &BodyBounds) -> [f32; 2] {
    if a.radius > UNLIKE * b.radius || b.radius > UNLIKE * a.radius {
        let exponent = unit(a, b);
        [growth(&a.frame, exponent), growth(&b.frame, exponent)]
    } else {
        [0.0; 2]
    }
}

/// The exponent of the unit: that of the larger body's frame.
#[inline(always)]
fn unit(a: &BodyBounds, b: &BodyBounds) -> i32 {
    if a.frame.exponent < b.frame.exponent { a.frame.exponent } else { b.frame.exponent }
}

/// No rotated planes.
#[inline(always)]
pub(super) const fn no_turned<N: Lanes>() -> Kept<N> {
    [(Child::EMPTY, N::NO_PLANE_ROWS); KEPT]
}

impl<'t, N: Lanes> Bounds<'t, N> {
    /// `P` is the kind of A's primitives.
    #[inline(always)]
    pub(super) fn new<P: Primitive>(
        pose: &Pose,
        a: &BodyBounds,
        b: &BodyBounds,
        turned: &'t mut Kept<N>,
    ) -> Self {
        let exponent = unit(a, b);
        let shrinkage = shrinkage::<P>(pose, a);
        if let Some(line) = Axis::new::<N>(pose, a, b, shrinkage, exponent) {
            return Self::Far(line);
        }
        let frame = Frame { exponent, ..b.frame };
        let map = map::<N, P>(pose, a, &frame);
        Self::Near(Near { map, frame, growth: growth(&b.frame, exponent), turned })
    }

    /// The least possible bound.
    pub(super) const fn least(&self) -> f32 {
        match self {
            Self::Near(_) => 0.0,
            Self::Far(_) => f32::MIN,
        }
    }

    /// Upper bound of the `f32` bounds of volumes at this distance, which is in the bodies' unit.
    pub(super) fn of_distance(&self, distance: f64) -> f32 {
        match self {
            Self::Near(near) => {
                let scaled = distance * near.frame.scale();
                round_up_f32(scaled * scaled * (1.0 + 8.0 * f64::EPSILON) + UNDERFLOW)
            }
            Self::Far(line) => line.relative(distance),
        }
    }

    /// Lower bound of the distance of volumes with this bound, in the bodies' unit.
    pub(super) fn distance(&self, bound: f32) -> f64 {
        let distance = match self {
            Self::Near(near) if bound > 0.0 => sqrt(f64::from(bound)) / near.frame.scale(),
            Self::Near(_) => 0.0,
            Self::Far(line) => line.distance(bound),
        };
        if distance > 0.0 { distance } else { 0.0 }
    }
}

/// The map that rotates planes of A into a frame.
#[inline(always)]
fn map<N: Lanes, P: Primitive>(pose: &Pose, a: &BodyBounds, frame: &Frame) -> N::Map {
    let (mut map, shrinkage) = (N::UNMAPPED, shrinkage::<P>(pose, a));
    N::map(&mut map, pose, a, frame);
    if shrinkage > 0.0 {
        N::widen(&mut map, frame, shrinkage);
    }
    map
}

impl<N: Lanes> Near<'_, N> {
    /// Factor that converts planes in a frame to the unit.
    pub(super) fn growth_in(&self, frame: &Frame) -> f32 {
        growth(frame, self.frame.exponent)
    }

    /// The rotated planes of the children of node `a`.
    #[inline(always)]
    pub(super) fn turn<P: Primitive>(
        &mut self,
        kernel: impl Kernel,
        tree: &BvhRef<'_, N, P>,
        a: Child,
        level: u8,
        stats: &mut QueryStats,
    ) -> &N::PlaneRows {
        let (kept, rows) = &mut self.turned[usize::from(level) % KEPT];
        if *kept != a
            && let Link::Inner(node) = a.link()
        {
            stats.realignments += 1;
            *kept = a;
            steps::turn(kernel, &tree.nodes()[node as usize], &self.map, rows);
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::Node16;
    use crate::primitive::Triangles;

    /// Bounds of two balls of radius 100 in their frames, with centres `far` units of A's frame apart; B's unit is 2^20
    /// times smaller.
    fn bounds(far: f64, kept: &mut Kept<Node16<18>>) -> Bounds<'_, Node16<18>> {
        let frame = |exponent| Frame { centre: [0.0; 3], exponent };
        let body = |exponent: i32| BodyBounds {
            frame: frame(exponent),
            max_coordinate: 100.0 * power_of_two(-exponent),
            radius: 100.0 * power_of_two(-exponent),
            half_width: [100.0; 3],
            max_plane: 200.0,
        };
        let far = far * power_of_two(-3);
        let rows = [[1.0, 0.0, 0.0, 0.6 * far], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.8 * far]];
        let pose = Pose::from_rows(rows).unwrap_or(Pose::IDENTITY);
        Bounds::new::<Triangles>(&pose, &body(3), &body(23), kept)
    }

    #[test]
    fn distances_round_up_to_bounds_and_bounds_down_to_distances() {
        for far in [0.0, 300.0, 3e3, 5e3, 1e5, 1e6, 1e9, 1e15, 1e60] {
            let mut kept = no_turned::<Node16<18>>();
            let bounds = bounds(far, &mut kept);
            assert_eq!(matches!(bounds, Bounds::Far(_)), far > 2e3, "{far}");
            let mut inexact = 0;
            for i in 0..1000 {
                // In the bodies' unit, about the distance of the bodies.
                let distance = (far + f64::from(i) * 0.731) * power_of_two(-3);
                let bound = bounds.of_distance(distance);
                // The bound before it was rounded up, computed in `f64`.
                let (exact, rounding) = match &bounds {
                    Bounds::Near(_) => ((8.0 * distance) * (8.0 * distance), 1e-15),
                    Bounds::Far(_) => (8.0 * (distance - bounds.distance(0.0)), 1e-15),
                };
                if exact > f64::from(f32::MAX) {
                    assert_eq!(bound, f32::INFINITY, "{far} {i}: nothing is known to be farther");
                    continue;
                }
                let difference = f64::from(bound) - exact;
                let allowed = rounding * exact.abs() + 1e-12 * far;
                assert!(difference >= -allowed, "{far} {i}: {bound:e} is below {exact:e}");
                assert!(difference <= 2e-7 * exact.abs() + allowed + 1e-40, "{far} {i}: {bound:e} {exact:e}");
                inexact += u32::from(difference > 1e-9 * exact);
                let back = bounds.distance(bound);
                let coarse = if let Bounds::Near(_) = &bounds { 1e-7 } else { 1e-12 };
                let allowed = 1e-6 * (f64::from(i) + 1.0) + coarse * distance;
                assert!((back - distance).abs() <= allowed, "{far} {i}: {back:e}");
                if i > 0 {
                    let below = bounds.distance(bound.next_down());
                    assert!(below <= distance, "{far} {i}: {below:e} is above {distance:e}");
                }
            }
            assert!(inexact > 500 || far > 1e8, "{far}: {inexact}");
        }
    }
}
