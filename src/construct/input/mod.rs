//! Input of a build: meshes and other geometries, and their validation.

mod caps;
mod checked;
mod closed;
mod corners;
mod geometry;
mod owned_mesh;
mod ranges;

pub use caps::Caps;
pub(super) use checked::Checked;
pub(super) use closed::first_at_place;
pub(crate) use closed::{Unclosed, check_closed};
pub(super) use corners::{bounding_box, corners_of};
pub(super) use geometry::Record;
pub use geometry::{Geometry, Mesh, ShapeSet, SphereSet};
pub use owned_mesh::OwnedMesh;
pub(super) use ranges::{check_records, check_vertices};
