//! From a URDF to a checked motion: is the robot's motion from here to there free at all times?
//!
//! ```sh
//! cargo run --release --features planning --example urdf_to_edge
//! ```

use simdop::planning::{PlanningScene, RobotFiles};
use simdop::{Pose, glam::DAffine3, primitive::Shape, scene::Body};

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/arm/");
    let robot = RobotFiles::new(format!("{folder}arm.urdf")).srdf(format!("{folder}arm.srdf")).load()?;
    let mut scene = PlanningScene::new(robot)?;
    let there = Pose::try_from(DAffine3::from_translation([0.6, 0.0, 0.5].into()))?;
    let _ = scene.insert("post", Body::new(Shape::cuboid([0.1, 0.1, 1.0])?).fixed(), &there)?;
    let mut workspace = scene.workspace();
    for (shoulder, is_free) in [(1.2, false), (-0.3, true)] {
        let ends: [&[f64]; 2] = [&[-0.9, shoulder, 0.0, 0.0], &[0.9, shoulder, 0.0, 0.0]];
        let answer = scene.check_motion(&mut workspace, ends)?;
        println!("shoulder at {shoulder}: {:?}", answer.verdict);
        assert_eq!(answer.is_free(), is_free);
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
