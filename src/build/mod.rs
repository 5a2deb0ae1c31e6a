//! Construction: a splitter assigns primitives to lanes, level by level; one packer makes the nodes.
//!
//! Splitters only ever return an [`Assignment`]. Planes, links, bytes and their order are the packer's alone, so two
//! splitters, or two machines, that agree on the assignment agree on every byte.

mod assignment;
mod cost;
mod longest_axis;
mod pack;

pub use assignment::Assignment;

use crate::frame::{Point, flush};
use crate::hierarchy::Bvh;
use crate::node::{Child, MAX_LEAF_SIZE, Node};
use crate::triangle::MAX_COORDINATE;
use alloc::vec::Vec;
use core::fmt;

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
    #[default]
    ExtendedLongestAxis,
    /// Cut where the sum of box area x primitives per lane is least: the surface area heuristic, without the detour over a binary tree.
    SurfaceArea,
    /// Cut where the sum of the cube of the box's mean width x primitives per lane is least, then exchange primitives between lanes
    /// as long as that sum falls. The fewest visits; the longest build.
    MeanWidth,
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
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeafSize { asked } => write!(f, "leaf size {asked}, must be 1 to {MAX_LEAF_SIZE}"),
            Self::TooLarge { count } => write!(f, "{count} triangles or vertices are too many"),
            Self::Vertex { index } => write!(f, "vertex {index} is not finite, or beyond 2^300"),
            Self::Triangle { index } => write!(f, "triangle {index} names a vertex that there is not"),
            Self::TooDeep => f.write_str("the tree would be too deep"),
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
    /// Extended longest axis, one triangle a leaf.
    #[must_use]
    pub const fn new() -> Self {
        Self { splitter: Splitter::ExtendedLongestAxis, leaf_size: 1 }
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
    /// [`crate::triangle::MIN_COORDINATE`] become zero. Degenerate triangles are kept and counted.
    ///
    /// # Errors
    /// [`BuildError`]: nothing is dropped or repaired in silence.
    pub fn build<N: Node>(&self, mesh: &Mesh<'_>) -> Result<Bvh<N>, BuildError> {
        if self.leaf_size == 0 || self.leaf_size > MAX_LEAF_SIZE {
            return Err(BuildError::LeafSize { asked: self.leaf_size });
        }
        let vertices = check(mesh)?;
        let mesh = Mesh { vertices: &vertices, triangles: mesh.triangles };
        let centroids: Vec<Point> = mesh.triangles.iter().map(|t| box_centre(&mesh.corners(t))).collect();
        let (arity, leaf_size) = (N::ARITY, self.leaf_size as usize);
        let by_cost = |measure, passes| {
            let boxes: Vec<_> = mesh.triangles.iter().map(|t| cost::Bounds::of(&mesh.corners(t))).collect();
            let primitives = cost::Primitives { boxes: &boxes, centroids: &centroids };
            cost::assign(primitives, cost::Plan { arity, leaf_size, measure, passes })
        };
        let assignment = match self.splitter {
            Splitter::LongestAxis | Splitter::ExtendedLongestAxis => {
                longest_axis::assign(&centroids, arity, leaf_size, self.splitter)
            }
            Splitter::SurfaceArea => by_cost(cost::Measure::Area, 0),
            Splitter::MeanWidth => by_cost(cost::Measure::MeanWidth, 2),
        };
        pack::pack(&mesh, &assignment, self.leaf_size)
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

/// Centre of a triangle's bounding box.
fn box_centre(corners: &[Point; 3]) -> Point {
    core::array::from_fn(|i| {
        let [a, b, c] = corners.map(|p| p[i]);
        0.5 * (a.min(b).min(c) + a.max(b).max(c))
    })
}
