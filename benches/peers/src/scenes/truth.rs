//! Decides which configurations are free, by brute force in exact arithmetic on corners that were moved to the world
//! frame.

use super::{Task, rows};
use crate::data::MeshData;
use crate::dyadic::sign_of_determinant;
use crate::exact::{Tri, meshes_meet};
use crate::suites::Rows;
use simdop::construct::OwnedMesh;

/// A body in the world, and its box.
struct Placed {
    triangles: Vec<Tri>,
    low: [f64; 3],
    high: [f64; 3],
}

impl Placed {
    fn new(mesh: &MeshData, rows: &Rows) -> Self {
        let triangles = mesh.placed(rows);
        let fold = |f: fn(f64, f64) -> f64, start: f64| {
            let corners = triangles.as_flattened().iter();
            corners.fold([start; 3], |m, p| core::array::from_fn(|i| f(m[i], p[i])))
        };
        Self { low: fold(f64::min, f64::INFINITY), high: fold(f64::max, f64::NEG_INFINITY), triangles }
    }

    fn is_near(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    fn meets(&self, other: &Self) -> bool {
        self.is_near(other) && meshes_meet(&self.triangles, &other.triangles)
    }

    /// Whether a part of this is inside the other, which is convex, given that their surfaces do not meet.
    fn is_partly_in(&self, convex: &Self) -> bool {
        let is_in = |p: &[f64; 3]| {
            (0..3).all(|i| convex.low[i] <= p[i] && p[i] <= convex.high[i])
                && convex.triangles.iter().all(|[a, b, c]| sign_of_determinant(a, b, c, [p, a]) <= 0)
        };
        // A triangle is inside if one of its corners is.
        self.is_near(convex) && self.triangles.iter().any(|triangle| is_in(&triangle[0]))
    }
}

/// For each configuration, whether it is free with the obstacles as surfaces, and as solids.
pub(super) fn free(task: &Task) -> [Vec<bool>; 2] {
    let obstacles = |problem: usize| -> Vec<Placed> {
        let obstacles = task.problems[problem].obstacles.iter();
        let placed = obstacles.map(|obstacle| {
            let OwnedMesh { vertices, triangles } = obstacle.shape.mesh();
            Placed::new(&MeshData { vertices, triangles }, &rows(&obstacle.at))
        });
        placed.collect()
    };
    let obstacles: Vec<Vec<Placed>> = (0..task.problems.len()).map(obstacles).collect();
    let decide = |configuration: &super::Configuration| {
        let links = task.robot.links.iter().zip(&configuration.places);
        let links: Vec<Placed> = links.map(|(link, rows)| Placed::new(&link.mesh, rows)).collect();
        let any = |meet: fn(&Placed, &Placed) -> bool| {
            let still = &obstacles[configuration.problem];
            still.iter().any(|obstacle| links.iter().any(|link| meet(link, obstacle)))
        };
        let hits = any(Placed::meets) || task.robot.pairs.iter().any(|&(i, j)| links[i].meets(&links[j]));
        (!hits, !(hits || any(Placed::is_partly_in)))
    };
    let (surfaces, solids) = task.configurations.iter().map(decide).unzip();
    [surfaces, solids]
}
