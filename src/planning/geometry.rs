//! The geometry of a link: a shape, or the tree of a mesh.

use super::PlanningNode;
use crate::construct::{BuildError, Builder, Mesh};
use crate::hierarchy::Bvh;
use crate::primitive::Shape;
use crate::scene::{Body, SharedTree};
use alloc::sync::Arc;

/// The geometry of a body of a robot.
#[derive(Clone, Debug)]
pub enum LinkGeometry {
    /// A mesh: a solid if it is closed or its holes were capped, otherwise a surface.
    Mesh {
        /// The tree of its triangles.
        tree: Arc<Bvh<PlanningNode>>,
        /// The width of the widest hole of a surface. `None` for a solid, and for a surface with more holes than
        /// [`Builder::solid_with_caps`] closes.
        hole: Option<f64>,
    },
    /// A shape, exactly as the description gives it.
    Shape(Shape),
}

impl LinkGeometry {
    /// A solid if the mesh is closed, or has no hole wider than `cap` ([`Builder::solid_with_caps`]); otherwise a
    /// surface.
    ///
    /// # Errors
    /// [`BuildError`], except for holes.
    pub fn of_mesh(mesh: &Mesh<'_>, cap: f64) -> Result<Self, BuildError> {
        let surface = |hole| Ok(Self::Mesh { tree: Arc::new(Builder::new().build_as(mesh)?), hole });
        match Builder::new().solid_with_caps(cap).build_as(mesh) {
            Err(BuildError::Hole { width, .. }) => surface(Some(width)),
            Err(BuildError::TooManyCaps { .. }) => surface(None),
            built => Ok(Self::Mesh { tree: Arc::new(built?), hole: None }),
        }
    }

    /// A body of a scene that shares the tree.
    #[must_use]
    pub fn body(&self) -> Body<'static, PlanningNode> {
        match self {
            Self::Mesh { tree, .. } => Body::new(SharedTree::Mesh(Arc::clone(tree))),
            Self::Shape(shape) => Body::new(*shape),
        }
    }

    /// Whether a body inside it is a hit: true for shapes and solids, but not for surfaces.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        match self {
            Self::Mesh { tree, .. } => tree.view().header().is_solid != 0,
            Self::Shape(_) => true,
        }
    }
}
