//! Construction: a splitter assigns primitives to lanes, level by level; one packer makes the nodes.
//!
//! Splitters only ever return an [`Assignment`]. Planes, links, bytes and their order are the packer's alone, so two
//! splitters, or two machines, that agree on the assignment agree on every byte.

mod assignment;
mod clustering;
mod cost;
#[cfg(feature = "gpu")]
pub mod gpu;
mod levels;
mod longest_axis;
mod neural_gas;
mod pack;
mod parallel;
mod progress;

pub use assignment::Assignment;
#[doc(hidden)]
pub use clustering::Clustering;
pub use progress::Progress;

use crate::hierarchy::Bvh;
use crate::node::{Child, MAX_LEAF_SIZE, Node};
use crate::range::MAX_COORDINATE;
use crate::range::{Point, flush};
use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;
use longest_axis::Cutter;
use progress::Observer;

/// Triangles as three indices each into the vertices. Duplicate, unused and non-manifold parts are welcome.
#[derive(Copy, Clone, Debug)]
pub struct Mesh<'a> {
    /// Corners, in the body's unit.
    pub vertices: &'a [Point],
    /// Indices of the corners.
    pub triangles: &'a [[u32; 3]],
}

/// How primitives are assigned to the lanes of a node (SIMDop paper, section IV-A).
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub enum Splitter {
    /// Sort along the longest axis and cut into equal parts.
    LongestAxis,
    /// Halve along the longest axis, then each half along its own, until there is a part for each lane.
    ExtendedLongestAxis,
    /// Cut where the sum of box area x primitives per lane is least: the surface area heuristic, without the detour over a binary tree.
    SurfaceArea,
    /// Cut where the sum of the cube of the box's mean width x primitives per lane is least, then exchange primitives between lanes
    /// as long as that sum falls, and look at the outermost lanes first. The fewest visits.
    #[default]
    MeanWidth,
    /// Cluster with Batch Neural Gas, one prototype for each lane (BNG paper, section 3): the slowest to build.
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
    /// A triangle weighs as much as its area, so that large ones are not outliers and come high up in the tree.
    Area,
}

/// What to build.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Builder {
    splitter: Splitter,
    leaf_size: u32,
}

/// Why a mesh cannot be built.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum BuildError {
    /// A leaf holds 1 to 16 triangles.
    LeafSize {
        /// The size asked for.
        asked: u32,
    },
    /// More triangles than [`Child::MAX_PRIMITIVES`], or as many vertices as do not fit in 32 bits.
    TooLarge {
        /// The number given.
        count: usize,
    },
    /// A coordinate is NaN, infinite, or beyond [`MAX_COORDINATE`].
    Vertex {
        /// Index of the vertex.
        index: usize,
    },
    /// A triangle names a vertex that there is not.
    Triangle {
        /// Index of the triangle.
        index: usize,
    },
    /// The tree would be deeper than [`crate::hierarchy::MAX_DEPTH`].
    TooDeep,
    /// The caller of [`Builder::build_with`] wished to stop.
    Cancelled,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeafSize { asked } => write!(f, "leaf size {asked}, must be 1 to {MAX_LEAF_SIZE}"),
            Self::TooLarge { count } => write!(f, "{count} triangles or vertices are too many"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite, or beyond 2^300"),
            Self::Triangle { index } => write!(f, "triangle {index} names a vertex that there is not"),
            Self::TooDeep => f.write_str("the tree would be too deep"),
            Self::Cancelled => f.write_str("the build was cancelled"),
        }
    }
}

impl core::error::Error for BuildError {}

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
        Self { splitter: Splitter::ExtendedLongestAxis, leaf_size: 1 }
    }

    /// Half the bytes of nodes at about the speed of the best: [`Splitter::MeanWidth`], up to two triangles a leaf.
    #[must_use]
    pub const fn balanced() -> Self {
        Self { splitter: Splitter::MeanWidth, leaf_size: 2 }
    }

    /// The fewest visits a query: [`Splitter::MeanWidth`], one triangle a leaf. Some fifteen times as long to build as the fast one.
    #[must_use]
    pub const fn best() -> Self {
        Self { splitter: Splitter::MeanWidth, leaf_size: 1 }
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

    /// Builds the hierarchy of a mesh. The choice of `N` is the choice of k and arity.
    ///
    /// Coordinates are kept as they are (stored as `f32` where that loses nothing), except that those below
    /// [`crate::range::MIN_COORDINATE`] become zero. Degenerate triangles are kept and counted.
    ///
    /// The same bytes on every machine and, with the feature `rayon`, from any number of threads: those of the current pool.
    /// A build needs some 100 bytes a triangle besides the mesh and the tree (k = 18, arity 16, half as many vertices as
    /// triangles), whatever the splitter.
    ///
    /// # Errors
    /// [`BuildError`]: nothing is dropped or repaired in silence.
    pub fn build<N: Node>(&self, mesh: &Mesh<'_>) -> Result<Bvh<N>, BuildError> {
        self.build_with(mesh, &mut |_| ControlFlow::Continue(()))
    }

    /// [`Builder::build`], telling `observer` after each level of the tree how far it is, and stopping when told to.
    ///
    /// # Errors
    /// [`BuildError`]: of the mesh, or [`BuildError::Cancelled`] if `observer` returned `Break`.
    pub fn build_with<N: Node>(
        &self,
        mesh: &Mesh<'_>,
        observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Bvh<N>, BuildError> {
        self.build_by(mesh, |mesh| self.assign(mesh, N::ARITY, observer))
    }

    /// Checks a mesh, lets `assign` make the shape of its tree, and packs it.
    fn build_by<N: Node, E: From<BuildError>>(
        &self,
        mesh: &Mesh<'_>,
        assign: impl FnOnce(&Mesh<'_>) -> Result<Assignment, E>,
    ) -> Result<Bvh<N>, E> {
        if self.leaf_size == 0 || self.leaf_size > MAX_LEAF_SIZE {
            return Err(BuildError::LeafSize { asked: self.leaf_size }.into());
        }
        let vertices = check(mesh)?;
        let mesh = Mesh { vertices: &vertices, triangles: mesh.triangles };
        let assignment = assign(&mesh)?;
        Ok(pack::pack(&mesh, &assignment, self.leaf_size)?)
    }

    /// The shape of a checked mesh's tree.
    fn assign(
        &self,
        mesh: &Mesh<'_>,
        arity: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Assignment, BuildError> {
        let centroids = centroids(mesh);
        let leaf_size = self.leaf_size as usize;
        let cutter = |extended| Cutter { arity, leaf_size, extended };
        let by_cost = |measure, passes, observer: &mut Observer<'_>| {
            let boxes: Vec<_> = mesh.triangles.iter().map(|t| cost::Bounds::of(&mesh.corners(t))).collect();
            let primitives = cost::Primitives { boxes: &boxes, centroids: &centroids };
            cost::assign(primitives, cost::Plan { arity, leaf_size, measure, passes }, observer)
        };
        match self.splitter {
            Splitter::LongestAxis => longest_axis::assign(&centroids, &cutter(false), observer),
            Splitter::ExtendedLongestAxis => longest_axis::assign(&centroids, &cutter(true), observer),
            Splitter::SurfaceArea => by_cost(cost::Measure::Area, 0, observer),
            Splitter::MeanWidth => by_cost(cost::Measure::MeanWidth, 3, observer),
            Splitter::BatchNeuralGas { magnification, seed } => {
                let weights = magnification.weights(mesh);
                let cloud = neural_gas::Cloud::new(&centroids, weights.as_deref());
                neural_gas::assign(&cloud, &cutter(true), seed, observer)
            }
        }
    }
}

impl Magnification {
    /// What the triangles of a mesh weigh; none if all weigh the same.
    fn weights(self, mesh: &Mesh<'_>) -> Option<Vec<f64>> {
        match self {
            Self::None => None,
            Self::Area => Some(areas(mesh)),
        }
    }
}

impl Mesh<'_> {
    /// The corners of a checked triangle.
    pub(crate) fn corners(&self, triangle: &[u32; 3]) -> [Point; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }
}

/// The vertices, checked and flushed.
fn check(mesh: &Mesh<'_>) -> Result<Vec<Point>, BuildError> {
    if mesh.triangles.len() > Child::MAX_PRIMITIVES as usize {
        return Err(BuildError::TooLarge { count: mesh.triangles.len() });
    }
    if u32::try_from(mesh.vertices.len()).is_err() {
        return Err(BuildError::TooLarge { count: mesh.vertices.len() });
    }
    // The comparison is false for NaN.
    if let Some(index) = mesh.vertices.iter().position(|p| !p.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
        return Err(BuildError::Vertex { index });
    }
    let in_range = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < mesh.vertices.len());
    if let Some(index) = mesh.triangles.iter().position(|t| !in_range(t)) {
        return Err(BuildError::Triangle { index });
    }
    Ok(mesh.vertices.iter().map(|p| p.map(flush)).collect())
}

/// Of each triangle's bounding box.
fn centroids(mesh: &Mesh<'_>) -> Vec<Point> {
    mesh.triangles.iter().map(|t| box_centre(&mesh.corners(t))).collect()
}

/// Centre of a triangle's bounding box.
fn box_centre(corners: &[Point; 3]) -> Point {
    core::array::from_fn(|i| {
        let [a, b, c] = corners.map(|p| p[i]);
        0.5 * (a.min(b).min(c) + a.max(b).max(c))
    })
}

/// The area of each triangle, in units of a power of two that suits the body.
fn areas(mesh: &Mesh<'_>) -> Vec<f64> {
    let largest = mesh.vertices.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let scale = crate::frame::scale_to_one(largest);
    let area = |[p, q, r]: [Point; 3]| {
        let edge = |a: Point, b: Point| -> Point { core::array::from_fn(|i| (b[i] - a[i]) * scale) };
        let (u, v) = (edge(p, q), edge(p, r));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        libm::sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2])
    };
    mesh.triangles.iter().map(|t| area(mesh.corners(t))).collect()
}
