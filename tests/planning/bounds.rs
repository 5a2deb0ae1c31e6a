//! Bounds change no verdict: `free` with them against `free` without them.

use super::{arm, at, scene};
use crate::real::{insert_obstacles, load, robots::SETTINGS};
use crate::support::data::{self, directory};
use crate::support::rng::Rng;
use simdop::planning::{PlanningError, PlanningScene, Workspace};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::scene::Body;
use simdop::{Isa, cloud::PointCloud};
use std::sync::Arc;

const CELL: f64 = 0.02;

fn random(scene: &PlanningScene, rng: &mut Rng, count: usize) -> Vec<f64> {
    (0..count).flat_map(|_| scene.random(|| rng.range(0.0, 1.0))).collect()
}

/// Verdicts with bounds are those without; what the bounds decide is right. Returns how many they decide.
fn compare(exact: &PlanningScene, bounded: &PlanningScene, values: &[f64]) -> usize {
    let verdicts = exact.free(values).unwrap();
    assert_eq!(bounded.free(values).unwrap(), verdicts);
    let decided = bounded.free_by_bounds(values).unwrap();
    assert_eq!(decided.len(), verdicts.len());
    for (i, (decided, verdict)) in decided.iter().zip(&verdicts).enumerate() {
        assert!(decided.is_none_or(|decided| decided == *verdict), "configuration {i}");
    }
    decided.iter().flatten().count()
}

/// A workspace serves all states of a scene, also after a configuration that is an error.
fn in_one_workspace(scene: &PlanningScene, workspace: &mut Workspace, values: &[f64]) {
    let mut wrong = values[..4 * 17].to_vec();
    wrong[4 * 16] = 1e3;
    assert!(scene.check_states(workspace, &wrong, &mut [false; 17]).is_err());
    let mut free = vec![false; values.len() / 4];
    scene.check_states(workspace, values, &mut free).unwrap();
    assert_eq!(free, scene.free(values).unwrap());
}

/// 100,000 configurations, or as many as `SIMDOP_CONFIGURATIONS` says.
#[test]
fn verdicts_of_robots_among_obstacles_are_those_of_the_scene() {
    let Some(folder) = directory() else { return };
    let all = std::env::var("SIMDOP_CONFIGURATIONS").map_or(100_000, |count| count.parse().unwrap());
    for setting in SETTINGS.iter().filter(|setting| !setting.is_drawn) {
        let (model, other) = (Arc::new(load(setting, &folder)), setting.robot(&folder));
        let problems = setting.problems(&folder, &other, 70);
        let mut rng = Rng::new(21);
        let (mut decided, mut asked) = (0, 0);
        for problem in &problems {
            let mut exact = PlanningScene::new(Arc::clone(&model)).unwrap();
            insert_obstacles(&mut exact, problem);
            let mut bounded = exact.clone();
            bounded.use_bounds(CELL).unwrap();
            let count = (all / (2 * problems.len())).max(1000) / data::suite_step() + 17;
            let values = random(&exact, &mut rng, count);
            decided += compare(&exact, &bounded, &values);
            asked += count;
        }
        assert!(decided * 10 > asked * 6, "{}: {decided} of {asked}", setting.name);
    }
}

/// Every instruction set decides the same configurations.
#[test]
fn bounds_are_the_same_on_every_instruction_set() {
    let Some(folder) = directory() else { return };
    let setting = &SETTINGS[0];
    let (model, other) = (load(setting, &folder), setting.robot(&folder));
    let mut scene = PlanningScene::new(model).unwrap();
    insert_obstacles(&mut scene, &setting.problems(&folder, &other, 1000)[0]);
    scene.use_bounds(CELL).unwrap();
    let values = random(&scene, &mut Rng::new(22), 3000);
    let on = |isa: Isa| scene.clone().with_query(Query::new(isa)).free_by_bounds(&values).unwrap();
    let scalar = on(Isa::SCALAR);
    assert!(scalar.contains(&Some(true)) && scalar.contains(&Some(false)) && scalar.contains(&None));
    for isa in Isa::available() {
        assert_eq!(on(isa), scalar, "{isa}");
    }
}

/// The bounds follow every change of the scene.
#[test]
fn bounds_follow_the_scene() {
    let mut exact = scene();
    let mut bounded = scene();
    bounded.use_bounds(CELL).unwrap();
    assert!(bounded.bound_bytes().is_some() && exact.bound_bytes().is_none());
    let (mut rng, mut workspace) = (Rng::new(23), bounded.workspace());
    let mut check = |exact: &PlanningScene, bounded: &PlanningScene| {
        let values = random(exact, &mut rng, 700);
        in_one_workspace(bounded, &mut workspace, &values);
        compare(exact, bounded, &values)
    };
    let mut all = 0;
    let mut both = |change: &mut dyn FnMut(&mut PlanningScene), applies: bool| {
        change(&mut exact);
        change(&mut bounded);
        assert_eq!(bounded.bound_bytes().is_some(), applies);
        let decided = check(&exact, &bounded);
        assert!(applies || decided == 0);
        all += decided;
    };
    let cuboid = |sides: [f64; 3]| Body::new(Shape::cuboid(sides).unwrap());
    let mut ids = Vec::new();
    let mut insert = |scene: &mut PlanningScene| {
        let wall = scene.insert("wall", cuboid([0.05, 1.0, 1.0]).fixed(), &at(0.5, 0.0, 0.5)).unwrap();
        let cup = scene.insert("cup", cuboid([0.06; 3]), &at(0.0, 0.4, 0.9)).unwrap();
        let cloud = PointCloud::new(&[[0.0, -0.5, 0.6], [0.1, -0.5, 0.6], [0.0, -0.5, 0.8]]).unwrap();
        let scan = Body::new(Arc::new(cloud)).fixed().with_radius(0.03);
        let _ = scene.insert("scan", scan, &Pose::IDENTITY).unwrap();
        ids.push([wall, cup]);
    };
    both(&mut insert, true);
    let [wall, cup] = ids[0];
    assert_eq!(ids[0], ids[1]);
    both(&mut |scene| scene.place(wall, &at(0.2, 0.0, 0.7)).unwrap(), true);
    both(&mut |scene| scene.place_base(&at(0.1, 0.0, 0.0)).unwrap(), true);
    let hand = exact_link("hand");
    both(&mut |scene| scene.allow_collision(hand, wall).unwrap(), true);
    both(&mut |scene| scene.attach(cup, "hand", &[0.0; 4], &["hand"]).unwrap(), false);
    both(&mut |scene| scene.detach(cup, &at(0.2, 0.4, 0.5)).unwrap(), true);
    // Two bodies that do not move meet: nothing is free.
    both(&mut |scene| scene.place(cup, &at(0.2, 0.0, 0.7)).unwrap(), true);
    both(&mut |scene| scene.remove(cup).map(drop).unwrap(), true);
    both(&mut |scene| scene.forbid_collision(hand, wall).unwrap(), true);
    both(&mut |scene| scene.remove(wall).map(drop).unwrap(), true);
    assert!(all > 1000, "{all}");
}

fn exact_link(name: &str) -> simdop::scene::BodyId {
    scene().link(name).unwrap()
}

#[test]
fn errors_and_budgets_are_those_of_the_scene() {
    let mut scene = scene();
    for cell in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = scene.use_bounds(cell);
        assert!(matches!(refused, Err(PlanningError::Cell { given }) if given.to_bits() == cell.to_bits()));
    }
    scene.use_bounds(0.05).unwrap();
    let mut values = random(&scene, &mut Rng::new(24), 40);
    values[4 * 33] = 9.0;
    let message = |found: Result<Vec<bool>, PlanningError>| found.unwrap_err().to_string();
    let plain = PlanningScene::new(arm()).unwrap();
    assert_eq!(message(scene.free(&values)), message(plain.free(&values)));
    assert_eq!(scene.free_by_bounds(&values).unwrap_err().to_string(), message(plain.free(&values)));
    assert!(matches!(scene.free_by_bounds(&[0.0; 7]), Err(PlanningError::Values { given: 7, variables: 4 })));
    values[4 * 33] = 0.0;
    let query = Query::new(Isa::detect()).with_budget(0);
    assert_eq!(
        scene.clone().with_query(query).free(&values).unwrap(),
        plain.with_query(query).free(&values).unwrap(),
        "a budget that runs out decides nothing"
    );
}
