//! Robots from their descriptions: the joints and bodies of a URDF file, and the pairs that an SRDF file rules out.
//!
//! A link that hangs on a fixed joint belongs to the moving link before it: what is left are the joints that move, as
//! [`crate::motion::Kinematics`] has them. Mesh files are named and not read.

mod error;
mod links;
mod srdf;

pub use error::RobotError;
pub use srdf::DisabledPair;

use crate::construct::{OwnedMesh, ShapeError};
use crate::motion::{Joint, Kinematics, LinkBody, MotionError};
use crate::range::MAX_COORDINATE;
use alloc::string::String;
use alloc::vec::Vec;

/// Which of a link's shapes are its bodies.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum LinkShapes {
    /// Those for collisions.
    Collision,
    /// Those that are drawn.
    Visual,
}

/// A shape of a link, in a frame of its own ([`LinkBody::at`]).
#[derive(Clone, PartialEq, Debug)]
pub enum LinkShape {
    /// A mesh file, and a factor for each coordinate.
    Mesh {
        /// As the description names it.
        file: String,
        /// For x, y and z.
        scale: [f64; 3],
    },
    /// A cuboid about the origin, with these sides.
    Cuboid {
        /// Along x, y and z.
        sides: [f64; 3],
    },
    /// A cylinder about the origin, along z.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A cylinder about the origin, along z, with a half ball at each end.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Between the centres of the half balls.
        height: f64,
    },
    /// A ball about the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
}

impl LinkShape {
    /// The closed mesh of a shape, and a radius about it ([`crate::scene::Body::with_radius`]). `None` of a mesh file. A
    /// cylinder becomes a prism around it, nowhere farther from it than `error`.
    ///
    /// # Errors
    /// [`ShapeError`] if a length is not above 0, or the error not either.
    pub fn mesh(&self, error: f64) -> Result<Option<(OwnedMesh, f64)>, ShapeError> {
        Ok(Some(match *self {
            Self::Mesh { .. } => return Ok(None),
            Self::Cuboid { sides } => (OwnedMesh::cuboid(sides)?, 0.0),
            Self::Cylinder { radius, height } => (OwnedMesh::cylinder(radius, height, error)?, 0.0),
            Self::Capsule { radius, height } => (OwnedMesh::segment(height)?, positive(radius)?),
            Self::Sphere { radius } => (OwnedMesh::point(), positive(radius)?),
        }))
    }
}

fn positive(radius: f64) -> Result<f64, ShapeError> {
    let is_length = radius > 0.0 && radius <= MAX_COORDINATE;
    if is_length { Ok(radius) } else { Err(ShapeError::Length { given: radius }) }
}

/// A robot, as its description has it.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// The joints that move, each behind those that it hangs on.
    pub joints: Vec<Joint>,
    /// Names of the variables: of all joints that move and mimic no other.
    pub variables: Vec<String>,
    /// The variables' lower and upper limits. Of a continuous joint, a whole turn either way.
    pub limits: Vec<[f64; 2]>,
    /// Where the bodies stand on the links.
    pub bodies: Vec<LinkBody>,
    /// What they are.
    pub shapes: Vec<LinkShape>,
    /// For each body, the name of the link that it is of: one that may hang on a fixed joint.
    pub names: Vec<String>,
}

impl Robot {
    /// The robot of a URDF file.
    ///
    /// # Errors
    /// [`RobotError`]: what is not a URDF, joints that are no tree or of a kind that moves in more than one way, limits that
    /// are none, a joint that mimics none, numbers that are no pose.
    pub fn from_urdf(text: &str, shapes: LinkShapes) -> Result<Self, RobotError> {
        links::read(text, shapes)
    }

    /// The joints and bodies as motions take them.
    ///
    /// # Errors
    /// [`MotionError`] if they were changed to what is none.
    pub fn kinematics(&self) -> Result<Kinematics<'_>, MotionError> {
        Kinematics::new(&self.joints, &self.bodies, &self.limits)
    }

    /// Pairs of bodies that joints move as one sees the other and that the description does not rule out, by their indices: a
    /// scene is told of these, and of no others.
    #[must_use]
    pub fn pairs(&self, disabled: &[DisabledPair]) -> Vec<(usize, usize)> {
        let is_asked = |&(i, j): &(usize, usize)| {
            let is_disabled = |pair: &DisabledPair| pair.is_of(&self.names[i], &self.names[j]);
            self.bodies[i].link != self.bodies[j].link && !disabled.iter().any(is_disabled)
        };
        let all = (0..self.bodies.len()).flat_map(|i| (i + 1..self.bodies.len()).map(move |j| (i, j)));
        all.filter(is_asked).collect()
    }
}
