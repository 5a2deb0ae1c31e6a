//! Packings of the meshes, by their number of spheres: the fraction of the volume that they leave uncovered, against
//! the time to compute the shared volume of two packings.

use super::approach::{DISTANCES, PerDistance};
use super::clock::{self, Times};
use crate::{body, error::Error, progress};
use core::ops::ControlFlow;
use serde::Serialize;
use simdop::construct::Mesh;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::mesh_io::MeshData;
use simdop::node::Node16;
use simdop::packing::{PackError, Packer, Packing};
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::query::Query;

/// The first spheres of a packing, equally many for each body.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(super) struct Packed {
    pub(super) spheres: usize,
    /// The fraction of the meshes' volume that no sphere covers.
    pub(super) volume_error: f64,
    /// Bytes of the trees.
    pub(super) bytes: usize,
    pub(super) at: PerDistance<PackedAt>,
}

/// Results at one distance.
#[derive(Copy, Clone, PartialEq, Default, Debug, Serialize)]
pub(super) struct PackedAt {
    /// Mean number of pairs of spheres that meet, over the poses.
    pub(super) pairs: f64,
    pub(super) visits: f64,
    pub(super) median_microseconds: f64,
    pub(super) p99_microseconds: f64,
}

/// The result of packing the meshes.
pub(super) enum Packings {
    /// None were requested.
    None,
    /// A mesh cannot be packed, for this reason.
    Impossible(String),
    Of(Vec<Packed>),
}

type Tree = Bvh<Node16<18>, Spheres>;

/// The meshes' packings with 10, 20, 50, 100 and so on spheres, up to `most`, measured at these poses.
pub(super) fn measure(
    meshes: &[(&str, &MeshData)],
    most: usize,
    poses: &PerDistance<Vec<Pose>>,
    isa: Isa,
    quiet: bool,
) -> Result<Packings, Error> {
    if most == 0 {
        return Ok(Packings::None);
    }
    let mut filled = Vec::new();
    for (name, mesh) in meshes {
        match fill(name, mesh, most, quiet) {
            Ok(packing) => filled.push((*name, packing)),
            Err(error @ (PackError::Open { .. } | PackError::Flat)) => {
                return Ok(Packings::Impossible(format!("{name}: {error}")));
            }
            Err(error) => return Err(Error::Pack { name: (*name).into(), error }),
        }
    }
    // At most as many as each packing has.
    let most = filled.iter().map(|(_, packing)| packing.spheres.len()).fold(most, usize::min);
    let mut entrants = Vec::new();
    for spheres in steps(most) {
        let tree = |(name, packing): &(&str, Packing)| body::of_spheres(name, &packing.spheres[..spheres]);
        entrants.push((spheres, filled.iter().map(tree).collect::<Result<Vec<Tree>, _>>()?));
    }
    let mut packed: Vec<Packed> = entrants
        .iter()
        .map(|(spheres, trees)| Packed {
            spheres: *spheres,
            volume_error: volume_error(&filled, *spheres),
            bytes: trees.iter().map(|tree| tree.as_bytes().len()).sum(),
            at: PerDistance::default(),
        })
        .collect();
    let query = Query::new(isa);
    let bar = progress::bar(DISTANCES.len() * clock::ROUNDS, "rounds of packings", quiet);
    for (distance, poses) in poses.iter().enumerate() {
        let ask = |which: usize, pose: &Pose| {
            let trees: &Vec<Tree> = &entrants[which].1;
            query.penetration(&trees[0], &trees[trees.len() - 1], pose)
        };
        let times = clock::in_turns(entrants.len(), poses.len(), &bar, |which, pose| {
            let _ = core::hint::black_box(ask(which, &poses[pose]));
        });
        for (which, (packed, Times { median, p99 })) in packed.iter_mut().zip(times).enumerate() {
            let found: Vec<_> = poses.iter().map(|pose| ask(which, pose)).collect();
            let mean = |sum: u64| sum as f64 / poses.len() as f64;
            packed.at[distance] = PackedAt {
                pairs: mean(found.iter().map(|one| one.pairs).sum()),
                visits: mean(found.iter().map(|one| one.stats.visits).sum()),
                median_microseconds: median,
                p99_microseconds: p99,
            };
        }
    }
    Ok(Packings::Of(packed))
}

fn fill(name: &str, mesh: &MeshData, most: usize, quiet: bool) -> Result<Packing, PackError> {
    let bar = progress::bar(most, &format!("spheres in {name}"), quiet);
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Packer::new().spheres(most).pack_with(&mesh, &mut |filling| {
        bar.set_position(filling.placed as u64);
        ControlFlow::Continue(())
    })
}

/// The volume that the first spheres of all packings leave uncovered, relative to the volume enclosed by the meshes.
fn volume_error(filled: &[(&str, Packing)], spheres: usize) -> f64 {
    let volume: f64 = filled.iter().map(|(_, packing)| packing.volume).sum();
    let covered = |packing: &Packing| {
        let share = spheres.checked_sub(1).and_then(|last| packing.shares().nth(last));
        share.unwrap_or_default() * packing.volume
    };
    1.0 - filled.iter().map(|(_, packing)| covered(packing)).sum::<f64>() / volume
}

/// 10, 20, 50, 100, 200 and so on, and `most` last.
fn steps(most: usize) -> Vec<usize> {
    let decades = (1..).map_while(|power| 10_usize.checked_pow(power));
    let mut steps: Vec<usize> =
        decades.flat_map(|ten| [ten, 2 * ten, 5 * ten]).take_while(|&step| step < most).collect();
    steps.push(most);
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use simdop::primitive::Sphere;

    #[test]
    fn steps_end_with_the_last_sphere() {
        assert_eq!(steps(1000), [10, 20, 50, 100, 200, 500, 1000]);
        assert_eq!(steps(30), [10, 20, 30]);
        assert_eq!(steps(1), [1]);
    }

    /// Two packings are weighted by the volumes of their meshes.
    #[test]
    fn what_is_uncovered_is_weighed_by_volume() {
        let ball = |radius| Sphere { centre: [0.0; 3], radius };
        let packing = |volume, radii: [f64; 2]| Packing { spheres: radii.map(ball).into(), volume };
        let filled = [("a", packing(10.0, [1.0, 0.5])), ("b", packing(30.0, [1.5, 0.1]))];
        let volume = |radius: f64| 4.0 / 3.0 * core::f64::consts::PI * radius.powi(3);
        let want = 1.0 - (volume(1.0) + volume(1.5)) / 40.0;
        assert!((volume_error(&filled, 1) - want).abs() < 1e-12);
        let want = want - (volume(0.5) + volume(0.1)) / 40.0;
        assert!((volume_error(&filled, 2) - want).abs() < 1e-12);
    }
}
