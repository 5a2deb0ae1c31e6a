//! Whether a mesh is closed, and what it encloses.

use super::PackError;
use crate::construct::{Mesh, check_records, check_vertices};
use crate::primitive::Triangles;
use crate::range::Point;
use alloc::vec::Vec;
use core::cmp::Ordering;
use glam::DVec3;

/// Proves that a mesh is one that can be filled, but for its volume.
pub(super) fn check(mesh: &Mesh<'_>) -> Result<(), PackError> {
    let Mesh { vertices, triangles } = *mesh;
    if triangles.is_empty() {
        return Err(PackError::Empty);
    }
    check_vertices::<Triangles>(vertices).map_err(PackError::Mesh)?;
    check_records(triangles, vertices.len()).map_err(PackError::Mesh)?;
    check_edges(mesh)
}

/// As many triangles run along each edge in one direction as in the other, once corners at one place are one.
///
/// Then the surface has no border, and how often it winds around a point does not depend on the ray by which
/// that is counted. Two triangles an edge is the usual case; where solids touch along an edge there are four.
fn check_edges(mesh: &Mesh<'_>) -> Result<(), PackError> {
    let first = first_at_place(mesh.vertices);
    let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * mesh.triangles.len());
    for t in mesh.triangles {
        let t = t.map(|v| first[v as usize]);
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            match a.cmp(&b) {
                Ordering::Less => edges.push(([a, b], true)),
                Ordering::Greater => edges.push(([b, a], false)),
                // Of a triangle without area: it runs nowhere.
                Ordering::Equal => {}
            }
        }
    }
    edges.sort_unstable();
    for run in edges.chunk_by(|x, y| x.0 == y.0) {
        let forward = run.iter().filter(|(_, is_forward)| *is_forward).count();
        let backward = run.len() - forward;
        if forward != backward {
            let edge = run[0].0;
            let corners = edge.map(|v| mesh.vertices[v as usize]);
            return Err(PackError::Open { edge, corners, forward, backward });
        }
    }
    Ok(())
}

/// For each vertex the first one with its coordinates. 0 and -0 are one place.
fn first_at_place(vertices: &[Point]) -> Vec<u32> {
    let compare = |a: &Point, b: &Point| -> Ordering {
        let axes = (0..3).map(|i| (a[i] + 0.0).total_cmp(&(b[i] + 0.0)));
        axes.fold(Ordering::Equal, Ordering::then)
    };
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_unstable_by(|&v, &w| {
        compare(&vertices[v as usize], &vertices[w as usize]).then_with(|| v.cmp(&w))
    });
    let mut first = alloc::vec![0; vertices.len()];
    let is_one = |v: &u32, w: &u32| compare(&vertices[*v as usize], &vertices[*w as usize]).is_eq();
    for group in order.chunk_by(is_one) {
        for &v in group {
            first[v as usize] = group[0];
        }
    }
    first
}

/// A volume below this share of the sum of the tetrahedra's is rounding: 2^-40.
const ROUNDING: f64 = f64::EPSILON * 4096.0;

/// The volume that closed triangles enclose, whatever their orientation: the sum of signed tetrahedra over a
/// point among them.
pub(super) fn volume(triangles: &[[DVec3; 3]], middle: DVec3) -> Option<f64> {
    let (mut sum, mut magnitude) = (0.0_f64, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|p| p - middle);
        let six_fold = a.dot(b.cross(c));
        sum += six_fold;
        magnitude += six_fold.abs();
    }
    (sum.abs() > ROUNDING * magnitude).then_some(sum.abs() / 6.0)
}
