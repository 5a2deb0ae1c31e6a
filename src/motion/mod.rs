//! Motions: the poses of bodies at any time from 0 to 1, and bounds of how far they move within a span of time.
//!
//! Motion bounds certify the edges of a planner ([`crate::scene::Scene::check_motion`]): two bodies that are farther
//! apart at one time than they can approach each other within a span do not meet in that span. Samples prove nothing
//! about the times between them.

mod error;
mod jacobian;
mod joint_motion;
mod joints;
mod screw;

pub use error::MotionError;
pub use joint_motion::JointMotion;
pub use joints::{Base, Joint, JointKind, Kinematics, LinkBody, LinkFrame};
pub use screw::{Screw, ScrewMotion};

use crate::exact::power_of_two;
use crate::pose::{Pose, PoseError};
use crate::range::Point;
use crate::vector::{cross, length};

/// A ball in the world at a motion's current time, rigidly attached to a body.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct CarriedBall {
    /// Its centre in the world.
    pub centre: Point,
    /// Its radius.
    pub radius: f64,
}

/// A motion of bodies, numbered from 0, over the times from 0 to 1.
pub trait Motion {
    /// Number of bodies that it moves.
    fn bodies(&self) -> usize;

    /// Makes `time` the current time, and writes the world poses of the bodies at that time.
    ///
    /// # Errors
    /// [`PoseError`] if a pose is out of range.
    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError>;

    /// Upper bound, in the bodies' unit, of the distance of any point of the ball, carried by body i, from its current
    /// position, at any time that is at most `span` before or after the current time and within 0 to 1. The bound
    /// covers the rounding of the pose that [`Motion::go_to`] wrote: the current position is where that pose puts the
    /// point.
    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64;

    /// Upper bound of how much any two points of two carried balls approach each other within `span`, compared with the
    /// current time. At most the sum of both motion bounds; less where the same joints move both bodies.
    fn motion_bound_between(&self, a: (usize, &CarriedBall), b: (usize, &CarriedBall), span: f64) -> f64 {
        self.motion_bound(a.0, a.1, span) + self.motion_bound(b.0, b.1, span)
    }
}

/// Rounding allowance for each rotation on the way to a position, relative to the largest coordinates on the way. A
/// rotation takes two products of poses, the sine and cosine of a rounded angle, and a sum: their error is less than
/// 2^-46 of the coordinates.
const ROUNDING: f64 = power_of_two(-44);

/// Upper bound of how far a point at `distance` from an axis moves when it rotates about it by at most `angle`. The
/// chord is at most the arc, and at most twice the distance.
#[inline(always)]
fn chord(angle: f64, distance: f64) -> f64 {
    (if angle < 2.0 { angle } else { 2.0 }) * distance
}

/// The sum of the magnitudes: an upper bound of the length.
#[inline(always)]
fn magnitude(a: &Point) -> f64 {
    (a[0].abs() + a[1].abs()) + a[2].abs()
}

/// Distance of a point from an axis through the origin whose direction is a unit vector.
#[inline(always)]
fn distance_from_axis(p: &Point, direction: &Point) -> f64 {
    length(&cross(p, direction))
}
