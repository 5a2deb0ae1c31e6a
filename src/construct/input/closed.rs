//! Whether a surface is closed after joining vertices with equal coordinates.

use super::geometry::Mesh;
use super::ranges::{check_records, check_vertices};
use crate::construct::error::{BuildError, OpenEdge};
use crate::primitive::Triangles;
use crate::range::Point;
use alloc::vec::Vec;
use core::cmp::Ordering;

/// Why a mesh does not bound a solid.
pub(crate) enum Unclosed {
    /// The mesh is invalid.
    Mesh(BuildError),
    /// The surface has a border.
    Open(OpenEdge),
}

/// Checks that a mesh is valid and closed.
pub(crate) fn check_closed(mesh: &Mesh<'_>) -> Result<(), Unclosed> {
    check_vertices::<Triangles>(mesh.vertices).map_err(Unclosed::Mesh)?;
    check_records(mesh.triangles, mesh.vertices.len()).map_err(Unclosed::Mesh)?;
    check_edges(mesh.vertices, mesh.triangles.iter().copied()).map_err(Unclosed::Open)
}

/// Checks that as many triangles run along each edge in one direction as in the other, after joining vertices with
/// equal coordinates.
///
/// Then the surface has no border, and its winding number around a point does not depend on the ray that counts it. An
/// edge usually has two triangles; where solids touch along an edge it has four.
pub(in crate::construct) fn check_edges(
    vertices: &[Point],
    triangles: impl Iterator<Item = [u32; 3]>,
) -> Result<(), OpenEdge> {
    let first = first_at_place(vertices);
    let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * triangles.size_hint().0);
    for t in triangles {
        let t = t.map(|v| first[v as usize]);
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            match a.cmp(&b) {
                Ordering::Less => edges.push(([a, b], true)),
                Ordering::Greater => edges.push(([b, a], false)),
                // An edge of a degenerate triangle: it has no direction.
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
            return Err(OpenEdge { edge, corners: edge.map(|v| vertices[v as usize]), forward, backward });
        }
    }
    Ok(())
}

/// For each vertex, the first one with the same coordinates. 0 and -0 are equal.
pub(in crate::construct) fn first_at_place(vertices: &[Point]) -> Vec<u32> {
    // Not inlined: a sort compares in many places.
    #[inline(never)]
    fn compare(a: &Point, b: &Point) -> Ordering {
        let axes = (0..3).map(|i| (a[i] + 0.0).total_cmp(&(b[i] + 0.0)));
        axes.fold(Ordering::Equal, Ordering::then)
    }
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
