//! Whether two triangles meet, from their corners on a lattice: in integers and `f32`, for cores without `f64`. Decides
//! nearly all pairs.
//!
//! Like the exact test ([`super`]), it compares sides of planes and then intervals, each with an error bound. A
//! difference of two corners is off by less than [`OFF`] steps: at most [`OFF_MOVED`] for each of the two. Its
//! conversion to `f32` adds a relative error of u = 2^-24. Let x and y be the triangle's edges and z the vector to a
//! point, as on the lattice. Let S(x) be the sum of the magnitudes of x, plus three times [`OFF`]. Then the determinant
//! is off by at most
//!
//! | source | at most |
//! |---|---|
//! | where the corners really are | `OFF (S(x) S(y) + S(x) S(z) + S(y) S(z))` |
//! | three conversions to `f32`, and five roundings of each of six products of three | `8.1 u S(x) S(y) S(z)` |
//!
//! The first row is the growth of a product of three sums that each grow by less than [`OFF`] on each axis: with `s`
//! the sums of magnitudes alone, `OFF (s s + s s + s s) + 2 OFF^2 (s + s + s) + 6 OFF^3`. The bound takes 9 steps
//! instead of 8 and 12 u instead of 8.1 u, for its own dozen roundings, and for the following.
//!
//! **What is certain here, the `f64` filter decides too, with the same result.** A determinant beyond the bound truly
//! exceeds u times the product of the sums, which is at least its permanent; the `f64` filter needs 2^-49 of that. So
//! the query statistics do not depend on which of the two decided. This also holds where the verdict takes several
//! signs: the exact test needs no integers for any sign computed here. It computes no other signs, or ends earlier
//! because the bounding boxes are disjoint, and then the triangles are too.

use super::interval::Wedge;
use super::sides::separated;
use crate::primitive::lattice::{LatticeCorners, OFF_MOVED};

/// Upper bound, in steps, of the error of a difference of two coordinates, plus one step for roundings.
const OFF: f32 = (2 * OFF_MOVED + 1) as f32;

/// Relative to the product of three sums of magnitudes.
const ROUNDINGS: f32 = 12.0 / (1 << 24) as f32;

/// A triangle on a lattice, to test against others.
#[derive(Debug)]
pub(crate) struct LatticeProbe<'t> {
    corners: &'t LatticeCorners,
    normal: [f32; 3],
    /// A determinant is off by at most `constant`, plus this times the sum of magnitudes of the vector to the point.
    per_length: f32,
    constant: f32,
}

impl<'t> LatticeProbe<'t> {
    #[inline(always)]
    pub(crate) fn new(corners: &'t LatticeCorners) -> Self {
        let [x, y] = [way(&corners[0], &corners[1]), way(&corners[0], &corners[2])];
        let (sum_x, sum_y) = (sum(&x) + 3.0 * OFF, sum(&y) + 3.0 * OFF);
        let product = sum_x * sum_y;
        let per_length = ROUNDINGS * product + OFF * (sum_x + sum_y);
        Self {
            corners,
            normal: [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]],
            per_length,
            constant: OFF * product + per_length * (3.0 * OFF),
        }
    }

    /// 1 or -1 if the point is certainly on that side of the plane, else 0.
    #[inline(always)]
    fn side(&self, p: &[i32; 3]) -> i8 {
        let (z, n) = (way(&self.corners[0], p), &self.normal);
        let determinant = (n[0] * z[0] + n[1] * z[1]) + n[2] * z[2];
        let bound = self.constant + self.per_length * sum(&z);
        i8::from(determinant > bound) - i8::from(determinant < -bound)
    }

    #[inline(never)]
    fn sides(&self, of: &LatticeCorners) -> [i8; 3] {
        [self.side(&of[0]), self.side(&of[1]), self.side(&of[2])]
    }

    /// Whether the triangles meet; `None` if not certain.
    #[inline(never)]
    pub(crate) fn meets(&self, other: &LatticeCorners) -> Option<bool> {
        let of_other = self.sides(other);
        if separated(of_other) {
            return Some(false);
        }
        let of_self = LatticeProbe::new(other).sides(self.corners);
        if separated(of_self) {
            return Some(false);
        }
        if of_other.contains(&0) || of_self.contains(&0) {
            return None;
        }
        let (a, b) = (Wedge::new(self.corners, of_self), Wedge::new(other, of_other));
        let side = |left: &[i32; 3], right: &[i32; 3]| {
            a.up * b.up * LatticeProbe::new(&[a.apex, *left, b.apex]).side(right)
        };
        match side(&a.left, &b.left) {
            0 => None,
            1 => Some(false),
            _ => match side(&a.right, &b.right) {
                0 => None,
                side => Some(side > 0),
            },
        }
    }
}

#[inline(always)]
fn way(from: &[i32; 3], to: &[i32; 3]) -> [f32; 3] {
    let along = |i: usize| to[i].wrapping_sub(from[i]) as f32;
    [along(0), along(1), along(2)]
}

#[inline(always)]
fn sum(x: &[f32; 3]) -> f32 {
    (x[0].abs() + x[1].abs()) + x[2].abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;
    use crate::primitive::lattice::Lattice;
    use crate::primitive::triangle::sides::Signs;
    use crate::primitive::triangle::{Probe, Triangle};
    use crate::range::Point;
    use crate::rng::Rng;

    /// A triangle at a pose, and its corners on the lattice.
    fn moved(t: &Triangle, pose: &Pose, lattice: &Lattice) -> (Triangle, LatticeCorners) {
        (t.map(|p| pose.apply(p)), t.map(|p| lattice.moved(lattice.double(&p))))
    }

    fn turn(rng: &mut Rng) -> Pose {
        let axis = [0, 1, 2].map(|_| rng.range(-1.0, 1.0));
        let length = crate::vector::length(&axis);
        Pose::turn(&axis.map(|x| x / length), rng.range(-3.2, 3.2))
            .shifted(&[0, 1, 2].map(|_| rng.range(-1.0, 1.0)))
    }

    fn triangle(rng: &mut Rng, at: &Point, size: f64) -> Triangle {
        [0, 1, 2].map(|_| at.map(|x| x + rng.range(-size, size)))
    }

    // Points a few steps from the plane of a triangle, whose size ranges from a few steps to that of the body. For some
    // of them the lattice alone would give the wrong side.
    #[test]
    fn sides_are_those_of_moved_corners() {
        let mut rng = Rng::new(4711);
        let (mut certain, mut wrong) = (0, 0);
        for round in 0..200_000 {
            let pose = turn(&mut rng);
            let lattice = Lattice::new(&pose, 1.0, 3.0).unwrap();
            let step = crate::exact::power_of_two(-lattice.exponent);
            let size = step * crate::exact::power_of_two([4, 8, 16, 22][round % 4]);
            let at = [0, 1, 2].map(|_| rng.range(-0.5, 0.5));
            let (t, corners) = moved(&triangle(&mut rng, &at, size), &pose, &lattice);
            let (v, w) = (rng.range(-2.0, 2.0), rng.range(-2.0, 2.0));
            let near = step * rng.range(0.0, 100.0);
            let p: Point = [0, 1, 2].map(|i| {
                let inside = t[0][i] + v * (t[1][i] - t[0][i]) + w * (t[2][i] - t[0][i]);
                inside + rng.range(-near, near)
            });
            let on_lattice = lattice.double(&p);
            let mut signs = Signs { exact: false };
            let (side, truth) = (LatticeProbe::new(&corners).side(&on_lattice), signs.side(&t, &p));
            if side != 0 {
                assert_eq!(side, truth, "{t:?} {p:?}");
                assert!(!signs.exact, "the filter in f64 decides it: {t:?} {p:?}");
                certain += 1;
            }
            wrong += i32::from(i32::from(truth) * sign_of(&corners, &on_lattice) < 0);
        }
        assert!(certain > 2000 && wrong > 1000, "{certain} {wrong}");
    }

    /// The exact side of a point, for corners and a point exactly on the lattice.
    fn sign_of(corners: &LatticeCorners, p: &[i32; 3]) -> i32 {
        let [x, y, z] = [&corners[1], &corners[2], p]
            .map(|p| [0, 1, 2].map(|i| i128::from(p[i]) - i128::from(corners[0][i])));
        let minor = |i: usize, j: usize| x[i] * y[j] - x[j] * y[i];
        (minor(1, 2) * z[0] + minor(2, 0) * z[1] + minor(0, 1) * z[2]).signum() as i32
    }

    // Corners as far apart as possible, where the rounding of `f32` exceeds the error of the corners.
    #[test]
    fn sides_are_right_in_spite_of_roundings() {
        let mut rng = Rng::new(99);
        let (mut certain, mut wrong) = (0, 0);
        for _ in 0..200_000 {
            let most = f64::from(1 << 27);
            let t: Triangle = [0, 1, 2].map(|_| [0, 1, 2].map(|_| rng.range(-most, most)));
            let corners: LatticeCorners = t.map(|p| p.map(|x| x as i32));
            let (v, w) = (rng.range(-0.5, 1.0), rng.range(-0.5, 1.0));
            let p = [0, 1, 2].map(|i| {
                let inside = t[0][i] + v * (t[1][i] - t[0][i]) + w * (t[2][i] - t[0][i]);
                (inside + rng.range(-400.0, 400.0)) as i32
            });
            let probe = LatticeProbe::new(&corners);
            let (side, truth) = (i32::from(probe.side(&p)), sign_of(&corners, &p));
            assert!(side == 0 || side == truth, "{corners:?} {p:?}");
            certain += side.abs();
            // The corners are exactly on the lattice, so the allowance for rounding suffices.
            let [x, y] = [way(&corners[0], &corners[1]), way(&corners[0], &corners[2])];
            let rounded =
                LatticeProbe { per_length: ROUNDINGS * (sum(&x) * sum(&y)), constant: 0.0, ..probe };
            let side = i32::from(rounded.side(&p));
            assert!(side == 0 || side == truth, "without a pad for where corners are: {corners:?} {p:?}");
            let unpadded = LatticeProbe { per_length: 0.0, constant: 0.0, ..probe };
            wrong += i32::from(i32::from(unpadded.side(&p)) * truth < 0);
        }
        assert!(certain > 5000 && wrong > 300, "{certain} {wrong}");
    }

    #[test]
    fn verdicts_are_exact_and_most_are_certain() {
        let mut rng = Rng::new(815);
        let (mut free, mut hits, mut unknown) = (0, 0, 0);
        for round in 0..200_000 {
            let pose = turn(&mut rng);
            let lattice = Lattice::new(&pose, 1.0, 3.0).unwrap();
            let size = [0.3, 1e-3, 1e-5, 2e-7][round % 4];
            let at = [0, 1, 2].map(|_| rng.range(-0.5, 0.5));
            let (a, on_a) = moved(&triangle(&mut rng, &at, size), &pose, &lattice);
            let b = triangle(&mut rng, &a[0], size);
            let on_b = b.map(|p| lattice.double(&p));
            let mut exact = 0;
            let truth = Probe::new(&a).overlaps(&b, &mut exact);
            let verdicts = [LatticeProbe::new(&on_a).meets(&on_b), LatticeProbe::new(&on_b).meets(&on_a)];
            for verdict in verdicts {
                match verdict {
                    None => unknown += usize::from(round % 4 < 2),
                    Some(verdict) => {
                        assert_eq!(verdict, truth, "{a:?} {b:?}");
                        assert_eq!(exact, 0, "{a:?} {b:?}");
                        *if truth { &mut hits } else { &mut free } += 1;
                    }
                }
            }
        }
        assert!(free > 100_000 && hits > 20_000 && unknown < 5000, "{free} {hits} {unknown}");
    }
}
