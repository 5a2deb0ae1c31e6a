//! Paths and free configurations.

use super::{both, simdop_planner, simdop_workspace};
use crate::boundary::{answered, given, guarded, items, places};
use crate::error::{Failure, simdop_error};
use simdop::planning::PlanSettings;
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;

/// How to plan. Start from simdop_plan_settings_default().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_plan_settings {
    /// Longest motion that extends a tree, as a distance in joint space. Positive.
    pub step: f64,
    /// Maximum number of random configurations.
    pub configurations: u32,
    /// Number of straight motions that are tried to shorten the path.
    pub shortcuts: u32,
    /// Seed of the random numbers. The same seed gives the same path on every machine.
    pub seed: u64,
}

/// The answer of simdop_planner_plan().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_planned_path {
    /// Number of configurations of the path, both ends included. 0 if no path was found.
    pub count: usize,
    /// Length of the path in joint space.
    pub length: f64,
    /// Number of motions that were checked.
    pub motions: u32,
    /// Number of configurations in both trees.
    pub nodes: usize,
}

/// A step of 1, 100,000 configurations, 100 shortcuts and the seed 1.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_plan_settings_default() -> simdop_plan_settings {
    let PlanSettings { step, configurations, shortcuts, seed } = PlanSettings::default();
    simdop_plan_settings { step, configurations, shortcuts, seed }
}

/// Plans a path by RRT-Connect from `start` to one of `goal_count` goals: straight motions that are free at all times.
/// `start` has a number for each variable that is planned for, and `goals` has as many for each goal, one after the
/// other. Goals that are not free are ignored; if the start is not free, there is no path.
///
/// Writes the configurations of the path, one after the other, to `path`, which has room for `room` of them. Writes
/// their number to `answer`, even if it exceeds `room`, which is SIMDOP_ERROR_BUFFER. The call allocates.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_plan(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    start: *const f64,
    goals: *const f64,
    goal_count: usize,
    settings: Option<&simdop_plan_settings>,
    path: *mut f64,
    room: usize,
    answer: Option<&mut MaybeUninit<simdop_planned_path>>,
) -> simdop_error {
    guarded(|| {
        let ((planner, workspace), answer) = (both(planner, workspace)?, given(answer, "answer")?);
        let simdop_plan_settings { step, configurations, shortcuts, seed } = *given(settings, "settings")?;
        let variables = planner.variables();
        let too_large = || Failure::new(simdop_error::TooLarge, "a path or its goals".into());
        // SAFETY: the caller guarantees the length.
        let start = unsafe { items(start, variables, "start") }?;
        let all = variables.checked_mul(goal_count).ok_or_else(too_large)?;
        // SAFETY: as above.
        let goals = unsafe { items(goals, all, "goals") }?;
        let all = variables.checked_mul(room).ok_or_else(too_large)?;
        // SAFETY: as above.
        let path = unsafe { places(path, all, "path") }?;
        let goals: Vec<&[f64]> = goals.chunks(variables.max(1)).collect();
        let settings = PlanSettings { step, configurations, shortcuts, seed };
        let found = planner.plan(workspace, start, &goals, &settings)?;
        let count = found.path.len();
        let written =
            simdop_planned_path { count, length: found.length, motions: found.motions, nodes: found.nodes };
        answer.write(written);
        if count > room {
            let message = format!("{count} configurations of a path, and room for {room}");
            return Err(Failure::new(simdop_error::Buffer, message));
        }
        for (place, value) in path.iter_mut().zip(found.path.iter().flatten()) {
            place.write(*value);
        }
        Ok(())
    })
}

/// Returns a random number from 0 to 1, excluding 1. It must return, without an exception or a longjmp().
pub type simdop_random = Option<unsafe extern "C" fn(user: *mut c_void) -> f64>;

/// Writes a random free configuration to `values`, a number for each variable that is planned for, and 1 to `is_found`.
/// `random` is called with `user` for each random number. After `tries` configurations that are not free, writes 0 to
/// `is_found` and zeros to `values`. The call allocates.
///
/// # Safety
/// The array has this length, and `user`, which may be NULL, is what `random` expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_random_free(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    random: simdop_random,
    user: *mut c_void,
    tries: usize,
    values: *mut f64,
    is_found: Option<&mut MaybeUninit<c_int>>,
) -> simdop_error {
    answered(is_found, || {
        let ((planner, workspace), random) = (both(planner, workspace)?, given(random, "random")?);
        // SAFETY: the caller guarantees the room.
        let places = unsafe { places(values, planner.variables(), "values") }?;
        // SAFETY: the caller guarantees that `user` is what the function expects.
        let found = planner.random_free(workspace, || unsafe { random(user) }, tries)?;
        let is_found = found.is_some();
        for (place, value) in places.iter_mut().zip(found.into_iter().flatten().chain(std::iter::repeat(0.0)))
        {
            place.write(value);
        }
        Ok(is_found.into())
    })
}
