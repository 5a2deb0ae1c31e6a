//! Triangulates bodies, for pictures.

use crate::arrays::table;
use crate::body::PyBody;
use crate::error::OrRaise;
use crate::geometry::Geometry;
use numpy::PyArray2;
use pyo3::prelude::*;
use simdop::construct::ConvexHull;
use simdop::primitive::Shape;
use simdop::primitive::shape::Core;
use simdop::range::Point;
use simdop::scene::BodyTree;
use std::f64::consts::TAU;

fn plus(p: &Point, x: f64, v: &Point) -> Point {
    [0, 1, 2].map(|i| p[i] + x * v[i])
}

/// A circle about an axis.
fn circle(centre: &Point, axis: &Point, radius: f64, segments: usize) -> Vec<Point> {
    let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0);
    let cross = |p: &Point, q: &Point| {
        [0, 1, 2].map(|i: usize| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            p[j] * q[k] - p[k] * q[j]
        })
    };
    let unit = |v: Point| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let mut beside = [0.0; 3];
    beside[least] = 1.0;
    let u = unit(cross(axis, &beside));
    let v = unit(cross(axis, &u));
    let at = |i: usize| {
        let (sine, cosine) = (TAU * i as f64 / segments as f64).sin_cos();
        plus(&plus(centre, radius * cosine, &u), radius * sine, &v)
    };
    (0..segments).map(at).collect()
}

/// Points whose hull is the core, or lies in it if the core is round. None for a half-space.
fn corners(core: &Core, segments: usize) -> Vec<Point> {
    match core {
        Core::Point(p) => vec![*p],
        Core::Segment(ends) => ends.to_vec(),
        Core::Triangle(corners) => corners.to_vec(),
        Core::Cuboid { centre, half } => (0..8)
            .map(|i| {
                (0..3).fold(*centre, |p, k| plus(&p, if i >> k & 1 == 0 { 1.0 } else { -1.0 }, &half[k]))
            })
            .collect(),
        Core::Cylinder { centre, half_axis, radius } => [-1.0, 1.0]
            .into_iter()
            .flat_map(|end| circle(&plus(centre, end, half_axis), half_axis, *radius, segments))
            .collect(),
        Core::Cone { base, axis, radius } => {
            let mut points = circle(base, axis, *radius, segments);
            points.push(plus(base, 1.0, axis));
            points
        }
        Core::HalfSpace { .. } => vec![],
    }
}

/// Points whose hull is the shape, or lies in it.
fn outline(shape: &Shape, segments: usize) -> Vec<Point> {
    let corners = corners(shape.core(), segments);
    if shape.radius() == 0.0 {
        return corners;
    }
    let mut ball = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let rings = (segments / 2).max(2);
    for i in 1..rings {
        let (sine, cosine) = (TAU * i as f64 / (2 * rings) as f64).sin_cos();
        ball.extend(circle(&[0.0, 0.0, cosine], &[0.0, 0.0, 1.0], sine, segments));
    }
    corners.iter().flat_map(|p| ball.iter().map(|d| plus(p, shape.radius(), d))).collect()
}

/// Vertices and faces.
type Triangulated<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// The triangles of a body.
fn triangulated(geometry: &Geometry, segments: usize) -> PyResult<(Vec<Point>, Vec<[u32; 3]>)> {
    match geometry.view() {
        BodyTree::Mesh(_) => {
            let mesh = geometry.mesh_data("mesh")?;
            Ok((mesh.vertices, mesh.triangles))
        }
        BodyTree::PointCloud(_) => Ok((vec![], vec![])),
        _ => {
            let (mut vertices, mut faces) = (Vec::new(), Vec::new());
            for shape in geometry.shape_list("mesh")? {
                let hull = ConvexHull::of(&outline(&shape, segments)).or_raise()?.mesh;
                let first = vertices.len() as u32;
                vertices.extend(hull.vertices);
                faces.extend(hull.triangles.iter().map(|face| face.map(|i| first + i)));
            }
            Ok((vertices, faces))
        }
    }
}

#[pymethods]
impl PyBody {
    /// Triangles for pictures: vertices (n, 3) and indices (m, 3). Round shapes become polyhedra with ``segments``
    /// corners around the axis, which are on the shape. A half-space and a cloud have no triangles.
    #[pyo3(signature = (segments = 24))]
    fn mesh<'py>(&self, py: Python<'py>, segments: usize) -> PyResult<Triangulated<'py>> {
        let segments = segments.clamp(3, 1024);
        let (vertices, faces) = py.detach(|| triangulated(&self.0, segments))?;
        Ok((table(py, vertices)?, table(py, faces)?))
    }
}
