//! Motions of the caller's: functions that the library calls back.

use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use simdop::motion::{CarriedBall, Motion};
use simdop::pose::{Pose, PoseError};
use std::ffi::{c_int, c_void};
use std::fmt;

/// A motion of some bodies over the times from 0 to 1, by functions of the caller's. They get `user`, and bodies by their place
/// in the list of those that move. They must return, without an exception or a longjmp(), and must not use the scene that the
/// question is about. At the same time a motion must always have the same poses and paths.
#[repr(C)]
#[derive(Copy, Clone)]
pub struct simdop_motion {
    /// What the functions are called with. May be NULL.
    pub user: *mut c_void,
    /// Writes where all bodies are in the world at a time: as many poses as bodies move, each of which is then checked. One that
    /// is left as it was is SIMDOP_ERROR_POSE_NOT_FINITE. Returns 0; anything else stops the query with
    /// SIMDOP_ERROR_MOTION_STOPPED, for instance because it takes too long.
    pub go_to: Option<unsafe extern "C" fn(user: *mut c_void, time: f64, poses: *mut simdop_pose) -> c_int>,
    /// How far a point of a ball, which a body carries as if the ball were part of it, gets at most from where it is at the time
    /// last gone to, at any time that is at most `span` before or after, within 0 to 1. `centre` has three numbers: where the
    /// ball's centre is in the world at the time last gone to.
    ///
    /// The verdict rests on this bound: one that is too small makes verdicts wrong. It must have room for the rounding of the
    /// poses that are written. One that is larger than need be only costs time. NaN, a negative number and one beyond 2^300
    /// count as infinite, by which nothing is certified.
    pub path: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            body: usize,
            centre: *const f64,
            radius: f64,
            span: f64,
        ) -> f64,
    >,
    /// The same of two balls that two moving bodies carry, as one sees the other: no two points of theirs come nearer to each
    /// other than they are at the time last gone to by more than this. May be NULL: then it is the sum of both paths. More
    /// than that it need never be, and less it is where both bodies are moved by the same, as the links of an arm are.
    pub motion_bound_between: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            body_a: usize,
            centre_a: *const f64,
            radius_a: f64,
            body_b: usize,
            centre_b: *const f64,
            radius_b: f64,
            span: f64,
        ) -> f64,
    >,
}

impl fmt::Debug for simdop_motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("simdop_motion").field("user", &self.user).finish_non_exhaustive()
    }
}

/// A motion that calls back.
pub(crate) struct Called<'m> {
    motion: simdop_motion,
    /// What `go_to` writes to: a place for each body.
    written: &'m mut [simdop_pose],
    /// Why the motion failed, if it did.
    failure: Option<Failure>,
}

impl<'m> Called<'m> {
    /// # Safety
    /// As long as this lives, the motion's functions may be called: `user` is what they take it for, and they do what is said of
    /// them.
    pub(crate) unsafe fn new(motion: simdop_motion, written: &'m mut [simdop_pose]) -> Self {
        Self { motion, written, failure: None }
    }

    /// What a query of the motion came to.
    pub(crate) fn conclude<T>(self, answer: Result<T, impl Into<Failure>>) -> Result<T, Failure> {
        match self.failure {
            Some(failure) => Err(failure),
            None => answer.map_err(Into::into),
        }
    }

    /// Keeps why there are no poses, to be said in the end.
    fn fail(&mut self, failure: Failure, error: PoseError) -> Result<(), PoseError> {
        self.failure = Some(failure);
        Err(error)
    }
}

/// A bound that a function of the caller's returned.
fn bound(path: f64) -> f64 {
    if path >= 0.0 { path } else { f64::INFINITY }
}

impl Motion for Called<'_> {
    fn bodies(&self) -> usize {
        self.written.len()
    }

    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError> {
        self.written.fill(simdop_pose::UNWRITTEN);
        let stopped = match self.motion.go_to {
            // SAFETY: it may be called, by the promise of `new`; there is a place for each body's pose.
            Some(go_to) => unsafe { go_to(self.motion.user, time, self.written.as_mut_ptr()) },
            None => 0,
        };
        if stopped != 0 {
            let message = format!("go_to returned {stopped} at the time {time}");
            // The library passes on that there is no pose; what is said of it is the above.
            return self.fail(Failure::new(simdop_error::MotionStopped, message), PoseError::NotFinite);
        }
        for (i, pose) in poses.iter_mut().enumerate() {
            *pose = match self.written[i].checked() {
                Ok(pose) => pose,
                Err(error) => {
                    let name = format!("pose {i} of a motion at the time {time}");
                    return self.fail(Failure::from(error).of(&name), error);
                }
            }
        }
        Ok(())
    }

    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64 {
        let Some(path) = self.motion.path else { return f64::INFINITY };
        // SAFETY: it may be called, by the promise of `new`; the centre has three numbers, which are there during the call.
        bound(unsafe { path(self.motion.user, i, ball.centre.as_ptr(), ball.radius, span) })
    }

    fn motion_bound_between(
        &self,
        (i, a): (usize, &CarriedBall),
        (j, b): (usize, &CarriedBall),
        span: f64,
    ) -> f64 {
        let Some(path) = self.motion.motion_bound_between else {
            return self.motion_bound(i, a, span) + self.motion_bound(j, b, span);
        };
        let (p, q) = (a.centre.as_ptr(), b.centre.as_ptr());
        // SAFETY: as of `path`, for two.
        bound(unsafe { path(self.motion.user, i, p, a.radius, j, q, b.radius, span) })
    }
}
