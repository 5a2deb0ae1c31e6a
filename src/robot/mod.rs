//! Robots from their descriptions: the joints and bodies of a URDF file, and the pairs that an SRDF file disables.
//!
//! Links on fixed joints are merged into the moving link that carries them, so only moving joints remain, as
//! [`crate::motion::Kinematics`] requires. Mesh files are named but not read.

mod description;
mod error;
mod groups;
mod links;
mod shapes;
mod srdf;

pub use description::{LinkParent, Robot, RobotLink};
pub use error::RobotError;
pub use groups::JointGroup;
pub use shapes::{LinkShape, LinkShapes};
pub use srdf::DisabledPair;

#[cfg(doc)]
use crate::motion::Kinematics;
