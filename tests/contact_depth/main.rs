//! Contacts and depths: intersections of triangles against exact rational ones, patches of cubes against their corners,
//! depths of boxes and convex bodies against known ones, bounds against sampled translations.

extern crate alloc;

#[path = "../support/heap.rs"]
mod heap;
#[path = "../support/mod.rs"]
mod support;

mod contacts;
mod counts;
mod depth;
mod kinds;
mod oracle;
mod packed;
mod patches;
mod scenes;
mod signed;

use crate::support::data::MeshData;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use simdop::pose::Pose;

pub(crate) type Tree = Bvh<Node16<18>>;

pub(crate) fn solid(mesh: &MeshData) -> Tree {
    Builder::new().solid().build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

/// The pose, and then a translation.
pub(crate) fn translated(at: &Pose, t: &[f64; 3]) -> Pose {
    let (rows, from) = (at.rows(), at.translation());
    Pose::from_rows(core::array::from_fn(|i| [rows[i][0], rows[i][1], rows[i][2], from[i] + t[i]])).unwrap()
}

pub(crate) fn length(t: &[f64; 3]) -> f64 {
    t.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A box whose faces are grids of `n` by `n` squares of two triangles, watertight.
pub(crate) fn grid_box(low: [f64; 3], high: [f64; 3], n: u32) -> MeshData {
    let mut mesh = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    for axis in 0..3 {
        for side in [false, true] {
            let first = mesh.vertices.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    // The ends are exact, so that faces share their borders.
                    let at = |axis: usize, k: u32| {
                        if k == n {
                            high[axis]
                        } else {
                            low[axis] + (high[axis] - low[axis]) / f64::from(n) * f64::from(k)
                        }
                    };
                    let mut p = [0.0; 3];
                    (p[axis], p[u], p[v]) = (if side { high[axis] } else { low[axis] }, at(u, i), at(v, j));
                    mesh.vertices.push(p);
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let p = first + i * (n + 1) + j;
                    let [q, r, s] = [p + n + 1, p + n + 2, p + 1];
                    let quad = if side { [[p, q, r], [p, r, s]] } else { [[p, r, q], [p, s, r]] };
                    mesh.triangles.extend(quad);
                }
            }
        }
    }
    mesh
}
