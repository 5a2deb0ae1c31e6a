//! Straight edges: all variables of a robot change at constant speed.
//!
//! **How far a link gets.** Let a ball be carried by link l, at the values of time m, and let t be within the span. The joints
//! between the base and l are brought from their values at m to those at t one after the other, that nearest to l first. When
//! joint j is changed, those before it are still as at m, so that its axis is where it is at m, and the change is a motion R in the
//! world. A point that is at p at time m, and has been brought to `p + u` by the joints behind, comes to `R (p + u)`, which is
//! `(R p - p) + R u` from p. So each joint adds at most what it would do to p alone: of a turn by at most a, the chord of a at the
//! distance of p from the axis, which is at most that of the ball's centre and its radius; of a way along the axis, the way.
//!
//! As one link sees another, only the joints between them move: each link from the last that both are on.

use super::{
    CarriedBall, JointKind, Kinematics, LinkFrame, Motion, MotionError, ROUNDING, chord, distance_from_axis,
    magnitude,
};
use crate::pose::{Pose, PoseError};
use crate::vector::difference;

/// A straight way of a robot from some values of its variables to others.
#[derive(Debug)]
pub struct JointMotion<'m> {
    kinematics: Kinematics<'m>,
    from: &'m [f64],
    to: &'m [f64],
    values: &'m mut [f64],
    links: &'m mut [LinkFrame],
}

impl<'m> JointMotion<'m> {
    /// From some values to others, within the limits. Lent are a place for each variable and for each link
    /// ([`Kinematics::links`]).
    ///
    /// # Errors
    /// Those of [`Kinematics::check`] for either values; [`MotionError::Length`] of what is lent.
    pub fn new(
        kinematics: Kinematics<'m>,
        [from, to]: [&'m [f64]; 2],
        values: &'m mut [f64],
        links: &'m mut [LinkFrame],
    ) -> Result<Self, MotionError> {
        kinematics.check(from)?;
        kinematics.check(to)?;
        kinematics.check_room(links, kinematics.bodies().len())?;
        if values.len() < from.len() {
            return Err(MotionError::Length { given: values.len(), needed: from.len() });
        }
        Ok(Self { kinematics, from, to, values, links })
    }

    /// How far from where it is now a ball of a link may get, as one sees it who stands on another link that it hangs on.
    fn motion_bound_from(&self, mut link: usize, base: usize, ball: &CarriedBall, span: f64) -> f64 {
        let mut path = 0.0;
        while link != base {
            let (joint, at) = (&self.kinematics.joints()[link - 1], &self.links[link]);
            let to_origin = difference(&ball.centre, &at.origin);
            let variable = joint.variable() as usize;
            let (from, to) = (self.from[variable], self.to[variable]);
            let change = joint.change_of(span * (to - from));
            path += match joint.kind() {
                JointKind::Revolute => chord(change, distance_from_axis(&to_origin, &at.axis) + ball.radius),
                JointKind::Prismatic => change,
            };
            // Of angles and ways alike.
            let value = 1.0 + joint.magnitude_of(from.abs().max(to.abs()));
            let coordinates = magnitude(&to_origin) + magnitude(&at.origin) + (ball.radius + path);
            path += ROUNDING * (value * coordinates);
            link = self.kinematics.parent_of(link);
        }
        path
    }

    /// What rounding does to the pose of a body on its link, and to a point of it.
    fn rounding(&self, i: usize, ball: &CarriedBall) -> f64 {
        let body = &self.kinematics.bodies()[i];
        let origin = self.links[body.link as usize].frame.translation();
        ROUNDING
            * ((magnitude(&body.at.translation()) + magnitude(&origin))
                + (magnitude(&ball.centre) + ball.radius))
    }
}

impl Motion for JointMotion<'_> {
    fn bodies(&self) -> usize {
        self.kinematics.bodies().len()
    }

    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError> {
        for (value, (from, to)) in self.values.iter_mut().zip(self.from.iter().zip(self.to)) {
            *value = from + time * (to - from);
        }
        self.kinematics.place(self.values, self.links, poses)
    }

    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64 {
        let link = self.kinematics.bodies()[i].link as usize;
        self.motion_bound_from(link, 0, ball, span) + self.rounding(i, ball)
    }

    fn motion_bound_between(
        &self,
        (i, a): (usize, &CarriedBall),
        (j, b): (usize, &CarriedBall),
        span: f64,
    ) -> f64 {
        let links = [i, j].map(|body| self.kinematics.bodies()[body].link as usize);
        let [mut p, mut q] = links;
        // Links come behind those that they hang on.
        while p != q {
            if p > q {
                p = self.kinematics.parent_of(p);
            } else {
                q = self.kinematics.parent_of(q);
            }
        }
        (self.motion_bound_from(links[0], p, a, span) + self.motion_bound_from(links[1], p, b, span))
            + (self.rounding(i, a) + self.rounding(j, b))
    }
}
