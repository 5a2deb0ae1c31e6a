//! Robots from their descriptions: the joints and bodies of a URDF file, and the pairs that an SRDF file disables.
//!
//! Links on fixed joints are merged into the moving link before them, so only moving joints remain, as
//! [`crate::motion::Kinematics`] needs them. Mesh files are named but not read.

mod description;
mod error;
mod groups;
mod links;
mod shapes;
mod srdf;

pub use description::{Link, LinkParent, Robot};
pub use error::RobotError;
pub use groups::JointGroup;
pub use shapes::{LinkShape, LinkShapes};
pub use srdf::DisabledPair;

#[cfg(doc)]
use crate::motion::Kinematics;
