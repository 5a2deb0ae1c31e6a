//! Classifies pairs of bodies over all values of a robot's joints.

use super::{simdop_body_id, simdop_scene, with_scene};
use crate::boundary::{answered, given, items, places};
use crate::error::simdop_error;
use crate::query::query;
use crate::robot::simdop_robot;
use simdop::scene::{BodyId, PairClass, PairReport};
use std::ffi::c_int;
use std::mem::MaybeUninit;

/// Whether two bodies meet, over all values of the joints within the limits.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_pair_class {
    /// At none: the pair need not be tested, see simdop_scene_allow_collision(). This is certain.
    Never = 0,
    /// At all. This is certain.
    Always = 1,
    /// At some, and not at others.
    Sometimes = 2,
    /// The limit on the number of boxes was reached before the class was certain.
    Undecided = 3,
}

/// The answer of simdop_scene_classify_pair().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_pair_report {
    /// The class.
    pub pair_class: simdop_pair_class,
    /// Nonzero: `meeting` holds values at which the two meet.
    pub has_meeting: c_int,
    /// Nonzero: `free` holds values at which they do not.
    pub has_free: c_int,
    /// Number of boxes of values tested.
    pub boxes: usize,
    /// Number of random values tested.
    pub samples: usize,
}

/// Do two bodies meet never, always, or sometimes, within the limits of a robot's joints? `moving` lists the scene's
/// bodies in the order of the robot's; all others stand still. Tests at most `boxes` boxes of values. `meeting` and
/// `free` have room for a number for each variable: values at which the two meet, and at which they do not, if any were
/// found. Otherwise they are not written. The call allocates. Afterwards, the bodies are at their original poses.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_classify_pair(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    robot: Option<&simdop_robot>,
    a: simdop_body_id,
    b: simdop_body_id,
    boxes: usize,
    meeting: *mut f64,
    free: *mut f64,
    report: Option<&mut MaybeUninit<simdop_pair_report>>,
) -> simdop_error {
    answered(report, || {
        let scene = &mut given(scene, "scene")?.scene;
        let kinematics = given(robot, "robot")?.kinematics()?;
        let variables = kinematics.limits().len();
        // SAFETY: the caller guarantees the length.
        let moving = unsafe { items(moving, count, "moving") }?;
        // SAFETY: the caller guarantees room for each variable.
        let meeting = unsafe { places(meeting, variables, "meeting") }?;
        // SAFETY: as above.
        let free = unsafe { places(free, variables, "free") }?;
        let moving: Vec<_> = moving.iter().copied().map(BodyId::from_bits).collect();
        let pair = (BodyId::from_bits(a), BodyId::from_bits(b));
        let found = with_scene!(scene, |scene| {
            scene.classify_pair(&query(u64::MAX), &moving, kinematics, pair, boxes)
        })?;
        Ok(report_of(found, meeting, free))
    })
}

/// Writes the values that were found.
pub(crate) fn report_of(
    found: PairReport,
    meeting: &mut [MaybeUninit<f64>],
    free: &mut [MaybeUninit<f64>],
) -> simdop_pair_report {
    let copy = |values: Option<Vec<f64>>, places: &mut [MaybeUninit<f64>]| {
        for (place, value) in places.iter_mut().zip(values.iter().flatten()) {
            place.write(*value);
        }
        c_int::from(values.is_some())
    };
    simdop_pair_report {
        pair_class: match found.class {
            PairClass::Never => simdop_pair_class::Never,
            PairClass::Always => simdop_pair_class::Always,
            PairClass::Sometimes => simdop_pair_class::Sometimes,
            PairClass::Undecided => simdop_pair_class::Undecided,
        },
        has_meeting: copy(found.meeting, meeting),
        has_free: copy(found.free, free),
        boxes: found.boxes,
        samples: found.samples,
    }
}
