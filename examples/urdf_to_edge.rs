//! From a URDF to a checked motion in thirty lines: may the robot move from here to there, at all times?
//!
//! ```sh
//! cargo run --release --features urdf --example urdf_to_edge
//! ```
//!
//! The links here are capsules, bodies as they are. `LinkShape::shape` returns nothing for a `<mesh>`: read its file and
//! build a tree from that.

use simdop::glam::{DAffine3, DVec3};
use simdop::motion::{JointMotion, LinkFrame};
use simdop::primitive::Shape;
use simdop::robot::{DisabledPair, LinkShapes, Robot};
use simdop::scene::{Body, MotionHit, MotionMemory, MotionVerdict};
use simdop::{Isa, Node16, Pose, Query, Scene};

/// Two capsules in a row, each half a metre long, on joints that rotate about z.
const URDF: &str = r#"<robot name="two_links">
  <link name="base"/>
  <link name="upper"><collision><origin xyz="0.25 0 0" rpy="0 1.5708 0"/>
    <geometry><capsule radius="0.04" length="0.4"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.25 0 0" rpy="0 1.5708 0"/>
    <geometry><capsule radius="0.04" length="0.4"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>"#;
const SRDF: &str =
    r#"<robot name="two_links"><disable_collisions link1="upper" link2="lower" reason="Adjacent"/></robot>"#;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let robot = Robot::from_urdf(URDF, LinkShapes::Collision)?;
    let asked = robot.pairs(&DisabledPair::from_srdf(SRDF)?);

    let (mut scene, mut ids) = (Scene::<'_, Node16<18>>::new(), Vec::new());
    for (i, link) in robot.shapes.iter().enumerate() {
        let shape = link.shape().ok_or("a mesh file is to be read")?;
        ids.push(scene.insert(Body::new(shape), &Pose::IDENTITY)?);
        for j in 0..i {
            if asked.contains(&(j, i)) {
                scene.forbid_collision(ids[j], ids[i])?;
            } else {
                scene.allow_collision(ids[j], ids[i])?;
            };
        }
    }
    let there = DAffine3::from_translation(DVec3::new(0.8, 0.0, 0.0));
    let pillar = Body::new(Shape::cuboid([0.1, 0.1, 1.0])?).fixed();
    let _ = scene.insert(pillar, &Pose::try_from(there)?)?;

    let (kinematics, query) = (robot.kinematics()?, Query::new(Isa::detect()));
    let (mut links, mut values) = (vec![LinkFrame::EMPTY; kinematics.links()], [0.0; 2]);
    let (mut poses, mut waiting) = (vec![Pose::IDENTITY; 2 * ids.len()], vec![MotionHit::EMPTY; 256]);
    for (elbow, is_free) in [(0.0, false), (1.9, true)] {
        let ends: [&[f64]; 2] = [&[-0.9, elbow], &[0.9, elbow]];
        let mut way = JointMotion::new(kinematics, ends, &mut values, &mut links)?;
        let mut memory = MotionMemory { poses: &mut poses, waiting: &mut waiting };
        let answer = scene.check_motion(&query, &ids, &mut way, 1e-6, &mut memory)?;
        println!("elbow at {elbow}: {:?}", answer.verdict);
        assert!(matches!(answer.verdict, MotionVerdict::Free) == is_free);
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
