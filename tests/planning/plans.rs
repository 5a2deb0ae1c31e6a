//! Paths: every motion of a path is certified, and failures are reported.

use super::{arm, at, scene};
use crate::support::rng::Rng;
use simdop::planning::{PlanSettings, PlannedPath, PlanningError, PlanningScene, RobotModel};
use simdop::primitive::Shape;
use simdop::robot::RobotError;
use simdop::scene::Body;

const START: [f64; 4] = [-1.2, 1.2, 0.0, 0.0];
const GOAL: [f64; 4] = [1.2, 1.2, 0.0, 0.0];

/// The arm with a post between start and goal.
fn with_post() -> PlanningScene {
    let mut scene = scene();
    let post = Body::new(Shape::cuboid([0.1, 0.1, 1.2]).unwrap()).fixed();
    let _ = scene.insert("post", post, &at(0.6, 0.0, 0.6)).unwrap();
    scene
}

fn plan(scene: &PlanningScene, goals: &[&[f64]], settings: &PlanSettings) -> PlannedPath {
    scene.plan(&mut scene.workspace(), &START, goals, settings).unwrap()
}

#[test]
fn a_path_leads_around_a_post_by_certified_motions() {
    let scene = with_post();
    let mut workspace = scene.workspace();
    assert!(!scene.check_motion(&mut workspace, [&START, &GOAL]).unwrap().is_free());
    for step in [0.4, 1.0, f64::INFINITY] {
        let settings = PlanSettings { step, ..PlanSettings::default() };
        let found = plan(&scene, &[&GOAL], &settings);
        assert_eq!(found, plan(&scene, &[&GOAL], &settings), "the same seed gives the same path");
        assert!(found.is_found() && found.path.len() > 2 && found.motions > 0);
        assert_eq!((&found.path[0][..], &found.path[found.path.len() - 1][..]), (&START[..], &GOAL[..]));
        let mut length = 0.0;
        for ends in found.path.windows(2) {
            assert!(scene.check_motion(&mut workspace, [&ends[0], &ends[1]]).unwrap().is_free());
            length += (0..4).map(|i| (ends[1][i] - ends[0][i]).powi(2)).sum::<f64>().sqrt();
        }
        assert!((found.length - length).abs() < 1e-12);
    }
}

#[test]
fn free_shares_of_motions_are_certified() {
    let scene = with_post();
    let (mut workspace, mut rng, mut counts) = (scene.workspace(), Rng::new(8), [0; 3]);
    let mut motions = Vec::new();
    for _ in 0..200 {
        let [from, to] = [(); 2].map(|()| scene.random(|| rng.range(0.0, 1.0)));
        let mut is_free_to = |share: f64| {
            let there = scene.between(&from, &to, share).unwrap();
            scene.check_motion(&mut workspace, [&from, &there]).unwrap().is_free()
        };
        let share = scene.free_share(&mut scene.workspace(), [&from, &to]).unwrap();
        if share == 1.0 {
            counts[0] += 1;
            assert!(is_free_to(1.0));
        } else {
            counts[if share == 0.0 { 1 } else { 2 }] += 1;
            assert!(share == 0.0 || is_free_to(share), "{share}");
            assert!(!is_free_to(share + 1.0 / 1024.0), "{share}");
        }
        motions.extend([from, to].concat());
    }
    assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
    let (mut free, motions) = (vec![false; 200], &motions[..]);
    scene.check_motions(&mut workspace, motions, &mut free).unwrap();
    assert_eq!(free, scene.free_motions(motions).unwrap());
    assert_eq!(free.iter().filter(|free| **free).count(), counts[0]);
    for wrong in [&mut free[..199], &mut []] {
        let error = scene.check_motions(&mut workspace, motions, wrong).unwrap_err();
        assert!(matches!(error, PlanningError::Values { given: 1600, variables: 8 }), "{error}");
    }
}

/// The straight motion from beside the post fails, and then nearly every random configuration is outside the domain of
/// the only node of the tree.
#[test]
fn a_node_beside_an_obstacle_is_extended_again() {
    let scene = with_post();
    let share = scene.free_share(&mut scene.workspace(), [&START, &GOAL]).unwrap();
    let start = scene.between(&START, &GOAL, share - 1.0 / 1024.0).unwrap();
    for seed in 0..5 {
        let settings = PlanSettings { step: 0.02, configurations: 3_000, shortcuts: 0, seed };
        assert!(scene.plan(&mut scene.workspace(), &start, &[&GOAL], &settings).unwrap().is_found());
    }
}

/// Without a second test of a shortcut that is not free, a path of n configurations has at most n (n - 1) / 2 tests.
#[test]
fn no_shortcut_is_tested_twice() {
    let scene = with_post();
    let settings = |shortcuts| PlanSettings { shortcuts, ..PlanSettings::default() };
    let (long, short) = (plan(&scene, &[&GOAL], &settings(0)), plan(&scene, &[&GOAL], &settings(10_000)));
    let n = long.path.len() as u32;
    assert!(short.path.len() < long.path.len() && short.path.len() > 2);
    assert!(short.motions - long.motions <= n * (n - 1) / 2);
}

#[test]
fn goals_that_are_not_free_are_ignored() {
    let scene = with_post();
    let inside = [0.0, 1.2, 0.0, 0.0];
    assert!(!scene.is_free(&mut scene.workspace(), &inside).unwrap());
    let settings = PlanSettings::default();
    assert_eq!(plan(&scene, &[&inside, &GOAL], &settings).path.last().unwrap(), &GOAL);
    for goals in [&[&inside[..]][..], &[]] {
        let none = plan(&scene, goals, &settings);
        assert!(!none.is_found() && none.length == 0.0 && none.motions == 0);
    }
    let near = plan(&scene, &[&[-1.0, 1.2, 0.0, 0.0]], &settings);
    assert_eq!(near.path.len(), 2, "the straight way is tried first");
}

/// A step below the rounding of the values also ends the search.
#[test]
fn every_search_ends() {
    let scene = with_post();
    for step in [0.0, -1.0, f64::NAN] {
        let settings = PlanSettings { step, ..PlanSettings::default() };
        let refused = scene.plan(&mut scene.workspace(), &START, &[&GOAL], &settings);
        assert!(matches!(refused, Err(PlanningError::Step { given }) if given.to_bits() == step.to_bits()));
    }
    let settings = PlanSettings { step: 1e-300, configurations: 10, ..PlanSettings::default() };
    assert!(!plan(&scene, &[&GOAL], &settings).is_found());
}

#[test]
fn a_model_has_a_geometry_for_each_body() {
    let model = arm();
    let bodies = model.bodies()[1..].to_vec();
    let refused = RobotModel::new(model.robot().clone(), bodies, Vec::new(), Vec::new());
    assert_eq!(refused.unwrap_err(), RobotError::Bodies { given: 4, needed: 5 });
}
