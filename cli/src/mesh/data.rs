//! The mesh that a file becomes.

use super::polygon;
use crate::error::{Fault, Place};
use std::collections::HashMap;

/// Vertices and triangles as the library takes them.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct MeshData {
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The faces of a file, before they are cut into triangles: their vertices may come later.
#[derive(Default)]
pub(super) struct Faces {
    corners: Vec<u32>,
    /// Where each face ends in `corners`, and where it is in the file.
    pub(super) ends: Vec<(usize, Place)>,
}

impl Faces {
    pub(super) fn add(&mut self, corners: impl IntoIterator<Item = u32>, place: Place) -> Result<(), Fault> {
        let start = self.corners.len();
        self.corners.extend(corners);
        let count = self.corners.len() - start;
        if count < 3 {
            let problem = format!("a face with {count} corners, at least 3 are needed");
            return Err(Fault { place, problem });
        }
        self.ends.push((self.corners.len(), place));
        Ok(())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&[u32], Place)> {
        let mut start = 0;
        self.ends
            .iter()
            .map(move |&(end, place)| (&self.corners[core::mem::replace(&mut start, end)..end], place))
    }

    /// The mesh of these faces. Every corner is one of the vertices.
    pub(super) fn into_mesh(self, vertices: Vec<[f64; 3]>) -> Result<MeshData, Fault> {
        let mut triangles = Vec::with_capacity(self.ends.len());
        let mut points = Vec::new();
        for (corners, place) in self.iter() {
            if let &[a, b, c] = corners {
                triangles.push([a, b, c]);
                continue;
            }
            points.clear();
            points.extend(corners.iter().map(|&v| vertices[v as usize]));
            polygon::triangulate(&points, |t| triangles.push(t.map(|i| corners[i])))
                .map_err(|problem| Fault { place, problem: problem.into() })?;
        }
        Ok(MeshData { vertices, triangles }.joined())
    }
}

impl MeshData {
    /// The mesh of triangles that are given by their corners.
    pub(crate) fn of(soup: &[[[f64; 3]; 3]]) -> Self {
        let first_corners = (0..soup.len() as u32).map(|i| 3 * i);
        Self { vertices: soup.concat(), triangles: first_corners.map(|c| [c, c + 1, c + 2]).collect() }
            .joined()
    }

    /// Vertices whose coordinates have the same bits become one; those that no triangle uses are left out.
    pub(super) fn joined(self) -> Self {
        let mut vertices = Vec::new();
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        let mut places = vec![None; self.vertices.len()];
        let mut place = |v: u32| {
            let p = self.vertices[v as usize];
            *places[v as usize].get_or_insert_with(|| {
                *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                    vertices.push(p);
                    (vertices.len() - 1) as u32
                })
            })
        };
        let triangles = self.triangles.iter().map(|t| t.map(&mut place)).collect();
        Self { vertices, triangles }
    }
}
