//! Kinematic chains and trees: links connected by joints.

use super::MotionError;
use crate::pose::{Pose, PoseError};
use crate::range::Point;
use crate::vector::unit;

/// The kind of a joint.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum JointKind {
    /// Rotates about its axis, by its value in radians.
    Revolute,
    /// Translates along its axis, by its value in the unit of length.
    Prismatic,
}

/// A joint and the link that it moves: joint i moves link i + 1, and link 0 is the base. Fixed joints are not listed:
/// what they carry belongs to the link that they are on.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Joint {
    parent: u32,
    origin: Pose,
    kind: JointKind,
    axis: Point,
    variable: u32,
    multiplier: f64,
    offset: f64,
}

impl Joint {
    /// A joint on link `parent`, at `origin` in the frame of that link. The axis is in the joint's frame, and
    /// `variable` is the index of the variable that moves the joint. If the matrix of `origin` is not quite a rotation,
    /// the nearest rotation replaces it: a joint that stretched the bodies it rotates would move them farther than an
    /// arc.
    ///
    /// # Errors
    /// [`MotionError::NoDirection`].
    pub fn new(
        kind: JointKind,
        parent: u32,
        origin: Pose,
        axis: Point,
        variable: u32,
    ) -> Result<Self, MotionError> {
        let axis = unit(&axis).ok_or(MotionError::NoDirection)?;
        Ok(Self { parent, origin: origin.orthonormal(), kind, axis, variable, multiplier: 1.0, offset: 0.0 })
    }

    /// The same joint with the value `multiplier * variable + offset`, such as one that mimics another.
    ///
    /// # Errors
    /// [`MotionError::NotFinite`].
    pub const fn following(self, multiplier: f64, offset: f64) -> Result<Self, MotionError> {
        if multiplier.is_finite() && offset.is_finite() {
            return Ok(Self { multiplier, offset, ..self });
        }
        Err(MotionError::NotFinite)
    }

    /// The link that the joint is on.
    #[must_use]
    pub const fn parent(&self) -> u32 {
        self.parent
    }

    /// The variable that moves the joint.
    #[must_use]
    pub const fn variable(&self) -> u32 {
        self.variable
    }

    pub(crate) const fn multiplier(&self) -> f64 {
        self.multiplier
    }

    pub(crate) const fn kind(&self) -> JointKind {
        self.kind
    }

    #[cfg(feature = "planning")]
    pub(crate) const fn offset(&self) -> f64 {
        self.offset
    }

    #[cfg(feature = "planning")]
    pub(crate) const fn origin(&self) -> &Pose {
        &self.origin
    }

    #[cfg(feature = "planning")]
    pub(crate) const fn axis(&self) -> &Point {
        &self.axis
    }

    pub(super) fn value(&self, variables: &[f64]) -> f64 {
        self.multiplier * variables[self.variable as usize] + self.offset
    }

    /// Magnitude of the change in the value when the variable changes by `change`.
    pub(super) const fn change_of(&self, change: f64) -> f64 {
        (self.multiplier * change).abs()
    }

    /// Upper bound of the value's magnitude if the variable's magnitude is at most `variable`.
    pub(crate) const fn magnitude_of(&self, variable: f64) -> f64 {
        self.change_of(variable) + self.offset.abs()
    }
}

/// A body on a link.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct LinkBody {
    /// The link: 0 is the base.
    pub link: u32,
    /// The pose of the body in the link's frame.
    pub at: Pose,
}

/// The state of a link at some values: memory for [`Kinematics::go_to`].
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct LinkFrame {
    /// The link's pose in the world.
    pub(super) frame: Pose,
    /// Its joint's origin in the world.
    pub(super) origin: Point,
    /// Its joint's axis in the world.
    pub(super) axis: Point,
}

impl LinkFrame {
    /// Initializes the caller's memory.
    pub const EMPTY: Self = Self { frame: Pose::IDENTITY, origin: [0.0; 3], axis: [0.0; 3] };
}

/// The pose of a robot's base, with its matrix replaced by the nearest rotation. That costs as much as a few joints, so
/// callers that make [`Kinematics`] for each query make the base only once.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Base(Pose);

impl Base {
    /// The base at the origin of the world.
    pub const ORIGIN: Self = Self(Pose::IDENTITY);
}

impl From<Pose> for Base {
    fn from(world: Pose) -> Self {
        Self(world.orthonormal())
    }
}

/// A robot: joints with limits, and bodies on its links. It borrows all of its data, which may be in flash.
#[derive(Copy, Clone, Debug)]
pub struct Kinematics<'r> {
    base: Base,
    joints: &'r [Joint],
    bodies: &'r [LinkBody],
    limits: &'r [[f64; 2]],
}

impl<'r> Kinematics<'r> {
    /// Makes a robot from its joints, each after its parent; its bodies; and the lower and upper limit of each
    /// variable. The base is at the origin of the world.
    ///
    /// ```
    /// use simdop::motion::{Joint, JointKind, Kinematics, LinkFrame, LinkBody};
    /// use simdop::{glam::{DQuat, DVec3}, pose::Pose};
    /// let at = |x: f64| Pose::try_from((DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)));
    /// // Two joints that rotate about z, the second a metre from the first, and a body half a metre behind the second.
    /// let joint = |parent, x| Joint::new(JointKind::Revolute, parent, at(x)?, [0.0, 0.0, 1.0], parent);
    /// let joints = [joint(0, 0.0)?, joint(1, 1.0)?];
    /// let bodies = [LinkBody { link: 2, at: at(0.5)? }];
    /// let arm = Kinematics::new(&joints, &bodies, &[[-2.0, 2.0]; 2])?;
    ///
    /// let (mut links, mut poses) = ([LinkFrame::EMPTY; 3], [Pose::IDENTITY]);
    /// arm.go_to(&[0.5 * core::f64::consts::PI, 0.0], &mut links, &mut poses)?;
    /// let [x, y, _] = poses[0].translation();
    /// assert!(x.abs() < 1e-12 && (y - 1.5).abs() < 1e-12);
    /// # Ok::<(), simdop::motion::MotionError>(())
    /// ```
    ///
    /// # Errors
    /// [`MotionError::NoSuchLink`], [`MotionError::NoSuchVariable`], [`MotionError::Limits`].
    pub fn new(
        joints: &'r [Joint],
        bodies: &'r [LinkBody],
        limits: &'r [[f64; 2]],
    ) -> Result<Self, MotionError> {
        for (index, joint) in joints.iter().enumerate() {
            if joint.parent as usize > index {
                return Err(MotionError::NoSuchLink { index, link: joint.parent });
            }
            if joint.variable as usize >= limits.len() {
                return Err(MotionError::NoSuchVariable { joint: index, variable: joint.variable });
            }
        }
        for (i, body) in bodies.iter().enumerate() {
            if body.link as usize > joints.len() {
                return Err(MotionError::NoSuchLink { index: joints.len() + i, link: body.link });
            }
        }
        let is_interval = |[from, to]: &[f64; 2]| from.is_finite() && to.is_finite() && from <= to;
        match limits.iter().position(|limits| !is_interval(limits)) {
            Some(variable) => Err(MotionError::Limits { variable }),
            None => Ok(Self { base: Base::ORIGIN, joints, bodies, limits }),
        }
    }

    /// As [`Kinematics::new`], for parts that it has accepted before.
    #[cfg(feature = "planning")]
    pub(crate) const fn checked_before(
        joints: &'r [Joint],
        bodies: &'r [LinkBody],
        limits: &'r [[f64; 2]],
    ) -> Self {
        Self { base: Base::ORIGIN, joints, bodies, limits }
    }

    /// Places the base in the world. The nearest rotation replaces its matrix, as for a joint's origin.
    #[must_use]
    pub fn with_base(self, base: impl Into<Base>) -> Self {
        Self { base: base.into(), ..self }
    }

    #[cfg(feature = "planning")]
    pub(crate) const fn base(&self) -> &Pose {
        &self.base.0
    }

    /// The joints.
    #[must_use]
    pub const fn joints(&self) -> &'r [Joint] {
        self.joints
    }

    /// The bodies on the links.
    #[must_use]
    pub const fn bodies(&self) -> &'r [LinkBody] {
        self.bodies
    }

    /// The lower and upper limit of each variable.
    #[must_use]
    pub const fn limits(&self) -> &'r [[f64; 2]] {
        self.limits
    }

    /// Number of links, the base included: [`Kinematics::go_to`] needs as many [`LinkFrame`]s.
    #[must_use]
    pub const fn links(&self) -> usize {
        self.joints.len() + 1
    }

    /// Checks that there is a value for each variable, within its limits.
    ///
    /// # Errors
    /// [`MotionError::Length`], [`MotionError::OutOfLimits`].
    pub fn check(&self, variables: &[f64]) -> Result<(), MotionError> {
        if variables.len() != self.limits.len() {
            return Err(MotionError::Length { given: variables.len(), needed: self.limits.len() });
        }
        let mut all = variables.iter().zip(self.limits).enumerate();
        match all.find(|(_, (value, [from, to]))| !(from..=to).contains(value)) {
            Some((variable, (&given, _))) => Err(MotionError::OutOfLimits { variable, given }),
            None => Ok(()),
        }
    }

    /// Forward kinematics: the links and the bodies' world poses at these values of the variables.
    ///
    /// # Errors
    /// Those of [`Kinematics::check`]; [`MotionError::Length`] if a slice is too short; [`MotionError::Pose`].
    pub fn go_to(
        &self,
        variables: &[f64],
        links: &mut [LinkFrame],
        poses: &mut [Pose],
    ) -> Result<(), MotionError> {
        self.check(variables)?;
        self.check_room(links, poses.len())?;
        Ok(self.place(variables, links, poses)?)
    }

    pub(super) const fn check_room(&self, links: &[LinkFrame], poses: usize) -> Result<(), MotionError> {
        if links.len() < self.links() {
            return Err(MotionError::Length { given: links.len(), needed: self.links() });
        }
        if poses < self.bodies.len() {
            return Err(MotionError::Length { given: poses, needed: self.bodies.len() });
        }
        Ok(())
    }

    /// [`Kinematics::go_to`] without checks, for the values of a motion, which rounding may put beyond the limits.
    /// `links` and `poses` have room for all links and bodies.
    pub(crate) fn place(
        &self,
        variables: &[f64],
        links: &mut [LinkFrame],
        poses: &mut [Pose],
    ) -> Result<(), PoseError> {
        links[0] = LinkFrame { frame: self.base.0, ..LinkFrame::EMPTY };
        for (i, joint) in self.joints.iter().enumerate() {
            let before = links[joint.parent as usize].frame.after(&joint.origin);
            let (value, axis) = (joint.value(variables), before.rotate(&joint.axis));
            let frame = match joint.kind {
                JointKind::Revolute => before.after(&Pose::turn(&joint.axis, value)),
                JointKind::Prismatic => before.shifted(&axis.map(|x| value * x)),
            };
            links[i + 1] = LinkFrame { frame, origin: before.translation(), axis };
        }
        for (pose, body) in poses.iter_mut().zip(self.bodies) {
            *pose = links[body.link as usize].frame.compose(&body.at)?;
        }
        Ok(())
    }

    pub(super) fn parent_of(&self, link: usize) -> usize {
        self.joints[link - 1].parent as usize
    }
}
