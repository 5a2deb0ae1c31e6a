//! Construction: a splitter assigns primitives to lanes, level by level; then the nodes are wrapped and
//! baked.
//!
//! Splitters only ever return an [`Assignment`]. Planes, links, bytes and their order are made in one place
//! (`wrap`, `bake`), so two splitters, or two machines, that agree on the assignment agree on every byte.

mod any;
mod assignment;
mod bake;
mod balls;
mod below;
mod closed;
mod clustering;
mod cost;
mod cover;
mod enclosing;
mod error;
mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
mod levels;
mod longest_axis;
mod neural_gas;
mod normal_slabs;
mod parts;
mod progress;
mod shape;
mod shapes;
mod wrap;

pub use assignment::Assignment;
pub(crate) use closed::{OpenEdge, Unclosed, check_closed};
#[doc(hidden)]
pub use clustering::Clustering;
pub use cover::CoverError;
pub(crate) use cover::{ROUNDING as COVER_ROUNDING, check_error as check_cover_error, cut};
pub use error::BuildError;
pub use geometry::{Geometry, Mesh, SphereSet};
pub use progress::Progress;
pub use shapes::{OwnedMesh, ShapeError};

use crate::halving::Halving;
use crate::hierarchy::Bvh;
use crate::node::{Dop, MAX_LEAF_SIZE, Node16};
use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use alloc::vec::Vec;
use core::borrow::Borrow;
use core::ops::ControlFlow;
use cost::Aabb;
use geometry::{Checked, check_vertices};
use progress::Observer;

/// How primitives are assigned to the lanes of a node (SIMDop paper, section IV-A).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Splitter {
    /// Sort along the longest axis and cut into equal parts.
    LongestAxis,
    /// Halve along the longest axis, then each half along its own, until there is a part for each lane.
    ExtendedLongestAxis,
    /// Cut where the sum of box area x primitives per lane is least: the surface area heuristic, without the
    /// detour over a binary tree.
    SurfaceArea,
    /// Cut where the sum of the cube of the box's mean width x primitives per lane is least, then exchange
    /// primitives between lanes as long as that sum falls, and look at the outermost lanes first. The
    /// fewest visits.
    #[default]
    MeanWidth,
    /// Cluster with Batch Neural Gas, one prototype for each lane (BNG paper, section 3): the slowest to
    /// build.
    BatchNeuralGas {
        /// What draws prototypes besides the number of primitives.
        magnification: Magnification,
        /// Decides where prototypes start, and nothing else.
        seed: u32,
    },
}

/// What a primitive weighs in a cluster: magnification control (BNG paper, section 3.1.1).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Magnification {
    /// Each primitive counts once, as in the SIMDop paper.
    #[default]
    None,
    /// A primitive weighs as much as it is large, a triangle its area, a sphere its volume, so that large ones are
    /// not outliers and come high up in the tree.
    Area,
}

/// What to build.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Builder {
    splitter: Splitter,
    leaf_size: u32,
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
        self.build_by(geometry, |table| self.assign::<G>(table, N::ARITY, observer))
    }

    /// Checks a geometry, lets `assign` make the shape of its tree, and bakes it.
    fn build_by<N: Dop, G: Geometry, A: Borrow<Assignment>, E: From<BuildError>>(
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
        Ok(bake::bake::<N, G>(&table, assignment.borrow(), *self)?)
    }

    /// The shape of a checked geometry's tree.
    fn assign<G: Geometry>(
        &self,
        table: &Checked<'_, G::Primitive>,
        arity: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Assignment, BuildError> {
        self.split(&self.items::<G>(table), arity, observer)
    }

    /// What is split.
    fn items<G: Geometry>(&self, table: &Checked<'_, G::Primitive>) -> Items {
        let weights = match self.splitter {
            Splitter::BatchNeuralGas { magnification, .. } => magnification.weights::<G>(table),
            _ => None,
        };
        Items { boxes: table.boxes().map(Aabb::of).collect(), weights }
    }

    /// The shape of a tree of items.
    fn split(
        &self,
        items: &Items,
        arity: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Assignment, BuildError> {
        let centroids = items.centroids();
        let leaf_size = self.leaf_size as usize;
        let halving = |extended| Halving { arity, leaf_size, extended };
        let by_cost = |measure, passes, observer: &mut Observer<'_>| {
            let primitives = cost::Primitives { boxes: &items.boxes, centroids: &centroids };
            cost::assign(primitives, cost::Plan { arity, leaf_size, measure, passes }, observer)
        };
        match self.splitter {
            Splitter::LongestAxis => longest_axis::assign(&centroids, &halving(false), observer),
            Splitter::ExtendedLongestAxis => longest_axis::assign(&centroids, &halving(true), observer),
            Splitter::SurfaceArea => by_cost(cost::Measure::Area, 0, observer),
            Splitter::MeanWidth => by_cost(cost::Measure::MeanWidth, 3, observer),
            Splitter::BatchNeuralGas { seed, .. } => {
                let samples = neural_gas::Samples::new(&centroids, items.weights.as_deref());
                neural_gas::assign(&samples, &halving(true), seed, observer)
            }
        }
    }
}

/// What a splitter splits.
struct Items {
    boxes: Vec<Aabb>,
    /// None if all weigh the same.
    weights: Option<Vec<f64>>,
}

impl Items {
    fn centroids(&self) -> Vec<Point> {
        self.boxes.iter().map(Aabb::centre).collect()
    }
}

/// The shape of a tree of sixteen lanes over points, each of which is a primitive.
pub(crate) fn assign_points(
    points: &[[f32; 3]],
    splitter: Splitter,
    leaf_size: u32,
) -> Result<Assignment, BuildError> {
    let sphere = |p: &[f32; 3]| Sphere { centre: p.map(f64::from), radius: 0.0 };
    let spheres: Vec<_> = points.iter().map(sphere).collect();
    let builder = Builder::best().splitter(splitter).leaf_size(leaf_size);
    let set = SphereSet { spheres: &spheres };
    let table = Checked::new(&set)?;
    builder.assign::<SphereSet<'_>>(&table, 16, &mut |_| ControlFlow::Continue(()))
}

impl Magnification {
    /// What the primitives of a table weigh; none if all weigh the same.
    fn weights<G: Geometry>(self, table: &Checked<'_, G::Primitive>) -> Option<Vec<f64>> {
        match self {
            Self::None => None,
            Self::Area => Some(table.weights::<G>()),
        }
    }
}
