//! The same verdicts and the same counters on every instruction set, and on every machine: one digest for
//! each suite of `tests/mesh_poses.rs` and node type, over all poses, equal on all instruction sets here and
//! to the number written below, which x86-64 and aarch64 share.
//!
//! A change of the builder, of the order of the traversal or of the re-alignment changes the counters and so
//! the digests: the failing test prints the new rows. The verdicts have a digest of their own, which only an
//! error can change.

mod support;

use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Answer, Lanes, Query, Verdict};
use support::data::{MeshData, Suite, suite_step, suites};
use support::digest::Digest;

/// Digests of the verdicts, and of the verdicts with their witnesses and counters.
type Digests = [u64; 2];

fn digests(answers: &[Answer]) -> Digests {
    let (mut verdicts, mut all) = (Digest::EMPTY, Digest::EMPTY);
    let add = |digest: &mut Digest, values: &[u64]| values.iter().for_each(|x| digest.add(&x.to_le_bytes()));
    for answer in answers {
        add(&mut verdicts, &[answer.hit().is_some().into()]);
        match answer.verdict {
            Verdict::Hit(pair) => add(&mut all, &[1, pair.a.into(), pair.b.into()]),
            Verdict::Free => add(&mut all, &[0]),
            Verdict::Unknown { .. } => panic!("a query without a budget knows its answer"),
        }
        let c = answer.counters;
        add(&mut all, &[c.visits, c.kernels, c.realignments, c.primitive_pairs, c.exact_pairs]);
    }
    [verdicts.0, all.0]
}

fn build<N: Lanes>(mesh: &MeshData) -> Bvh<N> {
    Builder::new().build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

/// The poses of a suite. The search for contact decides by the scalar kernel.
fn poses(suite: &Suite) -> Vec<Pose> {
    let (a, b) = (build::<Node16<18>>(&suite.a), build::<Node16<18>>(&suite.b));
    let pose = |rows: &[[f64; 4]; 3]| Pose::from_rows(*rows).unwrap();
    let meets = |rows: &[[f64; 4]; 3]| {
        Query::new(Isa::SCALAR).collide(&a.view(), &b.view(), &pose(rows)).hit().is_some()
    };
    suite.poses(suite_step(), meets).iter().map(pose).collect()
}

/// The digests of a node type on the scalar kernel, once every other instruction set has given the same
/// answers.
fn check<N: Lanes>(suite: &Suite, poses: &[Pose]) -> Digests {
    let (a, b) = (build::<N>(&suite.a), build::<N>(&suite.b));
    let answers = |isa: Isa| -> Vec<Answer> {
        poses.iter().map(|pose| Query::new(isa).collide(&a.view(), &b.view(), pose)).collect()
    };
    let want = answers(Isa::SCALAR);
    for isa in Isa::available() {
        let got = answers(isa);
        for (i, (got, want)) in got.iter().zip(&want).enumerate() {
            assert_eq!(got, want, "{} k {} arity {} pose {i}: {isa}", suite.name, N::K, N::ARITY);
        }
        let [verdicts, all] = digests(&got);
        println!("{:6} k {:2} arity {:2} {isa:6} {verdicts:016x} {all:016x}", suite.name, N::K, N::ARITY);
    }
    digests(&want)
}

/// A suite, the digest of its verdicts, and its digests of everything on `Node16<18>`, `Node4<18>` and
/// `Node16<32>`.
type Golden = (&'static str, u64, [u64; 3]);

#[rustfmt::skip]
const FULL: [Golden; 4] = [
    ("hand", 0x8695b75e697213a5, [0xec8698d4b05d86e7, 0x028c0b5c86d58c1c, 0x0310c7b9867e9c7c]),
    ("cow", 0x8695b75e697213a5, [0xedcabec9a9ca0a51, 0xceeb25fadc668147, 0x49a48219e9d87550]),
    ("pinion", 0x8695b75e697213a5, [0xf28c0999f2934053, 0xd0f15f24c5426096, 0x16bb5b5996efa80f]),
    ("unc", 0x37364cf83e5d95a5, [0x66c3cb0843265800, 0x88a9d90eca63a4a5, 0x2a0a748a6ee6f80f]),
];

#[rustfmt::skip]
const SMALL: [Golden; 4] = [
    ("hand", 0x03fad1219b933525, [0x1ccdfe2589c17c34, 0x3f251aa5db86a26e, 0x7bf10a38137b4f2a]),
    ("cow", 0x03fad1219b933525, [0x4420cdc25e45eb46, 0x5bec169eacd944eb, 0xe6b9ca3b96805b60]),
    ("pinion", 0x03fad1219b933525, [0x339fd6cae7c948a4, 0xab61488567059836, 0x9add6728830c9793]),
    ("unc", 0x54e24d3ba02a15a5, [0x08cc8d74c050b198, 0x9a999086e89171c0, 0x1111e1e1e7c9c3ef]),
];

#[test]
fn answers_are_the_same_on_every_instruction_set_and_machine() {
    let Some(suites) = suites() else { return };
    let golden = match suite_step() {
        1 => FULL,
        8 => SMALL,
        step => panic!("no digests for a step of {step}"),
    };
    let mut same = true;
    for (suite, want) in suites.iter().zip(golden) {
        let poses = poses(suite);
        let [wide, narrow, wide_32] = [
            check::<Node16<18>>(suite, &poses),
            check::<Node4<18>>(suite, &poses),
            check::<Node16<32>>(suite, &poses),
        ];
        assert!(
            wide[0] == narrow[0] && wide[0] == wide_32[0],
            "{}: verdicts differ between node types",
            suite.name
        );
        let got: Golden = (suite.name, wide[0], [wide[1], narrow[1], wide_32[1]]);
        if got != want {
            same = false;
            let (name, verdicts, [x, y, z]) = got;
            println!("    (\"{name}\", {verdicts:#018x}, [{x:#018x}, {y:#018x}, {z:#018x}]),");
        }
    }
    assert!(same, "digests are not the ones written here, but those above");
}
