//! How the points of a link move with the variables.

use super::{JointKind, Kinematics, LinkFrame};
use crate::range::Point;
use crate::vector::{cross, difference};

impl Kinematics<'_> {
    /// The derivatives of a point of a link with respect to each variable, at the values for which
    /// [`Kinematics::go_to`] computed `links`. The point is given in the world, and `derivatives[v]` is in its unit per
    /// unit of variable v. Entries of variables that do not move the link are set to zero; variables without an entry
    /// are ignored.
    pub fn point_jacobian(&self, links: &[LinkFrame], link: u32, point: Point, derivatives: &mut [Point]) {
        derivatives.fill([0.0; 3]);
        let mut link = link as usize;
        while link > 0 {
            let (Some(joint), Some(at)) = (self.joints().get(link - 1), links.get(link)) else { return };
            let moved = match joint.kind() {
                JointKind::Revolute => cross(&at.axis, &difference(&point, &at.origin)),
                JointKind::Prismatic => at.axis,
            };
            if let Some(derivative) = derivatives.get_mut(joint.variable() as usize) {
                *derivative = core::array::from_fn(|i| derivative[i] + joint.multiplier() * moved[i]);
            }
            link = joint.parent() as usize;
        }
    }
}
