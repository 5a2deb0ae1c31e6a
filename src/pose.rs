//! Rigid poses: where body A stands in the frame of body B.

use crate::range::{MAX_COORDINATE, MAX_MOVED, Point, flush};
use core::fmt;
use glam::{Affine3, Affine3A, DAffine3, DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

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
    /// The rows are not unit vectors at right angles within [`Pose::TOLERANCE`]: the largest deviation of `R R^T` from 1.
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
    /// [`PoseError`] if a number is not finite, R is not a rotation within [`Pose::TOLERANCE`], or t is too long.
    #[inline]
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Result<Self, PoseError> {
        let [p, q, r] = rows;
        let pose = Self {
            rows: [[p[0], p[1], p[2]], [q[0], q[1], q[2]], [r[0], r[1], r[2]]],
            translation: [p[3], q[3], r[3]],
        };
        if pose.is_rigid() { Ok(pose) } else { Err(pose.fault()) }
    }

    /// A rotation and a translation. Quaternions and single-precision types: through [`TryFrom`], which
    /// converts to `f64` first.
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
        let r = rotation.transpose().to_cols_array_2d();
        let t = translation.to_array();
        Self::from_rows(core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], t[i]]))
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
    #[inline(always)]
    #[must_use]
    pub fn apply(&self, p: Point) -> Point {
        let coordinate = |i: usize| {
            let r = &self.rows[i];
            flush(((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + self.translation[i])
        };
        // Not `array::from_fn`: it is not always inlined, and this is on the path of every pair of triangles.
        [coordinate(0), coordinate(1), coordinate(2)]
    }

    // Without a branch: a tenth of a query between bodies 5 % apart is spent here. Not NaN, by how each is compared.
    #[inline]
    fn is_rigid(&self) -> bool {
        let (r, t) = (&self.rows, &self.translation);
        let near = |x: f64| x.abs() <= MAX_COORDINATE;
        let off = |x: f64| x.abs() <= Self::TOLERANCE;
        (near(t[0]) & near(t[1]) & near(t[2]))
            & (off(dot(&r[0], &r[0]) - 1.0) & off(dot(&r[1], &r[1]) - 1.0) & off(dot(&r[2], &r[2]) - 1.0))
            & (off(dot(&r[0], &r[1])) & off(dot(&r[0], &r[2])) & off(dot(&r[1], &r[2])))
            & (self.determinant() >= 0.0)
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
        // A product that overflows makes that of its row with itself infinite. max() drops a NaN beside it.
        let off = |i: usize, j: usize| (dot(&r[i], &r[j]) - if i == j { 1.0 } else { 0.0 }).abs();
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let deviation = pairs.iter().fold(0.0, |m: f64, &(i, j)| m.max(off(i, j)));
        if deviation > Self::TOLERANCE {
            return PoseError::NotOrthonormal { deviation };
        }
        PoseError::Mirrored
    }

    #[inline]
    fn determinant(&self) -> f64 {
        let [p, q, r] = &self.rows;
        dot(p, &[q[1] * r[2] - q[2] * r[1], q[2] * r[0] - q[0] * r[2], q[0] * r[1] - q[1] * r[0]])
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
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

impl TryFrom<DAffine3> for Pose {
    type Error = PoseError;
    fn try_from(a: DAffine3) -> Result<Self, PoseError> {
        Self::new(a.matrix3, a.translation)
    }
}

impl TryFrom<Affine3A> for Pose {
    type Error = PoseError;
    fn try_from(a: Affine3A) -> Result<Self, PoseError> {
        Self::new(Mat3::from(a.matrix3).as_dmat3(), Vec3::from(a.translation).as_dvec3())
    }
}

impl TryFrom<Affine3> for Pose {
    type Error = PoseError;
    fn try_from(a: Affine3) -> Result<Self, PoseError> {
        Self::new(a.matrix3.as_dmat3(), a.translation.as_dvec3())
    }
}

impl TryFrom<(DQuat, DVec3)> for Pose {
    type Error = PoseError;
    fn try_from((rotation, translation): (DQuat, DVec3)) -> Result<Self, PoseError> {
        if !(rotation.is_finite() && translation.is_finite()) {
            return Err(PoseError::NotFinite);
        }
        // The matrix would not show it: that of (0, 0, 0, w) is the identity for every w.
        let deviation = (rotation.length_squared() - 1.0).abs();
        if deviation > Self::TOLERANCE {
            return Err(PoseError::NotUnit { deviation });
        }
        Self::new(DMat3::from_quat(rotation.normalize()), translation)
    }
}

impl TryFrom<(Quat, Vec3)> for Pose {
    type Error = PoseError;
    fn try_from((rotation, translation): (Quat, Vec3)) -> Result<Self, PoseError> {
        Self::try_from((rotation.as_dquat(), translation.as_dvec3()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glam_types_give_the_matrix_that_glam_applies() {
        let (q, t) = (DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0), DVec3::new(1.0, -2.0, 0.5));
        let affine = DAffine3::from_rotation_translation(q, t);
        let p = DVec3::new(0.7, 11.0, -3.0);
        let want = affine.transform_point3(p);
        for pose in [Pose::try_from(affine).unwrap(), Pose::try_from((q, t)).unwrap()] {
            let got = DVec3::from_array(pose.apply(p.to_array()));
            assert!((want - got).length() < 1e-14, "{want} {got}");
        }
        let single = Affine3A::from_rotation_translation(q.as_quat(), t.as_vec3());
        let pair = Pose::try_from((q.as_quat(), t.as_vec3())).unwrap();
        for pose in [Pose::try_from(single).unwrap(), Pose::try_from(Affine3::from(single)).unwrap(), pair] {
            let got = DVec3::from_array(pose.apply(p.to_array()));
            assert!((want - got).length() < 1e-5, "{want} {got}");
        }
    }

    /// Turns about many axes, in no order.
    fn turns() -> impl Iterator<Item = DQuat> {
        (0..2000).map(|i| {
            let [x, y, z] = [0.7, 1.3, 2.9].map(|step| f64::from(i) * step);
            DQuat::from_euler(glam::EulerRot::XYZ, x, y, z)
        })
    }

    fn of(q: [f64; 4]) -> Result<Pose, PoseError> {
        Pose::try_from((DQuat::from_array(q), DVec3::new(1.0, 2.0, 3.0)))
    }

    #[test]
    fn a_quaternion_that_is_not_a_unit_one_is_refused() {
        let refused = |q: [f64; 4]| match of(q) {
            Err(PoseError::NotUnit { deviation }) => deviation,
            other => panic!("{q:?}: {other:?}"),
        };
        assert_eq!(refused([0.0; 4]), 1.0, "an unset message");
        assert_eq!(refused([0.0, 0.0, 0.0, 2.0]), 3.0, "its matrix is the identity");
        assert_eq!(refused([0.0, 0.0, 0.0, -0.5]), 0.75);
        assert_eq!(refused([1.0; 4]), 3.0);
        assert_eq!(refused([0.0, 1e200, 0.0, 0.0]), f64::INFINITY);
        assert_eq!(refused([5e-324, 0.0, 0.0, 0.0]), 1.0);
        for turn in turns() {
            for factor in [0.0, 0.5, 0.9999, 1.0001, 2.0] {
                let deviation = refused((turn * factor).to_array());
                assert!((deviation - f64::abs(factor * factor - 1.0)).abs() < 1e-12, "{turn} {factor}");
            }
        }
        let single = (Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), Vec3::ZERO);
        assert_eq!(Pose::try_from(single), Err(PoseError::NotUnit { deviation: 1.0 }));
    }

    #[test]
    fn a_quaternion_that_is_not_finite_is_refused_as_such() {
        for component in 0..4 {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut q = [0.0, 0.0, 0.0, 1.0];
                q[component] = value;
                assert_eq!(of(q), Err(PoseError::NotFinite), "{q:?}");
            }
        }
        let nowhere = (DQuat::IDENTITY, DVec3::new(0.0, f64::NAN, 0.0));
        assert_eq!(Pose::try_from(nowhere), Err(PoseError::NotFinite));
        assert_eq!(Pose::try_from((DQuat::IDENTITY, DVec3::new(0.0, 0.0, 1e300))), Err(PoseError::TooFar));
    }

    /// Rounded to `f32`, printed with five digits, or a bit off by whatever else: the pose is a rotation to
    /// within `f64` all the same, and not farther from the one that was meant than the quaternion is.
    #[test]
    fn a_quaternion_that_is_nearly_a_unit_one_gives_a_rotation() {
        let five_digits = |x: f64| (x * 1e5).round() / 1e5;
        for turn in turns() {
            let exact = DMat3::from_quat(turn);
            let single = turn.as_quat();
            for (q, off) in [
                (turn, 1e-14),
                (-turn, 1e-14),
                (turn * (1.0 - 4.9e-5), 1e-14),
                (turn * (1.0 + 4.9e-5), 1e-14),
                (single.as_dquat(), 1e-6),
                (DQuat::from_array(turn.to_array().map(five_digits)), 1e-4),
            ] {
                let pose = of(q.to_array()).unwrap_or_else(|e| panic!("{q}: {e}"));
                let rotation = DMat3::from_cols_array_2d(pose.rows()).transpose();
                assert!(rotation.abs_diff_eq(exact, off), "{q}: {rotation} {exact}");
                let product = rotation * rotation.transpose();
                assert!(product.abs_diff_eq(DMat3::IDENTITY, 1e-14), "{q}: {product}");
                assert_eq!(pose.translation(), [1.0, 2.0, 3.0]);
            }
            let pose = Pose::try_from((single, Vec3::ZERO)).unwrap();
            assert_eq!(
                pose.rows(),
                of(single.as_dquat().to_array()).unwrap().rows(),
                "converted before all else"
            );
        }
        assert_eq!(of([0.0, 0.0, 0.0, 1.0]).unwrap().rows(), Pose::IDENTITY.rows());
    }

    /// Corners of the cube of all points, turned onto an axis and moved away: nothing that is accepted goes
    /// farther.
    #[test]
    fn moved_points_are_in_the_range_of_moved_points() {
        let mut farthest = 0.0;
        let third = f64::sqrt(1.0 / 3.0);
        let diagonal = DQuat::from_rotation_arc(DVec3::splat(third), DVec3::X);
        for turn in turns().chain([diagonal]) {
            // As long as rows may be.
            let rotation = DMat3::from_quat(turn) * (1.0 + 0.499 * Pose::TOLERANCE);
            for corner in 0..8 {
                let signs: Point = core::array::from_fn(|i| if corner >> i & 1 == 0 { 1.0 } else { -1.0 });
                let pose = Pose::new(rotation, MAX_COORDINATE * DVec3::from_array(signs)).unwrap();
                for other in 0..8 {
                    let p =
                        core::array::from_fn(|i| MAX_COORDINATE * (1.0 - f64::from(other >> i & 1) * 2.0));
                    farthest = pose.apply(p).iter().fold(farthest, |m: f64, x| m.max(x.abs()));
                }
            }
        }
        assert!(farthest <= MAX_MOVED, "{farthest:e}");
        assert!(farthest > 2.73 * MAX_COORDINATE, "the worst case is among them: {farthest:e}");
    }

    #[test]
    fn what_is_not_rigid_is_refused() {
        let ok = [[1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        assert!(Pose::from_rows(ok).is_ok());
        let with = |row: usize, column: usize, value: f64| {
            let mut rows = ok;
            rows[row][column] = value;
            Pose::from_rows(rows)
        };
        for row in 0..3 {
            for column in 0..4 {
                for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    assert_eq!(with(row, column, value), Err(PoseError::NotFinite));
                }
                let off = with(row, column, if row == column { -0.9998 } else { 2e-4 });
                assert_eq!(
                    matches!(off, Err(PoseError::NotOrthonormal { .. })),
                    column < 3,
                    "{row} {column}"
                );
            }
            assert_eq!(with(row, 3, -1e300), Err(PoseError::TooFar));
        }
        assert!(matches!(with(0, 0, 1.001), Err(PoseError::NotOrthonormal { .. })));
        assert!(matches!(with(0, 1, 1e-3), Err(PoseError::NotOrthonormal { .. })));
        assert!(matches!(with(0, 0, 1e200), Err(PoseError::NotOrthonormal { .. })));
        assert!(matches!(with(0, 0, 0.0), Err(PoseError::NotOrthonormal { .. })));
        assert_eq!(with(2, 2, -1.0), Err(PoseError::Mirrored));
    }
}
