//! Poses, by rows or by quaternion.

use crate::boundary::{given, guarded, items};
use crate::error::simdop_error;
use simdop::glam::{DQuat, DVec3};
use simdop::pose::{Pose, PoseError};
use std::mem::MaybeUninit;

/// A rigid motion x -> R x + t: the three rows of [R|t]. Fill it in, or use simdop_pose_from_quaternion(). Every function that
/// takes one checks it: R R^T may differ from 1 by 1e-4, in a scene by 1.5e-5, and R must not mirror.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_pose {
    /// R, with t as the last column.
    pub rows: [[f64; 4]; 3],
}

impl simdop_pose {
    /// No pose: one that a callback did not write.
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
/// `xyzw` are four numbers, `translation` three.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_pose_from_quaternion(
    xyzw: *const f64,
    translation: *const f64,
    pose: Option<&mut MaybeUninit<simdop_pose>>,
) -> simdop_error {
    guarded(|| {
        // SAFETY: there are four, by the caller's promise.
        let xyzw = unsafe { items(xyzw, 4, "xyzw") }?;
        // SAFETY: there are three, by the caller's promise.
        let translation = unsafe { items(translation, 3, "translation") }?;
        let pose = given(pose, "pose")?;
        let checked = Pose::try_from((DQuat::from_slice(xyzw), DVec3::from_slice(translation)))?;
        pose.write((&checked).into());
        Ok(())
    })
}
