//! Meshes of simple shapes.

use super::geometry::Mesh;
use crate::exact::power_of_two;
use crate::primitive::shape::{ShapeError, length};
use crate::range::Point;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// A mesh that owns its vertices and triangles.
///
/// The meshes made here are closed, with triangles counterclockwise as seen from outside, and so may be
/// [solid](crate::construct::Builder::solid). They are for drawing, and for functions that take only meshes: queries
/// take a [`Shape`](crate::primitive::Shape) itself, without an approximation error.
///
/// ```
/// use simdop::construct::{Builder, OwnedMesh};
///
/// let can = OwnedMesh::cylinder(0.03, 0.14, 1e-4)?;
/// assert_eq!((can.vertices.len(), can.triangles.len()), (80, 156));
/// let solid = Builder::new().solid().build(&can.as_mesh())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Debug)]
pub struct OwnedMesh {
    /// Corners, in the body's unit.
    pub vertices: Vec<Point>,
    /// Indices of the corners.
    pub triangles: Vec<[u32; 3]>,
}

/// Relative allowance for the roundings of a vertex.
const ROUNDING: f64 = power_of_two(-48);

impl OwnedMesh {
    /// The largest number of sides of a cylinder or a cone. It allows an error of 3e-7 of the radius.
    pub const MAX_SIDES: u32 = 4096;

    /// The mesh, borrowed.
    #[must_use]
    pub fn as_mesh(&self) -> Mesh<'_> {
        Mesh { vertices: &self.vertices, triangles: &self.triangles }
    }

    /// A cuboid with these side lengths, centred at the origin.
    ///
    /// # Errors
    /// [`ShapeError::Length`].
    pub fn cuboid(sides: Point) -> Result<Self, ShapeError> {
        let half = [0.5 * length(sides[0])?, 0.5 * length(sides[1])?, 0.5 * length(sides[2])?];
        let corner =
            |bits: usize| core::array::from_fn(|i| if bits >> i & 1 == 0 { -half[i] } else { half[i] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Ok(Self { vertices: (0..8).map(corner).collect(), triangles })
    }

    /// A prism along z, centred at the origin, that contains the cylinder of this radius and height. No point of it is
    /// farther than `error` from the cylinder.
    ///
    /// # Errors
    /// [`ShapeError::Length`]; [`ShapeError::Error`] if the error is not positive, or too small.
    pub fn cylinder(radius: f64, height: f64, error: f64) -> Result<Self, ShapeError> {
        let (rim, half) = (rim(radius, error)?, 0.5 * length(height)?);
        let sides = rim.len() as u32;
        let mut vertices = Vec::with_capacity(2 * rim.len() + 2);
        vertices.extend([[0.0, 0.0, -half], [0.0, 0.0, half]]);
        vertices.extend(rim.iter().flat_map(|&[x, y]| [[x, y, -half], [x, y, half]]));
        let mut triangles = Vec::with_capacity(4 * rim.len());
        for i in 0..sides {
            let (p, q) = (2 + 2 * i, 2 + 2 * ((i + 1) % sides));
            triangles.extend([[0, q, p], [p, q, q + 1], [p, q + 1, p + 1], [1, p + 1, q + 1]]);
        }
        Ok(Self { vertices, triangles })
    }

    /// A pyramid around the z axis that contains the cone of this radius and height. No point of it is farther than
    /// `error` from the cone. The origin is midway between the base and the tip, which is above.
    ///
    /// # Errors
    /// As [`OwnedMesh::cylinder`].
    pub fn cone(radius: f64, height: f64, error: f64) -> Result<Self, ShapeError> {
        let (rim, half) = (rim(radius, error)?, 0.5 * length(height)?);
        let sides = rim.len() as u32;
        let mut vertices = alloc::vec![[0.0, 0.0, -half], [0.0, 0.0, half]];
        vertices.extend(rim.iter().map(|&[x, y]| [x, y, -half]));
        let mut triangles = Vec::with_capacity(2 * rim.len());
        for i in 0..sides {
            let (p, q) = (2 + i, 2 + (i + 1) % sides);
            triangles.extend([[0, q, p], [1, p, q]]);
        }
        Ok(Self { vertices, triangles })
    }
}

/// The corners of the regular polygon with the fewest sides that contains the circle and is within `error` of it.
fn rim(radius: f64, error: f64) -> Result<Vec<[f64; 2]>, ShapeError> {
    let radius = length(radius)?;
    // The corners of a polygon of n sides around a circle are 1 / cos(pi / n) times the radius away.
    let outer = |sides: u32| radius * (1.0 + ROUNDING) / libm::cos(PI / f64::from(sides));
    let allowed = (radius + error) * (1.0 - ROUNDING);
    let fits = |sides: u32| outer(sides) <= allowed;
    if !(error > 0.0 && fits(OwnedMesh::MAX_SIDES)) {
        return Err(ShapeError::Error { given: error });
    }
    // The distance decreases with the number of sides: bisection finds the least number that fits.
    let (mut below, mut sides) = (2, OwnedMesh::MAX_SIDES);
    while sides - below > 1 {
        let middle = below.midpoint(sides);
        if fits(middle) { sides = middle } else { below = middle }
    }
    let away = outer(sides);
    let corner = |i: u32| {
        let (sin, cos) = libm::sincos(2.0 * PI * f64::from(i) / f64::from(sides));
        [away * cos, away * sin]
    };
    Ok((0..sides).map(corner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of the origin from an edge: the foot is its middle.
    fn edge(p: &[f64; 2], q: &[f64; 2]) -> f64 {
        (0.5 * (p[0] + q[0])).hypot(0.5 * (p[1] + q[1]))
    }

    #[test]
    fn polygons_hold_their_circle_and_are_near_it() {
        for radius in [1.0, 0.03, 1e-70, 1e60] {
            for relative in [4.0, 0.9, 0.1, 1e-3, 1e-5, 4e-7] {
                let error = relative * radius;
                let rim = rim(radius, error).unwrap();
                for (i, p) in rim.iter().enumerate() {
                    let q = &rim[(i + 1) % rim.len()];
                    assert!(edge(p, q) >= radius, "{radius} {relative}: {}", edge(p, q));
                    assert!(p[0].hypot(p[1]) <= radius + error, "{radius} {relative}");
                }
                // One side fewer does not suffice.
                let fewer = rim.len() - 1;
                assert!(fewer < 3 || radius / (PI / fewer as f64).cos() > (radius + error) * (1.0 - 1e-12));
            }
        }
    }

    /// The volume by tetrahedra from the origin: positive, so the triangles are counterclockwise from outside.
    fn volume(mesh: &OwnedMesh) -> f64 {
        let corner = |v: u32| glam::DVec3::from_array(mesh.vertices[v as usize]);
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    #[test]
    fn shapes_are_closed_and_as_large_as_they_are() {
        let (cuboid, can, cone) = (
            OwnedMesh::cuboid([1.0, 2.0, 3.0]).unwrap(),
            OwnedMesh::cylinder(2.0, 5.0, 1e-4).unwrap(),
            OwnedMesh::cone(2.0, 5.0, 1e-4).unwrap(),
        );
        for (mesh, want, off) in
            [(&cuboid, 6.0, 0.0), (&can, 20.0 * PI, 1e-4), (&cone, 20.0 / 3.0 * PI, 1e-4)]
        {
            let got = volume(mesh);
            assert!(got >= want * (1.0 - 1e-12) && got <= want * (1.0 + 1e-12 + off), "{got} {want}");
            let mut edges: Vec<_> =
                mesh.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
            edges.sort_unstable();
            assert!(edges.iter().all(|[p, q]| edges.binary_search(&[*q, *p]).is_ok()), "closed");
            assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "each edge once either way");
        }
        let high = |mesh: &OwnedMesh| mesh.vertices.iter().fold(0.0, |m: f64, p| m.max(p[2].abs()));
        assert_eq!([high(&cuboid), high(&can), high(&cone)], [1.5, 2.5, 2.5]);
        assert_eq!(cone.vertices[1], [0.0, 0.0, 2.5], "the tip is above");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for given in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            let refused = |error: Option<ShapeError>| match error {
                Some(ShapeError::Length { given: named }) => named.to_bits() == given.to_bits(),
                _ => false,
            };
            assert!(refused(OwnedMesh::cuboid([1.0, given, 1.0]).err()));
            assert!(refused(OwnedMesh::cylinder(given, 1.0, 0.1).err()));
            assert!(refused(OwnedMesh::cone(1.0, given, 0.1).err()));
        }
        for error in [0.0, -1.0, f64::NAN, 1e-8] {
            assert!(matches!(OwnedMesh::cylinder(1.0, 1.0, error), Err(ShapeError::Error { .. })), "{error}");
        }
    }
}
