//! The Talos in a street scanned by a lidar.

use super::rng::Rng;
use simdop::cloud::PointCloud;
use simdop::planning::{PlanningScene, RobotFiles, RobotModel};
use simdop::pose::Pose;
use simdop::robot::DisabledPair;
use simdop::scene::Body;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Scale of the scan, which has no points within 1.8 m.
const SCALE: f64 = 0.4;
/// One point in so many is used.
const STEP: usize = 8;
/// Radius of each point, in metres.
const RADIUS: f64 = 0.01;
const SAMPLES: usize = 200;

/// Pairs that meet in about half of all configurations or more, but not in nearly all. The Talos' published SRDF file
/// disables them, for the reason "Default": example-robot-data, `robots/talos_data/srdf/talos.srdf`.
const DEFAULT: [[&str; 2]; 3] = [
    ["base_link", "torso_2_link"],
    ["gripper_left_fingertip_2_link", "gripper_left_motor_double_link"],
    ["gripper_right_fingertip_2_link", "gripper_right_motor_double_link"],
];

/// The Talos. Disables [`DEFAULT`] and the pairs of links that meet in nearly all of some random configurations, since
/// the data has no SRDF file.
pub(crate) fn talos(folder: &Path) -> RobotModel {
    let model = RobotFiles::new(folder.join("robots/talos/talos.urdf")).load().unwrap();
    let scene = PlanningScene::new(model.clone()).unwrap();
    let (mut workspace, mut rng, mut met) = (scene.workspace(), Rng::new(31), BTreeMap::new());
    for _ in 0..SAMPLES {
        let values = scene.random(|| rng.range(0.0, 1.0));
        for hit in scene.hits(&mut workspace, &values, 0.0).unwrap() {
            *met.entry((hit.a, hit.b)).or_insert(0) += 1;
        }
    }
    let link = |id| {
        let body = scene.links().iter().position(|link| *link == id).unwrap();
        model.robot().names[body].clone()
    };
    let always = met.into_iter().filter(|(_, count)| count * 10 > SAMPLES * 9);
    let disabled = always
        .map(|((a, b), _)| [link(a), link(b)])
        .chain(DEFAULT.map(|pair| pair.map(String::from)))
        .map(|links| DisabledPair { links, reason: "Default".into(), line: 0 })
        .collect();
    RobotModel::new(model.robot().clone(), model.bodies().to_vec(), disabled, Vec::new()).unwrap()
}

/// The robot in the middle of the street.
pub(crate) fn scene(folder: &Path) -> PlanningScene {
    let mut scene = PlanningScene::new(talos(folder)).unwrap();
    let bytes = std::fs::read(folder.join("points/street_lidar_target.ply")).unwrap();
    let points = simdop::mesh_io::points("street.ply", &bytes).unwrap();
    // Rays without a return are points at the origin.
    let seen = points.iter().filter(|p| **p != [0.0; 3]).step_by(STEP);
    let points: Vec<_> = seen.map(|p| p.map(|x| (x * SCALE) as f32)).collect();
    let cloud = Body::new(Arc::new(PointCloud::new(&points).unwrap())).fixed().with_radius(RADIUS);
    let _ = scene.insert("street", cloud, &Pose::IDENTITY).unwrap();
    scene
}
