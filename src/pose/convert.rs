//! Poses from types of other crates.

use super::{Pose, PoseError, is_near};
use glam::{Affine3, Affine3A, DAffine3, DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

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
        // Check the quaternion: the matrix of (0, 0, 0, w) is the identity for every w.
        let deviation = (rotation.length_squared() - 1.0).abs();
        if deviation > Self::TOLERANCE {
            return Err(PoseError::NotUnit { deviation });
        }
        let translation = translation.to_array();
        if !is_near(&translation) {
            return Err(PoseError::TooFar);
        }
        // The matrix of a unit quaternion needs no check.
        let [x, y, z] = DMat3::from_quat(rotation.normalize()).transpose().to_cols_array_2d();
        Ok(Self { rows: [x, y, z], translation })
    }
}

impl TryFrom<(Quat, Vec3)> for Pose {
    type Error = PoseError;
    fn try_from((rotation, translation): (Quat, Vec3)) -> Result<Self, PoseError> {
        Self::try_from((rotation.as_dquat(), translation.as_dvec3()))
    }
}

#[cfg(feature = "mint")]
mod of_mint {
    use super::{DQuat, DVec3, Pose, PoseError};
    use mint::{ColumnMatrix3x4, Quaternion, RowMatrix3x4, Vector3};

    /// The scalar types of mint's poses.
    macro_rules! poses_of {
        ($($float:ty)*) => { $(
            impl TryFrom<RowMatrix3x4<$float>> for Pose {
                type Error = PoseError;
                fn try_from(m: RowMatrix3x4<$float>) -> Result<Self, PoseError> {
                    let rows: [[$float; 4]; 3] = m.into();
                    Self::from_rows(rows.map(|row| row.map(f64::from)))
                }
            }

            impl TryFrom<ColumnMatrix3x4<$float>> for Pose {
                type Error = PoseError;
                fn try_from(m: ColumnMatrix3x4<$float>) -> Result<Self, PoseError> {
                    Self::try_from(RowMatrix3x4::from(m))
                }
            }

            impl TryFrom<(Quaternion<$float>, Vector3<$float>)> for Pose {
                type Error = PoseError;
                fn try_from((q, t): (Quaternion<$float>, Vector3<$float>)) -> Result<Self, PoseError> {
                    let [x, y, z, w] = [q.v.x, q.v.y, q.v.z, q.s].map(f64::from);
                    let t: [$float; 3] = t.into();
                    Self::try_from((DQuat::from_xyzw(x, y, z, w), DVec3::from_array(t.map(f64::from))))
                }
            }
        )* };
    }

    poses_of!(f32 f64);
}

#[cfg(feature = "nalgebra")]
mod of_nalgebra {
    use super::{DQuat, DVec3, Pose, PoseError};
    use nalgebra::Isometry3;

    impl TryFrom<Isometry3<f64>> for Pose {
        type Error = PoseError;
        fn try_from(motion: Isometry3<f64>) -> Result<Self, PoseError> {
            let [x, y, z, w] = motion.rotation.coords.into();
            Self::try_from((
                DQuat::from_xyzw(x, y, z, w),
                DVec3::from_array(motion.translation.vector.into()),
            ))
        }
    }

    impl TryFrom<Isometry3<f32>> for Pose {
        type Error = PoseError;
        fn try_from(motion: Isometry3<f32>) -> Result<Self, PoseError> {
            Self::try_from(motion.cast::<f64>())
        }
    }
}
