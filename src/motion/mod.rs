//! Motions: where bodies are at any time from 0 to 1, and how far they can get within a span of it.
//!
//! A bound of the way is what makes an edge of a planner certain ([`crate::scene::Scene::check_motion`]): two bodies that are farther
//! apart at one time than they can come closer within a span of it do not meet in all of the span. Sampled times prove nothing
//! about the times between them.

mod error;
mod joint_motion;
mod joints;
mod screw;

pub use error::MotionError;
pub use joint_motion::JointMotion;
pub use joints::{Joint, JointKind, Kinematics, LinkBody, LinkFrame};
pub use screw::{Screw, ScrewMotion};

use crate::exact::power_of_two;
use crate::pose::{Pose, PoseError};
use crate::range::Point;
use crate::vector::{cross, length};

/// A ball in the world, at the time that a motion was asked about, which moves with a body as if it were part of it.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct CarriedBall {
    /// Its centre in the world.
    pub centre: Point,
    /// Its radius.
    pub radius: f64,
}

/// A motion of some bodies, numbered from 0, over the times from 0 to 1.
pub trait Motion {
    /// How many bodies it moves.
    fn bodies(&self) -> usize;

    /// Goes to a time, and writes where the bodies are then in the world.
    ///
    /// # Errors
    /// [`PoseError`] if one is where no pose can be.
    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError>;

    /// No point of the ball, which body i carries, is farther from where it is at the time gone to than this, at any time that
    /// is at most `span` before or after, within 0 to 1. In the bodies' unit. The rounding of the pose that was written is
    /// heeded: the point is where that pose puts it.
    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64;

    /// The same of what two bodies carry, as one sees the other: no two points come nearer to each other than they are at the
    /// time gone to by more than this. Never more than the sum of both paths; less where both are moved by the same.
    fn motion_bound_between(&self, a: (usize, &CarriedBall), b: (usize, &CarriedBall), span: f64) -> f64 {
        self.motion_bound(a.0, a.1, span) + self.motion_bound(b.0, b.1, span)
    }
}

/// Bounds what rounding does to a place that some turns about axes lead to, of the coordinates on the way and a turn: each of
/// them costs two products of poses, the sine and cosine of an angle which itself is rounded, and a sum, less than 2^-46 of them.
const ROUNDING: f64 = power_of_two(-44);

/// How far a point gets at most that is `distance` from an axis and turns about it by at most `angle`: the chord is not longer
/// than the arc, nor than twice the distance.
#[inline(always)]
fn chord(angle: f64, distance: f64) -> f64 {
    (if angle < 2.0 { angle } else { 2.0 }) * distance
}

/// The sum of the magnitudes: never less than the length.
#[inline(always)]
fn magnitude(a: &Point) -> f64 {
    (a[0].abs() + a[1].abs()) + a[2].abs()
}

/// How far a point is from an axis through the origin, whose direction is a unit vector.
#[inline(always)]
fn distance_from_axis(p: &Point, direction: &Point) -> f64 {
    length(&cross(p, direction))
}

/// A direction made a unit vector; `None` if it is none.
fn unit(direction: &Point) -> Option<Point> {
    let greatest = direction.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if !(greatest > 0.0 && greatest.is_finite()) || direction.iter().any(|x| x.is_nan()) {
        return None;
    }
    let [x, y, z] = direction.map(|x| x / greatest);
    let length = length(&[x, y, z]);
    Some([x / length, y / length, z / length])
}
