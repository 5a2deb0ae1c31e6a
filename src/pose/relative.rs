//! The pose of one body in the frame of another, from their world poses, with a bound of the rounding error.
//!
//! The world poses of A and B are `x -> R_A x + t_A` and `x -> R_B x + t_B`. In the frame of B, a point p of A is at
//! `N (R_A p + d)`, where N is the inverse of `R_B` and `d = t_A - t_B`. N is not the transpose: the matrices of
//! poses may deviate from rotations by 1e-4. All computations are in `f64`. With `u = 2^-53` and the norms of `R_A`,
//! `R_B` and N at most 1.0002, the error of each computed value is at most
//!
//! | value | error | reason |
//! |---|---|---|
//! | cofactors of `R_B` | 2.1 u per entry | two products whose magnitudes sum to at most 1.0001, and their difference |
//! | its determinant, within 5e-4 of 1 | 6.7 u | a sum of three products of a row and cofactors |
//! | N, a quotient of these | 9.9 u per entry, 30 u in norm | |
//! | `M = N R_A` | 40 u in norm | 30 u from N, and 3.1 u per entry from the sums |
//! | `t = N d` | `37 u abs(d)` | 30 u from N, 1.1 u from d, 5.3 u from the sums |
//! | [`Pose::apply`] | `8 u (abs(M) abs(p) + abs(t))`, plus [`MIN_COORDINATE`] per axis | see there |
//!
//! Hence a vertex with coordinates of at most c, as moved by `apply`, is off by less than `84 u c + 46 u abs(d)` plus
//! twice [`MIN_COORDINATE`]. Since `abs(d)` is at most 1.74 times the largest coordinate of t, the first two terms
//! together are less than 2^-46 = 128 u times the sum of c and that coordinate. Underflow is far below
//! `MIN_COORDINATE`.

use super::{Pose, PoseError};
use crate::exact::power_of_two;
use crate::range::MIN_COORDINATE;
use crate::vector::{cross, dot};

const ROUNDING: f64 = power_of_two(-46);

/// The pose of body A in the frame of body B, computed from their world poses by [`Pose::relative`].
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Relative {
    pose: Pose,
    /// The part of the error that is due to the translation, in the bodies' unit.
    error: f64,
    /// Bound of the relative change of lengths by the matrix of B.
    skew: f64,
}

impl Relative {
    /// The rounded pose of A in the frame of B.
    #[inline]
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Bound of the distance between a point of A as moved by [`Pose::apply`] with [`Relative::pose`] and its exact
    /// position in the frame of B. No coordinate of the point, in the frame of A, may exceed `max_coordinate`
    /// ([`crate::hierarchy::Header::max_coordinate`]). In the bodies' unit: about 1e-14 of the coordinates.
    #[inline]
    #[must_use]
    pub fn error(&self, max_coordinate: f64) -> f64 {
        ROUNDING * max_coordinate + self.error
    }

    /// The margin to use in a query with [`Relative::pose`], so that bodies reported free are more than `margin` apart
    /// in the world. `max_coordinate` bounds the coordinates of A, and `radii` bounds the sum of a radius of A's
    /// primitives and one of B's; it is 0 for triangles.
    ///
    /// The result adds the [error](Relative::error), and the change of lengths by the pose of B, which is only nearly
    /// a rotation.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// use glam::{DQuat, DVec3};
    /// let world_a = Pose::try_from((DQuat::from_rotation_z(0.3), DVec3::new(1.0, 2.0, 0.5)))?;
    /// // A corner of A and a corner of B coincide.
    /// let world_b = Pose::try_from((DQuat::from_rotation_x(-1.1), DVec3::new(1.0, 2.0, 0.5)))?;
    /// let a_in_b = Pose::relative(&world_a, &world_b)?;
    /// let margin = a_in_b.margin(0.0, body.view().header().max_coordinate, 0.0);
    /// let answer = Query::new(Isa::detect()).within(&body, &body, a_in_b.pose(), margin)?;
    /// assert!(answer.hit().is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline]
    #[must_use]
    pub fn margin(&self, margin: f64, max_coordinate: f64, radii: f64) -> f64 {
        (margin + self.skew * (margin + radii)) + self.error(max_coordinate)
    }
}

impl Pose {
    /// The inverse: maps `R x + t` to x, up to rounding (see [`Relative::error`]). Inverts the matrix instead of
    /// transposing it, since its rows may not be quite orthonormal.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too large, or if the inverse deviates from a rotation by more than
    /// [`Pose::TOLERANCE`], which is possible if the matrix itself is near the limit.
    pub fn inverse(&self) -> Result<Self, PoseError> {
        Ok(Self::relative(&Self::IDENTITY, self)?.pose)
    }

    /// The composition: maps x to `self(inner(x))`, up to rounding of about 1e-15 of the coordinates. Given A in the
    /// frame of B as `inner`, and B in the world as `self`, it is A in the world.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too large, or if the product deviates from a rotation by more than
    /// [`Pose::TOLERANCE`], which is possible if both matrices deviate by half as much.
    pub fn compose(&self, inner: &Self) -> Result<Self, PoseError> {
        self.after(inner).checked()
    }

    /// As [`Pose::compose`], not checked.
    #[inline]
    pub(crate) fn after(&self, inner: &Self) -> Self {
        Self { rows: product(&self.rows, &inner.rows), translation: self.unflushed(&inner.translation) }
    }

    /// The pose of A in the frame of B, from their world poses: the inverse of `world_b`, composed with `world_a`.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too large, or if the product deviates from a rotation by more than
    /// [`Pose::TOLERANCE`], which is possible if both matrices deviate by half as much.
    #[inline]
    pub fn relative(world_a: &Self, world_b: &Self) -> Result<Relative, PoseError> {
        let relative = world_b.inverted().relative(world_a, world_b);
        Ok(Relative { pose: relative.pose.checked()?, ..relative })
    }

    #[inline]
    pub(crate) fn inverted(&self) -> Inverted {
        let [p, q, r] = &self.rows;
        let (a, b, c) = (cross(q, r), cross(r, p), cross(p, q));
        let determinant = dot(p, &a);
        let along = |i: usize| [a[i] / determinant, b[i] / determinant, c[i] / determinant];
        Inverted { rows: [along(0), along(1), along(2)], skew: self.skew() }
    }

    /// Bound of the relative change of lengths by the matrix. A singular value is no farther from 1 than its square, an
    /// eigenvalue of `R transpose(R)`. The square differs from 1 by at most three times the greatest entry of `R
    /// transpose(R) - 1`.
    #[inline(always)]
    pub(crate) fn skew(&self) -> f64 {
        let m = &self.rows;
        let mut skew = SKEW_ROUNDING;
        for i in 0..3 {
            for j in 0..=i {
                let off = (dot(&m[i], &m[j]) - if i == j { 1.0 } else { 0.0 }).abs() + SKEW_ROUNDING;
                skew = if off > skew { off } else { skew };
            }
        }
        3.0 * skew
    }
}

/// Bounds the rounding error of a sum of three products of rows that are unit vectors.
const SKEW_ROUNDING: f64 = power_of_two(-46);

/// The inverse of a pose's matrix, for many bodies in one frame.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Inverted {
    rows: [[f64; 3]; 3],
    skew: f64,
}

impl Inverted {
    /// The inverse of the identity.
    pub(crate) const IDENTITY: Self = Self { rows: Pose::IDENTITY.rows, skew: 3.0 * SKEW_ROUNDING };

    /// The pose of A in the frame of B, where `self` is the inverse of B's matrix. Not checked: the product may not
    /// be a valid pose.
    #[inline]
    pub(crate) fn relative(&self, world_a: &Pose, world_b: &Pose) -> Relative {
        let n = &self.rows;
        let (s, t) = (&world_a.translation, &world_b.translation);
        let d = [s[0] - t[0], s[1] - t[1], s[2] - t[2]];
        let translation = [dot(&n[0], &d), dot(&n[1], &d), dot(&n[2], &d)];
        let pose = Pose { rows: product(n, &world_a.rows), translation };
        let [x, y, z] = translation.map(f64::abs);
        let error = ROUNDING * x.max(y).max(z) + 4.0 * MIN_COORDINATE;
        Relative { pose, error, skew: self.skew }
    }
}

#[inline]
fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let entry = |i: usize, j: usize| (a[i][0] * b[0][j] + a[i][1] * b[1][j]) + a[i][2] * b[2][j];
    let row = |i: usize| [entry(i, 0), entry(i, 1), entry(i, 2)];
    [row(0), row(1), row(2)]
}
