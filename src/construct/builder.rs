//! What can be chosen about a hierarchy, and its construction on the CPU.

use super::bake::{Contents, bake};
use super::error::BuildError;
use super::input::{Checked, Geometry, Mesh};
use super::split::{Assignment, Items, Progress, Splitter};
use crate::hierarchy::Bvh;
use crate::node::{Dop, MAX_LEAF_SIZE, Node16};
use crate::primitive::Primitive;
use core::borrow::Borrow;
use core::ops::ControlFlow;

/// How to build a hierarchy.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Builder {
    pub(super) splitter: Splitter,
    pub(super) leaf_size: u32,
    has_normal_slabs: bool,
    has_balls: bool,
    is_solid: bool,
}

impl Default for Builder {
    fn default() -> Self {
        Self::new()
    }
}

impl Builder {
    /// [`Builder::best`].
    #[must_use]
    pub const fn new() -> Self {
        Self::best()
    }

    /// Built soonest: [`Splitter::ExtendedLongestAxis`], one triangle a leaf.
    #[must_use]
    pub const fn fast() -> Self {
        Self { splitter: Splitter::ExtendedLongestAxis, ..Self::best() }
    }

    /// Half the bytes of nodes at about the speed of the best: [`Splitter::MeanWidth`], up to two triangles a
    /// leaf.
    #[must_use]
    pub const fn balanced() -> Self {
        Self { leaf_size: 2, ..Self::best() }
    }

    /// The fewest visits a query: [`Splitter::MeanWidth`], one triangle a leaf. Some eleven times as long to
    /// build as the fast one.
    #[must_use]
    pub const fn best() -> Self {
        Self {
            splitter: Splitter::MeanWidth,
            leaf_size: 1,
            has_normal_slabs: true,
            has_balls: true,
            is_solid: false,
        }
    }

    /// Assigns with `splitter`.
    #[must_use]
    pub const fn splitter(self, splitter: Splitter) -> Self {
        Self { splitter, ..self }
    }

    /// Up to `triangles` (1 ..= 16) in a leaf: fewer nodes, more triangle pairs to test.
    #[must_use]
    pub const fn leaf_size(self, triangles: u32) -> Self {
        Self { leaf_size: triangles, ..self }
    }

    /// Leaves out the [`NormalSlab`](crate::node::NormalSlab)s: a fifth fewer bytes of nodes, and more visits of
    /// smooth meshes that nearly touch. Trees of spheres never have them.
    #[must_use]
    pub const fn without_normal_slabs(self) -> Self {
        Self { has_normal_slabs: false, ..self }
    }

    /// Leaves out the [`Ball16`](crate::node::Ball16)s, which trees of spheres have where nodes have sixteen lanes: a
    /// third fewer bytes of nodes (k = 18), and penetration volumes take longer and have no upper bound before they are
    /// complete.
    #[must_use]
    pub const fn without_balls(self) -> Self {
        Self { has_balls: false, ..self }
    }

    /// The mesh bounds a solid: a body that is wholly inside of it, without touching its surface, is a hit of
    /// [`collide`](crate::query::Query::collide) and [`within`](crate::query::Query::within), and its distance is 0.
    /// Without this a body is a surface, and what is wholly inside of it is free.
    ///
    /// Inside is where the surface winds around a point, as often as it may: parts that overlap are one solid, so is
    /// a shell in a shell of the same orientation, and a shell of the other orientation is a cavity. A mesh that is turned
    /// inside out is as solid. It must be closed: with corners of the same coordinates joined, as many triangles run
    /// along each edge in one direction as in the other. An empty mesh is.
    ///
    /// Sets of spheres are solid anyway: of them this changes nothing.
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    /// let surface = Builder::new().build(&mesh)?;
    /// let solid = Builder::new().solid().build(&mesh)?;
    ///
    /// let small = vertices.map(|p| p.map(|x| 0.1 * x + 0.1)); // inside
    /// let small = Builder::new().build(&Mesh { vertices: &small, triangles: &triangles })?;
    /// let query = Query::new(Isa::detect());
    /// assert!(query.collide(&small, &surface, &Pose::IDENTITY).is_free());
    /// assert!(query.collide(&small, &solid, &Pose::IDENTITY).hit().is_some());
    ///
    /// let open = Mesh { vertices: &vertices, triangles: &triangles[1..] };
    /// let error = Builder::new().solid().build(&open).unwrap_err();
    /// assert!(error.to_string().contains("open"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn solid(self) -> Self {
        Self { is_solid: true, ..self }
    }

    /// Builds the hierarchy of a mesh. The choice of `N` is the choice of k and arity.
    ///
    /// Coordinates are kept as they are (stored as `f32` where that loses nothing), except that those below
    /// [`crate::range::MIN_COORDINATE`] become zero. Degenerate triangles are kept and counted.
    ///
    /// Planes are 16 bits wide across the whole mesh. Near a part whose triangles are smaller than one 65,536th of the
    /// mesh's width, such as a screw in a hall, a query tests most triangles of that part: build it as a body of its own.
    ///
    /// The same bytes on every machine and, with the feature `rayon`, from any number of threads: those of
    /// the current pool. A build needs some 100 bytes a triangle besides the mesh and the tree (k = 18,
    /// arity 16, half as many vertices as triangles), whatever the splitter.
    ///
    /// # Errors
    /// [`BuildError`]: nothing is dropped or repaired in silence.
    pub fn build(&self, mesh: &Mesh<'_>) -> Result<Bvh<Node16<18>>, BuildError> {
        self.build_as(mesh)
    }

    /// [`Builder::build`] with another type of node than the default.
    ///
    /// # Errors
    /// As [`Builder::build`].
    pub fn build_as<N: Dop>(&self, mesh: &Mesh<'_>) -> Result<Bvh<N>, BuildError> {
        self.build_with(mesh, &mut |_| ControlFlow::Continue(()))
    }

    /// [`Builder::build`], telling `observer` after each level of the tree how far it is, and stopping when
    /// told to.
    ///
    /// # Errors
    /// [`BuildError`]: of the mesh, or [`BuildError::Cancelled`] if `observer` returned `Break`.
    pub fn build_with<N: Dop>(
        &self,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, BuildError> {
        self.build_geometry(mesh, observer)
    }

    /// [`Builder::build_with`] of any primitives.
    ///
    /// # Errors
    /// As [`Builder::build_with`].
    pub fn build_geometry<N: Dop, G: Geometry>(
        &self,
        geometry: &G,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N, G::Primitive>, BuildError> {
        self.build_by(geometry, |table| {
            Items::new::<G>(table, self.splitter).split(self.splitter, self.leaf_size, N::ARITY, observer)
        })
    }

    /// The tree of a shape that the caller has chosen, whatever the splitter: with the builder's leaf size, for
    /// nodes of this arity. It may have at most [`MAX_DEPTH`](crate::hierarchy::MAX_DEPTH) levels.
    ///
    /// ```
    /// use simdop::construct::{Assignment, Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, node::Node4};
    ///
    /// let spheres = [0.0, 9.0, 1.0, 3.0, 2.0, 4.0].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 0.5 });
    /// // The one that is far from the others alone, and two nodes of which the second has a leaf more.
    /// let shape = Assignment { order: vec![1, 0, 2, 4, 3, 5], ends: vec![1, 3, 6, 6, 2, 3, 3, 3, 4, 5, 6, 6] };
    /// let tree: Bvh<Node4<18>, Spheres> =
    ///     Builder::new().build_assigned(&SphereSet { spheres: &spheres }, &shape)?;
    /// assert_eq!(tree.view().nodes().len(), 3);
    /// assert_eq!(tree.view().source(0), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError`]: of the geometry; [`BuildError::Assignment`]; [`BuildError::TooDeep`].
    pub fn build_assigned<N: Dop, G: Geometry>(
        &self,
        geometry: &G,
        assignment: &Assignment,
    ) -> Result<Bvh<N, G::Primitive>, BuildError> {
        self.build_by(geometry, |table| {
            assignment.check(table.primitives.len(), N::ARITY, self.leaf_size as usize)?;
            Ok::<_, BuildError>(assignment)
        })
    }

    /// Checks a geometry, calls `assign` for the shape of its tree, and bakes it.
    pub(super) fn build_by<N: Dop, G: Geometry, A: Borrow<Assignment>, E: From<BuildError>>(
        &self,
        geometry: &G,
        assign: impl FnOnce(&Checked<'_, G::Primitive>) -> Result<A, E>,
    ) -> Result<Bvh<N, G::Primitive>, E> {
        if self.leaf_size == 0 || self.leaf_size > MAX_LEAF_SIZE {
            return Err(BuildError::LeafSize { asked: self.leaf_size }.into());
        }
        let table = Checked::new(geometry)?;
        if self.is_solid && G::Primitive::BOUNDS_SOLIDS {
            table.check_closed()?;
        }
        let assignment = assign(&table)?;
        let Self { leaf_size, has_normal_slabs, has_balls, is_solid, .. } = *self;
        let contents = Contents { leaf_size, has_normal_slabs, has_balls, is_solid };
        Ok(bake::<N, G>(&table, assignment.borrow(), contents)?)
    }
}
