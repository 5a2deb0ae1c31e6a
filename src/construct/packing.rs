//! Solids that carry a packing.

use super::builder::Builder;
use super::error::BuildError;
use super::input::SphereSet;
use crate::hierarchy::Bvh;
use crate::node::Dop;
use crate::primitive::{Sphere, Spheres};
use core::ops::ControlFlow;

impl Builder {
    /// Adds spheres inside a solid, such as those of a [`Packer`](crate::packing::Packer), to the bytes of its tree,
    /// for [`Query::depth`](crate::query::Query::depth). An existing packing is replaced. The other bytes stay
    /// unchanged, and no other query reads the packing.
    ///
    /// The builder's splitter and leaf size apply to the spheres' tree. Proves that each sphere is inside, in time
    /// proportional to the number of spheres times that of triangles; spheres may touch the surface.
    ///
    /// ```
    /// use simdop::construct::OwnedMesh;
    /// use simdop::packing::Packer;
    /// use simdop::{Builder, Bvh, Isa, Pose, Query};
    ///
    /// let mesh = OwnedMesh::cuboid([1.0; 3])?;
    /// let cube = Builder::new().solid().build(&mesh.as_mesh())?;
    /// let spheres = Packer::new().spheres(30).pack(&mesh.as_mesh())?.spheres;
    /// let packed = Builder::new().add_packing(&cube, &spheres)?;
    /// let packed = Bvh::<simdop::node::Node16<18>>::from_bytes(packed.as_bytes())?;
    /// assert_eq!(packed.view().packing().map_or(0, |packing| packing.len()), 30);
    ///
    /// let pose = Pose::from_rows([[1.0, 0.0, 0.0, 0.875], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    /// let depth = Query::new(Isa::detect()).with_budget(2000).depth(&packed, &packed, &pose, None);
    /// assert!(depth.lower > 0.12 && depth.lower <= 0.125 && depth.upper >= 0.125);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError::Packing`] if the tree is not that of a solid, its nodes do not have sixteen lanes, or there are
    /// no spheres; [`BuildError::NotInside`] if a sphere is not inside; else as [`Builder::build`].
    pub fn add_packing<N: Dop>(&self, tree: &Bvh<N>, spheres: &[Sphere]) -> Result<Bvh<N>, BuildError> {
        let wrong = |problem| Err(BuildError::Packing { problem });
        if !tree.view().is_solid() {
            return wrong("the tree is not that of a solid");
        }
        if N::ARITY != 16 {
            return wrong("nodes of four lanes have no balls");
        }
        if spheres.is_empty() {
            return wrong("there are no spheres");
        }
        let go_on = &mut |_| ControlFlow::Continue(());
        let packing: Bvh<N, Spheres> = self.with_balls().build_geometry(&SphereSet { spheres }, go_on)?;
        match tree.view().first_outside(&packing.view()) {
            Some(index) => Err(BuildError::NotInside { index: packing.view().source(index) as usize }),
            None => Ok(tree.with_packing(&packing)),
        }
    }
}
