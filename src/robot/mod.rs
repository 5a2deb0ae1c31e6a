//! Robots from their descriptions: the joints and bodies of a URDF file, and the pairs that an SRDF file disables.
//!
//! Links on fixed joints are merged into the moving link before them, so only moving joints remain, as
//! [`crate::motion::Kinematics`] needs them. Mesh files are named but not read.

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

/// Which of a link's shapes become its bodies.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum LinkShapes {
    /// The collision shapes.
    Collision,
    /// The visual shapes.
    Visual,
}

/// A shape of a link, in its own frame ([`LinkBody::at`]).
#[derive(Clone, PartialEq, Debug)]
pub enum LinkShape {
    /// A mesh file, scaled along each axis.
    Mesh {
        /// File name, as in the description.
        file: String,
        /// Scale factors along x, y and z.
        scale: [f64; 3],
    },
    /// A cuboid centred at the origin.
    Cuboid {
        /// Side lengths along x, y and z.
        sides: [f64; 3],
    },
    /// A cylinder centred at the origin, along z.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its height.
        height: f64,
    },
    /// A capsule centred at the origin, along z.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Distance of the centres of its two hemispheres.
        height: f64,
    },
    /// A ball centred at the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
}

impl LinkShape {
    /// A closed mesh, and a radius around it ([`crate::scene::Body::with_radius`]). `None` for a mesh file. A cylinder
    /// becomes a prism that contains it, at most `error` from it everywhere.
    ///
    /// # Errors
    /// [`ShapeError`] if a length or the error is not above 0.
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

/// A robot from its description.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// The moving joints, each after its ancestors.
    pub joints: Vec<Joint>,
    /// Names of the variables: of all moving joints that mimic no other.
    pub variables: Vec<String>,
    /// Lower and upper limits of the variables. For a continuous joint, one full turn either way.
    pub limits: Vec<[f64; 2]>,
    /// The bodies' poses on the links.
    pub bodies: Vec<LinkBody>,
    /// The bodies' shapes.
    pub shapes: Vec<LinkShape>,
    /// For each body, the name of its link in the description, which may be on a fixed joint.
    pub names: Vec<String>,
}

impl Robot {
    /// The robot of a URDF file.
    ///
    /// # Errors
    /// [`RobotError`]: the text is not a URDF file, the joints are not a tree, a joint has more than one degree of
    /// freedom, invalid limits, an invalid mimic joint, or an invalid pose.
    pub fn from_urdf(text: &str, shapes: LinkShapes) -> Result<Self, RobotError> {
        links::read(text, shapes)
    }

    /// The joints and bodies in the form that motions take.
    ///
    /// # Errors
    /// [`MotionError`] if the fields were changed to invalid values.
    pub fn kinematics(&self) -> Result<Kinematics<'_>, MotionError> {
        Kinematics::new(&self.joints, &self.bodies, &self.limits)
    }

    /// Pairs of bodies to test, by index: those whose relative pose depends on a joint and that `disabled` does not
    /// contain. In a scene, forbid these pairs to collide, and allow all others
    /// ([`Scene::forbid_collision`](crate::scene::Scene::forbid_collision)).
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
