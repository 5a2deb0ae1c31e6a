//! Primitives over a table of vertices.

#[cfg(doc)]
use crate::construct::{Builder, Magnification};
#[cfg(doc)]
use crate::node::NormalSlab;
use crate::primitive::shape::{ShapeError, ShapeNumbers};
use crate::primitive::{Primitive, Shape, Shapes, Sphere, Spheres, Triangles, triangle};
use crate::range::Point;
use crate::vector::sqrt;
use alloc::borrow::Cow;
use alloc::vec::Vec;

/// Primitives over a table of vertices: the input of [`Builder::build_geometry`].
pub trait Geometry {
    /// The type of the primitives. Their records are the indices of their corners.
    type Primitive: Primitive<Record: AsRef<[u32]> + AsMut<[u32]>>;

    /// All vertices, in the body's unit.
    fn vertices(&self) -> &[<Self::Primitive as Primitive>::Double];
    /// The indices of each primitive's corners.
    fn primitives(&self) -> Cow<'_, [<Self::Primitive as Primitive>::Record]>;
    /// The weight of a primitive for [`Magnification::Area`]: finite and not negative. Corners and radius are scaled so
    /// that no number is above 2.
    fn weight(corners: &[Point], radius: f64) -> f64;
    /// A primitive's normal, of either sign, with the weight as its length; zero if it has none. Children get a
    /// [`NormalSlab`] along the mean normal of their primitives.
    #[must_use]
    fn normal(_corners: &[Point]) -> Point {
        [0.0; 3]
    }
    /// Whether a primitive is degenerate, such as a triangle without area. Degenerate primitives are counted.
    fn is_degenerate(corners: &[Point], radius: f64) -> bool;
}

/// The record of a geometry's primitives.
pub(in crate::construct) type Record<G> = <<G as Geometry>::Primitive as Primitive>::Record;

/// Triangles as three indices each into the vertices. Duplicate, unused and non-manifold parts are accepted.
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
        sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2])
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

    /// The volume, up to a constant factor.
    fn weight(_corners: &[Point], radius: f64) -> f64 {
        radius * radius * radius
    }

    fn is_degenerate(_corners: &[Point], radius: f64) -> bool {
        radius == 0.0
    }
}

/// Shapes, which may overlap and coincide: a link of several capsules, or a shelf of cuboids.
#[derive(Clone, Debug)]
pub struct ShapeSet {
    shapes: Vec<ShapeNumbers>,
}

impl ShapeSet {
    /// A set of shapes.
    ///
    /// # Errors
    /// [`ShapeError::Unbounded`] if one of them is a half-space.
    pub fn new(shapes: &[Shape]) -> Result<Self, ShapeError> {
        Ok(Self { shapes: shapes.iter().map(ShapeNumbers::try_from).collect::<Result<_, _>>()? })
    }
}

impl Geometry for ShapeSet {
    type Primitive = Shapes;

    fn vertices(&self) -> &[ShapeNumbers] {
        &self.shapes
    }

    fn primitives(&self) -> Cow<'_, [[u32; 1]]> {
        (0..self.shapes.len()).map(|index| [index as u32]).collect()
    }

    /// The squared size, up to a constant factor.
    fn weight(corners: &[Point], radius: f64) -> f64 {
        let Some(first) = corners.first() else { return 0.0 };
        let square = |p: &Point| (0..3).map(|i| (p[i] - first[i]) * (p[i] - first[i])).sum::<f64>();
        corners.iter().map(square).fold(radius * radius, f64::max)
    }

    fn is_degenerate(corners: &[Point], radius: f64) -> bool {
        radius == 0.0 && corners.len() == 1
    }
}
