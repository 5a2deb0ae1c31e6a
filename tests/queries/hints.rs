//! Hints change only the work of a query: verdicts and distances are the same without a hint, wherever the hint
//! is from.

use crate::build;
use crate::pairs_that_meet;
use crate::support::data::{MeshData, Suite, emulator_step, suite_step, suites};
use crate::support::exact::{Tri, triangles_meet};
use crate::support::rng::Rng;
use crate::support::turns::pose;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::triangle::distance::separation;
use simdop::query::{Answer, Distance, Hint, Lanes, Query, Verdict};

type Rows = [[f64; 4]; 3];

fn bodies<N: Lanes>(suite: &Suite) -> (Bvh<N>, Bvh<N>) {
    (build(&suite.a), build(&suite.b))
}

/// The pair of a hit, by the meshes: it must meet, or be within the margin.
fn check_hit(answer: &Answer, margin: f64, moved: &[Tri], still: &[Tri], what: &str) {
    let Verdict::Hit(pair) = answer.verdict else { return };
    let (p, q) = (&moved[pair.a as usize], &still[pair.b as usize]);
    if margin == 0.0 {
        assert!(triangles_meet(p, q), "{what}: {pair:?}");
    } else {
        assert!(separation(p, q).lower <= margin, "{what}: {pair:?}");
    }
}

fn check_distance(hinted: &Distance, plain: &Distance, what: &str) {
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-12 * y;
    assert!(
        close(hinted.upper, plain.upper) && close(hinted.lower, plain.lower),
        "{what}: {hinted:?} {plain:?}"
    );
    assert_eq!(hinted.upper == 0.0, plain.upper == 0.0, "{what}");
}

/// One pose with each of the hints. Returns how many hits cost no visit.
fn check_pose<N: Lanes>(suite: &Suite, (a, b): (&Bvh<N>, &Bvh<N>), rows: &Rows, hints: &[Hint]) -> usize {
    let (a, b, pose) = (a.view(), b.view(), Pose::from_rows(*rows).unwrap());
    let (moved, still) = (suite.a.placed(rows), suite.b.corners());
    let query = Query::new(Isa::detect());
    let margins = [0.0, 1e-3 * suite.a.diagonal()];
    let plain = margins.map(|margin| query.within(&a, &b, &pose, margin).unwrap());
    let apart = query.distance(&a, &b, &pose, 0.0).unwrap();
    let mut free_of_charge = 0;
    for hint in hints {
        let what = format!("{} {rows:?} {hint:?}", suite.name);
        let hinted = query.with_hint(*hint);
        for (margin, plain) in margins.into_iter().zip(&plain) {
            let answer = hinted.within(&a, &b, &pose, margin).unwrap();
            assert_eq!(answer.is_free(), plain.is_free(), "{what} {margin}");
            check_hit(&answer, margin, &moved, &still, &what);
            if answer.is_free() {
                assert_eq!(answer.hint, *hint, "{what}: a free query passes its hint on");
                assert_eq!(answer.stats.visits, plain.stats.visits, "{what}");
            } else if answer.stats.visits == 0 {
                assert_eq!((answer.stats.primitive_pairs, answer.hint), (1, *hint), "{what}");
                free_of_charge += 1;
            }
            // With the hint of its own answer, a query finds the hit without a visit.
            if answer.hit().is_some() {
                let again = query.with_hint(answer.hint).within(&a, &b, &pose, margin).unwrap();
                assert_eq!((again.verdict, again.stats.visits), (answer.verdict, 0), "{what}");
            }
        }
        assert_eq!(hinted.collide(&a, &b, &pose), hinted.within(&a, &b, &pose, 0.0).unwrap(), "{what}");
        let far = hinted.distance(&a, &b, &pose, 0.0).unwrap();
        check_distance(&far, &apart, &what);
        let best = query.with_hint(apart.hint).distance(&a, &b, &pose, 0.0).unwrap();
        check_distance(&best, &apart, &what);
        let most = if apart.upper == 0.0 { 0 } else { apart.stats.visits };
        assert!(best.stats.visits <= most, "{what}: the answer is a good start");
    }
    free_of_charge
}

/// Hints from the pose before, from other poses, and from bodies with more triangles.
fn check_suite<N: Lanes>(suite: &Suite, poses: &[Rows], foreign: &[Hint]) {
    let (a, b) = bodies::<N>(suite);
    let query = Query::new(Isa::detect());
    let pose = |rows: &Rows| Pose::from_rows(*rows).unwrap();
    let found: Vec<Hint> =
        poses.iter().map(|p| query.distance(&a.view(), &b.view(), &pose(p), 0.1).unwrap().hint).collect();
    let mut rng = Rng::new(5);
    let mut free_of_charge = 0;
    for (i, rows) in poses.iter().enumerate() {
        let hints = [Hint::NONE, found[i.saturating_sub(1)], *rng.pick(&found), *rng.pick(foreign)];
        free_of_charge += check_pose(suite, (&a, &b), rows, &hints);
    }
    assert!(free_of_charge > 0, "{}: no hint was of use", suite.name);
}

#[test]
fn hints_change_no_verdict_and_no_distance() {
    let Some(suites) = suites() else { return };
    let largest = bodies::<Node16<18>>(&suites[1]);
    let query = Query::new(Isa::detect());
    let mut rng = Rng::new(3);
    let foreign: Vec<Hint> = (0..50)
        .map(|_| {
            let (r, t) = (rng.rotation(), rng.rotation()[0]);
            let pose = pose(&r, t);
            query.distance(&largest.0.view(), &largest.1.view(), &pose, 1.0).unwrap().hint
        })
        .collect();
    for suite in suites.iter().step_by(emulator_step().div_ceil(2)) {
        let (a, b) = bodies::<Node16<18>>(suite);
        let meets = |rows: &Rows| {
            query.collide(&a.view(), &b.view(), &Pose::from_rows(*rows).unwrap()).hit().is_some()
        };
        let poses = suite.poses(suite_step().max(4), meets);
        check_suite::<Node16<18>>(suite, &poses, &foreign);
        check_suite::<Node4<14>>(suite, &poses[..16], &foreign);
    }
}

#[test]
fn enumerations_and_empty_bodies_take_no_hint() {
    let one =
        MeshData { vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]] };
    let empty = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    let (one, empty) = (build::<Node16<18>>(&one), build::<Node16<18>>(&empty));
    let query = Query::new(Isa::detect());
    let hint = query.collide(&one.view(), &one.view(), &Pose::IDENTITY).hint;
    assert_ne!(hint, Hint::NONE);
    let hinted = query.with_hint(hint);
    assert_eq!(pairs_that_meet(hinted, &one, &one, &Pose::IDENTITY).0.len(), 1);
    let nothing = hinted.collide(&one.view(), &empty.view(), &Pose::IDENTITY);
    assert_eq!((nothing.verdict, nothing.hint), (Verdict::Free, hint));
    let nowhere = hinted.distance(&empty.view(), &one.view(), &Pose::IDENTITY, 0.0).unwrap();
    assert_eq!((nowhere.witness, nowhere.hint), (None, hint));
}
