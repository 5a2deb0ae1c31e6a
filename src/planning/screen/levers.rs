//! Motion bounds of a robot's bodies within spans of a motion, for sixteen configurations at a time.
//!
//! The bound of [`JointMotion`](crate::motion::JointMotion): a joint that rotates by an angle moves the points of a
//! body by at most the angle, capped at 2, times the greatest distance of the body's ball from the joint's axis.
//!
//! **Error.** The ball is about the lanes' centre, with a radius that covers the body in the scene. The lanes' axis is
//! displaced from the scene's by the error of the joint's origin, and tilted by the error m of the link's matrix, that
//! is by m d at a distance of d along it. The cross product, its square and the root round by less than 32 u d.
//! [`Lever::reach`] includes all of these. Changes of joints and sums are rounded up by 2^-18.

use super::bodies::LaneBody;
use super::chain::{LaneChain, LaneFrame};
use super::lanes::{LANES, Lane16, Point16};
use crate::exact::power_of_two;
use crate::motion::{JointKind, Kinematics};
use alloc::vec::Vec;
use core::ops::Range;

/// Allowance for roundings, relative to a bound.
const ROUNDING: f64 = power_of_two(-18);

/// A joint that moves a body.
#[derive(Copy, Clone, Debug)]
struct Lever {
    /// The link that the joint moves.
    link: usize,
    kind: JointKind,
    /// Added to the distance of the body's centre from the axis.
    reach: f32,
}

/// The joints that move each body, from its link to the base.
#[derive(Clone, Debug)]
pub(super) struct Levers {
    all: Vec<Lever>,
    /// Index of the first lever of each body, and the total number.
    first: Vec<usize>,
    /// The variable of each joint, and the joint's multiplier.
    joints: Vec<(usize, f64)>,
    /// Allowance for the rounding of poses.
    more: f32,
    /// Estimate of how far a joint moves a point, per unit of its value.
    far: Vec<f32>,
}

impl Levers {
    /// `more` is the allowance for the rounding of poses.
    pub(super) fn new(
        kinematics: &Kinematics<'_>,
        chain: &LaneChain,
        bodies: &[LaneBody],
        more: f64,
    ) -> Self {
        let (mut all, mut first) = (Vec::new(), alloc::vec![0]);
        for body in bodies {
            let centre = body.whole.centre.map(f64::from);
            let mut link = body.link;
            while link > 0 {
                let joint = &kinematics.joints()[link - 1];
                let slack = chain.axis_error(link, body.link, &centre);
                let reach = (body.whole.outer + slack) * (1.0 + ROUNDING);
                all.push(Lever { link, kind: joint.kind(), reach: reach as f32 });
                link = joint.parent() as usize;
            }
            first.push(all.len());
        }
        let joints = kinematics.joints().iter();
        let joints: Vec<_> = joints.map(|joint| (joint.variable() as usize, joint.multiplier())).collect();
        let mut far = alloc::vec![0.0_f64; joints.len()];
        for (body, ends) in bodies.iter().zip(first.windows(2)) {
            for lever in &all[ends[0]..ends[1]] {
                let lever: &Lever = lever;
                let away = match lever.kind {
                    // Arms are seldom stretched, hence the factor.
                    JointKind::Revolute => {
                        0.5 * (chain.reach_from_base(body.link) - chain.reach_from_base(lever.link))
                    }
                    JointKind::Prismatic => 1.0,
                };
                far[lever.link - 1] = far[lever.link - 1].max(away + body.whole.outer);
            }
        }
        let far = far.into_iter().map(|away| away as f32).collect();
        Self { far, all, first, joints, more: (more * (1.0 + ROUNDING)) as f32 }
    }

    /// Number of levers of all bodies.
    pub(super) const fn len(&self) -> usize {
        self.all.len()
    }

    /// Number of joints.
    pub(super) const fn joints(&self) -> usize {
        self.joints.len()
    }

    /// The joints that move a body, as indices into `moved` in [`Levers::go_to`].
    pub(super) fn of(&self, body: usize) -> Range<usize> {
        self.first[body]..self.first[body + 1]
    }

    /// For each of two bodies, the number of joints that move it but not the other.
    pub(super) fn to_common(&self, bodies: [usize; 2]) -> [usize; 2] {
        let [p, q] = bodies.map(|body| &self.all[self.of(body)]);
        let both = p.iter().rev().zip(q.iter().rev()).take_while(|(p, q)| p.link == q.link).count();
        [p.len() - both, q.len() - both]
    }

    /// How much each joint changes along a motion of the variables.
    pub(super) fn changes(&self, [from, to]: [&[f64]; 2], changes: &mut [f32]) {
        for (change, &(variable, multiplier)) in changes.iter_mut().zip(&self.joints) {
            *change = ((multiplier * (to[variable] - from[variable])).abs() * (1.0 + ROUNDING)) as f32;
        }
    }

    /// Estimate of how far the fastest body moves along a motion.
    pub(super) fn far(&self, changes: &[f32]) -> f32 {
        changes.iter().zip(&self.far).map(|(change, far)| change * far).sum()
    }

    /// Upper bounds of how far a body moves, within spans of the motion around the configurations in the lanes,
    /// relative to the parent link of each of its joints: the last is relative to the base.
    #[inline(always)]
    pub(super) fn go_to(
        &self,
        body: usize,
        centre: &Point16,
        (frames, changes, spans): (&[LaneFrame], &[f32], &Lane16),
        moved: &mut [Lane16],
    ) {
        let mut sum = [0.0; LANES];
        for (lever, moved) in self.all[self.of(body)].iter().zip(&mut moved[self.of(body)]) {
            let change = changes[lever.link - 1];
            match lever.kind {
                JointKind::Revolute => {
                    let square = frames[lever.link].square_from_axis(centre);
                    for lane in 0..LANES {
                        let angle = change * spans[lane];
                        let angle = if angle < 2.0 { angle } else { 2.0 };
                        sum[lane] += angle * (square[lane].sqrt() + lever.reach);
                    }
                }
                JointKind::Prismatic => {
                    for lane in 0..LANES {
                        sum[lane] += change * spans[lane];
                    }
                }
            }
            *moved = sum;
        }
    }

    /// Upper bound of how much two bodies approach each other, from how far each moves; `None` for one that does not
    /// move.
    #[inline(always)]
    pub(super) fn approach(&self, [a, b]: [Option<&Lane16>; 2]) -> Lane16 {
        let mut sum = [self.more; LANES];
        for moved in [a, b].into_iter().flatten() {
            for lane in 0..LANES {
                sum[lane] += moved[lane];
            }
        }
        for of in &mut sum {
            *of *= 1.0 + ROUNDING as f32;
        }
        sum
    }
}
