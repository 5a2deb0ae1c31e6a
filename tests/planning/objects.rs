//! Objects that are inserted, moved, removed and carried.

use super::{at, model_of_text, scene};
use simdop::cloud::PointCloud;
use simdop::glam::{DQuat, DVec3};
use simdop::planning::{PlanningError, PlanningScene};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::scene::{Body, MotionVerdict};
use std::sync::Arc;

const UPRIGHT: [f64; 4] = [0.0; 4];

fn cube(side: f64) -> Body<'static, simdop::planning::PlanningNode> {
    Body::new(Shape::cuboid([side; 3]).unwrap())
}

/// One workspace serves every state of a scene, and its copies.
#[test]
fn a_workspace_serves_each_state() {
    let mut scene = scene();
    let mut workspace = scene.workspace();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    let alone = scene.clone();
    let post = scene.insert("post", cube(0.2).fixed(), &at(0.0, 0.0, 1.05)).unwrap();
    let hit = scene.collide(&mut workspace, &UPRIGHT).unwrap().hit().unwrap();
    let mut names = [scene.name(hit.a), scene.name(hit.b)];
    names.sort_unstable();
    assert!(names.contains(&"post"), "{names:?}");
    assert_eq!(scene.hits(&mut workspace, &UPRIGHT, 0.0).unwrap().len(), 2, "forearm and hand");
    assert!(alone.is_free(&mut workspace, &UPRIGHT).unwrap());
    scene.place(post, &at(1.0, 0.0, 1.05)).unwrap();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    assert!(!scene.within(&mut workspace, &UPRIGHT, 0.9).unwrap().is_free());
    scene.place(post, &at(0.0, 0.0, 1.05)).unwrap();
    for link in ["forearm", "hand"] {
        let link = scene.link(link).unwrap();
        scene.allow_collision(post, link).unwrap();
    }
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    let hand = scene.link("hand").unwrap();
    scene.forbid_collision(post, hand).unwrap();
    assert!(!scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    let _ = scene.remove(post).unwrap();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap() && scene.objects().is_empty());
    assert!(scene.place(post, &Pose::IDENTITY).is_err());
}

/// A cup in the hand, which stands at `[0, 0, 1.32]` with its palm up, moves with it.
#[test]
fn what_is_attached_is_carried() {
    let mut scene = scene();
    let mut workspace = scene.workspace();
    let folded = [0.0, 1.2_f64, 0.0, 0.0];
    let cup = scene.insert("cup", cube(0.04), &at(0.0, 0.0, 1.26)).unwrap();
    assert!(!scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    scene.attach(cup, "hand", &UPRIGHT, &["hand"]).unwrap();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    assert!(matches!(scene.attach(cup, "hand", &UPRIGHT, &[]), Err(PlanningError::Scene(_))));
    // The position of the cup if the shoulder, at a height of 0.35, rotates about y.
    let radius = 1.26 - 0.35;
    let (sin, cos) = folded[1].sin_cos();
    let wall =
        scene.insert("wall", cube(0.02).fixed(), &at(radius * sin, 0.03, 0.35 + radius * cos)).unwrap();
    let hits = scene.hits(&mut workspace, &folded, 0.0).unwrap();
    assert!(
        hits.iter().any(|hit| [hit.a, hit.b].contains(&cup) && [hit.a, hit.b].contains(&wall)),
        "{hits:?}"
    );
    let _ = scene.remove(wall).unwrap();
    let in_world = scene.to_world(&workspace, cup, [0.0; 3]).unwrap();
    assert!((in_world[0] - radius * sin).abs() < 1e-12 && (in_world[2] - 0.35 - radius * cos).abs() < 1e-12);
    // A motion carries it, too.
    let inside = scene.insert(
        "shelf",
        cube(0.02).fixed(),
        &at(radius * 0.6_f64.sin(), 0.0, 0.35 + radius * 0.6_f64.cos()),
    );
    let inside = inside.unwrap();
    let hand = scene.link("hand").unwrap();
    scene.allow_collision(inside, hand).unwrap();
    let answer = scene.check_motion(&mut workspace, [&UPRIGHT, &folded]).unwrap();
    let MotionVerdict::Hit { hit, .. } = answer.verdict else { panic!("{answer:?}") };
    assert!([hit.a, hit.b].contains(&cup));
    let _ = scene.remove(inside).unwrap();
    assert!(scene.check_motion(&mut workspace, [&UPRIGHT, &folded]).unwrap().is_free());
    // An object that cannot be put down stays in the hand.
    assert!(scene.detach(cup, &at(2.0_f64.powi(299), 0.0, 0.0)).is_err());
    assert!(scene.is_free(&mut workspace, &folded).unwrap());
    assert_eq!(scene.to_world(&workspace, cup, [0.0; 3]).unwrap(), in_world);
    // Put down in the hand's way, the cup is an obstacle again.
    scene.detach(cup, &at(0.0, 0.0, 1.26)).unwrap();
    assert!(
        !scene.is_free(&mut workspace, &UPRIGHT).unwrap() && scene.is_free(&mut workspace, &folded).unwrap()
    );
}

#[test]
fn the_robot_itself_is_no_object() {
    let mut scene = scene();
    let hand = scene.link("hand").unwrap();
    for fault in [
        scene.place(hand, &Pose::IDENTITY),
        scene.remove(hand).map(drop),
        scene.detach(hand, &Pose::IDENTITY),
    ] {
        assert!(matches!(fault, Err(PlanningError::IsRobot { name }) if name == "hand"));
    }
    assert!(matches!(scene.link("tail"), Err(PlanningError::NoLink { name }) if name == "tail"));
    let mut workspace = scene.workspace();
    for (values, text) in
        [(&[0.0; 3][..], "3"), (&[9.0, 0.0, 0.0, 0.0], "9"), (&[f64::NAN, 0.0, 0.0, 0.0], "NaN")]
    {
        let message = scene.is_free(&mut workspace, values).unwrap_err().to_string();
        assert!(message.contains(text), "{message}");
        assert!(scene.check_motion(&mut workspace, [&UPRIGHT, values]).is_err());
    }
    assert!(matches!(scene.free(&[0.0; 7]), Err(PlanningError::Values { given: 7, variables: 4 })));
    assert!(matches!(scene.free_motions(&[0.0; 4]), Err(PlanningError::Values { given: 4, variables: 8 })));
    assert!(scene.free(&[0.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0]).is_err());
    assert_eq!(scene.free(&[]).unwrap(), [false; 0]);
}

#[test]
fn clouds_and_a_moved_base_are_obstacles_too() {
    let mut scene = scene();
    let mut workspace = scene.workspace();
    let cloud = Arc::new(PointCloud::new(&[[5.0, 0.0, 1.0]]).unwrap());
    let _ = scene.insert("scan", Body::new(cloud).fixed(), &Pose::IDENTITY).unwrap();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    scene.place_base(&at(5.0, 0.0, 0.0)).unwrap();
    assert!(!scene.is_free(&mut workspace, &UPRIGHT).unwrap());
    assert!(scene.place_base(&at(2.0_f64.powi(299), 0.0, 0.0)).is_err());
    let turned = Pose::try_from((DQuat::from_rotation_z(1.0), DVec3::ZERO)).unwrap();
    scene.place_base(&turned).unwrap();
    assert!(scene.is_free(&mut workspace, &UPRIGHT).unwrap());
}

const WHEEL: &str = r#"<robot name="wheel"><link name="hub"/><link name="spoke"><collision><origin xyz="1 0 0"/>
  <geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="axle" type="continuous"><parent link="hub"/><child link="spoke"/><axis xyz="0 0 1"/></joint></robot>"#;

/// A continuous joint takes the shorter way, and a value may have any number of turns.
#[test]
fn continuous_joints_wrap() {
    let mut scene = PlanningScene::new(model_of_text("wheel", WHEEL)).unwrap();
    assert_eq!(scene.variable_names().collect::<Vec<_>>(), ["axle"]);
    assert!(scene.is_continuous(0) && !scene.is_continuous(1));
    let _ = scene.insert("ahead", cube(0.1).fixed(), &at(1.0, 0.0, 0.0)).unwrap();
    let mut workspace = scene.workspace();
    for turns in [-7.0, -1.0, 0.0, 1.0, 5.0] {
        let angle = |x: f64| [x + turns * core::f64::consts::TAU];
        assert!(!scene.is_free(&mut workspace, &angle(0.05)).unwrap());
        assert!(scene.is_free(&mut workspace, &angle(2.0)).unwrap());
        // From 3 to -3 the short way is past half a turn, not past 0.
        assert!(scene.check_motion(&mut workspace, [&angle(3.0), &[-3.0]]).unwrap().is_free());
        assert!(!scene.check_motion(&mut workspace, [&angle(1.0), &[-1.0]]).unwrap().is_free());
        let distance = scene.distance(&angle(3.0), &[-3.0]).unwrap();
        assert!((distance - (core::f64::consts::TAU - 6.0)).abs() < 1e-12);
    }
}
