//! Rigid poses: where body A stands in the frame of body B.

use crate::range::{MAX_COORDINATE, MAX_MOVED, Point, flush};
use crate::vector::{cross, dot, length};
use core::fmt;
use glam::{DMat3, DVec3};

mod convert;
mod relative;
#[cfg(test)]
mod tests;

pub(crate) use relative::Inverted;
pub use relative::Relative;

/// A rigid motion `x -> R x + t`, in `f64`, in the unit of the bodies.
///
/// The rows of R are the ones given, not re-orthogonalised: verdicts are exact for just this matrix.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Pose {
    /// R by rows.
    rows: [[f64; 3]; 3],
    translation: Point,
}

/// Why a matrix and a vector are not a pose.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is NaN or infinite.
    NotFinite,
    /// The translation is longer than [`MAX_COORDINATE`].
    TooFar,
    /// The rows are not unit vectors at right angles within [`Pose::TOLERANCE`]: the largest deviation of `R
    /// R^T` from 1.
    NotOrthonormal {
        /// Largest absolute entry of `R R^T - 1`.
        deviation: f64,
    },
    /// The matrix mirrors: its determinant is -1.
    Mirrored,
    /// The quaternion is not a unit one within [`Pose::TOLERANCE`]. A deviation of 1 is that of (0, 0, 0, 0),
    /// which a message holds that nobody has filled in.
    NotUnit {
        /// How far the sum of the squares of its components is from 1.
        deviation: f64,
    },
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("the pose has an entry that is not finite"),
            Self::TooFar => f.write_str("the pose's translation is beyond 2^300"),
            Self::NotOrthonormal { deviation } => write!(
                f,
                "the pose is not rigid: R times its transpose differs from 1 by {deviation:e}, more than {:e}",
                Pose::TOLERANCE
            ),
            Self::Mirrored => f.write_str("the pose is not rigid: it mirrors (determinant -1)"),
            Self::NotUnit { deviation } => write!(
                f,
                "the pose's quaternion is not a unit one: its squared length differs from 1 by \
                 {deviation:e}, more than {:e}",
                Pose::TOLERANCE
            ),
        }
    }
}

impl core::error::Error for PoseError {}

impl Pose {
    /// Largest accepted absolute entry of `R R^T - 1`, and largest accepted `abs(q . q - 1)` of a quaternion
    /// q: room for numbers written with five digits (which are 2e-5 off in a quaternion) or in `f32` (3e-7),
    /// none for scaled ones.
    pub const TOLERANCE: f64 = 1e-4;

    /// The identity.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// The pose `[R|t]` from three rows of four numbers.
    ///
    /// # Errors
    /// [`PoseError`] if a number is not finite, R is not a rotation within [`Pose::TOLERANCE`], or t is too
    /// long.
    #[inline]
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Result<Self, PoseError> {
        let [p, q, r] = rows;
        let pose = Self {
            rows: [[p[0], p[1], p[2]], [q[0], q[1], q[2]], [r[0], r[1], r[2]]],
            translation: [p[3], q[3], r[3]],
        };
        pose.checked()
    }

    /// A rotation and a translation. Quaternions and single-precision types, and those of mint and nalgebra with the features
    /// of these names: through [`TryFrom`], which converts to `f64` first.
    ///
    /// A quaternion must be a unit one within [`Pose::TOLERANCE`], and is then divided by its length: the
    /// matrix is a rotation to within the rounding of `f64`, however few digits the quaternion came with.
    ///
    /// ```
    /// use glam::{DQuat, DVec3};
    /// use simdop::pose::{Pose, PoseError};
    /// let (turn, shift) = (DQuat::from_rotation_z(1.0), DVec3::new(0.5, 0.0, 0.0));
    /// assert!(Pose::try_from((turn, shift)).is_ok());
    /// let unset = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    /// assert_eq!(Pose::try_from((unset, shift)), Err(PoseError::NotUnit { deviation: 1.0 }));
    /// ```
    ///
    /// # Errors
    /// As [`Pose::from_rows`].
    pub fn new(rotation: DMat3, translation: DVec3) -> Result<Self, PoseError> {
        let [x, y, z] = rotation.transpose().to_cols_array_2d();
        Self { rows: [x, y, z], translation: translation.to_array() }.checked()
    }

    /// R by rows.
    #[inline]
    #[must_use]
    pub const fn rows(&self) -> &[[f64; 3]; 3] {
        &self.rows
    }

    /// t.
    #[inline]
    #[must_use]
    pub const fn translation(&self) -> Point {
        self.translation
    }

    /// `R p + t` in `f64`, each coordinate as `((r0 x + r1 y) + r2 z) + t` without fused operations: the same
    /// bits everywhere, within 2^-50 (|R||p| + |t|) of the exact image. Coordinates below
    /// [`crate::range::MIN_COORDINATE`] become zero; of a point within [`MAX_COORDINATE`] none is beyond
    /// [`MAX_MOVED`].
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    #[must_use]
    pub fn apply(&self, p: Point) -> Point {
        let [x, y, z] = self.unflushed(&p);
        [flush(x), flush(y), flush(z)]
    }

    /// The way back, for bodies about c: it takes the image of c to c, and ways from there to the ways from c by R
    /// transposed. Not checked: it may lead farther than a pose.
    pub(crate) fn back_to(&self, c: &Point) -> Self {
        let (r, q) = (&self.rows, self.unflushed_called(c));
        let along = |j: usize| c[j] - ((r[0][j] * q[0] + r[1][j] * q[1]) + r[2][j] * q[2]);
        Self {
            rows: [[r[0][0], r[1][0], r[2][0]], [r[0][1], r[1][1], r[2][1]], [r[0][2], r[1][2], r[2][2]]],
            translation: [along(0), along(1), along(2)],
        }
    }

    /// Where the pose puts a point that need not be one of a body.
    #[inline(always)]
    pub(crate) fn unflushed(&self, p: &Point) -> Point {
        let coordinate = |i: usize| dot(&self.rows[i], p) + self.translation[i];
        // Not `array::from_fn`: it is not always inlined, and this is on the path of every pair of triangles.
        [coordinate(0), coordinate(1), coordinate(2)]
    }

    /// [`Pose::unflushed`] where a call is of no account.
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    pub(crate) fn unflushed_called(&self, p: &Point) -> Point {
        self.unflushed(p)
    }

    /// A turn about an axis through the origin, by an angle in radians. The axis is a unit vector up to rounding, and so the
    /// matrix is a rotation.
    #[inline]
    pub(crate) fn turn(axis: &Point, angle: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle);
        let ([x, y, z], rest) = (*axis, 1.0 - cosine);
        let ([p, q, r], [s, t, u]) = ([rest * x, rest * y, rest * z], [sine * x, sine * y, sine * z]);
        Self {
            rows: [
                [p * x + cosine, p * y - u, p * z + t],
                [q * x + u, q * y + cosine, q * z - s],
                [r * x - t, r * y + s, r * z + cosine],
            ],
            translation: [0.0; 3],
        }
    }

    /// With a rotation, up to a few roundings, in place of a matrix that is accepted as one: the first row is kept but for its
    /// length, and of the second what is at a right angle to it. No entry changes by more than twice what the matrix is off.
    #[must_use]
    pub(crate) fn orthonormal(&self) -> Self {
        let unit = |a: &Point| {
            let length = length(a);
            [a[0] / length, a[1] / length, a[2] / length]
        };
        let x = unit(&self.rows[0]);
        let (q, along) = (&self.rows[1], dot(&x, &self.rows[1]));
        let y = unit(&[q[0] - along * x[0], q[1] - along * x[1], q[2] - along * x[2]]);
        Self { rows: [x, y, cross(&x, &y)], translation: self.translation }
    }

    /// The pose with a way added to its translation. Not checked.
    #[inline]
    pub(crate) fn shifted(&self, by: &Point) -> Self {
        let t = &self.translation;
        Self { rows: self.rows, translation: [t[0] + by[0], t[1] + by[1], t[2] + by[2]] }
    }

    /// Where the pose's rotation takes a direction.
    #[inline]
    pub(crate) fn rotate(&self, direction: &Point) -> Point {
        let r = &self.rows;
        [dot(&r[0], direction), dot(&r[1], direction), dot(&r[2], direction)]
    }

    #[inline]
    fn checked(self) -> Result<Self, PoseError> {
        if self.is_rigid() { Ok(self) } else { Err(self.fault()) }
    }

    // Without a branch: a tenth of a query between bodies 5 % apart is spent here. Not NaN, by how each is
    // compared.
    #[inline]
    fn is_rigid(&self) -> bool {
        is_near(&self.translation) & self.is_rotation(Self::TOLERANCE) & (self.determinant() >= 0.0)
    }

    /// Whether no entry of `R R^T - 1` is greater.
    #[inline(always)]
    pub(crate) fn is_rotation(&self, tolerance: f64) -> bool {
        let r = &self.rows;
        let off = |x: f64| x.abs() <= tolerance;
        (off(dot(&r[0], &r[0]) - 1.0) & off(dot(&r[1], &r[1]) - 1.0) & off(dot(&r[2], &r[2]) - 1.0))
            & (off(dot(&r[0], &r[1])) & off(dot(&r[0], &r[2])) & off(dot(&r[1], &r[2])))
    }

    /// What is wrong with a pose that is not rigid.
    #[cold]
    fn fault(&self) -> PoseError {
        let (r, t) = (&self.rows, &self.translation);
        if !r.iter().flatten().chain(t).all(|x| x.is_finite()) {
            return PoseError::NotFinite;
        }
        if t.iter().any(|x| x.abs() > MAX_COORDINATE) {
            return PoseError::TooFar;
        }
        let deviation = self.deviation();
        if deviation > Self::TOLERANCE {
            return PoseError::NotOrthonormal { deviation };
        }
        PoseError::Mirrored
    }

    /// The largest absolute entry of `R R^T - 1`.
    pub(crate) fn deviation(&self) -> f64 {
        let r = &self.rows;
        // A product that overflows makes that of its row with itself infinite. max() drops a NaN beside it.
        let off = |i: usize, j: usize| (dot(&r[i], &r[j]) - if i == j { 1.0 } else { 0.0 }).abs();
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        pairs.iter().fold(0.0, |m: f64, &(i, j)| m.max(off(i, j)))
    }

    #[inline]
    fn determinant(&self) -> f64 {
        let [p, q, r] = &self.rows;
        dot(p, &cross(q, r))
    }
}

// A row of R is at most sqrt(1 + TOLERANCE) long and a point sqrt(3) MAX_COORDINATE, so their product is at
// most that times this; the translation adds at most MAX_COORDINATE. There is plenty left for rounding.
const _: () = {
    let by_rotation = MAX_MOVED / MAX_COORDINATE - 1.0;
    assert!(
        by_rotation * by_rotation > 2.0 * 3.0 * (1.0 + Pose::TOLERANCE),
        "moved points are within MAX_MOVED"
    );
};

#[inline]
fn is_near(t: &Point) -> bool {
    let near = |x: f64| x.abs() <= MAX_COORDINATE;
    near(t[0]) & near(t[1]) & near(t[2])
}
