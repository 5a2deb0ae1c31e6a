//! Spheres that cover the meshes within an error: coarser bodies for a scene. Their "free" is certain, and their "hit"
//! means that the meshes are nearer than the errors.

use super::approach::{self, DISTANCES, PerDistance};
use super::clock::{self, Times};
use crate::cover::{self, Covered, CoveredPart, ToCover};
use crate::{error::Error, progress};
use serde::Serialize;
use simdop::isa::Isa;
use simdop::mesh_io::MeshData;
use simdop::pose::Pose;
use simdop::query::Query;
use std::time::Instant;

/// Errors relative to the largest diagonal.
const ERRORS: [f64; 3] = [0.05, 0.02, 0.01];

/// The covers of all meshes within one error.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(super) struct CoveredBodies {
    /// Maximum distance of the spheres' points from the mesh, in its unit.
    pub(super) error: f64,
    /// Number of spheres of all bodies.
    pub(super) spheres: usize,
    /// Bytes of all trees.
    pub(super) bytes: usize,
    /// The time to compute the spheres and build their trees.
    pub(super) build_milliseconds: f64,
    pub(super) at: PerDistance<CoveredAt>,
}

/// Results at one distance.
#[derive(Copy, Clone, PartialEq, Default, Debug, Serialize)]
pub(super) struct CoveredAt {
    /// Poses at which spheres meet.
    pub(super) hits: usize,
    pub(super) visits: f64,
    pub(super) median_microseconds: f64,
    pub(super) p99_microseconds: f64,
}

impl CoveredBodies {
    /// The geometric mean of the medians at the distances, in microseconds.
    pub(super) fn geometric_mean_microseconds(&self) -> f64 {
        clock::geometric_mean(self.at.map(|at| at.median_microseconds))
    }
}

/// The covers for all [`ERRORS`], the coarsest first, measured at these poses.
pub(super) fn measure(
    meshes: &[(&str, &MeshData)],
    poses: &PerDistance<Vec<Pose>>,
    isa: Isa,
    quiet: bool,
) -> Result<Vec<CoveredBodies>, Error> {
    let diagonals = meshes.iter().map(|(_, mesh)| approach::diagonal(&approach::bounds(mesh)));
    let diagonal = diagonals.fold(0.0, f64::max);
    let bar = progress::bar(ERRORS.len(), "covers", quiet);
    let mut entrants: Vec<(CoveredBodies, Vec<Covered>)> = Vec::new();
    for error in ERRORS.map(|share| share * diagonal) {
        let start = Instant::now();
        let subjects = meshes.iter().map(|&(name, mesh)| ToCover { name, mesh, part: CoveredPart::Surface });
        let covers = subjects.map(|subject| cover::cover(&subject, error));
        let covers = covers.collect::<Result<Vec<Covered>, Error>>()?;
        let build_milliseconds = 1e3 * start.elapsed().as_secs_f64();
        let spheres = covers.iter().map(|cover| cover.spheres.len()).sum();
        let bytes = covers.iter().map(|cover| cover.tree.as_bytes().len()).sum();
        let at = PerDistance::default();
        entrants.push((CoveredBodies { error, spheres, bytes, build_milliseconds, at }, covers));
        bar.inc(1);
    }
    let query = Query::new(isa);
    let bar = progress::bar(DISTANCES.len() * clock::ROUNDS, "rounds of covers", quiet);
    for (distance, poses) in poses.iter().enumerate() {
        let ask = |which: usize, pose: &Pose| {
            let (_, covers) = &entrants[which];
            query.collide(&covers[0].tree, &covers[covers.len() - 1].tree, pose)
        };
        let times = clock::in_turns(entrants.len(), poses.len(), &bar, |which, pose| {
            let _ = core::hint::black_box(ask(which, &poses[pose]));
        });
        let at: Vec<CoveredAt> = (times.iter().enumerate())
            .map(|(which, Times { median, p99 })| {
                let answers: Vec<_> = poses.iter().map(|pose| ask(which, pose)).collect();
                let visits: u64 = answers.iter().map(|answer| answer.stats.visits).sum();
                CoveredAt {
                    hits: answers.iter().filter(|answer| !answer.is_free()).count(),
                    visits: visits as f64 / poses.len() as f64,
                    median_microseconds: *median,
                    p99_microseconds: *p99,
                }
            })
            .collect();
        for ((bodies, _), at) in entrants.iter_mut().zip(at) {
            bodies.at[distance] = at;
        }
    }
    Ok(entrants.into_iter().map(|(bodies, _)| bodies).collect())
}
