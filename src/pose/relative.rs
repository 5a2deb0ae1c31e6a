//! From two poses in the world to one body's in the frame of the other, with a bound of what is lost on the way.
//!
//! A planner knows where A and B stand in the world, `x -> R_A x + t_A` and `x -> R_B x + t_B`. Seen from B, a point p of A
//! stands at `N (R_A p + d)` with N the inverse of `R_B` and `d = t_A - t_B`. N is not the transpose: the matrices of poses
//! are accepted with up to 1e-4 off. All of it is in `f64`. With `u = 2^-53` and the norms of `R_A`, `R_B` and N at most
//! 1.0002, each computed value is off by at most
//!
//! | what | of entries, rows or vectors | how |
//! |---|---|---|
//! | cofactors of `R_B` | 2.1 u an entry | two products whose magnitudes sum up to at most 1.0001, and their difference |
//! | its determinant, within 5e-4 of 1 | 6.7 u | a sum of three products of a row and cofactors |
//! | N, a quotient of these | 9.9 u an entry, 30 u in all | |
//! | `M = N R_A` | 40 u in all | 30 u of N, and 3.1 u an entry for the sums |
//! | `t = N d` | `37 u abs(d)` | 30 u of N, 1.1 u of d, 5.3 u for the sums |
//! | [`Pose::apply`] | `8 u (abs(M) abs(p) + abs(t))`, and less than [`MIN_COORDINATE`] an axis | its documentation |
//!
//! so that a corner whose coordinates are at most c in magnitude, as `apply` moves it, is less than `84 u c + 46 u abs(d)` and
//! twice [`MIN_COORDINATE`] away from where it stands. `abs(d)` is at most 1.74 times the largest coordinate of t, and all of it
//! less than 2^-46 = 128 u times c and that coordinate. What is too small for a normal number is far below `MIN_COORDINATE`.

use super::{Pose, PoseError};
use crate::exact::power_of_two;
use crate::range::MIN_COORDINATE;
use crate::vector::{cross, dot};

const ROUNDING: f64 = power_of_two(-46);

/// Where body A stands in the frame of body B, from where both stand in the world: [`Pose::relative`].
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Relative {
    pose: Pose,
    /// The translation's share of the error, in the bodies' unit.
    error: f64,
    /// By how much of itself the frame of B makes a vector longer or shorter, at most.
    skew: f64,
}

impl Relative {
    /// A in the frame of B, rounded.
    #[inline]
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// How far, at most, a point of A is from where it stands in the frame of B when [`Pose::apply`] moves it by
    /// [`Relative::pose`]. No coordinate of the point, in the frame of A, is greater than `max_coordinate`
    /// ([`crate::hierarchy::Header::max_coordinate`]). In the bodies' unit: some 1e-14 of the coordinates.
    #[inline]
    #[must_use]
    pub fn error(&self, max_coordinate: f64) -> f64 {
        ROUNDING * max_coordinate + self.error
    }

    /// The margin that a query by [`Relative::pose`] has to be asked with, so that bodies which it tells free are farther
    /// apart than `margin` in the world. No coordinate of A is greater than `max_coordinate`, and no two radii of A's and B's
    /// primitives sum up to more than `radii`, which is 0 for triangles.
    ///
    /// It is greater by the [error](Relative::error), and by what the pose of B, which is accepted if it is nearly a rotation,
    /// makes lengths differ.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// use glam::{DQuat, DVec3};
    /// let world_a = Pose::try_from((DQuat::from_rotation_z(0.3), DVec3::new(1.0, 2.0, 0.5)))?;
    /// // A corner of each is at one place.
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
    /// The way back: takes `R x + t` to x, up to rounding. Of the matrix, not its transpose, which differs where the rows are
    /// not quite orthonormal. [`Pose::relative`] says how far off it is.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too long, or if the inverse is farther from a rotation than [`Pose::TOLERANCE`],
    /// as that of a matrix may be which itself is at the limit.
    pub fn inverse(&self) -> Result<Self, PoseError> {
        Ok(Self::relative(&Self::IDENTITY, self)?.pose)
    }

    /// First `inner`, then `self`: x goes to `self(inner(x))`, up to rounding, some 1e-15 of the coordinates. With A in the
    /// frame of B and B in the world, A in the world.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too long, or if the product is farther from a rotation than [`Pose::TOLERANCE`],
    /// as that of two matrices may be which are by half as much.
    pub fn compose(&self, inner: &Self) -> Result<Self, PoseError> {
        self.after(inner).checked()
    }

    /// As [`Pose::compose`], not checked.
    #[inline]
    pub(crate) fn after(&self, inner: &Self) -> Self {
        Self { rows: product(&self.rows, &inner.rows), translation: self.unflushed(&inner.translation) }
    }

    /// Where A stands in the frame of B, when both poses place their bodies in the world: the inverse of `world_b` after
    /// `world_a`.
    ///
    /// # Errors
    /// [`PoseError`] if the translation is too long, or if the product is farther from a rotation than [`Pose::TOLERANCE`],
    /// as that of two matrices may be which are by half as much.
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

    /// By how much of itself the matrix makes a vector longer or shorter, at most. No singular value is farther from 1 than its
    /// square, and that is an eigenvalue of `R transpose(R)`, so three times the greatest entry of `R transpose(R) - 1` away.
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

/// Bounds the roundings of a sum of three products of a matrix whose rows are unit vectors.
const SKEW_ROUNDING: f64 = power_of_two(-46);

/// The inverse of a pose's matrix, for many bodies in one frame.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Inverted {
    rows: [[f64; 3]; 3],
    skew: f64,
}

impl Inverted {
    /// Of the identity.
    pub(crate) const IDENTITY: Self = Self { rows: Pose::IDENTITY.rows, skew: 3.0 * SKEW_ROUNDING };

    /// Where A stands in the frame of B, of whose matrix `self` is the inverse. Not checked: the product may be no pose.
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
