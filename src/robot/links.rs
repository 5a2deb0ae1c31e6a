//! Converts the links and joints of a URDF file to moving joints.

use super::description::{LinkParent, Robot, RobotLink};
use super::error::RobotError;
use super::shapes::{LinkShape, LinkShapes};
use crate::motion::{Joint, JointKind, LinkBody, MotionError};
use crate::pose::{Pose, PoseError};
use crate::primitive::Shape;
use crate::primitive::shape::ShapeError;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;
use glam::{DQuat, DVec3, EulerRot};
use urdf_rs::{Geometry, JointType};

fn read(text: &str, shapes: LinkShapes) -> Result<Robot, RobotError> {
    let urdf =
        urdf_rs::read_from_string(text).map_err(|error| RobotError::Format { problem: error.to_string() })?;
    let mut robot = Robot {
        name: urdf.name.clone(),
        joints: Vec::new(),
        variables: Vec::new(),
        limits: Vec::new(),
        bodies: Vec::new(),
        shapes: Vec::new(),
        names: Vec::new(),
        continuous: Vec::new(),
        links: links(&urdf)?,
    };
    for joint in &urdf.joints {
        let is_variable = moves(joint)?.is_some() && joint.mimic.is_none();
        if is_variable {
            robot.variables.push(joint.name.clone());
            robot.limits.push(limits(joint));
            robot.continuous.push(matches!(joint.joint_type, JointType::Continuous));
        }
    }
    let root = root(&urdf)?;
    // Links placed so far, each with the moving link that it belongs to and its pose on that link.
    let mut placed = vec![(root, 0, Pose::IDENTITY)];
    let mut next = 0;
    while let Some(&(link, moving, at)) = placed.get(next) {
        next += 1;
        robot.add_bodies(&urdf.links[link], moving, &at, shapes)?;
        for joint in urdf.joints.iter().filter(|joint| joint.parent.link == urdf.links[link].name) {
            let origin = of(&joint.name, pose(&joint.origin).and_then(|origin| at.compose(&origin)))?;
            let child = link_of(&urdf, joint, &joint.child.link)?;
            if placed.iter().any(|&(link, ..)| link == child) {
                return Err(RobotError::NoTree { link: joint.child.link.clone() });
            }
            let Some(kind) = moves(joint)? else {
                placed.push((child, moving, origin));
                continue;
            };
            let fault = |error| RobotError::Joint { joint: joint.name.clone(), error };
            robot.joints.push(
                robot
                    .moving_joint(joint, kind, moving, origin)
                    .map_err(fault)?
                    .ok_or_else(|| RobotError::Mimic { joint: joint.name.clone() })?,
            );
            placed.push((child, robot.joints.len() as u32, Pose::IDENTITY));
        }
    }
    if let Some(i) = (0..urdf.links.len()).find(|&i| placed.iter().all(|&(link, ..)| link != i)) {
        return Err(RobotError::NoTree { link: urdf.links[i].name.clone() });
    }
    Ok(robot)
}

impl Robot {
    /// The robot of a URDF file.
    ///
    /// # Errors
    /// [`RobotError`]: the text is not a URDF file, the joints are not a tree, a joint has more than one degree of
    /// freedom, invalid limits, an invalid mimic joint, or an invalid pose; or a length of a shape is not positive.
    pub fn from_urdf(text: &str, shapes: LinkShapes) -> Result<Self, RobotError> {
        read(text, shapes)
    }

    /// `None` if it mimics a joint that is not a variable.
    fn moving_joint(
        &self,
        joint: &urdf_rs::Joint,
        kind: JointKind,
        parent: u32,
        origin: Pose,
    ) -> Result<Option<Joint>, MotionError> {
        let leader = joint.mimic.as_ref().map_or(&joint.name, |mimic| &mimic.joint);
        let Some(variable) = self.variables.iter().position(|name| name == leader) else { return Ok(None) };
        let [from, to] = self.limits[variable];
        if !(from.is_finite() && to.is_finite() && from <= to) {
            return Err(MotionError::Limits { variable });
        }
        let moving = Joint::new(kind, parent, origin, *joint.axis.xyz, variable as u32)?;
        match &joint.mimic {
            Some(mimic) => moving.following(mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0)),
            None => Ok(moving),
        }
        .map(Some)
    }

    fn add_bodies(
        &mut self,
        link: &urdf_rs::Link,
        moving: u32,
        at: &Pose,
        shapes: LinkShapes,
    ) -> Result<(), RobotError> {
        let parts: Vec<_> = match shapes {
            LinkShapes::Collision => {
                link.collision.iter().map(|part| (&part.origin, &part.geometry)).collect()
            }
            LinkShapes::Visual => link.visual.iter().map(|part| (&part.origin, &part.geometry)).collect(),
        };
        for (origin, geometry) in parts {
            let at = of(&link.name, pose(origin).and_then(|origin| at.compose(&origin)))?;
            self.bodies.push(LinkBody { link: moving, at });
            let shape = shape(geometry);
            self.shapes.push(shape.map_err(|error| RobotError::Shape { link: link.name.clone(), error })?);
            self.names.push(link.name.clone());
        }
        Ok(())
    }
}

fn shape(geometry: &Geometry) -> Result<LinkShape, ShapeError> {
    let shape = match geometry {
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or([1.0; 3], |scale| *scale);
            return Ok(LinkShape::Mesh { file: filename.clone(), scale });
        }
        Geometry::Box { size } => Shape::cuboid(**size),
        &Geometry::Cylinder { radius, length } => Shape::cylinder(radius, length),
        &Geometry::Capsule { radius, length } => Shape::capsule(radius, length),
        &Geometry::Sphere { radius } => Shape::sphere(radius),
    };
    shape.map(LinkShape::Shape)
}

/// The kind of a joint; `None` if it is fixed.
fn moves(joint: &urdf_rs::Joint) -> Result<Option<JointKind>, RobotError> {
    match joint.joint_type {
        JointType::Fixed => Ok(None),
        JointType::Revolute | JointType::Continuous => Ok(Some(JointKind::Revolute)),
        JointType::Prismatic => Ok(Some(JointKind::Prismatic)),
        JointType::Floating | JointType::Planar | JointType::Spherical => {
            Err(RobotError::Kind { joint: joint.name.clone() })
        }
    }
}

fn limits(joint: &urdf_rs::Joint) -> [f64; 2] {
    match joint.joint_type {
        JointType::Continuous => [-2.0 * PI, 2.0 * PI],
        _ => [joint.limit.lower, joint.limit.upper],
    }
}

/// All links, each with its parent.
fn links(urdf: &urdf_rs::Robot) -> Result<Vec<RobotLink>, RobotError> {
    let mut links: Vec<_> =
        urdf.links.iter().map(|link| RobotLink { name: link.name.clone(), parent: None }).collect();
    for joint in &urdf.joints {
        let link = link_of(urdf, joint, &joint.parent.link)?;
        let child = link_of(urdf, joint, &joint.child.link)?;
        links[child].parent = Some(LinkParent { link, joint: joint.name.clone() });
    }
    Ok(links)
}

/// The one link that is not the child of any joint.
fn root(urdf: &urdf_rs::Robot) -> Result<usize, RobotError> {
    let is_root = |link: &urdf_rs::Link| urdf.joints.iter().all(|joint| joint.child.link != link.name);
    let mut roots = (0..urdf.links.len()).filter(|&i| is_root(&urdf.links[i]));
    let no_tree = |i: usize| RobotError::NoTree {
        link: urdf.links.get(i).map_or_else(String::new, |link| link.name.clone()),
    };
    let root = roots.next().ok_or_else(|| no_tree(0))?;
    for joint in &urdf.joints {
        let _ = link_of(urdf, joint, &joint.parent.link)?;
    }
    match roots.next() {
        Some(other) => Err(no_tree(other)),
        None => Ok(root),
    }
}

fn link_of(urdf: &urdf_rs::Robot, joint: &urdf_rs::Joint, name: &str) -> Result<usize, RobotError> {
    urdf.links
        .iter()
        .position(|link| link.name == name)
        .ok_or_else(|| RobotError::NoSuchLink { joint: joint.name.clone(), link: name.to_string() })
}

fn of<T>(name: &str, pose: Result<T, PoseError>) -> Result<T, RobotError> {
    pose.map_err(|error| RobotError::Pose { of: name.to_string(), error })
}

/// Rotations about fixed axes: x, then y, then z.
fn pose(origin: &urdf_rs::Pose) -> Result<Pose, PoseError> {
    let [roll, pitch, yaw] = *origin.rpy;
    let turn = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
    Pose::try_from((turn, DVec3::from_array(*origin.xyz)))
}
