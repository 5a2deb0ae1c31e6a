//! Queries of a planner.

use super::{both, simdop_planner, simdop_workspace};
use crate::boundary::{answered, filled, given, guarded, items, places};
use crate::error::{Failure, simdop_error};
use crate::scene::{
    SIMDOP_NO_BODY, report_of, simdop_body_id, simdop_motion_answer, simdop_on_hit, simdop_pair_report,
    simdop_scene_answer, simdop_scene_clearance_answer, simdop_scene_hits, simdop_scene_signed_answer,
};
use simdop::query::Pair;
use simdop::scene::{BodyId, SceneHit, SceneWitness};
use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::num::NonZeroU32;
use std::ops::ControlFlow;

/// The values of many queries, `length` numbers each, and a place for each verdict.
///
/// # Safety
/// Unless a pointer is NULL or misaligned, there are as many values, which nobody writes during `'a`, and as many
/// places, which nobody else reads or writes.
unsafe fn many<'a>(
    values: *const f64,
    length: usize,
    count: usize,
    free: *mut u8,
) -> Result<(&'a [f64], &'a mut [bool]), Failure> {
    let all = length.checked_mul(count);
    let all = all.ok_or_else(|| Failure::new(simdop_error::TooLarge, "values".into()))?;
    // SAFETY: the caller guarantees the length.
    let values = unsafe { items(values, all, "values") }?;
    // SAFETY: as above. A `bool` is a byte of 0 or 1.
    let free = unsafe { places(free.cast::<bool>(), count, "free") }?;
    Ok((values, filled(free, false)))
}

/// The values of both ends of a motion.
///
/// # Safety
/// Unless a pointer is NULL or misaligned, there are as many values, which nobody writes during `'a`.
unsafe fn ends<'a>(from: *const f64, to: *const f64, count: usize) -> Result<[&'a [f64]; 2], Failure> {
    // SAFETY: the caller guarantees the length.
    let from = unsafe { items(from, count, "from") }?;
    // SAFETY: as above.
    Ok([from, unsafe { items(to, count, "to") }?])
}

/// The witness that an answer's bodies and points were made from.
fn witness_of(near: &simdop_scene_clearance_answer) -> Option<SceneWitness> {
    let (hit, id) = (near.hit, BodyId::from_bits);
    let pair = Pair { a: hit.pair.a, b: hit.pair.b };
    (hit.a != SIMDOP_NO_BODY).then(|| SceneWitness {
        hit: SceneHit { a: id(hit.a), b: id(hit.b), pair },
        a: near.point_a,
        b: near.point_b,
    })
}

/// Do two bodies come within `margin` of each other in a configuration? `values` has a number for each variable that is
/// planned for. With the margin 0, it is free if none meet.
///
/// # Safety
/// The array has this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_within(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    margin: f64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        Ok(planner.within(workspace, values, margin)?.into())
    })
}

/// Which of `state_count` configurations are free? `values` has a number for each variable that is planned for, for the
/// first configuration, then for the second, and so on. `free` has room for a byte for each: 1 if it is certainly free,
/// otherwise 0. Writes the number of these to `count`. On failure, `free` is written, but means nothing.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_states(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    state_count: usize,
    free: *mut u8,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the lengths.
        let (values, free) = unsafe { many(values, planner.variables(), state_count, free) }?;
        planner.check_states(workspace, values, free).map_err(|error| {
            let mut each = values.chunks(planner.variables().max(1));
            let at_fault = each.position(|values| planner.is_free(workspace, values).is_err());
            Failure::from(error).of(&format!("configuration {}", at_fault.unwrap_or(0)))
        })?;
        Ok(free.iter().filter(|free| **free).count())
    })
}

/// Which of `point_count` points of the world are within `margin` of the robot in a configuration, or inside it? Remove
/// these points from a scan before it becomes an obstacle. Attached objects are parts of the robot. A point that is not
/// finite is not near. `values` has a number for each variable that is planned for, and `points` three for each point.
/// `near` has room for a byte for each: 1 if it is near, otherwise 0. Writes the number of near points to `count`. The
/// call allocates.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_near_robot(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    points: *const f32,
    point_count: usize,
    margin: f64,
    near: *mut u8,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        // SAFETY: as above; three numbers in a row are aligned as one.
        let points: &[[f32; 3]] = unsafe { items(points.cast(), point_count, "points") }?;
        // SAFETY: as above.
        let near = unsafe { places(near, point_count, "near") }?;
        let found = planner.near_robot(workspace, values, points, margin)?;
        for (place, is_near) in near.iter_mut().zip(&found) {
            place.write((*is_near).into());
        }
        Ok(found.iter().filter(|is_near| **is_near).count())
    })
}

/// Is the straight motion from one configuration to another free at all times? Continuous joints rotate the shorter way
/// around. `from` and `to` have a number for each variable that is planned for.
///
/// # Safety
/// The arrays have this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_motion(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    from: *const f64,
    to: *const f64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the lengths.
        let ends = unsafe { ends(from, to, planner.variables()) }?;
        Ok(planner.check_motion(workspace, ends)?.into())
    })
}

/// Like simdop_planner_check_motion(), but only at `parts` + 1 evenly spaced times. The verdict is never free: nothing
/// is certain between these times.
///
/// # Safety
/// The arrays have this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_motion_discrete(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    from: *const f64,
    to: *const f64,
    parts: u32,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the lengths.
        let ends = unsafe { ends(from, to, planner.variables()) }?;
        let parts = NonZeroU32::new(parts);
        let parts = parts.ok_or_else(|| Failure::new(simdop_error::MotionNoParts, "parts is 0".into()))?;
        Ok(planner.check_motion_discrete(workspace, ends, parts)?.into())
    })
}

/// Which of `motion_count` straight motions are free at all times? `ends` has the values of the start and of the end of
/// the first motion, then those of the second motion, and so on. `free` and `count` are as in
/// simdop_planner_check_states().
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_motions(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    ends: *const f64,
    motion_count: usize,
    free: *mut u8,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the lengths.
        let (ends, free) = unsafe { many(ends, 2 * planner.variables(), motion_count, free) }?;
        planner.check_motions(workspace, ends, free)?;
        Ok(free.iter().filter(|free| **free).count())
    })
}

/// How much of a straight motion, as a fraction from its start, is free at all times? Writes 1 for the whole motion,
/// and 0 if not even the start is free. Otherwise the motion to `from` + share (`to` - `from`) is free, where
/// continuous joints rotate the shorter way around, and a hit or an unresolved time follows after at most 1/1024 of the
/// motion.
///
/// # Safety
/// The arrays have a number for each variable that is planned for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_free_share(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    from: *const f64,
    to: *const f64,
    share: Option<&mut MaybeUninit<f64>>,
) -> simdop_error {
    answered(share, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the lengths.
        let ends = unsafe { ends(from, to, planner.variables()) }?;
        Ok(planner.free_share(workspace, ends)?)
    })
}

/// Calls `on_hit` with `user` once for each pair of bodies that come within `margin` of each other in a configuration.
/// The callback must not use the workspace. Otherwise like simdop_scene_each_hit().
///
/// # Safety
/// `values` has a number for each variable that is planned for, and `user`, which may be NULL, is what `on_hit`
/// expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_each_hit(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    margin: f64,
    on_hit: simdop_on_hit,
    user: *mut c_void,
    hits: Option<&mut MaybeUninit<simdop_scene_hits>>,
) -> simdop_error {
    answered(hits, || {
        let ((planner, workspace), on_hit) = (both(planner, workspace)?, given(on_hit, "on_hit")?);
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        let visit = |hit: SceneHit| {
            // SAFETY: the caller guarantees that `user` is what the function expects; the hit lives during the call.
            match unsafe { on_hit(user, &hit.into()) } {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let (completion, pairs, stats) = planner.for_each_hit(workspace, values, margin, visit)?;
        Ok(simdop_scene_hits { completion: completion.into(), pairs, stats: stats.into() })
    })
}

/// The least distance of two bodies in a configuration: like simdop_scene_clearance().
///
/// # Safety
/// `values` has a number for each variable that is planned for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_clearance(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    tolerance: f64,
    cutoff: f64,
    answer: Option<&mut MaybeUninit<simdop_scene_clearance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        Ok(planner.clearance(workspace, values, tolerance, cutoff)?.into())
    })
}

/// Writes the derivative of a clearance with respect to each variable that is planned for, in the bodies' unit per unit
/// of the variable. `near` is what simdop_planner_clearance() wrote, which must have been the last query of the
/// workspace. Zeros if it has no hit, or its points coincide.
///
/// # Safety
/// `gradient` has room for a number for each variable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_clearance_gradient(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    near: Option<&simdop_scene_clearance_answer>,
    gradient: *mut f64,
) -> simdop_error {
    guarded(|| {
        let ((planner, workspace), near) = (both(planner, workspace)?, given(near, "near")?);
        // SAFETY: the caller guarantees the room.
        let gradient = filled(unsafe { places(gradient, planner.variables(), "gradient") }?, 0.0);
        match witness_of(near) {
            Some(witness) => Ok(planner.clearance_gradient(workspace, &witness, gradient)?),
            None => Ok(()),
        }
    })
}

/// Writes the position in the world of a point of a body, in the last configuration of the workspace. `point` has three
/// numbers, in the body's frame.
///
/// # Safety
/// `point` has three numbers, and `world` has room for them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_to_world(
    planner: Option<&simdop_planner>,
    workspace: Option<&simdop_workspace>,
    id: simdop_body_id,
    point: *const f64,
    world: *mut f64,
) -> simdop_error {
    guarded(|| {
        let (planner, workspace) = (&given(planner, "planner")?.scene, &given(workspace, "workspace")?.0);
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one, here and below.
        let point = unsafe { items(point.cast::<[f64; 3]>(), 1, "point") }?[0];
        // SAFETY: as above.
        let world = unsafe { places(world.cast::<[f64; 3]>(), 1, "world") }?;
        world[0].write(planner.to_world(workspace, BodyId::from_bits(id), point)?);
        Ok(())
    })
}

/// Do two bodies meet never, always, or sometimes, within the limits of all joints of the robot? Like
/// simdop_scene_classify_pair(): `meeting` and `free` have room for a number for each variable of the robot, whether or
/// not it is planned for. The call allocates.
///
/// # Safety
/// The arrays have this room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_classify_pair(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    a: simdop_body_id,
    b: simdop_body_id,
    boxes: usize,
    meeting: *mut f64,
    free: *mut f64,
    report: Option<&mut MaybeUninit<simdop_pair_report>>,
) -> simdop_error {
    answered(report, || {
        let (planner, workspace) = both(planner, workspace)?;
        let variables = planner.robot().robot().limits.len();
        // SAFETY: the caller guarantees the room.
        let meeting = unsafe { places(meeting, variables, "meeting") }?;
        // SAFETY: as above.
        let free = unsafe { places(free, variables, "free") }?;
        let pair = (BodyId::from_bits(a), BodyId::from_bits(b));
        Ok(report_of(planner.classify_pair(workspace, pair, boxes)?, meeting, free))
    })
}

/// Writes the least signed distance of two bodies in a configuration, like simdop_scene_signed_clearance(). Writes its
/// derivative with respect to each variable to `gradient`: that of a distance, or of `lower` if bodies meet.
///
/// # Safety
/// `values` and `gradient` have a number for each variable that is planned for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_signed_clearance(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    tolerance: f64,
    cutoff: f64,
    gradient: *mut f64,
    answer: Option<&mut MaybeUninit<simdop_scene_signed_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        // SAFETY: as above.
        let gradient = filled(unsafe { places(gradient, planner.variables(), "gradient") }?, 0.0);
        Ok(planner.signed_clearance(workspace, values, tolerance, cutoff, gradient)?.into())
    })
}
