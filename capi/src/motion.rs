//! Motions given by the caller as callbacks.

use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use simdop::motion::{CarriedBall, Motion};
use simdop::pose::{Pose, PoseError};
use std::ffi::{c_int, c_void};
use std::fmt;

/// A motion of some bodies over the times from 0 to 1, given by callbacks. They receive `user`, and refer to bodies by
/// index in the list of moving bodies. They must return, without an exception or a longjmp(), and must not use the
/// scene of the query. For equal times they must give equal poses and bounds.
#[repr(C)]
#[derive(Copy, Clone)]
pub struct simdop_motion {
    /// Passed to each callback. May be NULL.
    pub user: *mut c_void,
    /// Writes the poses of all moving bodies in the world at `time`: one pose for each moving body, each of which is
    /// then checked. A pose left unwritten is SIMDOP_ERROR_POSE_NOT_FINITE. Returns 0; any other value stops the query
    /// with SIMDOP_ERROR_MOTION_STOPPED, for instance after a timeout.
    pub go_to: Option<unsafe extern "C" fn(user: *mut c_void, time: f64, poses: *mut simdop_pose) -> c_int>,
    /// Returns an upper bound on how far any point of a ball that is rigidly attached to the body gets from its
    /// position at the time of the last `go_to`. The bound holds for all times from 0 to 1 that differ from that time
    /// by at most `span`. `centre` has three numbers: the centre of the ball in the world at the time of the last
    /// `go_to`.
    ///
    /// The verdict relies on this bound: one that is too small makes verdicts wrong. It must include the rounding of
    /// the poses that `go_to` writes. A loose bound costs only time. NaN, negative numbers and numbers beyond 2^300
    /// count as infinite, and certify nothing.
    pub path: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            body: usize,
            centre: *const f64,
            radius: f64,
            span: f64,
        ) -> f64,
    >,
    /// The same for two balls attached to two moving bodies, relative to each other: an upper bound on how much any two
    /// of their points approach each other, compared with the time of the last `go_to`. May be NULL: then the sum of
    /// both `path` bounds is used. The bound never needs to exceed that sum, and is smaller where both bodies share a
    /// motion, as the links of an arm do.
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

/// A motion given by callbacks.
pub(crate) struct Called<'m> {
    motion: simdop_motion,
    /// What `go_to` writes to: one pose for each moving body.
    written: &'m mut [simdop_pose],
    /// Why the motion failed, if it did.
    failure: Option<Failure>,
}

impl<'m> Called<'m> {
    /// # Safety
    /// While this value lives, the motion's callbacks may be called: `user` is what they expect, and they fulfil the
    /// contract of [`simdop_motion`].
    pub(crate) unsafe fn new(motion: simdop_motion, written: &'m mut [simdop_pose]) -> Self {
        Self { motion, written, failure: None }
    }

    /// The result of a query, or the failure of the motion.
    pub(crate) fn conclude<T>(self, answer: Result<T, impl Into<Failure>>) -> Result<T, Failure> {
        match self.failure {
            Some(failure) => Err(failure),
            None => answer.map_err(Into::into),
        }
    }

    /// Stores the failure, to be reported when the query ends.
    fn fail(&mut self, failure: Failure, error: PoseError) -> Result<(), PoseError> {
        self.failure = Some(failure);
        Err(error)
    }
}

/// A bound returned by a callback; infinite if it is invalid.
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
            // SAFETY: `new` requires that it may be called; there is room for each body's pose.
            Some(go_to) => unsafe { go_to(self.motion.user, time, self.written.as_mut_ptr()) },
            None => 0,
        };
        if stopped != 0 {
            let message = format!("go_to returned {stopped} at the time {time}");
            // The library reports only that the pose is invalid; the stored failure holds the cause.
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
        // SAFETY: `new` requires that it may be called; the centre has three numbers, which live during the call.
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
        // SAFETY: as for `path`, with two balls.
        bound(unsafe { path(self.motion.user, i, p, a.radius, j, q, b.radius, span) })
    }
}
