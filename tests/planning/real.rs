//! The Panda and the UR5 among obstacles: a planning scene against pairs of bodies at poses from other kinematics.

#[path = "../../benches/support/planning_scenes.rs"]
mod planning_scenes;
#[path = "../../benches/support/robots.rs"]
pub(crate) mod robots;
#[path = "../../benches/support/street.rs"]
pub(crate) mod street;

pub(crate) use planning_scenes::{insert_obstacles, values};

use crate::support::data::{self, directory};
use crate::support::rng::{self, Rng};
use robots::{Configuration, SETTINGS, Setting};
use simdop::glam::DAffine3;
use simdop::planning::{LinkGeometry, PlanningScene, RobotModel};
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::MotionVerdict;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// The robot of a setting. Loaded once for all tests, since its bounds take long to compute.
pub(crate) fn model_of(setting: &Setting, folder: &Path) -> Arc<RobotModel> {
    static MODELS: Mutex<BTreeMap<&str, Arc<RobotModel>>> = Mutex::new(BTreeMap::new());
    let mut models = MODELS.lock().unwrap();
    Arc::clone(
        models.entry(setting.robot).or_insert_with(|| Arc::new(planning_scenes::load(setting, folder))),
    )
}

/// Distances up to this count as meeting, since relative poses are rounded from world poses.
const ROUNDING: f64 = 1e-11;

fn named(model: &RobotModel, values: &[f64]) -> Configuration {
    model.robot().variables.iter().cloned().zip(values.iter().copied()).collect()
}

/// Whether the two are within `margin`, by queries of one pair.
fn are_near(query: &Query, [a, b]: [(&LinkGeometry, &DAffine3); 2], margin: f64) -> bool {
    let pose = Pose::try_from(b.1.inverse() * *a.1).unwrap();
    let (LinkGeometry::Mesh { tree: p, .. }, LinkGeometry::Mesh { tree: q, .. }) = (a.0, b.0) else {
        panic!("the links are meshes")
    };
    !query.within(&**p, &**q, &pose, margin).unwrap().is_free()
}

#[test]
fn verdicts_are_those_of_pairs_at_poses_from_other_kinematics() {
    let Some(folder) = directory() else { return };
    let query = Query::new(simdop::Isa::detect());
    for setting in SETTINGS.iter().filter(|setting| !setting.is_drawn && setting.robot == "panda") {
        let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
        let mut rng = Rng::new(5);
        let place =
            |body: usize| other.links.iter().position(|link| link.name == model.robot().names[body]).unwrap();
        let (mut hits, mut frees) = (0, 0);
        for problem in setting.problems(&folder, &other, 40 * data::suite_step()) {
            let mut scene = PlanningScene::new(Arc::clone(&model)).unwrap();
            insert_obstacles(&mut scene, &problem);
            let mut workspace = scene.workspace();
            let random = (0..6).map(|_| scene.random(|| rng.range(0.0, 1.0)));
            let all: Vec<_> = problem.ends.iter().map(|end| values(&model, end)).chain(random).collect();
            for values in &all {
                let mut configuration = named(&model, values);
                // The second finger mimics the first.
                if let Some(finger) = configuration.get("panda_finger_joint1").copied() {
                    configuration.insert("panda_finger_joint2".into(), finger);
                }
                let poses = other.poses(&configuration);
                let body = |i: usize| (&model.bodies()[i], &poses[place(i)]);
                let is_near = |margin: f64| {
                    let own =
                        model.pairs().iter().any(|&(i, j)| are_near(&query, [body(i), body(j)], margin));
                    own || problem.obstacles.iter().any(|obstacle| {
                        (0..model.bodies().len()).any(|i| {
                            let (LinkGeometry::Mesh { tree, .. }, at) = body(i) else { panic!("a mesh") };
                            let pose = Pose::try_from(at.inverse() * obstacle.at).unwrap();
                            let answer = query.within_shape(&obstacle.shape.shape(), &**tree, &pose, margin);
                            !answer.unwrap().is_free()
                        })
                    })
                };
                match scene.is_free(&mut workspace, values).unwrap() {
                    true => assert!(!is_near(0.0), "missed at {values:?}"),
                    false => assert!(is_near(ROUNDING), "invented at {values:?}"),
                }
                *(if is_near(0.0) { &mut hits } else { &mut frees }) += 1;
            }
            let free = scene.free(&all.concat()).unwrap();
            let one_by_one = all.iter().map(|values| scene.is_free(&mut workspace, values).unwrap());
            assert_eq!(free, one_by_one.collect::<Vec<_>>());
            let motions: Vec<f64> = all.windows(2).flatten().flatten().copied().collect();
            let free = scene.free_motions(&motions).unwrap();
            for (ends, free) in all.windows(2).zip(free) {
                let answer = scene.check_motion(&mut workspace, [&ends[0], &ends[1]]).unwrap();
                assert_eq!(answer.is_free(), free);
                if let MotionVerdict::Hit { time, .. } = answer.verdict {
                    let there: Vec<f64> =
                        ends[0].iter().zip(&ends[1]).map(|(from, to)| from + time * (to - from)).collect();
                    assert!(!scene.is_free(&mut workspace, &there).unwrap(), "at {time}");
                }
            }
        }
        assert!(hits > 20 / data::suite_step() && frees > 5, "{hits} {frees}");
    }
}

/// The gradient of the clearance equals finite differences, where the same primitives are the nearest.
#[test]
fn gradients_are_those_of_differences() {
    let Some(folder) = directory() else { return };
    let setting = &SETTINGS[0];
    let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
    let mut scene = PlanningScene::new(model).unwrap();
    insert_obstacles(&mut scene, &setting.problems(&folder, &other, 1000)[0]);
    let (mut workspace, mut rng, mut compared) = (scene.workspace(), Rng::new(9), 0);
    let step = 1e-6;
    for _ in 0..400 / data::suite_step() {
        let values = scene.random(|| rng.range(0.05, 0.95));
        let found = scene.clearance(&mut workspace, &values, 0.0, 10.0).unwrap();
        let Some(witness) = found.witness.filter(|_| found.upper > 1e-3) else { continue };
        let mut gradient = vec![7.0; scene.variables()];
        scene.clearance_gradient(&mut workspace, &witness, &mut gradient).unwrap();
        for (variable, slope) in gradient.iter().enumerate() {
            let mut at = |step: f64| {
                let mut moved = values.clone();
                moved[variable] += step;
                scene.clearance(&mut workspace, &moved, 0.0, 10.0).unwrap()
            };
            let (before, after) = (at(-step), at(step));
            let is_smooth = |other: &simdop::scene::SceneDistance| {
                // The same bodies, at points that moved only slightly.
                other.witness.is_some_and(|near| {
                    let moved = [(near.a, witness.a), (near.b, witness.b)];
                    let is_close = |(p, q): ([f64; 3], [f64; 3])| (0..3).all(|i| (p[i] - q[i]).abs() < 1e-4);
                    (near.hit.a, near.hit.b) == (witness.hit.a, witness.hit.b)
                        && moved.into_iter().all(is_close)
                })
            };
            if is_smooth(&before) && is_smooth(&after) {
                let difference = (after.upper - before.upper) / (2.0 * step);
                assert!((difference - slope).abs() < 1e-4, "{variable} at {values:?}: {difference} {slope}");
                compared += 1;
            }
        }
    }
    assert!(compared > 300 / data::suite_step(), "{compared}");
}

/// Samples find no hit in a motion that is free.
#[test]
fn samples_refute_no_motion() {
    let Some(folder) = directory() else { return };
    let setting = &SETTINGS[2];
    let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
    let (mut free, mut rng) = (0, Rng::new(11));
    for problem in setting.problems(&folder, &other, 100 * data::suite_step()) {
        let mut scene = PlanningScene::new(Arc::clone(&model)).unwrap();
        insert_obstacles(&mut scene, &problem);
        let mut workspace = scene.workspace();
        let start = values(&model, &problem.ends[0]);
        for _ in 0..20 {
            let random = scene.random(|| rng.range(0.0, 1.0));
            let to: Vec<f64> =
                start.iter().zip(&random).map(|(from, to)| from + 0.15 * (to - from)).collect();
            let answer = scene.check_motion(&mut workspace, [&start, &to]).unwrap();
            let parts = core::num::NonZeroU32::new(50).unwrap();
            let sampled = scene.check_motion_discrete(&mut workspace, [&start, &to], parts).unwrap();
            if answer.is_free() {
                free += 1;
                assert!(matches!(sampled.verdict, MotionVerdict::Unresolved { .. }), "{sampled:?}");
            }
        }
    }
    assert!(free > 10, "{free}");
}
