//! What can be built: primitives over a table of vertices.

use super::BuildError;
use super::closed::{OpenEdge, check_edges};
use crate::frame::scale_to_one;
use crate::node::Child;
#[cfg(doc)]
use crate::node::NormalSlab;
use crate::primitive::{Primitive, Sphere, Spheres, Triangles, triangle};
use crate::range::{MAX_COORDINATE, Point, flush};
use alloc::borrow::Cow;
use alloc::vec::Vec;

/// Primitives over a table of vertices: what [`super::Builder::build_geometry`] makes a tree of.
pub trait Geometry {
    /// What they are. Their records are the indices of their corners.
    type Primitive: Primitive<Record: AsRef<[u32]> + AsMut<[u32]>>;

    /// All vertices, in the body's unit.
    fn vertices(&self) -> &[<Self::Primitive as Primitive>::Double];
    /// The indices of each primitive's corners.
    fn primitives(&self) -> Cow<'_, [<Self::Primitive as Primitive>::Record]>;
    /// What a primitive weighs with [`super::Magnification::Area`]: finite and not negative. Its corners and its
    /// radius are in a unit of length in which none of these numbers is above 2.
    fn weight(corners: &[Point], radius: f64) -> f64;
    /// A primitive's normal, of either sign, as long as it weighs; zero if it has none. Children get a
    /// [`NormalSlab`] along their primitives' mean normal.
    #[must_use]
    fn normal(_corners: &[Point]) -> Point {
        [0.0; 3]
    }
    /// Whether a primitive is flat in more ways than its kind is, as a triangle without area: such ones are
    /// counted.
    fn is_degenerate(corners: &[Point], radius: f64) -> bool;
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

    fn primitives(&self) -> Cow<'_, [[u32; 3]]> {
        Cow::Borrowed(self.triangles)
    }

    /// Its area.
    fn weight(corners: &[Point], _radius: f64) -> f64 {
        let n = Self::normal(corners);
        libm::sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2])
    }

    fn normal(corners: &[Point]) -> Point {
        let &[p, q, r] = corners else { return [0.0; 3] };
        let edge = |a: Point, b: Point| -> Point { core::array::from_fn(|i| b[i] - a[i]) };
        let (u, v) = (edge(p, q), edge(p, r));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    }

    fn is_degenerate(corners: &[Point], _radius: f64) -> bool {
        let &[p, q, r] = corners else { return true };
        triangle::is_degenerate(&[p, q, r])
    }
}

/// Spheres, which may overlap, coincide, and be points.
///
/// ```
/// use core::ops::ControlFlow;
/// use simdop::construct::{Builder, SphereSet};
/// use simdop::{hierarchy::Bvh, isa::Isa, node::Node16, pose::Pose, query::Query};
/// use simdop::primitive::{Sphere, Spheres};
///
/// let spheres = [0.0, 3.0].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 1.0 });
/// let set = SphereSet { spheres: &spheres };
/// let body: Bvh<Node16<18>, Spheres> =
///     Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(()))?;
///
/// let query = Query::new(Isa::detect());
/// let up = |z| Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]]);
/// assert!(query.collide(&body, &body, &up(2.0)?).hit().is_some()); // they touch
/// assert!(query.collide(&body, &body, &up(2.0000001)?).is_free());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Copy, Clone, Debug)]
pub struct SphereSet<'a> {
    /// The spheres, in the body's unit.
    pub spheres: &'a [Sphere],
}

impl Geometry for SphereSet<'_> {
    type Primitive = Spheres;

    fn vertices(&self) -> &[Sphere] {
        self.spheres
    }

    fn primitives(&self) -> Cow<'_, [[u32; 1]]> {
        (0..self.spheres.len()).map(|index| [index as u32]).collect()
    }

    /// The volume, but for a factor.
    fn weight(_corners: &[Point], radius: f64) -> f64 {
        radius * radius * radius
    }

    fn is_degenerate(_corners: &[Point], radius: f64) -> bool {
        radius == 0.0
    }
}

/// A geometry that was checked, its coordinates flushed.
#[derive(Clone, Debug)]
pub(super) struct Checked<'a, P: Primitive> {
    pub(super) vertices: Vec<P::Double>,
    pub(super) primitives: Cow<'a, [P::Record]>,
}

impl<'a, P: Primitive<Record: AsRef<[u32]>>> Checked<'a, P> {
    pub(super) fn new<G: Geometry<Primitive = P>>(geometry: &'a G) -> Result<Self, BuildError> {
        let vertices = geometry.vertices();
        check_vertices::<P>(vertices)?;
        let size = |ball: Sphere| ball.centre.into_iter().fold(ball.radius, |m, x| m.max(x.abs()));
        let greatest = vertices.iter().map(|vertex| size(P::ball(vertex))).fold(0.0, f64::max);
        if greatest > 0.0 && flush(greatest) == 0.0 {
            return Err(BuildError::TooSmall);
        }
        let primitives = geometry.primitives();
        check_records(&primitives, vertices.len())?;
        Ok(Self { vertices: vertices.iter().map(|v| P::map(v, flush)).collect(), primitives })
    }

    /// Whether triangles close.
    pub(super) fn check_closed(&self) -> Result<(), BuildError> {
        // The corners of a triangle, as of all primitives that bound solids.
        let triangles = self.primitives.iter().filter_map(|record| record.as_ref().try_into().ok());
        check_edges(&self.places(), triangles).map_err(|OpenEdge { edge, corners, forward, backward }| {
            BuildError::Open { edge, corners, forward, backward }
        })
    }

    fn places(&self) -> Vec<Point> {
        self.vertices.iter().map(|vertex| P::ball(vertex).centre).collect()
    }

    /// The box of each primitive.
    pub(super) fn boxes(&self) -> impl Iterator<Item = (Point, Point)> {
        self.primitives.iter().map(|record| bounding_box(balls::<P>(&self.vertices, record)))
    }

    /// What each primitive weighs.
    pub(super) fn weights<G: Geometry<Primitive = P>>(&self) -> Vec<f64> {
        let all = self.primitives.iter().flat_map(|record| balls::<P>(&self.vertices, record));
        let size = |ball: Sphere| ball.centre.into_iter().fold(ball.radius, |m, x| m.max(x.abs()));
        let scale = scale_to_one(all.map(size).fold(0.0, f64::max));
        let mut corners = Vec::new();
        let weigh = |record: &P::Record| {
            let radius = corners_of::<P>(&self.vertices, record, &mut corners);
            corners.iter_mut().flatten().for_each(|x| *x *= scale);
            G::weight(&corners, radius * scale)
        };
        self.primitives.iter().map(weigh).collect()
    }
}

/// Whether vertices are in the range, and not too many.
pub(super) fn check_vertices<P: Primitive>(vertices: &[P::Double]) -> Result<(), BuildError> {
    if u32::try_from(vertices.len()).is_err() {
        return Err(BuildError::TooLarge { count: vertices.len() });
    }
    for (index, vertex) in vertices.iter().enumerate() {
        let Sphere { centre, radius } = P::ball(vertex);
        // The comparisons are false for NaN.
        if !centre.iter().all(|x| x.abs() <= MAX_COORDINATE) {
            return Err(BuildError::Vertex { index });
        }
        if !(radius >= 0.0 && centre.iter().all(|x| x.abs() + radius <= MAX_COORDINATE)) {
            return Err(BuildError::Radius { index });
        }
    }
    Ok(())
}

/// Whether records are not too many, and name no vertex but the first `vertices`.
pub(super) fn check_records<R: AsRef<[u32]>>(records: &[R], vertices: usize) -> Result<(), BuildError> {
    if records.len() > Child::MAX_PRIMITIVES as usize {
        return Err(BuildError::TooLarge { count: records.len() });
    }
    let in_range = |record: &R| record.as_ref().iter().all(|&v| (v as usize) < vertices);
    match records.iter().position(|record| !in_range(record)) {
        Some(index) => Err(BuildError::Primitive { index }),
        None => Ok(()),
    }
}

/// What the corners of a primitive are, with the radius about them.
pub(super) fn balls<P: Primitive<Record: AsRef<[u32]>>>(
    vertices: &[P::Double],
    record: &P::Record,
) -> impl Iterator<Item = Sphere> {
    record.as_ref().iter().map(|&vertex| P::ball(&vertices[vertex as usize]))
}

/// Writes the corners of a primitive, and returns its radius.
pub(super) fn corners_of<P: Primitive<Record: AsRef<[u32]>>>(
    vertices: &[P::Double],
    record: &P::Record,
    corners: &mut Vec<Point>,
) -> f64 {
    corners.clear();
    corners.extend(balls::<P>(vertices, record).map(|ball| ball.centre));
    balls::<P>(vertices, record).fold(0.0, |radius, ball| f64::max(radius, ball.radius))
}

/// Low and high corner of the box of some balls; of none, infinities.
pub(super) fn bounding_box(balls: impl Iterator<Item = Sphere>) -> (Point, Point) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for Sphere { centre, radius } in balls {
        for i in 0..3 {
            low[i] = low[i].min(centre[i] - radius);
            high[i] = high[i].max(centre[i] + radius);
        }
    }
    (low, high)
}
