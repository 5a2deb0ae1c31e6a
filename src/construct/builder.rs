//! Settings of a build, and builds on the CPU.

use super::bake::{Contents, bake};
use super::error::BuildError;
use super::hull::ConvexHull;
use super::input::{Caps, Checked, Geometry, Mesh};
use super::split::{Assignment, Items, Progress, Splitter};
use crate::hierarchy::Bvh;
use crate::node::{Dop, MAX_LEAF_SIZE, Node16};
use crate::primitive::Primitive;
use crate::range::Point;
use core::borrow::Borrow;
use core::ops::ControlFlow;

/// How to build a hierarchy.
///
/// Planes have 16 bits for the extent of the whole body. Near parts that are a thousand times finer than the body or
/// more, queries test 4 to 7,000 times as many nodes (benches/peers/SIZES.md). Build such a part as a body of its own.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Builder {
    pub(super) splitter: Splitter,
    pub(super) leaf_size: u32,
    has_normal_slabs: bool,
    has_balls: bool,
    inside: Inside,
}

/// What a mesh bounds.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Inside {
    Surface,
    Solid,
    /// A solid with caps over holes of at most this width: the bits of an `f64`, so that builders are `Eq`.
    Capped(u64),
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

    /// Fastest to build: [`Splitter::ExtendedLongestAxis`], one triangle per leaf.
    #[must_use]
    pub const fn fast() -> Self {
        Self { splitter: Splitter::ExtendedLongestAxis, ..Self::best() }
    }

    /// Half the bytes of nodes at about the query speed of [`Builder::best`]: [`Splitter::MeanWidth`], up to two
    /// triangles per leaf.
    #[must_use]
    pub const fn balanced() -> Self {
        Self { leaf_size: 2, ..Self::best() }
    }

    /// The fewest visits per query: [`Splitter::MeanWidth`], one triangle per leaf. A build takes about eleven times as
    /// long as with [`Builder::fast`].
    #[must_use]
    pub const fn best() -> Self {
        Self {
            splitter: Splitter::MeanWidth,
            leaf_size: 1,
            has_normal_slabs: true,
            has_balls: true,
            inside: Inside::Surface,
        }
    }

    /// Sets the splitter.
    #[must_use]
    pub const fn splitter(self, splitter: Splitter) -> Self {
        Self { splitter, ..self }
    }

    /// Sets the largest number of triangles per leaf, 1 to 16. Larger leaves give fewer nodes, and more triangle pairs
    /// to test.
    #[must_use]
    pub const fn leaf_size(self, triangles: u32) -> Self {
        Self { leaf_size: triangles, ..self }
    }

    /// Omits the [`NormalSlab`](crate::node::NormalSlab)s. Nodes take a fifth fewer bytes, and smooth meshes that
    /// nearly touch need more visits. Trees of spheres never have them.
    #[must_use]
    pub const fn without_normal_slabs(self) -> Self {
        Self { has_normal_slabs: false, ..self }
    }

    /// Omits the [`Ball16`](crate::node::Ball16)s, which trees of spheres have if their nodes have sixteen lanes. Nodes
    /// take a third fewer bytes (k = 18). Penetration volumes take longer, and have no upper bound before they are
    /// complete.
    #[must_use]
    pub const fn without_balls(self) -> Self {
        Self { has_balls: false, ..self }
    }

    pub(super) const fn with_balls(self) -> Self {
        Self { has_balls: true, ..self }
    }

    /// Makes the mesh a solid. A body that lies wholly inside it, without touching its surface, is a hit of
    /// [`collide`](crate::query::Query::collide) and [`within`](crate::query::Query::within), and its distance is 0.
    /// Without this setting a mesh is a surface, and a body wholly inside it is free.
    ///
    /// A point is inside if the winding number of the surface around it is not zero: overlapping parts are one solid,
    /// as are nested shells of the same orientation, while a nested shell of the opposite orientation bounds a cavity.
    /// A mesh that is turned inside out is just as solid. The mesh must be closed: after joining vertices with equal
    /// coordinates, as many triangles run along each edge in one direction as in the other. An empty mesh is closed.
    /// [`Builder::solid_with_caps`] takes meshes with holes.
    ///
    /// Sets of spheres are always solid: for them this setting changes nothing.
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
        Self { inside: Inside::Solid, ..self }
    }

    /// [`Builder::solid`], for a mesh that need not be closed: holes of at most this width are capped. The width of a
    /// hole is the greatest distance between two corners of its border, in the mesh's unit.
    ///
    /// The border of a mesh consists of the edges along which different numbers of triangles run in the two
    /// directions, after joining vertices with equal coordinates. It decomposes into loops, the holes: gaps between
    /// triangles, but also the outlines of triangles that are oriented the wrong way, and of walls inside a solid, at
    /// whose edges three triangles meet. A cap is a fan of triangles from one corner of a loop to its edges: over a
    /// flat hole it is flat, and over any other it is the fan of least area.
    ///
    /// Only the inside test uses caps:
    ///
    /// * A body is a hit if any point of it is inside or on a cap, even if it touches no triangle. The hit names a
    ///   primitive at the border of the hole, never a cap.
    /// * Distances are measured to the triangles of the mesh, and are 0 for a body that is a hit. So a distance may
    ///   drop to 0 where a body reaches a cap. Neither [`within`](crate::query::Query::within) with a margin nor the
    ///   radius of [a body in a scene](crate::scene::Body::with_radius) extends to caps.
    /// * [`check_motion`](crate::scene::Scene::check_motion) and
    ///   [`classify_pair`](crate::scene::Scene::classify_pair) never certify a motion through a cap as free.
    ///
    /// [`BvhRef::cap_stats`](crate::hierarchy::BvhRef::cap_stats) reports what was capped. A closed mesh gives the
    /// same bytes as with [`Builder::solid`].
    ///
    /// ```
    /// use simdop::construct::{BuildError, OwnedMesh};
    /// use simdop::{Builder, Isa, Pose, Query};
    ///
    /// let mut open = OwnedMesh::cuboid([1.0; 3])?;
    /// open.triangles.truncate(10); // a side is missing
    /// let error = Builder::new().solid_with_caps(1.0).build(&open.as_mesh()).unwrap_err();
    /// assert!(matches!(error, BuildError::Hole { width, .. } if width == 2.0_f64.sqrt()));
    ///
    /// let solid = Builder::new().solid_with_caps(1.5).build(&open.as_mesh())?;
    /// let caps = solid.view().cap_stats();
    /// assert_eq!((caps.holes, caps.triangles), (1, 2));
    ///
    /// let small = Builder::new().build(&OwnedMesh::cuboid([0.1; 3])?.as_mesh())?;
    /// let answer = Query::new(Isa::detect()).collide(&small, &solid, &Pose::IDENTITY);
    /// assert!(answer.hit().is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn solid_with_caps(self, width: f64) -> Self {
        Self { inside: Inside::Capped(width.to_bits()), ..self }
    }

    /// Builds the hierarchy of a mesh, with k = 18 and arity 16. [`Builder::build_as`] builds other node types.
    ///
    /// Coordinates keep their values, and are stored as `f32` where that is exact; those below
    /// [`crate::range::MIN_COORDINATE`] become zero. Degenerate triangles are kept and counted.
    ///
    /// Planes have 16 bits across the whole mesh. Near a part whose triangles are smaller than 1/65,536 of the mesh's
    /// width, such as a screw in a hall, a query tests most triangles of that part. Build such a part as a separate
    /// body.
    ///
    /// The bytes are the same on every machine and, with the feature `rayon`, for any number of threads; a build uses
    /// those of the current pool. With any splitter, a build needs about 100 bytes per triangle besides the mesh and
    /// the tree (k = 18, arity 16, half as many vertices as triangles).
    ///
    /// # Errors
    /// [`BuildError`] if the mesh or a setting is invalid. Nothing is dropped or repaired silently.
    pub fn build(&self, mesh: &Mesh<'_>) -> Result<Bvh<Node16<18>>, BuildError> {
        self.build_as(mesh)
    }

    /// [`Builder::build`] with any node type.
    ///
    /// # Errors
    /// As [`Builder::build`].
    pub fn build_as<N: Dop>(&self, mesh: &Mesh<'_>) -> Result<Bvh<N>, BuildError> {
        self.build_with(mesh, &mut |_| ControlFlow::Continue(()))
    }

    /// Builds the convex hull of points, with k = 18 and arity 16. It is [solid](Builder::solid), whatever the
    /// builder's setting, unless all points are in one plane. For other node types, [`ConvexHull`] makes the mesh.
    ///
    /// ```
    /// use simdop::primitive::Shape;
    /// use simdop::{Builder, Isa, Pose, Query};
    ///
    /// let octahedron =
    ///     [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    /// let hull = Builder::new().build_convex_hull(&octahedron)?;
    /// let (ball, query) = (Shape::sphere(0.25)?, Query::new(Isa::detect()));
    /// let up = |z| Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]]);
    /// assert!(query.collide_shape(&ball, &hull, &up(0.0)?).hit().is_some()); // inside
    /// assert!(query.collide_shape(&ball, &hull, &up(1.25)?).hit().is_some()); // touches a corner
    /// assert!(query.collide_shape(&ball, &hull, &up(1.25000001)?).is_free());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`ConvexHull::of`] and [`Builder::build`].
    pub fn build_convex_hull(&self, points: &[Point]) -> Result<Bvh<Node16<18>>, BuildError> {
        let hull = ConvexHull::of(points)?;
        let inside = if hull.is_solid { Inside::Solid } else { Inside::Surface };
        Self { inside, ..*self }.build(&hull.mesh.as_mesh())
    }

    /// [`Builder::build`], calling `observer` after each level of the tree. The build stops if `observer` returns
    /// `Break`.
    ///
    /// # Errors
    /// [`BuildError`], including [`BuildError::Cancelled`] if `observer` returned `Break`.
    pub fn build_with<N: Dop>(
        &self,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, BuildError> {
        self.build_geometry(mesh, observer)
    }

    /// [`Builder::build_with`] for any primitives.
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

    /// Builds a tree whose shape the caller chooses; the splitter is ignored. The assignment is for the builder's leaf
    /// size and nodes of this arity, with at most [`MAX_DEPTH`](crate::hierarchy::MAX_DEPTH) levels.
    ///
    /// ```
    /// use simdop::construct::{Assignment, Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, node::Node4};
    ///
    /// let spheres = [0.0, 9.0, 1.0, 3.0, 2.0, 4.0].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 0.5 });
    /// // The sphere far from the others is alone; the rest is in two nodes, of which the second has one more leaf.
    /// let shape = Assignment { order: vec![1, 0, 2, 4, 3, 5], ends: vec![1, 3, 6, 6, 2, 3, 3, 3, 4, 5, 6, 6] };
    /// let tree: Bvh<Node4<18>, Spheres> =
    ///     Builder::new().build_assigned(&SphereSet { spheres: &spheres }, &shape)?;
    /// assert_eq!(tree.view().nodes().len(), 3);
    /// assert_eq!(tree.view().source(0), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError`], including [`BuildError::Assignment`] and [`BuildError::TooDeep`].
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
        let inside = if G::Primitive::BOUNDS_SOLIDS { self.inside } else { Inside::Surface };
        let caps = match inside {
            Inside::Surface => Caps::default(),
            Inside::Solid => table.check_closed().map(|()| Caps::default())?,
            Inside::Capped(width) => table.caps(f64::from_bits(width))?,
        };
        let assignment = assign(&table)?;
        let Self { leaf_size, has_normal_slabs, has_balls, .. } = *self;
        let is_solid = inside != Inside::Surface;
        let contents = Contents { leaf_size, has_normal_slabs, has_balls, is_solid, caps: &caps };
        Ok(bake::<N, G>(&table, assignment.borrow(), contents)?)
    }
}
