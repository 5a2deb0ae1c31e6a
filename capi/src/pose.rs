//! Poses, from rows or from a quaternion.

use crate::boundary::{given, guarded, items};
use crate::error::simdop_error;
use simdop::glam::{DQuat, DVec3};
use simdop::pose::{Pose, PoseError};
use std::mem::MaybeUninit;

/// A rigid motion x -> R x + t: the three rows of [R|t]. Fill it in, or use simdop_pose_from_quaternion(). Every
/// function that takes a pose checks it: the entries of R R^T may differ from the identity's by 1e-4, in a scene by
/// 1.5e-5, and R must not be a reflection.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_pose {
    /// R, with t as the last column.
    pub rows: [[f64; 4]; 3],
}

impl simdop_pose {
    /// Invalid: a pose that a callback did not write.
    pub(crate) const UNWRITTEN: Self = Self { rows: [[f64::NAN; 4]; 3] };

    pub(crate) fn checked(&self) -> Result<Pose, PoseError> {
        Pose::from_rows(self.rows)
    }
}

impl From<&Pose> for simdop_pose {
    fn from(pose: &Pose) -> Self {
        let (rows, t) = (pose.rows(), pose.translation());
        Self { rows: [0, 1, 2].map(|i| [rows[i][0], rows[i][1], rows[i][2], t[i]]) }
    }
}

/// The pose of a quaternion (x, y, z, w), whose squared length may differ from 1 by 1e-4, and a translation.
///
/// # Safety
/// `xyzw` points to four numbers, `translation` to three.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_pose_from_quaternion(
    xyzw: *const f64,
    translation: *const f64,
    pose: Option<&mut MaybeUninit<simdop_pose>>,
) -> simdop_error {
    guarded(|| {
        // SAFETY: the caller guarantees four numbers.
        let xyzw = unsafe { items(xyzw, 4, "xyzw") }?;
        // SAFETY: the caller guarantees three numbers.
        let translation = unsafe { items(translation, 3, "translation") }?;
        let pose = given(pose, "pose")?;
        let checked = Pose::try_from((DQuat::from_slice(xyzw), DVec3::from_slice(translation)))?;
        pose.write((&checked).into());
        Ok(())
    })
}
