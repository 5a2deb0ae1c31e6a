//! Points near the robot, against distances in closed form and against searches of single points.

use super::{arm, at, scene};
use crate::real::{model_of, robots::SETTINGS};
use crate::support::data::directory;
use crate::support::rng::Rng;
use simdop::Isa;
use simdop::cloud::{PointCloud, RangeSearch};
use simdop::planning::{LinkGeometry, PlanningError, PlanningScene};
use simdop::primitive::Shape;
use simdop::scene::Body;

fn points(rng: &mut Rng, count: usize, reach: f64) -> Vec<[f32; 3]> {
    (0..count)
        .map(|_| {
            [(-reach, reach), (-reach, reach), (-0.1, 1.4)].map(|(low, high)| rng.range(low, high) as f32)
        })
        .collect()
}

/// The distance of a point from a body of the built-in arm, in the frame of the body.
fn distance(shape: usize, [x, y, z]: [f64; 3]) -> f64 {
    let cuboid = |sides: [f64; 3]| {
        let gaps = [(x, 0), (y, 1), (z, 2)].map(|(x, i)| (x.abs() - 0.5 * sides[i]).max(0.0));
        gaps.iter().map(|gap| gap * gap).sum::<f64>().sqrt()
    };
    let capsule = |radius: f64, length: f64| {
        let z = (z.abs() - 0.5 * length).max(0.0);
        ((x * x + y * y + z * z).sqrt() - radius).max(0.0)
    };
    match shape {
        0 => cuboid([0.24, 0.24, 0.1]),
        1 => capsule(0.07, 0.2),
        2 => capsule(0.06, 0.36),
        3 => capsule(0.05, 0.3),
        _ => cuboid([0.06, 0.12, 0.14]),
    }
}

#[test]
fn points_near_an_arm_are_those_of_closed_forms() {
    let mut scene = scene();
    let mut workspace = scene.workspace();
    // A cup in the hand is a part of the robot, and a wall is not.
    let cup = scene.insert("cup", Body::new(Shape::sphere(0.05).unwrap()), &at(0.0, 0.0, 1.3)).unwrap();
    scene.attach(cup, "hand", &[0.0; 4], &["hand"]).unwrap();
    let wall = Body::new(Shape::cuboid([0.1, 2.0, 2.0]).unwrap()).fixed();
    let _ = scene.insert("wall", wall, &at(0.6, 0.0, 0.5)).unwrap();
    let mut rng = Rng::new(41);
    let (mut near, mut all) = (0, 0);
    for (round, margin) in [0.0, 0.0, 0.02, 0.1, 0.3].into_iter().enumerate() {
        let values = scene.random(|| rng.range(0.0, 1.0));
        let points = points(&mut rng, 4000, 0.9);
        let found = scene.near_robot(&mut workspace, &values, &points, margin).unwrap();
        let placed = scene.placed(&mut workspace, &values).unwrap();
        for (point, is_near) in points.iter().zip(found) {
            let seen = |i: usize| {
                let [r0, r1, r2] = placed[i].2.rows();
                let t = placed[i].2.translation();
                let p = [0, 1, 2].map(|i| f64::from(point[i]) - t[i]);
                [0, 1, 2].map(|i| r0[i] * p[0] + r1[i] * p[1] + r2[i] * p[2])
            };
            let of_cup = seen(5).iter().map(|x| x * x).sum::<f64>().sqrt() - 0.05;
            let least = (0..5).map(|i| distance(i, seen(i))).fold(of_cup.max(0.0), f64::min);
            let is_certain = least == 0.0 || (least - margin).abs() > 1e-9;
            assert!(!is_certain || is_near == (least <= margin), "{round} {point:?} {least}");
            (near, all) = (near + usize::from(is_near), all + 1);
        }
    }
    assert!(near > 200 && near < all / 2, "{near} of {all}");
}

/// Meshes: each point alone, as a cloud, by the search of clouds.
#[test]
fn points_near_the_panda_are_those_of_single_searches() {
    let Some(folder) = directory() else { return };
    let model = model_of(&SETTINGS[0], &folder);
    let scene = PlanningScene::new(model).unwrap();
    let (mut workspace, mut rng) = (scene.workspace(), Rng::new(42));
    let search = RangeSearch::new(Isa::detect());
    let (mut near, mut inside) = (0, 0);
    for margin in [0.0, 0.01, 0.1] {
        let values = scene.random(|| rng.range(0.0, 1.0));
        let points = points(&mut rng, 1500, 0.6);
        let found = scene.near_robot(&mut workspace, &values, &points, margin).unwrap();
        let placed = scene.placed(&mut workspace, &values).unwrap();
        for (point, is_near) in points.iter().zip(found) {
            let cloud = PointCloud::new(&[*point]).unwrap();
            let is_near_one = placed.iter().zip(scene.robot().bodies()).any(|((_, _, world), body)| {
                let LinkGeometry::Mesh { tree, .. } = body else { panic!("links are meshes") };
                search.body_within(&cloud.view(), &**tree, world, margin).unwrap().is_some()
            });
            assert_eq!(is_near, is_near_one, "{point:?}");
            near += usize::from(is_near);
            inside += usize::from(is_near && margin == 0.0);
        }
    }
    assert!(near > 60 && inside > 3, "{near} {inside}");
}

#[test]
fn points_without_a_depth_are_not_near() {
    let scene = PlanningScene::new(arm()).unwrap();
    let mut workspace = scene.workspace();
    let points = [[f32::NAN, 0.0, 0.5], [0.0, f32::INFINITY, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, f32::MAX]];
    let found = scene.near_robot(&mut workspace, &[0.0; 4], &points, 0.0).unwrap();
    assert_eq!(found, [false, false, true, false]);
    for margin in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = scene.near_robot(&mut workspace, &[0.0; 4], &points, margin);
        assert!(matches!(refused, Err(PlanningError::Scene(_))), "{margin}");
    }
    assert!(scene.near_robot(&mut workspace, &[9.0; 4], &points, 0.0).is_err());
}
