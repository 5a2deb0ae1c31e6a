//! Coarser versions of a mesh, by clustering vertices in the cells of a grid (Rossignac & Borrel 1993).

use crate::data::MeshData;
use std::collections::{BTreeMap, BTreeSet};

/// A scan and a machined part.
pub(crate) const MODELS: [&str; 2] = ["armadillo", "fandisk_large"];

/// Cells of the decimating grids along the longest side of the model.
const GRIDS: [u32; 6] = [16, 24, 36, 54, 80, 120];

/// The mesh decimated on each of the grids, and the original last.
pub(crate) fn series(mesh: &MeshData) -> Vec<MeshData> {
    let coarser = GRIDS.iter().map(|&cells| decimated(mesh, cells));
    let mut meshes: Vec<MeshData> =
        coarser.filter(|m| m.triangles.len() * 10 < mesh.triangles.len() * 9).collect();
    meshes.push(mesh.clone());
    meshes
}

/// Replaces the vertices of a cell by their mean. Drops triangles with two corners in one cell, and duplicates.
fn decimated(mesh: &MeshData, cells: u32) -> MeshData {
    let bound = |i: usize, f: fn(f64, f64) -> f64| mesh.vertices.iter().map(|p| p[i]).reduce(f).unwrap();
    let low: [f64; 3] = core::array::from_fn(|i| bound(i, f64::min));
    let longest = (0..3).map(|i| bound(i, f64::max) - low[i]).fold(0.0, f64::max);
    let cell = |p: &[f64; 3]| -> [u32; 3] {
        core::array::from_fn(|i| ((p[i] - low[i]) / longest * f64::from(cells)) as u32)
    };
    let mut members: BTreeMap<[u32; 3], Vec<[f64; 3]>> = BTreeMap::new();
    for p in &mesh.vertices {
        members.entry(cell(p)).or_default().push(*p);
    }
    let mean = |points: &Vec<[f64; 3]>| -> [f64; 3] {
        core::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64)
    };
    let index: BTreeMap<[u32; 3], u32> = members.keys().copied().zip(0..).collect();
    let mut seen = BTreeSet::new();
    let mut triangles = Vec::new();
    for corners in &mesh.triangles {
        let triangle = corners.map(|v| index[&cell(&mesh.vertices[v as usize])]);
        let mut set = triangle;
        set.sort_unstable();
        if set[0] != set[1] && set[1] != set[2] && seen.insert(set) {
            triangles.push(triangle);
        }
    }
    MeshData { vertices: members.values().map(mean).collect(), triangles }
}
