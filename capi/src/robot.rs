//! Robots: bodies on links that joints move.

use crate::boundary::{checked, given, guarded, items, make, places};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use simdop::motion::{Base, Joint, JointKind, Kinematics, LinkBody, LinkFrame, MotionError};
use simdop::pose::Pose;
use std::mem::MaybeUninit;

/// The kind of a joint.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_joint_kind {
    /// Rotates about its axis by its value in radians.
    Revolute = 0,
    /// Slides along its axis by its value in the unit of length.
    Prismatic = 1,
}

/// A joint, and the link that it moves: joint i moves link i + 1, and link 0 is the base. Fixed joints are not listed:
/// what they carry belongs to the link that they are on.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_joint {
    /// One of simdop_joint_kind.
    pub kind: u32,
    /// The index of the link that carries the joint: at most i for joint i.
    pub parent: u32,
    /// The index of the variable that moves it. For a joint that mimics another, the variable of the other.
    pub variable: u32,
    /// The pose of the joint in the frame of its parent link.
    pub origin: simdop_pose,
    /// The axis in the joint's frame, of any length.
    pub axis: [f64; 3],
    /// The joint's value is `multiplier` times its variable, plus `offset`. 1, unless the joint mimics another.
    pub multiplier: f64,
    /// Offset, in radians or in the unit of length. 0, unless the joint mimics another.
    pub offset: f64,
}

/// A body on a link.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_link_body {
    /// The link: 0 is the base.
    pub link: u32,
    /// The pose of the body in the link's frame.
    pub pose: simdop_pose,
}

/// A robot: joints, the limits of the variables that move them, and the poses of bodies on the links. Each query names
/// the scene's bodies that correspond to them.
#[derive(Debug)]
pub struct simdop_robot {
    parts: Parts,
    /// Memory for forward kinematics: an entry for each link and for each body.
    links: Vec<LinkFrame>,
    poses: Vec<Pose>,
}

#[derive(Debug)]
struct Parts {
    base: Base,
    joints: Vec<Joint>,
    bodies: Vec<LinkBody>,
    limits: Vec<[f64; 2]>,
}

impl Parts {
    /// Each call validates everything, which takes a comparison or two for each joint, body and variable.
    fn kinematics(&self) -> Result<Kinematics<'_>, MotionError> {
        Ok(Kinematics::new(&self.joints, &self.bodies, &self.limits)?.with_base(self.base))
    }
}

impl simdop_robot {
    fn new(parts: Parts) -> Result<Self, MotionError> {
        let kinematics = parts.kinematics()?;
        let links = vec![LinkFrame::EMPTY; kinematics.links()];
        let poses = vec![Pose::IDENTITY; kinematics.bodies().len()];
        Ok(Self { parts, links, poses })
    }

    #[cfg(feature = "urdf")]
    pub(crate) fn of(
        base: Pose,
        joints: Vec<Joint>,
        bodies: Vec<LinkBody>,
        limits: Vec<[f64; 2]>,
    ) -> Result<Self, MotionError> {
        Self::new(Parts { base: base.into(), joints, bodies, limits })
    }

    pub(crate) fn kinematics(&self) -> Result<Kinematics<'_>, MotionError> {
        self.parts.kinematics()
    }
}

impl simdop_joint {
    fn checked(&self) -> Result<Joint, Failure> {
        // A field of the enumeration's type could not be checked: any other number in it would be undefined behaviour.
        let kinds = [
            (simdop_joint_kind::Revolute, JointKind::Revolute),
            (simdop_joint_kind::Prismatic, JointKind::Prismatic),
        ];
        let Some((_, kind)) = kinds.into_iter().find(|(number, _)| *number as u32 == self.kind) else {
            let message = format!("{} is no kind of a joint", self.kind);
            return Err(Failure::new(simdop_error::MotionNoSuchKind, message));
        };
        let joint = Joint::new(kind, self.parent, self.origin.checked()?, self.axis, self.variable)?;
        Ok(joint.following(self.multiplier, self.offset)?)
    }
}

impl simdop_link_body {
    fn checked(&self) -> Result<LinkBody, Failure> {
        Ok(LinkBody { link: self.link, at: self.pose.checked()? })
    }
}

/// Creates a robot. `base` is the pose of its base in the world; the `joint_count` joints are in an order in which each
/// comes after those between it and the base; `body_count` bodies are on the links; `limits` holds the lower and the
/// upper limit of each of `variable_count` variables, all finite. Everything is copied.
///
/// # Safety
/// The arrays have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_robot_new(
    base: Option<&simdop_pose>,
    joints: *const simdop_joint,
    joint_count: usize,
    bodies: *const simdop_link_body,
    body_count: usize,
    limits: *const f64,
    variable_count: usize,
    robot: Option<&mut MaybeUninit<Option<Box<simdop_robot>>>>,
) -> simdop_error {
    make(robot, "robot", || {
        let base = given(base, "base")?.checked()?.into();
        // SAFETY: the caller guarantees the length.
        let joints = unsafe { items(joints, joint_count, "joints") }?;
        // SAFETY: as above.
        let bodies = unsafe { items(bodies, body_count, "bodies") }?;
        // SAFETY: as above; two numbers in a row are aligned as one.
        let limits: &[[f64; 2]] = unsafe { items(limits.cast(), variable_count, "limits") }?;
        Ok(simdop_robot::new(Parts {
            base,
            joints: checked(joints, "joint", simdop_joint::checked)?,
            bodies: checked(bodies, "body", simdop_link_body::checked)?,
            limits: limits.to_vec(),
        })?)
    })
}

/// Forward kinematics: the poses of a robot's bodies in the world. `values` has a number for each variable, within its
/// limits; `poses` has room for a pose for each body. The robot is not const, since the call writes to memory in it.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_robot_poses(
    robot: Option<&mut simdop_robot>,
    values: *const f64,
    poses: *mut simdop_pose,
) -> simdop_error {
    guarded(|| {
        let simdop_robot { parts, links, poses: placed } = given(robot, "robot")?;
        let kinematics = parts.kinematics()?;
        // SAFETY: the caller guarantees one for each variable.
        let values = unsafe { items(values, parts.limits.len(), "values") }?;
        // SAFETY: the caller guarantees room for each body.
        let poses = unsafe { places(poses, placed.len(), "poses") }?;
        kinematics.go_to(values, links, placed)?;
        for (pose, placed) in poses.iter_mut().zip(placed) {
            pose.write((&*placed).into());
        }
        Ok(())
    })
}

/// Destroys a robot. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_robot_free(robot: Option<Box<simdop_robot>>) {
    drop(robot);
}
