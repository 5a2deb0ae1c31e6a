//! Rigid poses: the placement of body A in the frame of body B.

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
/// R is stored as given, without re-orthogonalisation: verdicts are exact for this matrix.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Pose {
    /// The rows of R.
    rows: [[f64; 3]; 3],
    translation: Point,
}

/// Why a matrix and a vector do not form a pose.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum PoseError {
    /// An entry is NaN or infinite.
    NotFinite,
    /// A component of the translation is beyond [`MAX_COORDINATE`].
    TooFar,
    /// The rows are not orthonormal within [`Pose::TOLERANCE`].
    NotOrthonormal {
        /// Largest absolute entry of `R R^T - 1`.
        deviation: f64,
    },
    /// The matrix is a reflection: its determinant is -1.
    Mirrored,
    /// The quaternion does not have unit length within [`Pose::TOLERANCE`]. The deviation of (0, 0, 0, 0), the value in
    /// an uninitialised message, is 1.
    NotUnit {
        /// The absolute difference of the squared length from 1.
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
    /// Largest accepted absolute entry of `R R^T - 1`, and largest accepted `abs(q . q - 1)` of a quaternion q. Accepts
    /// numbers written with five digits (errors of 2e-5 in a quaternion) or in `f32` (3e-7), and rejects scaled
    /// rotations.
    pub const TOLERANCE: f64 = 1e-4;

    /// The identity.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// The pose `[R|t]` from its three rows.
    ///
    /// # Errors
    /// [`PoseError`] if a number is not finite, R is not a rotation within [`Pose::TOLERANCE`], or t is too large.
    #[inline]
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Result<Self, PoseError> {
        let [p, q, r] = rows;
        let pose = Self {
            rows: [[p[0], p[1], p[2]], [q[0], q[1], q[2]], [r[0], r[1], r[2]]],
            translation: [p[3], q[3], r[3]],
        };
        pose.checked()
    }

    /// The pose of a rotation and a translation. [`TryFrom`] also accepts quaternions and single-precision types, and
    /// with the features of these names, types of mint and nalgebra. It converts to `f64` first.
    ///
    /// A quaternion must have unit length within [`Pose::TOLERANCE`], and is then normalised. So the matrix is a
    /// rotation to within `f64` rounding, even if the quaternion had few digits.
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

    /// The rows of R.
    #[inline]
    #[must_use]
    pub const fn rows(&self) -> &[[f64; 3]; 3] {
        &self.rows
    }

    /// The translation t.
    #[inline]
    #[must_use]
    pub const fn translation(&self) -> Point {
        self.translation
    }

    /// `R p + t` in `f64`, each coordinate as `((r0 x + r1 y) + r2 z) + t` without fused operations: the same bits on
    /// every machine, within 2^-50 (|R||p| + |t|) of the exact image. Coordinates below
    /// [`crate::range::MIN_COORDINATE`] become zero. The image of a point within [`MAX_COORDINATE`] is within
    /// [`MAX_MOVED`].
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    #[must_use]
    pub fn apply(&self, p: Point) -> Point {
        let [x, y, z] = self.unflushed(&p);
        [flush(x), flush(y), flush(z)]
    }

    /// The inverse motion about the image of c: maps the image of c to c, and rotates offsets from it by the transpose
    /// of R. Not checked: its translation may be larger than a pose's.
    pub(crate) fn back_to(&self, c: &Point) -> Self {
        let (r, q) = (&self.rows, self.unflushed_called(c));
        let along = |j: usize| c[j] - ((r[0][j] * q[0] + r[1][j] * q[1]) + r[2][j] * q[2]);
        Self {
            rows: [[r[0][0], r[1][0], r[2][0]], [r[0][1], r[1][1], r[2][1]], [r[0][2], r[1][2], r[2][2]]],
            translation: [along(0), along(1), along(2)],
        }
    }

    /// The image of any point, not necessarily of a body, without flushing small coordinates.
    #[inline(always)]
    pub(crate) fn unflushed(&self, p: &Point) -> Point {
        let coordinate = |i: usize| dot(&self.rows[i], p) + self.translation[i];
        // Not `array::from_fn`: it is not always inlined, and this is on the path of every pair of triangles.
        [coordinate(0), coordinate(1), coordinate(2)]
    }

    /// [`Pose::unflushed`], where the cost of a call does not matter.
    #[cfg_attr(simdop_small, inline(never))]
    #[cfg_attr(not(simdop_small), inline(always))]
    pub(crate) fn unflushed_called(&self, p: &Point) -> Point {
        self.unflushed(p)
    }

    /// A rotation about an axis through the origin, by an angle in radians. The axis is a unit vector up to rounding,
    /// so the matrix is a rotation up to rounding.
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

    /// The pose with its matrix replaced by a rotation, up to a few roundings (Gram-Schmidt on the rows). No entry
    /// changes by more than twice the matrix's deviation.
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

    /// The pose with an offset added to its translation. Not checked.
    #[inline]
    pub(crate) fn shifted(&self, by: &Point) -> Self {
        let t = &self.translation;
        Self { rows: self.rows, translation: [t[0] + by[0], t[1] + by[1], t[2] + by[2]] }
    }

    /// Rotates a direction.
    #[inline]
    pub(crate) fn rotate(&self, direction: &Point) -> Point {
        let r = &self.rows;
        [dot(&r[0], direction), dot(&r[1], direction), dot(&r[2], direction)]
    }

    #[inline]
    fn checked(self) -> Result<Self, PoseError> {
        if self.is_rigid() { Ok(self) } else { Err(self.fault()) }
    }

    // Without branches: this takes a tenth of a query between bodies 5 % apart. All comparisons are false for NaN.
    #[inline]
    fn is_rigid(&self) -> bool {
        is_near(&self.translation) & self.is_rotation(Self::TOLERANCE) & (self.determinant() >= 0.0)
    }

    /// Whether no entry of `R R^T - 1` exceeds `tolerance`.
    #[inline(always)]
    pub(crate) fn is_rotation(&self, tolerance: f64) -> bool {
        let r = &self.rows;
        let off = |x: f64| x.abs() <= tolerance;
        (off(dot(&r[0], &r[0]) - 1.0) & off(dot(&r[1], &r[1]) - 1.0) & off(dot(&r[2], &r[2]) - 1.0))
            & (off(dot(&r[0], &r[1])) & off(dot(&r[0], &r[2])) & off(dot(&r[1], &r[2])))
    }

    /// The error of a matrix that failed [`Pose::is_rigid`].
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
        // If a product overflows, so does the product of its row with itself, to infinity. `max` ignores a NaN.
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

// A row of R is at most sqrt(1 + TOLERANCE) long and a point at most sqrt(3) MAX_COORDINATE, which bounds their
// product; the translation adds at most MAX_COORDINATE. The factor 2 leaves room for rounding.
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
