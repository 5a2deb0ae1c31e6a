//! A robot, in a form independent of the file format.

use super::error::RobotError;
use super::shapes::LinkShape;
use super::srdf::DisabledPair;
use crate::motion::{Joint, Kinematics, LinkBody, MotionError};
use alloc::string::String;
use alloc::vec::Vec;

/// A robot from its description.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// The moving joints, each after its ancestors.
    pub joints: Vec<Joint>,
    /// Names of the variables: one for each moving joint that mimics no other.
    pub variables: Vec<String>,
    /// Lower and upper limits of the variables. For a continuous joint, one full turn either way.
    pub limits: Vec<[f64; 2]>,
    /// The bodies' poses on the links.
    pub bodies: Vec<LinkBody>,
    /// The bodies' shapes.
    pub shapes: Vec<LinkShape>,
    /// For each body, the name of its link in the description, which may be on a fixed joint.
    pub names: Vec<String>,
    /// Whether each variable belongs to a continuous joint: values that differ by full turns are the same.
    pub continuous: Vec<bool>,
    /// All links of the description, with and without bodies.
    pub links: Vec<RobotLink>,
}

/// A link of a description.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RobotLink {
    /// Its name.
    pub name: String,
    /// The joint to its parent, which may be fixed, and the parent link. `None` for the root.
    pub parent: Option<LinkParent>,
}

/// How a link is connected to its parent.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LinkParent {
    /// The parent's index in [`Robot::links`].
    pub link: usize,
    /// The name of the joint.
    pub joint: String,
}

impl Robot {
    /// The joints and bodies in the form that motions take.
    ///
    /// # Errors
    /// [`MotionError`] if the fields were changed to invalid values.
    pub fn kinematics(&self) -> Result<Kinematics<'_>, MotionError> {
        Kinematics::new(&self.joints, &self.bodies, &self.limits)
    }

    /// Pairs of bodies to test, by index: those whose relative pose depends on a joint, except those in `disabled`. In
    /// a scene, forbid these pairs to collide, and allow all others
    /// ([`Scene::forbid_collision`](crate::scene::Scene::forbid_collision)).
    ///
    /// # Errors
    /// [`RobotError::UnknownLink`] if `disabled` names a link that the robot does not have.
    pub fn pairs(&self, disabled: &[DisabledPair]) -> Result<Vec<(usize, usize)>, RobotError> {
        for DisabledPair { links, line, .. } in disabled {
            for link in links {
                self.link_named(link, *line)?;
            }
        }
        let is_asked = |&(i, j): &(usize, usize)| {
            let is_disabled = |pair: &DisabledPair| pair.is_of(&self.names[i], &self.names[j]);
            self.bodies[i].link != self.bodies[j].link && !disabled.iter().any(is_disabled)
        };
        let all = (0..self.bodies.len()).flat_map(|i| (i + 1..self.bodies.len()).map(move |j| (i, j)));
        Ok(all.filter(is_asked).collect())
    }

    /// The index of a link in [`Robot::links`].
    pub(super) fn link_named(&self, name: &str, line: u32) -> Result<usize, RobotError> {
        let index = self.links.iter().position(|link| link.name == name);
        index.ok_or_else(|| RobotError::UnknownLink { line, link: name.into() })
    }
}
