//! Whether triangles close, once corners at one place are one.

use super::geometry::Mesh;
use super::ranges::{check_records, check_vertices};
use crate::construct::error::{BuildError, OpenEdge};
use crate::primitive::Triangles;
use crate::range::Point;
use alloc::vec::Vec;
use core::cmp::Ordering;

/// Why a mesh bounds no solid.
pub(crate) enum Unclosed {
    /// It is no mesh that could be built.
    Mesh(BuildError),
    /// It has a border.
    Open(OpenEdge),
}

/// Proves that a mesh can be built, and is closed.
pub(crate) fn check_closed(mesh: &Mesh<'_>) -> Result<(), Unclosed> {
    check_vertices::<Triangles>(mesh.vertices).map_err(Unclosed::Mesh)?;
    check_records(mesh.triangles, mesh.vertices.len()).map_err(Unclosed::Mesh)?;
    check_edges(mesh.vertices, mesh.triangles.iter().copied()).map_err(Unclosed::Open)
}

/// As many triangles run along each edge in one direction as in the other, once corners at one place are one.
///
/// Then the surface has no border, and how often it winds around a point does not depend on the ray by which
/// that is counted. Two triangles an edge is the usual case; where solids touch along an edge there are four.
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
            return Err(OpenEdge { edge, corners: edge.map(|v| vertices[v as usize]), forward, backward });
        }
    }
    Ok(())
}

/// For each vertex the first one with its coordinates. 0 and -0 are one place.
pub(in crate::construct) fn first_at_place(vertices: &[Point]) -> Vec<u32> {
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
