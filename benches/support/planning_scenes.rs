//! Planning scenes of the robots among the obstacles of their problems.

use super::robots::{Configuration, Problem, Setting};
use simdop::planning::{PlanningScene, RobotFiles, RobotModel};
use simdop::pose::Pose;
use simdop::scene::Body;
use std::path::Path;
use std::sync::Arc;

pub(crate) fn load(setting: &Setting, folder: &Path) -> RobotModel {
    let folder = folder.join("robots").join(setting.robot);
    let file = |extension: &str| folder.join(format!("{}.{extension}", setting.robot));
    RobotFiles::new(file("urdf")).srdf(file("srdf")).load().unwrap()
}

pub(crate) fn insert_obstacles(scene: &mut PlanningScene, problem: &Problem) {
    for obstacle in &problem.obstacles {
        let at = Pose::try_from(obstacle.at).unwrap();
        let _ = scene.insert("obstacle", Body::new(obstacle.shape.shape()).fixed(), &at).unwrap();
    }
}

/// The robot among the obstacles of a problem.
pub(crate) fn scene_of(model: &Arc<RobotModel>, problem: &Problem) -> PlanningScene {
    let mut scene = PlanningScene::new(Arc::clone(model)).unwrap();
    insert_obstacles(&mut scene, problem);
    scene
}

/// Values of the robot's variables.
pub(crate) fn values(model: &RobotModel, configuration: &Configuration) -> Vec<f64> {
    let robot = model.robot();
    let value = |(name, limits): (&String, &[f64; 2])| {
        configuration.get(name).copied().unwrap_or(0.0).clamp(limits[0], limits[1])
    };
    robot.variables.iter().zip(&robot.limits).map(value).collect()
}

/// Uses every helper once, so that those who need only some of them compile without a warning.
const _: () = {
    let _ = (load, insert_obstacles, scene_of, values);
};
