//! Queries on real meshes: every verdict equals brute force in exact arithmetic, at gaps and depths down to
//! 1e-8 of the diagonal.
//!
//! For each of the four pairs of meshes of `support::data::suites` (in CI's emulator two of them), on every instruction
//! set of this machine:
//!
//! * Verdicts at all 200 poses of the pair, which brute force judges once. Trees of every k (6, 14, 18, 26, 32)
//!   and both arities with one triangle per leaf, by the default splitter (mean width) and by the fast preset's
//!   (extended longest axis); and three more with other leaf sizes. Witnesses and statistics are equal on all
//!   instruction sets.
//! * All pairs of triangles that meet, at two deep poses: every k and both arities, with two triangles per leaf,
//!   by the default splitter.
//!
//! `SIMDOP_SUITE=full` has 200 poses instead of 32, and verifies the trees first.

use crate::pairs_that_meet;
use crate::support::data::{MeshData, Suite, emulator_step, suite_step, suites};
use crate::support::exact::{meeting_pairs, meshes_meet};
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};
use std::collections::BTreeSet;

fn build<N: Lanes>(mesh: &MeshData, leaf_size: u32, splitter: Splitter) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let tree = Builder::new().leaf_size(leaf_size).splitter(splitter).build_as(&mesh).unwrap();
    let view: simdop::hierarchy::BvhRef<'_, N> = tree.view();
    view.validate().unwrap();
    if suite_step() == 1 {
        view.verify().unwrap();
    }
    tree
}

/// A pose, and whether the bodies meet there.
type Judged = ([[f64; 4]; 3], bool);

/// The poses of a suite with the oracle's verdicts.
fn judged(suite: &Suite) -> Vec<Judged> {
    let a = build::<Node16<18>>(&suite.a, 1, Splitter::ExtendedLongestAxis);
    let b = build::<Node16<18>>(&suite.b, 1, Splitter::ExtendedLongestAxis);
    let query = Query::new(Isa::detect());
    let poses = suite
        .poses(suite_step(), |rows| query.collide(&a, &b, &Pose::from_rows(*rows).unwrap()).hit().is_some());
    let still = suite.b.corners();
    let judge = |pose: &[[f64; 4]; 3]| meshes_meet(&suite.a.placed(pose), &still);
    poses.into_iter().map(|pose| (pose, judge(&pose))).collect()
}

fn check<N: Lanes>(suite: &Suite, judged: &[Judged], leaf_size: u32, splitter: Splitter) {
    let a = build::<N>(&suite.a, leaf_size, splitter);
    let b = build::<N>(&suite.b, leaf_size, splitter);
    let trees = format!("{} k {} arity {} leaf {leaf_size} {splitter:?}", suite.name, N::K, N::ARITY);
    let (mut pairs, mut exact) = (0, 0);
    for (i, (rows, meets)) in judged.iter().enumerate() {
        let pose = Pose::from_rows(*rows).unwrap();
        let mut first = None;
        for isa in Isa::available() {
            let answer = Query::new(isa).collide(&a, &b, &pose);
            let found = (answer.is_free(), answer.hit().is_some());
            assert_eq!(found, (!*meets, *meets), "{trees} {isa} pose {i} {rows:?}");
            assert_eq!(answer, *first.get_or_insert(answer), "{trees} {isa} pose {i} {rows:?}");
        }
        let stats = first.expect("scalar, if nothing else").stats;
        pairs += stats.primitive_pairs;
        exact += stats.exact_pairs;
    }
    println!("{trees}: {} poses, {pairs} triangle pairs, {exact} of them exact", judged.len());
    assert!(exact * 1000 <= pairs, "{trees}: {exact} exact fallbacks in {pairs} pairs are more than 0.1 %");
}

#[test]
fn verdicts_equal_brute_force_in_exact_arithmetic() {
    let Some(suites) = suites() else { return };
    for suite in suites.iter().step_by(emulator_step().div_ceil(2)) {
        let judged = judged(suite);
        let hits = judged.iter().filter(|(_, meets)| *meets).count();
        println!("{}: {hits} hits in {} poses", suite.name, judged.len());
        assert!(hits * 4 > judged.len() && hits * 4 < judged.len() * 3, "both answers are frequent");
        for splitter in [Splitter::default(), Splitter::ExtendedLongestAxis] {
            for_each_node!(check(suite, &judged, 1, splitter));
        }
        check::<Node16<18>>(suite, &judged, 5, Splitter::ExtendedLongestAxis);
        check::<Node16<18>>(suite, &judged, 16, Splitter::LongestAxis);
        check::<Node4<14>>(suite, &judged, 3, Splitter::LongestAxis);
    }
}

/// All pairs equal the oracle's list, at deep poses with many pairs.
fn check_pairs<N: Lanes>(suite: &Suite, wanted: &[(Pose, BTreeSet<(u32, u32)>)]) {
    let a = build::<N>(&suite.a, 2, Splitter::default());
    let b = build::<N>(&suite.b, 2, Splitter::default());
    for (pose, want) in wanted {
        for isa in Isa::available() {
            let (got, _) = pairs_that_meet(Query::new(isa), &a, &b, pose);
            let what = format!("{} k {} arity {} {isa}", suite.name, N::K, N::ARITY);
            assert!(got == *want, "{what}: {} pairs, should be {}", got.len(), want.len());
        }
    }
}

#[test]
fn all_pairs_equal_brute_force() {
    let Some(suites) = suites() else { return };
    for suite in suites.iter().step_by(emulator_step().div_ceil(2)) {
        let deep = |rows: [[f64; 3]; 3]| -> [[f64; 4]; 3] {
            core::array::from_fn(|i| [rows[i][0], rows[i][1], rows[i][2], 0.01 * suite.a.diagonal()])
        };
        let turned = [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let wanted = [deep(turned), deep(identity)].map(|rows| {
            let pairs = meeting_pairs(&suite.a.placed(&rows), &suite.b.corners());
            assert!(pairs.len() > 100, "{}: {} pairs are few", suite.name, pairs.len());
            let pairs = pairs.into_iter().map(|(i, j)| (i as u32, j as u32)).collect();
            (Pose::from_rows(rows).unwrap(), pairs)
        });
        for_each_node!(check_pairs(suite, &wanted));
    }
}
