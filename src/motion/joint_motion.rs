//! Straight edges: all variables of a robot change at constant speed.
//!
//! **Motion bound of a link.** Let link l carry a ball, let m be the current time, and let t be within the span. Move
//! the joints between the base and l from their values at m to those at t one at a time, the joint nearest to l first.
//! When joint j moves, the joints before it still have their values at m. So its axis is where it was at m, and it
//! applies a rigid motion R in the world. Consider a point that is at p at time m, and that the joints between j and l
//! have moved to `p + u`. It moves to `R (p + u)`, and its displacement from p is `(R p - p) + R u`. So each joint adds
//! at most the displacement of p under R. A rotation by at most a adds the chord of a at the distance of p from the
//! axis, which is at most the distance of the ball's centre plus its radius. A translation along the axis adds its
//! length.
//!
//! The motion of one link relative to another depends only on the joints between each of the two and their last common
//! ancestor. These form a chain from one link to the other, so the bound may let all of them move the ball of either
//! link.

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
    /// The motion from the values `from` to the values `to`, both within the limits. `values` must hold an entry for
    /// each variable, and `links` one for each link ([`Kinematics::links`]).
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

    /// As [`Motion::motion_bound_between`], or less: the least of three bounds, in which the joints of each link move
    /// its own ball, or the joints of both move either ball. A body that stands still has `None` instead of a number.
    #[cfg(feature = "alloc")]
    pub(crate) fn least_bound_between(
        &self,
        (i, a): (Option<usize>, &CarriedBall),
        (j, b): (Option<usize>, &CarriedBall),
        span: f64,
    ) -> f64 {
        let links = [i, j].map(|body| body.map_or(0, |body| self.kinematics.bodies()[body].link as usize));
        let common = self.common_link(links);
        let [[aa, ab], [ba, bb]] =
            links.map(|link| [a, b].map(|ball| self.motion_bound_from(link, common, ball, span)));
        // Rounding of each body's own points, whichever ball the joints move.
        let rounding = |body: Option<usize>, link: usize, ball: &CarriedBall, path: f64| {
            self.rounding_along(link, common, ball, path) + body.map_or(0.0, |i| self.rounding(i, ball))
        };
        (aa + bb).min(aa + ba).min(ab + bb) + (rounding(i, links[0], a, aa) + rounding(j, links[1], b, bb))
    }

    /// Rounding of the joints of [`JointMotion::motion_bound_from`], which returns `path`.
    #[cfg(feature = "alloc")]
    fn rounding_along(&self, mut link: usize, base: usize, ball: &CarriedBall, path: f64) -> f64 {
        let mut all = 0.0;
        while link != base {
            let (joint, at) = (&self.kinematics.joints()[link - 1], &self.links[link]);
            let variable = joint.variable() as usize;
            let value = 1.0 + joint.magnitude_of(self.from[variable].abs().max(self.to[variable].abs()));
            let to_origin = difference(&ball.centre, &at.origin);
            all += value * (magnitude(&to_origin) + magnitude(&at.origin) + (ball.radius + path));
            link = self.kinematics.parent_of(link);
        }
        ROUNDING * all
    }

    /// The last common ancestor of two links.
    fn common_link(&self, [mut p, mut q]: [usize; 2]) -> usize {
        // Links come after their ancestors.
        while p != q {
            if p > q {
                p = self.kinematics.parent_of(p);
            } else {
                q = self.kinematics.parent_of(q);
            }
        }
        p
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
        let p = self.common_link(links);
        (self.motion_bound_from(links[0], p, a, span) + self.motion_bound_from(links[1], p, b, span))
            + (self.rounding(i, a) + self.rounding(j, b))
    }
}

#[cfg(all(test, feature = "alloc"))]
mod tests {
    use super::*;
    use crate::motion::{Joint, LinkBody};
    use crate::random::SplitMix64;
    use crate::range::Point;
    use crate::vector::length;
    use alloc::vec::Vec;

    fn within(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
        low + (high - low) * (random.bits() as f64 / 2.0_f64.powi(64))
    }

    fn point(random: &mut SplitMix64, reach: f64) -> Point {
        [(); 3].map(|()| within(random, -reach, reach))
    }

    /// No two points of two balls approach or recede by more than the least bound, which is below the sum of both
    /// bodies' own motion bounds.
    #[test]
    fn no_points_approach_more_than_the_least_bound() {
        let mut random = SplitMix64(17);
        let (mut worst, mut less) = (0.0_f64, 0);
        for _ in 0..400 {
            // Two branches of three joints each, on a common one.
            let joint = |i: u32, random: &mut SplitMix64| {
                let kind = if i.is_multiple_of(3) { JointKind::Prismatic } else { JointKind::Revolute };
                let turn = glam::DQuat::from_euler(glam::EulerRot::ZYX, within(random, -3.0, 3.0), 0.4, 1.0);
                let at = glam::DVec3::from_array(point(random, 0.5));
                let origin = Pose::try_from((turn, at)).unwrap();
                Joint::new(kind, if i == 4 { 1 } else { i }, origin, point(random, 1.0), i).unwrap()
            };
            let joints: Vec<Joint> = (0..7).map(|i| joint(i, &mut random)).collect();
            let bodies = [4, 7].map(|link| LinkBody { link, at: Pose::IDENTITY });
            let limits = [[-3.0, 3.0]; 7];
            let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
            let half = within(&mut random, 0.01, 0.3);
            let middle: Vec<f64> = (0..7).map(|_| within(&mut random, -2.5, 2.5)).collect();
            let [from, to] = [-half, half].map(|by| middle.iter().map(|x| x + by).collect::<Vec<f64>>());
            let (mut now, mut links) = ([0.0; 7], [LinkFrame::EMPTY; 8]);
            let mut poses = [Pose::IDENTITY; 2];
            let mut motion = JointMotion::new(robot, [&from, &to], &mut now, &mut links).unwrap();
            motion.go_to(0.5, &mut poses).unwrap();
            let radii = [0.05, 0.4];
            let balls = [0, 1].map(|i| CarriedBall { centre: poses[i].translation(), radius: radii[i] });
            let bound = motion.least_bound_between((Some(0), &balls[0]), (Some(1), &balls[1]), 0.5);
            let sum = motion.motion_bound_between((0, &balls[0]), (1, &balls[1]), 0.5);
            less += usize::from(bound < 0.9 * sum);
            let apart = |poses: &[Pose; 2], [p, q]: [&Point; 2]| {
                length(&difference(&poses[0].unflushed(p), &poses[1].unflushed(q)))
            };
            let (mut other_links, mut other) = ([LinkFrame::EMPTY; 8], [Pose::IDENTITY; 2]);
            for corner in 0..20 {
                let end = |x: &f64| match corner {
                    0..10 if random.bits() & 1 == 0 => x + half,
                    0..10 => x - half,
                    _ => within(&mut random, x - half, x + half),
                };
                let values: Vec<f64> = middle.iter().map(end).collect();
                robot.go_to(&values, &mut other_links, &mut other).unwrap();
                for _ in 0..10 {
                    let points = [0, 1].map(|i| point(&mut random, radii[i] / 3.0_f64.sqrt()));
                    let points = [&points[0], &points[1]];
                    let change = (apart(&poses, points) - apart(&other, points)).abs();
                    assert!(change <= bound, "{change} above {bound}");
                    worst = worst.max(change / bound);
                }
            }
        }
        assert!(worst > 0.3 && less > 50, "{worst} {less}");
    }
}
