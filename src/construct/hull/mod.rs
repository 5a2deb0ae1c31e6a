//! Convex hulls of points, exact by the signs of orientation determinants.

mod facets;
mod fan;
mod flat;
mod order;
mod orientation;
mod polygons;

use super::error::BuildError;
use super::input::{OwnedMesh, check_vertices};
use crate::primitive::Triangles;
use crate::range::{Point, flush};
use alloc::vec::Vec;
use facets::Facets;
use order::reorder;
use orientation::{area, compare, height, projected};

/// The convex hull of points, as triangles.
///
/// It is exact: each corner is one of the points, and each point is in the hull. Facets are polygons of any number of
/// corners, cut into a fan of triangles each. No vertex is inside a facet or an edge, and no triangle of the hull of
/// points in space is degenerate. The mesh depends on the set of points only, not on their order, and is the same on
/// every machine.
///
/// Points in one plane, on one line or at one place have a hull, too, which is not solid: a polygon, oriented either
/// way, or one degenerate triangle. The hull of no points is empty. The hull has no radius: for points widened by a
/// radius, use that [of a body in a scene](crate::scene::Body::with_radius), or
/// [`Query::within`](crate::query::Query::within).
///
/// The points are inserted in a fixed pseudorandom order, and each facet has a list of the points that it sees
/// (Clarkson and Shor, *Applications of random sampling in computational geometry II*, 1989). For n points this takes
/// an expected time proportional to `n log n` and memory proportional to n; both are at most about the square of n.
///
/// ```
/// use simdop::construct::ConvexHull;
///
/// // The corners of a cube, its centre, and the centre of a side.
/// let corners = (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
/// let points: Vec<_> = corners.chain([[0.5; 3], [0.5, 0.5, 1.0]]).collect();
/// let hull = ConvexHull::of(&points)?;
/// assert!(hull.is_solid);
/// assert_eq!((hull.mesh.vertices.len(), hull.mesh.triangles.len()), (8, 12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Debug)]
pub struct ConvexHull {
    /// The corners in lexicographic order, and triangles that are counterclockwise as seen from outside.
    pub mesh: OwnedMesh,
    /// Whether the points are not all in one plane. Then the mesh is closed, and may be
    /// [solid](crate::construct::Builder::solid).
    pub is_solid: bool,
}

impl ConvexHull {
    /// The hull of points in any order, which may coincide. As in all bodies, coordinates below
    /// [`MIN_COORDINATE`](crate::range::MIN_COORDINATE) become zero.
    ///
    /// # Errors
    /// [`BuildError::Vertex`] with the index of a point that is NaN, infinite or out of range;
    /// [`BuildError::TooLarge`]; [`BuildError::TooSmall`].
    pub fn of(points: &[Point]) -> Result<Self, BuildError> {
        // Up to twice as many facets have indices.
        if points.len() > (u32::MAX / 4) as usize {
            return Err(BuildError::TooLarge { count: points.len() });
        }
        check_vertices::<Triangles>(points)?;
        let is_zero = |points: &[Point]| points.as_flattened().iter().all(|x| *x == 0.0);
        let mut flushed: Vec<Point> = points.iter().map(|p| p.map(flush)).collect();
        if is_zero(&flushed) && !is_zero(points) {
            return Err(BuildError::TooSmall);
        }
        let corners = spanning(&flushed);
        let mesh = match *corners.as_slice() {
            [] => OwnedMesh { vertices: corners.clone(), triangles: Vec::new() },
            [_] => OwnedMesh { vertices: corners.clone(), triangles: alloc::vec![[0; 3]] },
            [_, _] => OwnedMesh { vertices: corners.clone(), triangles: alloc::vec![[0, 1, 1]] },
            [p, q, r] => flat::hull(flushed, &[p, q, r]),
            _ => {
                reorder(&mut flushed);
                let points = [corners.as_slice(), &flushed].concat();
                polygons::mesh(&points, Facets::around(&points).facets())
            }
        };
        Ok(Self { mesh, is_solid: corners.len() == 4 })
    }
}

/// Points with the affine span of all points, one more than its dimension. Two are the ends of points on a line; more
/// are far from each other.
fn spanning(points: &[Point]) -> Vec<Point> {
    let ends = (points.iter().copied().min_by(compare), points.iter().copied().max_by(compare));
    let (Some(p), Some(q)) = ends else { return Vec::new() };
    if p == q {
        return alloc::vec![p];
    }
    // A determinant of 0 is exact.
    let farthest = |measure: &dyn Fn(&Point) -> f64| {
        let mut found = (0.0, None);
        for point in points {
            let size = measure(point);
            if size > found.0 {
                found = (size, Some(*point));
            }
        }
        found.1
    };
    let from_line = |r: &Point| {
        let areas = [0, 1, 2].map(|axis| area(projected(&[p, q, *r], axis)).abs());
        areas[0].max(areas[1]).max(areas[2])
    };
    let Some(r) = farthest(&from_line) else { return alloc::vec![p, q] };
    match farthest(&|s| height([&p, &q, &r], s).abs()) {
        Some(s) => alloc::vec![p, q, r, s],
        None => alloc::vec![p, q, r],
    }
}
