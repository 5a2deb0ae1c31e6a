//! Straight edges: all variables of a robot change at constant speed.
//!
//! **Motion bound of a link.** Let link l carry a ball, let m be the current time, and let t be within the span. Bring
//! the joints between the base and l from their values at m to those at t one after the other, the joint nearest to l
//! first. When joint j changes, the joints before it still have their values at m. So its axis is where it is at m, and
//! its change is a rigid motion R in the world. A point that is at p at time m, and that the joints behind j have
//! brought to `p + u`, comes to `R (p + u)`, which is `(R p - p) + R u` from p. So each joint adds at most what it
//! would do to p alone. A rotation by at most a adds the chord of a at the distance of p from the axis, which is at
//! most that of the ball's centre plus its radius. A translation along the axis adds its length.
//!
//! The motion of one link relative to another depends only on the joints between them: for each of the two links, the
//! joints up to their last common ancestor.

use super::{
    CarriedBall, JointKind, Kinematics, LinkFrame, Motion, MotionError, ROUNDING, chord, distance_from_axis,
    magnitude,
};
use crate::pose::{Pose, PoseError};
use crate::vector::difference;

/// A straight edge in the space of a robot's variables.
#[derive(Debug)]
pub struct JointMotion<'m> {
    kinematics: Kinematics<'m>,
    from: &'m [f64],
    to: &'m [f64],
    values: &'m mut [f64],
    links: &'m mut [LinkFrame],
}

impl<'m> JointMotion<'m> {
    /// From the values `from` to the values `to`, both within the limits. `values` must hold an entry for each
    /// variable, and `links` one for each link ([`Kinematics::links`]).
    ///
    /// # Errors
    /// Those of [`Kinematics::check`] for either end; [`MotionError::Length`] if `values` or `links` is too short.
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

    /// Upper bound of how far a ball carried by `link` moves relative to `base`, an ancestor of `link`, within `span`.
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
            // Holds for angles and lengths alike.
            let value = 1.0 + joint.magnitude_of(from.abs().max(to.abs()));
            let coordinates = magnitude(&to_origin) + magnitude(&at.origin) + (ball.radius + path);
            path += ROUNDING * (value * coordinates);
            link = self.kinematics.parent_of(link);
        }
        path
    }

    /// Rounding of the pose of a body on its link, and of a point of the body.
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
        // Links come after their ancestors.
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
