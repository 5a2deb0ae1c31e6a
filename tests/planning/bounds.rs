//! Bounds change no verdict: `free` with bounds against `free` without.

use super::{arm, at, model_of_text, scene};
use crate::real::{self, insert_obstacles, model_of, robots::SETTINGS, street};
use crate::support::data::{by_suite, directory, suite_step};
use crate::support::rng::Rng;
use simdop::construct::{Builder, OwnedMesh};
use simdop::planning::{PlanningError, PlanningScene, RobotModel, Workspace};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::scene::{Body, BodyId, MotionVerdict};
use simdop::{Isa, cloud::PointCloud};
use std::sync::Arc;

const CELL: f64 = 0.02;

fn random(scene: &PlanningScene, rng: &mut Rng, count: usize) -> Vec<f64> {
    (0..count).flat_map(|_| scene.random(|| rng.range(0.0, 1.0))).collect()
}

/// Motions with bounds have the verdicts of motions without; where bodies meet, the scene confirms it. Returns how many
/// motions are free, and how many are not.
fn compare_motions(exact: &PlanningScene, bounded: &PlanningScene, motions: &[[&[f64]; 2]]) -> [usize; 2] {
    let (mut workspace, mut other) = (exact.workspace(), bounded.workspace());
    let mut count = [0; 2];
    for &ends in motions {
        let verdict = exact.check_motion(&mut workspace, ends).unwrap().verdict;
        let found = bounded.check_motion(&mut other, ends).unwrap().verdict;
        let is_free = match (verdict, found) {
            (MotionVerdict::Free, MotionVerdict::Free) => true,
            (MotionVerdict::Hit { .. }, MotionVerdict::Hit { hit, time }) => {
                let [from, to] = ends;
                let there = exact.between(from, to, time).unwrap();
                let hits = exact.hits(&mut workspace, &there, 0.0).unwrap();
                assert!(hits.iter().any(|other| (other.a, other.b) == (hit.a, hit.b)), "{hit:?} at {time}");
                false
            }
            (MotionVerdict::Unresolved { .. }, MotionVerdict::Unresolved { .. }) => false,
            verdicts => panic!("{ends:?}: {verdicts:?}"),
        };
        assert_eq!(bounded.is_motion_free(&mut other, ends).unwrap(), is_free);
        count[usize::from(!is_free)] += 1;
    }
    count
}

/// The ends of two motions from the same configuration, close to each other: the first barely hits, or is not known to
/// be free. They are between two ends of which the motion to the first hits and that to the second is free.
fn grazing(exact: &PlanningScene, from: &[f64], mut ends: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let mut workspace = exact.workspace();
    for _ in 0..12 {
        let middle = exact.between(&ends[0], &ends[1], 0.5).unwrap();
        let is_free = exact.is_motion_free(&mut workspace, [from, &middle]).unwrap();
        ends[usize::from(is_free)] = middle;
    }
    ends
}

/// Verdicts with bounds equal those without, and those that the bounds decide are right. Returns how many these are,
/// and how many configurations are free.
fn compare(exact: &PlanningScene, bounded: &PlanningScene, values: &[f64]) -> [usize; 2] {
    let verdicts = exact.free(values).unwrap();
    assert_eq!(bounded.free(values).unwrap(), verdicts);
    let ends: Vec<&[f64]> = values.chunks(exact.variables()).take(60).collect();
    let ends: Vec<[&[f64]; 2]> = ends.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let _ = compare_motions(exact, bounded, &ends);
    let decided = bounded.free_by_bounds(values).unwrap();
    assert_eq!(decided.len(), verdicts.len());
    for (i, (decided, verdict)) in decided.iter().zip(&verdicts).enumerate() {
        assert!(decided.is_none_or(|decided| decided == *verdict), "configuration {i}");
    }
    [decided.iter().flatten().count(), verdicts.iter().filter(|is_free| **is_free).count()]
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

/// The number in `SIMDOP_CONFIGURATIONS`, or 100,000 in the full suite.
fn configurations() -> usize {
    std::env::var("SIMDOP_CONFIGURATIONS").map_or(100_000 / suite_step(), |count| count.parse().unwrap())
}

#[test]
fn verdicts_of_robots_among_obstacles_are_those_of_the_scene() {
    let Some(folder) = directory() else { return };
    let all = configurations();
    for setting in SETTINGS.iter().filter(|setting| !setting.is_drawn) {
        let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
        let problems = setting.problems(&folder, &other, 70 * suite_step());
        let mut rng = Rng::new(21);
        let (mut decided, mut asked) = (0, 0);
        for problem in &problems {
            let mut exact = PlanningScene::new(Arc::clone(&model)).unwrap();
            insert_obstacles(&mut exact, problem);
            let mut bounded = exact.clone();
            bounded.use_bounds(CELL).unwrap();
            let count = (all / (2 * problems.len())).max(1000 / suite_step()) + 17;
            let values = random(&exact, &mut rng, count);
            decided += compare(&exact, &bounded, &values)[0];
            asked += count;
        }
        assert!(decided * 10 > asked * 6, "{}: {decided} of {asked}", setting.name);
    }
}

/// Every other thousand is from the middle of the limits: most others are hits of the robot with itself.
#[test]
#[ignore = "minutes: the bounds of the Talos"]
fn verdicts_of_the_talos_in_a_scan_are_those_of_the_scene() {
    let Some(folder) = directory() else { return };
    let exact = street::scene(&folder);
    let mut bounded = exact.clone();
    bounded.use_bounds(CELL).unwrap();
    let (mut rng, mut decided, mut free, mut asked) = (Rng::new(29), 0, 0, 0);
    while asked < configurations() {
        let margin = [0.35, 0.0][asked / 1000 % 2];
        let each = (0..1000).flat_map(|_| exact.random(|| rng.range(margin, 1.0 - margin)));
        let values: Vec<f64> = each.collect();
        let count = compare(&exact, &bounded, &values);
        (decided, free, asked) = (decided + count[0], free + count[1], asked + 1000);
    }
    println!("{free} of {asked} free, bounds decide {decided}");
    assert!(free * 50 > asked && free * 2 < asked && decided * 2 > asked, "{free} and {decided} of {asked}");
}

/// Motions of all lengths, from ends of the problems and between random configurations, and motions that barely hit.
#[test]
fn motions_by_bounds_are_those_of_the_scene() {
    let Some(folder) = directory() else { return };
    for setting in SETTINGS.iter().filter(|setting| !setting.is_drawn) {
        let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
        let mut rng = Rng::new(25);
        let (mut all, mut grazed) = ([0; 2], 0);
        for problem in setting.problems(&folder, &other, 70 * suite_step()) {
            let mut exact = PlanningScene::new(Arc::clone(&model)).unwrap();
            insert_obstacles(&mut exact, &problem);
            let mut bounded = exact.clone();
            bounded.use_bounds(CELL).unwrap();
            let start = real::values(&model, &problem.ends[0]);
            // Ends of motions from the start that are not free, and of free ones.
            let mut ends_of: [Vec<Vec<f64>>; 2] = Default::default();
            for _ in 0..(200 / suite_step()).max(12) {
                let random = random(&exact, &mut rng, 2);
                let (a, b) = random.split_at(exact.variables());
                let near = |from: &[f64], rng: &mut Rng| {
                    exact.between(from, b, rng.range(0.0, 0.2).powi(2)).unwrap()
                };
                let ends = [near(&start, &mut rng), near(a, &mut rng)];
                let mut compare = |motions: &[[&[f64]; 2]]| {
                    let count = compare_motions(&exact, &bounded, motions);
                    all = [all[0] + count[0], all[1] + count[1]];
                    count
                };
                compare(&[[a, b], [a, &ends[1]], [a, a]]);
                for end in [a, &ends[0]] {
                    let [free, _] = compare(&[[&start, end]]);
                    ends_of[free].push(end.to_vec());
                }
            }
            let [hits, free] = ends_of;
            for (hit, free) in hits.into_iter().zip(free) {
                let [hit, free] = grazing(&exact, &start, [hit, free]);
                let _ = compare_motions(&exact, &bounded, &[[&start, &hit], [&start, &free]]);
                grazed += 1;
            }
        }
        println!("{}: {all:?} free and not, {grazed} that barely hit", setting.name);
        assert!(all.iter().all(|count| *count > 100 / suite_step()), "{}: {all:?}", setting.name);
        assert!(grazed > 100 / suite_step(), "{}: {grazed}", setting.name);
    }
}

/// A chain of five links in a plane, with balls at the ends of the first and the last: four joints between them are too
/// many for a table, and the spheres around these bodies are the balls themselves.
fn chain() -> RobotModel {
    let link = |i: usize| {
        let ball =
            r#"<collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>"#;
        let (before, x, ball) = (i - 1, if i == 1 { 0.0 } else { 0.3 }, if i % 4 == 1 { ball } else { "" });
        format!(
            r#"<link name="l{i}">{ball}</link><joint name="j{i}" type="revolute"><parent link="l{before}"/>
            <child link="l{i}"/><origin xyz="{x} 0 0"/><axis xyz="0 0 1"/>
            <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>"#
        )
    };
    let links: String = (1..=5).map(link).collect();
    model_of_text("chain", &format!(r#"<robot name="chain"><link name="l0"/>{links}</robot>"#))
}

#[test]
fn motions_of_a_chain_barely_hit() {
    let exact = PlanningScene::new(chain()).unwrap();
    let mut bounded = exact.clone();
    bounded.use_bounds(CELL).unwrap();
    let (mut rng, mut workspace, mut grazed) = (Rng::new(27), exact.workspace(), 0);
    for _ in 0..40 {
        let all = random(&exact, &mut rng, 30);
        let (from, others) = all.split_at(exact.variables());
        let is_free = |end: &&[f64]| exact.is_motion_free(&mut workspace, [from, end]).unwrap();
        let (free, hits): (Vec<&[f64]>, Vec<_>) = others.chunks(exact.variables()).partition(is_free);
        for (hit, free) in hits.into_iter().zip(free) {
            let [hit, free] = grazing(&exact, from, [hit.to_vec(), free.to_vec()]);
            let _ = compare_motions(&exact, &bounded, &[[from, &hit], [from, &free]]);
            grazed += 1;
        }
    }
    assert!(grazed > 50, "{grazed}");
}

/// Rounding puts the end of a motion beyond the limits. The walls are close, so most motions are tested at the end.
#[test]
fn motions_end_at_the_limits() {
    let mut exact = scene();
    for x in [-0.35, 0.35] {
        let wall = Body::new(Shape::cuboid([0.05, 1.0, 1.0]).unwrap()).fixed();
        let _ = exact.insert("wall", wall, &at(x, 0.0, 0.5)).unwrap();
    }
    let mut bounded = exact.clone();
    bounded.use_bounds(CELL).unwrap();
    let mut rng = Rng::new(26);
    let to: Vec<f64> = exact.limits().iter().map(|limits| limits[1]).collect();
    let mut beyond = 0;
    for _ in 0..300 {
        let from = random(&exact, &mut rng, 1);
        beyond += usize::from(from.iter().zip(&to).any(|(from, to)| from + (to - from) > *to));
        compare_motions(&exact, &bounded, &[[&from, &to]]);
    }
    assert!(beyond > 20, "{beyond}");
}

/// Every instruction set decides the same configurations and motions, with the same work left to the scene.
#[test]
fn bounds_are_the_same_on_every_instruction_set() {
    let Some(folder) = directory() else { return };
    let setting = &SETTINGS[0];
    let (model, other) = (model_of(setting, &folder), setting.robot(&folder));
    let mut scene = PlanningScene::new(model).unwrap();
    insert_obstacles(&mut scene, &setting.problems(&folder, &other, 1000)[0]);
    scene.use_bounds(CELL).unwrap();
    let values = random(&scene, &mut Rng::new(22), 3000 / suite_step());
    let on = |isa: Isa| scene.clone().with_query(Query::new(isa)).free_by_bounds(&values).unwrap();
    let scalar = on(Isa::SCALAR);
    assert!(scalar.contains(&Some(true)) && scalar.contains(&Some(false)) && scalar.contains(&None));
    let motions = |isa: Isa| {
        let scene = scene.clone().with_query(Query::new(isa));
        let mut workspace = scene.workspace();
        let ends: Vec<&[f64]> = values.chunks(scene.variables()).take(300 / suite_step()).collect();
        let ask = |ends: &[&[f64]]| scene.check_motion(&mut workspace, [ends[0], ends[1]]).unwrap();
        ends.windows(2).map(ask).collect::<Vec<_>>()
    };
    let of_motions = motions(Isa::SCALAR);
    for isa in Isa::available() {
        assert_eq!(on(isa), scalar, "{isa}");
        assert_eq!(motions(isa), of_motions, "{isa}");
    }
}

/// The bounds follow every change of the scene: they decide about as many configurations as new bounds.
#[test]
fn bounds_follow_the_scene() {
    let mut exact = scene();
    let mut bounded = scene();
    bounded.use_bounds(CELL).unwrap();
    assert!(bounded.bound_bytes().is_some() && exact.bound_bytes().is_none());
    let (mut rng, mut workspace) = (Rng::new(23), bounded.workspace());
    let mut changes = 0;
    let mut check = |exact: &PlanningScene, bounded: &PlanningScene| {
        let values = random(exact, &mut rng, 700);
        changes += 1;
        // New bounds take most of the time.
        if by_suite(true, changes % 2 == 0) {
            let mut fresh = exact.clone();
            fresh.use_bounds(CELL).unwrap();
            let [new, old] = [&fresh, bounded].map(|scene| {
                let decided = scene.free_by_bounds(&values).unwrap();
                decided.iter().flatten().count()
            });
            assert!(new.abs_diff(old) <= 2 + new / 30, "{old} decided, by new bounds {new}");
        }
        // The scene takes much longer.
        let values = &values[..700 / suite_step() * exact.variables()];
        in_one_workspace(bounded, &mut workspace, values);
        compare(exact, bounded, values)[0]
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
    let mut ids: Vec<[BodyId; 2]> = Vec::new();
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
    // Where the base was before.
    both(&mut |scene| scene.place(cup, &at(-0.1, 0.0, 0.0)).unwrap(), true);
    both(&mut |scene| scene.place(cup, &at(0.0, 0.4, 0.9)).unwrap(), true);
    let hand = exact_link("hand");
    both(&mut |scene| scene.allow_collision(hand, wall).unwrap(), true);
    both(&mut |scene| scene.attach(cup, "hand", &[0.0; 4], &["hand"]).unwrap(), true);
    both(&mut |scene| scene.place(wall, &at(0.25, 0.1, 0.7)).unwrap(), true);
    both(&mut |scene| scene.remove(cup).map(drop).unwrap(), true);
    let mut insert = |scene: &mut PlanningScene| {
        // A mesh in the way of the arm, with a radius around it.
        let mesh = OwnedMesh::cylinder(0.05, 0.4, 0.002).unwrap();
        let tree = Arc::new(Builder::new().solid().build_as(&mesh.as_mesh()).unwrap());
        let cup = Body::new(tree).with_radius(0.01);
        ids.push([wall, scene.insert("cup", cup, &at(0.0, 0.4, 0.9)).unwrap()]);
    };
    both(&mut insert, true);
    let cup = ids[2][1];
    both(&mut |scene| scene.attach(cup, "forearm", &[0.3; 4], &["forearm"]).unwrap(), true);
    both(&mut |scene| scene.place(wall, &at(0.2, 0.0, 0.7)).unwrap(), true);
    // Other kinds of bodies have no bounds.
    let grid = PointCloud::new(&[[0.0; 3], [0.0, 0.0, 0.1]]).unwrap();
    let grid = Arc::new(grid);
    let mut insert = |scene: &mut PlanningScene| {
        let body = Body::new(Arc::clone(&grid)).with_radius(0.02);
        ids.push([wall, scene.insert("grid", body, &at(0.0, 0.4, 1.2)).unwrap()]);
    };
    both(&mut insert, true);
    let points = ids[4][1];
    both(&mut |scene| scene.attach(points, "hand", &[0.0; 4], &["hand"]).unwrap(), false);
    both(&mut |scene| scene.remove(points).map(drop).unwrap(), true);
    both(&mut |scene| scene.detach(cup, &at(0.2, 0.4, 0.5)).unwrap(), true);
    // Two bodies that do not move meet: nothing is free.
    both(&mut |scene| scene.place(cup, &at(0.2, 0.0, 0.7)).unwrap(), true);
    both(&mut |scene| scene.remove(cup).map(drop).unwrap(), true);
    both(&mut |scene| scene.forbid_collision(hand, wall).unwrap(), true);
    both(&mut |scene| scene.remove(wall).map(drop).unwrap(), true);
    assert!(all > 1000 / suite_step(), "{all}");
}

fn exact_link(name: &str) -> BodyId {
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
    for resolution in [0.0, -1.0, f64::NAN] {
        let [bounded, plain] = [&scene, &plain].map(|scene| scene.clone().with_resolution(resolution));
        for ends in values.chunks(8).map(|ends| ends.split_at(4)) {
            let ends = [ends.0, ends.1];
            let refused = plain.check_motion(&mut plain.workspace(), ends).unwrap_err().to_string();
            let mut workspace = bounded.workspace();
            let message = |found: Result<bool, PlanningError>| found.unwrap_err().to_string();
            assert_eq!(message(bounded.is_motion_free(&mut workspace, ends)), refused);
            assert_eq!(message(bounded.check_motion(&mut workspace, ends).map(|_| true)), refused);
        }
    }
    let query = Query::new(Isa::detect()).with_budget(0);
    assert_eq!(
        scene.clone().with_query(query).free(&values).unwrap(),
        plain.with_query(query).free(&values).unwrap(),
        "a budget that runs out decides nothing"
    );
}
