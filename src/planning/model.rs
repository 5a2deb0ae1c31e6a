//! A robot with its bodies, and the pairs of them that are tested.

use super::geometry::LinkGeometry;
use super::screen::RobotBounds;
use crate::robot::{DisabledPair, JointGroup, Robot, RobotError};
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use std::sync::OnceLock;

/// A robot with the geometry of its bodies, which scenes share.
#[derive(Clone, Debug)]
pub struct RobotModel {
    robot: Robot,
    bodies: Vec<LinkGeometry>,
    names: Vec<String>,
    disabled: Vec<DisabledPair>,
    pairs: Vec<(usize, usize)>,
    groups: Vec<JointGroup>,
    /// Made when a scene first requests them.
    pub(super) bounds: OnceLock<Option<Arc<RobotBounds>>>,
}

impl RobotModel {
    /// Makes a model from a description, the geometry of each of its bodies, and the additions of an SRDF file.
    ///
    /// # Errors
    /// [`RobotError::UnknownLink`] if `disabled` names a link that the robot does not have; [`RobotError::Bodies`] if
    /// there is not one geometry for each body of the robot.
    pub fn new(
        robot: Robot,
        bodies: Vec<LinkGeometry>,
        disabled: Vec<DisabledPair>,
        groups: Vec<JointGroup>,
    ) -> Result<Self, RobotError> {
        if bodies.len() != robot.bodies.len() {
            return Err(RobotError::Bodies { given: bodies.len(), needed: robot.bodies.len() });
        }
        let (names, pairs) = (numbered(&robot.names), robot.pairs(&disabled)?);
        Ok(Self { robot, bodies, names, disabled, pairs, groups, bounds: OnceLock::new() })
    }

    /// The description.
    #[must_use]
    pub const fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The geometry of each body.
    #[must_use]
    pub fn bodies(&self) -> &[LinkGeometry] {
        &self.bodies
    }

    /// The names of the bodies: those of their links, with a number for all but the first body of a link.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The pairs that the SRDF file disables.
    #[must_use]
    pub fn disabled(&self) -> &[DisabledPair] {
        &self.disabled
    }

    /// The pairs of bodies that are tested, by index.
    #[must_use]
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    pub(super) fn bounds(&self) -> Option<&Arc<RobotBounds>> {
        let make =
            || RobotBounds::of(&self.robot.kinematics().ok()?, &self.bodies, &self.pairs).map(Arc::new);
        self.bounds.get_or_init(make).as_ref()
    }

    /// The groups of joints of the SRDF file.
    #[must_use]
    pub fn groups(&self) -> &[JointGroup] {
        &self.groups
    }
}

fn numbered(links: &[String]) -> Vec<String> {
    let name = |(i, link): (usize, &String)| match links[..i].iter().filter(|before| *before == link).count()
    {
        0 => link.clone(),
        before => format!("{link} ({})", before + 1),
    };
    links.iter().enumerate().map(name).collect()
}
