//! The main job on real meshes: every verdict equal to brute force in exact arithmetic, at gaps and depths down to 1e-8 of the diagonal.

mod support;

use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Completion, Lanes, Query};
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use support::data::{MeshData, Suite, suite_step, suites};
use support::exact::{meeting_pairs, meshes_meet};

fn build<N: Lanes>(mesh: &MeshData, leaf_size: u32, splitter: Splitter) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let tree = Builder::new().leaf_size(leaf_size).splitter(splitter).build(&mesh).unwrap();
    let view: simdop::hierarchy::BvhRef<'_, N> = tree.view();
    view.validate().unwrap();
    view.verify().unwrap();
    tree
}

fn collide<N: Lanes>(a: &Bvh<N>, b: &Bvh<N>, pose: &[[f64; 4]; 3]) -> bool {
    let pose = Pose::from_rows(*pose).unwrap();
    Query::new(Isa::detect()).collide(&a.view(), &b.view(), &pose).hit().is_some()
}

/// The poses of a suite, and the oracle's verdict on each.
fn judged(suite: &Suite) -> Vec<([[f64; 4]; 3], bool)> {
    let a = build::<Node16<18>>(&suite.a, 1, Splitter::ExtendedLongestAxis);
    let b = build::<Node16<18>>(&suite.b, 1, Splitter::ExtendedLongestAxis);
    let poses = suite.poses(suite_step(), |pose| collide(&a, &b, pose));
    let still = suite.b.corners();
    let judge = |pose: &[[f64; 4]; 3]| meshes_meet(&suite.a.placed(pose), &still);
    poses.into_iter().map(|pose| (pose, judge(&pose))).collect()
}

fn check<N: Lanes>(suite: &Suite, judged: &[([[f64; 4]; 3], bool)], leaf_size: u32, splitter: Splitter) {
    let a = build::<N>(&suite.a, leaf_size, splitter);
    let b = build::<N>(&suite.b, leaf_size, splitter);
    let (mut pairs, mut exact) = (0, 0);
    for (i, (rows, meets)) in judged.iter().enumerate() {
        let pose = Pose::from_rows(*rows).unwrap();
        let answer = Query::new(Isa::detect()).collide(&a.view(), &b.view(), &pose);
        let what = format!("{} k {} arity {} leaf {leaf_size} pose {i} {rows:?}", suite.name, N::K, N::ARITY);
        assert_eq!((answer.is_free(), answer.hit().is_some()), (!*meets, *meets), "{what}");
        pairs += answer.counters.primitive_pairs;
        exact += answer.counters.exact_pairs;
    }
    println!(
        "{:7} k {:2} arity {:2} leaf {leaf_size:2}: {} poses, {pairs} triangle pairs, {exact} of them exact",
        suite.name,
        N::K,
        N::ARITY,
        judged.len()
    );
    assert!(
        exact * 1000 <= pairs,
        "{}: {exact} exact fallbacks in {pairs} pairs are more than 0.1 %",
        suite.name
    );
}

#[test]
fn verdicts_equal_brute_force_in_exact_arithmetic() {
    let Some(suites) = suites() else { return };
    for suite in &suites {
        let judged = judged(suite);
        let hits = judged.iter().filter(|(_, meets)| *meets).count();
        println!("{}: {hits} hits in {} poses", suite.name, judged.len());
        assert!(hits * 4 > judged.len() && hits * 4 < judged.len() * 3, "both answers are frequent");
        macro_rules! check_all {
            ($($node:ty),*) => { $( check::<$node>(suite, &judged, 1, Splitter::ExtendedLongestAxis); )* };
        }
        check_all!(Node16<6>, Node16<14>, Node16<18>, Node16<26>, Node16<32>);
        check_all!(Node4<6>, Node4<14>, Node4<18>, Node4<26>, Node4<32>);
        check::<Node16<18>>(suite, &judged, 5, Splitter::ExtendedLongestAxis);
        check::<Node16<18>>(suite, &judged, 16, Splitter::LongestAxis);
        check::<Node4<14>>(suite, &judged, 3, Splitter::LongestAxis);
    }
}

/// All pairs, not only the first: equal to the oracle's list, for deep poses with many of them.
fn check_pairs<N: Lanes>(suite: &Suite, pose: &[[f64; 4]; 3], want: &BTreeSet<(u32, u32)>) {
    let a = build::<N>(&suite.a, 2, Splitter::ExtendedLongestAxis);
    let b = build::<N>(&suite.b, 2, Splitter::ExtendedLongestAxis);
    let mut got = BTreeSet::new();
    let pose = Pose::from_rows(*pose).unwrap();
    let (completion, _) = Query::new(Isa::detect()).for_each_pair(&a.view(), &b.view(), &pose, |pair| {
        assert!(got.insert((pair.a, pair.b)), "each pair once");
        ControlFlow::Continue(())
    });
    assert_eq!(completion, Completion::Complete);
    assert!(got == *want, "{} k {}: {} pairs, should be {}", suite.name, N::K, got.len(), want.len());
}

#[test]
fn all_pairs_equal_brute_force() {
    let Some(suites) = suites() else { return };
    for suite in &suites {
        let deep = |rows: [[f64; 3]; 3]| -> [[f64; 4]; 3] {
            core::array::from_fn(|i| [rows[i][0], rows[i][1], rows[i][2], 0.01 * suite.a.diagonal()])
        };
        let turned = [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for pose in [deep(turned), deep(identity)] {
            let want = meeting_pairs(&suite.a.placed(&pose), &suite.b.corners());
            let want = want.into_iter().map(|(i, j)| (i as u32, j as u32)).collect();
            check_pairs::<Node16<18>>(suite, &pose, &want);
            check_pairs::<Node4<14>>(suite, &pose, &want);
        }
    }
}
