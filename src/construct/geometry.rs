//! What can be built: primitives over a table of vertices.

use super::BuildError;
use crate::frame::scale_to_one;
use crate::node::Child;
#[cfg(doc)]
use crate::node::ThinSlab;
use crate::primitive::{Primitive, Triangles, triangle};
use crate::range::{MAX_COORDINATE, Point, flush};
use alloc::vec::Vec;

/// Primitives over a table of vertices: what [`super::Builder::build_geometry`] makes a tree of.
pub trait Geometry {
    /// What they are. Their records are the indices of their corners.
    type Primitive: Primitive<Double = Point, Record: AsRef<[u32]> + AsMut<[u32]>>;

    /// All vertices, in the body's unit.
    fn vertices(&self) -> &[Point];
    /// The indices of each primitive's corners.
    fn primitives(&self) -> &[<Self::Primitive as Primitive>::Record];
    /// What a primitive weighs with [`super::Magnification::Area`]: finite and not negative. Its corners are
    /// in a unit of length in which no coordinate is above 2.
    fn weight(corners: &[Point]) -> f64;
    /// A primitive's normal, of either sign, as long as it weighs; zero if it has none. Children get a
    /// [`ThinSlab`] along their primitives' mean normal.
    #[must_use]
    fn normal(_corners: &[Point]) -> Point {
        [0.0; 3]
    }
    /// Whether a primitive is flat in more ways than its kind is, as a triangle without area: such ones are
    /// counted.
    fn is_degenerate(corners: &[Point]) -> bool;
}

/// What a geometry's records are.
pub(super) type Record<G> = <<G as Geometry>::Primitive as Primitive>::Record;

/// Triangles as three indices each into the vertices. Duplicate, unused and non-manifold parts are welcome.
#[derive(Copy, Clone, Debug)]
pub struct Mesh<'a> {
    /// Corners, in the body's unit.
    pub vertices: &'a [Point],
    /// Indices of the corners.
    pub triangles: &'a [[u32; 3]],
}

impl Geometry for Mesh<'_> {
    type Primitive = Triangles;

    fn vertices(&self) -> &[Point] {
        self.vertices
    }

    fn primitives(&self) -> &[[u32; 3]] {
        self.triangles
    }

    /// Its area.
    fn weight(corners: &[Point]) -> f64 {
        let n = Self::normal(corners);
        libm::sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2])
    }

    fn normal(corners: &[Point]) -> Point {
        let &[p, q, r] = corners else { return [0.0; 3] };
        let edge = |a: Point, b: Point| -> Point { core::array::from_fn(|i| b[i] - a[i]) };
        let (u, v) = (edge(p, q), edge(p, r));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    }

    fn is_degenerate(corners: &[Point]) -> bool {
        let &[p, q, r] = corners else { return true };
        triangle::is_degenerate(&[p, q, r])
    }
}

/// A geometry that was checked, its coordinates flushed.
#[derive(Clone, Debug)]
pub(super) struct Checked<'a, R> {
    pub(super) vertices: Vec<Point>,
    pub(super) primitives: &'a [R],
}

impl<'a, R: AsRef<[u32]>> Checked<'a, R> {
    pub(super) fn new<G: Geometry>(geometry: &'a G) -> Result<Self, BuildError>
    where
        G::Primitive: Primitive<Record = R>,
    {
        let (vertices, primitives) = (geometry.vertices(), geometry.primitives());
        if primitives.len() > Child::MAX_PRIMITIVES as usize {
            return Err(BuildError::TooLarge { count: primitives.len() });
        }
        if u32::try_from(vertices.len()).is_err() {
            return Err(BuildError::TooLarge { count: vertices.len() });
        }
        // The comparison is false for NaN.
        if let Some(index) = vertices.iter().position(|p| !p.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
            return Err(BuildError::Vertex { index });
        }
        let greatest = vertices.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        if greatest > 0.0 && flush(greatest) == 0.0 {
            return Err(BuildError::TooSmall);
        }
        let in_range = |record: &R| record.as_ref().iter().all(|&v| (v as usize) < vertices.len());
        if let Some(index) = primitives.iter().position(|record| !in_range(record)) {
            return Err(BuildError::Primitive { index });
        }
        Ok(Self { vertices: vertices.iter().map(|p| p.map(flush)).collect(), primitives })
    }

    /// The corners of a primitive.
    pub(super) fn corners(&self, record: &R) -> impl Iterator<Item = Point> {
        record.as_ref().iter().map(|&vertex| self.vertices[vertex as usize])
    }

    /// The centre of each primitive's bounding box.
    pub(super) fn centroids(&self) -> Vec<Point> {
        let centre = |record: &R| -> Point {
            let (low, high) = bounding_box(self.corners(record));
            core::array::from_fn(|i| 0.5 * (low[i] + high[i]))
        };
        self.primitives.iter().map(centre).collect()
    }

    /// What each primitive weighs.
    pub(super) fn weights<G: Geometry>(&self) -> Vec<f64> {
        let all = self.primitives.iter().flat_map(|record| self.corners(record));
        let scale = scale_to_one(all.flatten().fold(0.0, |m: f64, x| m.max(x.abs())));
        let mut corners = Vec::new();
        let weigh = |record: &R| {
            corners.clear();
            corners.extend(self.corners(record).map(|p| p.map(|x| x * scale)));
            G::weight(&corners)
        };
        self.primitives.iter().map(weigh).collect()
    }
}

/// Low and high corner of the box of some points; of none, infinities.
pub(super) fn bounding_box(points: impl Iterator<Item = Point>) -> (Point, Point) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    (low, high)
}
