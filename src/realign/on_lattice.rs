//! Planes of moved triangles from their corners on a lattice, in integers: where a key is certain, it is the same as in
//! `f64`.
//!
//! In `f64` ([`super::planes_of`], [`Key::above`]) a plane is computed as follows. x is the greatest support of the
//! corners about the frame's centre plus its pad, in steps of the planes. Then x plus 2^-23 of x, as an `f32`, is
//! rounded to the nearest code. In steps of the lattice, x differs from the support of the lattice's corners by less
//! than
//!
//! | source | downwards | upwards |
//! |---|---|---|
//! | corners and centre, times the sum of the direction's magnitudes | [`OFF`] | [`OFF`] |
//! | the margin, below an eighth of a step; pad and roundings in `f64`, below 2^-12 | 2^-12 | 1 + 2^-12 |
//! | 2^-23 of x, rounded to `f32` | 0 | 1.51 2^-23 of it |
//!
//! If one code is nearest to all of these numbers, it is the plane. For most triangles this holds for every plane; the
//! remaining planes of the others are computed in `f64`.

use crate::directions::{Directions, SUPPORTED, table};
use crate::frame::Frame;
use crate::key::{Key, Storage};
use crate::primitive::Primitive;
use crate::primitive::lattice::{self, LatticeCorners, OFF_MOVED, OFF_STILL};
use crate::realign::{Supports, planes_of_slab};

/// Error of a coordinate about the frame's centre, in steps.
const OFF: i32 = OFF_MOVED + OFF_STILL;

/// Binary logarithm of the number of lattice steps per plane step. With fewer, hardly any plane would be certain; more
/// do not occur for bodies of nonzero size.
const STEPS: core::ops::RangeInclusive<i32> = 5..=20;

// Coordinates about a centre are below 2.87 2^26 steps.
const _: () = {
    let mut set = 0;
    while set < SUPPORTED.len() {
        let vectors = table(SUPPORTED[set]).vectors;
        let mut j = 0;
        while j < vectors.len() {
            let [x, y, z] = vectors[j];
            assert!(x.unsigned_abs() + y.unsigned_abs() + z.unsigned_abs() <= 7, "supports are below 2^31");
            j += 1;
        }
        set += 1;
    }
};

/// Calls `put` with [`super::planes_of`] of corners on a lattice of `2^exponent` steps to the unit, moved by a pose.
/// Returns a bit for each plane that is not certain: `put` got an unspecified value for it, or for [`ALL`] was not
/// called.
// Does not return the planes, since that took as much stack again.
#[inline(always)]
pub(crate) fn planes_on_lattice<const K: usize, S: Storage>(
    b: &Frame,
    triangles: impl Iterator<Item = Option<LatticeCorners>>,
    exponent: i32,
    margin: f64,
    mut put: impl FnMut(usize, Key<S>),
) -> u32 {
    let steps = exponent - b.exponent;
    if !STEPS.contains(&steps) || lattice::logarithm(margin) + exponent > -3 {
        return ALL;
    }
    let centre = lattice::still(&b.centre, exponent);
    let mut greatest = [i32::MIN; K];
    for corners in triangles {
        let Some(corners) = corners else { return ALL };
        for p in corners {
            let [x, y, z] = [0, 1, 2].map(|i| p[i].wrapping_sub(centre[i]));
            for (s, greatest) in greatest.as_chunks_mut::<2>().0.iter_mut().enumerate() {
                let n = Directions::<K>::TABLE.vectors[2 * s].map(i32::from);
                let support = n[0]
                    .wrapping_mul(x)
                    .wrapping_add(n[1].wrapping_mul(y))
                    .wrapping_add(n[2].wrapping_mul(z));
                greatest[0] = greatest[0].max(support);
                greatest[1] = greatest[1].max(support.wrapping_neg());
            }
        }
    }
    let (half, step) = (1 << (steps - 1), f32::from_bits(((127 - steps) as u32) << 23));
    let code = |x: i32| {
        if S::IS_HALF {
            return S::around(x as f32 * step);
        }
        (x.wrapping_add(half) >> steps).clamp((!S::GREATEST).into(), S::INFINITY.into()) as i16
    };
    let mut left = 0;
    for (j, greatest) in greatest.into_iter().enumerate() {
        let [x, y, z] = Directions::<K>::TABLE.vectors[j];
        let off = OFF * i32::from(x.unsigned_abs() + y.unsigned_abs() + z.unsigned_abs()) + 1;
        let more = off + 2 + (greatest.wrapping_abs() >> 22);
        let (low, high) = (code(greatest.wrapping_sub(off)), code(greatest.wrapping_add(more)));
        put(j, Key::bounded(low));
        left |= u32::from(low != high) << j;
    }
    left
}

/// All planes of a set of directions.
pub(crate) const ALL: u32 = u32::MAX;

/// Calls `put` with [`super::planes_of`] for the slabs of the `wanted` planes, one bit each: the same operations, slab
/// by slab.
#[inline(always)]
pub(crate) fn some_planes_of<P: Primitive, const K: usize, S: Storage>(
    b: &Frame,
    items: impl Iterator<Item = P::Item>,
    margin: f64,
    wanted: u32,
    mut put: impl FnMut(usize, Key<S>),
) {
    let is_wanted = |s: usize| wanted >> (2 * s) & 3 != 0;
    // Not destructured, since that copied it.
    let supports = Supports::<K>::of_slabs::<P>(b, items, is_wanted);
    let scale = b.scale();
    for s in (0..K / 2).filter(|&s| is_wanted(s)) {
        let [ahead, behind] = planes_of_slab::<K, S>(
            s,
            [supports.least[s], supports.greatest[s]],
            supports.size,
            margin,
            scale,
        );
        put(2 * s, ahead);
        put(2 * s + 1, behind);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{Fixed, Half};
    use crate::pose::Pose;
    use crate::primitive::{Lattice, Triangles};
    use crate::range::Point;
    use crate::realign::planes_of;
    use crate::rng::{CASES_STEP, Rng};

    fn planes<const K: usize, S: Storage>(
        b: &Frame,
        corners: LatticeCorners,
        exponent: i32,
        margin: f64,
    ) -> ([Key<S>; K], u32) {
        let mut planes = [Key::<S>::LOWEST; K];
        let triangles = [Some(corners)].into_iter();
        let left = planes_on_lattice::<K, S>(b, triangles, exponent, margin, |j, plane| planes[j] = plane);
        (planes, left)
    }

    /// Checks that planes equal those of `f64`, and that at least `least` tenths of the triangles have only certain
    /// planes. The body is within 1 of its origin, and moved by `away`, up to 1 more or less, along each axis. The
    /// frame is within 1 of `centre` along each axis.
    fn same_as_in_doubles<const K: usize, S: Storage>(away: f64, centre: f64, exponent: i32, least: usize) {
        let mut rng = Rng::new(K as u64);
        let (mut certain, rounds) = (0, 100_000 / CASES_STEP);
        for _ in 0..rounds {
            let axis = [0, 1, 2].map(|_| rng.range(-1.0, 1.0));
            let length = crate::vector::length(&axis);
            let pose = Pose::turn(&axis.map(|x| x / length), rng.range(-3.2, 3.2))
                .shifted(&[0, 1, 2].map(|_| away + rng.range(-1.0, 1.0)));
            let lattice = Lattice::new(&pose, 1.0, centre.abs() + 1.0).unwrap();
            let b = Frame { centre: [0, 1, 2].map(|_| centre + rng.range(-1.0, 1.0)), exponent };
            let size = rng.range(0.0, 0.5);
            let triangle = [0, 1, 2].map(|_| [0, 1, 2].map(|_| rng.range(-size, size)));
            let corners = triangle.map(|p| lattice.moved(lattice.double(&p)));
            // As small as the margin of the inverse pose.
            let margin = if rng.range(0.0, 1.0) < 0.5 { 0.0 } else { 1e-13 };
            let moved = triangle.map(|p| pose.apply(p));
            let truth = planes_of::<Triangles, K, S>(&b, [moved].into_iter(), margin);
            let (mut found, left) = planes::<K, S>(&b, corners, lattice.exponent, margin);
            for (j, plane) in found.iter_mut().enumerate().filter(|(j, _)| left >> j & 1 != 0) {
                *plane = truth[j];
            }
            assert_eq!(found, truth, "{triangle:?} {pose:?} {b:?}");
            certain += usize::from(left == 0);
            // The remaining planes, and only those, by whole slabs.
            let mut rest = [None; K];
            let items = [moved].into_iter();
            some_planes_of::<Triangles, K, S>(&b, items, margin, left, |j, plane| rest[j] = Some(plane));
            for (j, plane) in rest.into_iter().enumerate() {
                let is_wanted = left >> (j & !1) & 3 != 0;
                assert_eq!(
                    plane,
                    is_wanted.then_some(truth[j]),
                    "{j} of {left:b}: {triangle:?} {pose:?} {b:?}"
                );
            }
        }
        assert!(certain * 10 > rounds * least, "k {K}: {certain}");
    }

    #[test]
    fn planes_are_the_same_as_in_doubles() {
        same_as_in_doubles::<6, Fixed>(0.0, 0.0, 12, 6);
        same_as_in_doubles::<18, Fixed>(0.0, 0.0, 12, 6);
        same_as_in_doubles::<32, Fixed>(0.0, 0.0, 12, 6);
        // As far from the frame as the lattice extends, where the rounding from `f64` to `f32` is tens of steps.
        same_as_in_doubles::<6, Fixed>(-2.9, 2.9, 11, 6);
        same_as_in_doubles::<18, Fixed>(-2.9, 2.9, 10, 6);
        // Half floats are coarser than steps nearly everywhere.
        same_as_in_doubles::<18, Half>(0.0, 0.0, 12, 6);
        same_as_in_doubles::<6, Half>(-2.9, 2.9, 11, 6);
    }

    /// Everything that the margin lets a triangle reach along a direction, and no more than a step beyond.
    #[test]
    fn planes_hold_what_is_within_the_margin() {
        let mut rng = Rng::new(33);
        for _ in 0..500 {
            let mut point = || [0, 1, 2].map(|_| rng.range(-1.0, 1.0));
            let (b, triangle) = (Frame { centre: point(), exponent: 12 }, [0, 1, 2].map(|_| point()));
            let margin = rng.range(0.0, 0.5);
            let planes = planes_of::<Triangles, 18, Fixed>(&b, [triangle].into_iter(), margin);
            for (j, plane) in planes.into_iter().enumerate() {
                let n = Directions::<18>::TABLE.vectors[j].map(f64::from);
                let length = crate::vector::length(&n);
                let moved =
                    |by: f64| triangle.map(|p: Point| core::array::from_fn(|i| p[i] + by / length * n[i]));
                let at = |by| planes_of::<Triangles, 18, Fixed>(&b, [moved(by)].into_iter(), 0.0)[j].code();
                assert!(at(margin * (1.0 - 1e-9)) <= plane.code(), "{j}: {margin} {triangle:?}");
                assert!(plane.code() <= at(margin * (1.0 + 1e-9)) + 1, "{j}: {margin} {triangle:?}");
            }
        }
    }

    #[test]
    fn other_scales_and_margins_are_left_to_doubles() {
        let corners = [[1 << 20; 3]; 3];
        let at = |exponent, margin| {
            let b = Frame { centre: [0.0; 3], exponent: 12 };
            planes::<18, Fixed>(&b, corners, exponent, margin)
        };
        assert!(at(24, 0.0).1 == 0 && at(24, 0.0) == at(24, 1e-9));
        assert!(at(24, 1e-6).1 == ALL && at(14, 0.0).1 == ALL && at(40, 0.0).1 == ALL);
    }
}
