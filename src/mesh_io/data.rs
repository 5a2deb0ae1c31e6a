//! The mesh that a file becomes.

use super::error::{FileError, FilePlace};
use super::polygon;
use crate::construct::Mesh;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use std::collections::HashMap;

/// The mesh of a file.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct MeshData {
    /// The vertices, in the file's unit.
    pub vertices: Vec<[f64; 3]>,
    /// Three indices into the vertices for each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// The faces of a file, before they are cut into triangles: their vertices may come later.
#[derive(Default)]
pub(super) struct Faces {
    corners: Vec<u32>,
    /// Where each face ends in `corners`, and where it is in the file.
    pub(super) ends: Vec<(usize, FilePlace)>,
}

impl Faces {
    pub(super) fn add(
        &mut self,
        corners: impl IntoIterator<Item = u32>,
        place: FilePlace,
    ) -> Result<(), FileError> {
        let start = self.corners.len();
        self.corners.extend(corners);
        let count = self.corners.len() - start;
        if count < 3 {
            let problem = format!("a face with {count} corners, at least 3 are needed");
            return Err(FileError { place, problem });
        }
        self.ends.push((self.corners.len(), place));
        Ok(())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&[u32], FilePlace)> {
        let mut start = 0;
        self.ends
            .iter()
            .map(move |&(end, place)| (&self.corners[core::mem::replace(&mut start, end)..end], place))
    }

    /// The mesh of these faces. Every corner is one of the vertices.
    pub(super) fn into_mesh(self, vertices: Vec<[f64; 3]>) -> Result<MeshData, FileError> {
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
                .map_err(|problem| FileError { place, problem: problem.into() })?;
        }
        Ok(MeshData { vertices, triangles }.joined())
    }
}

impl MeshData {
    /// The mesh as builders take it.
    #[must_use]
    pub fn as_mesh(&self) -> Mesh<'_> {
        Mesh { vertices: &self.vertices, triangles: &self.triangles }
    }

    /// Scales the vertices along each axis. A reflection reverses the triangles, so that what was inside stays inside.
    #[must_use]
    pub fn scaled(mut self, scale: [f64; 3]) -> Self {
        for vertex in &mut self.vertices {
            *vertex = core::array::from_fn(|i| scale[i] * vertex[i]);
        }
        if scale.iter().product::<f64>() < 0.0 {
            self.triangles.iter_mut().for_each(|[_, b, c]| core::mem::swap(b, c));
        }
        self
    }

    /// The mesh of triangles that are given by their corners. Corners whose coordinates have the same bits become one
    /// vertex.
    #[must_use]
    pub fn of(soup: &[[[f64; 3]; 3]]) -> Self {
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
