//! Planning scenes: verdicts, gradients and motions against scenes assembled by hand, and invalid files.

#[path = "../support/mod.rs"]
mod support;

mod bounds;
mod files;
mod objects;
mod plans;
mod real;
mod self_filter;
mod signed;

use simdop::planning::{PlanningScene, RobotFiles, RobotModel};
use simdop::pose::Pose;
use std::path::Path;

fn arm_file(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/arm").join(name)
}

fn arm() -> RobotModel {
    RobotFiles::new(arm_file("arm.urdf")).srdf(arm_file("arm.srdf")).load().unwrap()
}

/// A robot from the text of a URDF file. Each test has a name of its own for its files.
fn model_of_text(name: &str, urdf: &str) -> RobotModel {
    let folder = files::Folder::new(name);
    RobotFiles::new(folder.file("robot.urdf", urdf)).load().unwrap()
}

fn scene() -> PlanningScene {
    PlanningScene::new(arm()).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]).unwrap()
}
