//! The same verdicts and statistics on every instruction set and on every machine. For each suite of
//! `tests/queries/mesh_poses.rs` and node type there is one digest over all poses. It is equal on all
//! instruction sets here, and equals the number below, which x86-64 and aarch64 share.
//!
//! A change of the builder, of the order of the traversal or of the realignment changes the statistics, and so
//! the digests: the failing test prints the new rows. The verdicts have a digest of their own, which only an
//! error can change.

use crate::support::data::{Suite, suite_step, suites};
use crate::support::digest::Digest;
use crate::{HalfNode, build};
use simdop::isa::Isa;
#[cfg(simdop_all_nodes)]
use simdop::node::Node4;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Answer, Lanes, Query, Verdict};

/// The digest of the verdicts, and that of the verdicts with their witnesses and statistics.
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
        let c = answer.stats;
        add(&mut all, &[c.visits, c.kernels, c.realignments, c.primitive_pairs, c.exact_pairs]);
    }
    [verdicts.0, all.0]
}

/// The poses of a suite. The search for contact uses the scalar kernel.
fn poses(suite: &Suite) -> Vec<Pose> {
    let (a, b) = (build::<Node16<18>>(&suite.a), build::<Node16<18>>(&suite.b));
    let pose = |rows: &[[f64; 4]; 3]| Pose::from_rows(*rows).unwrap();
    let meets = |rows: &[[f64; 4]; 3]| {
        Query::new(Isa::SCALAR).collide(&a.view(), &b.view(), &pose(rows)).hit().is_some()
    };
    suite.poses(suite_step(), meets).iter().map(pose).collect()
}

/// The digests of a node type on the scalar kernel, after a check that every other instruction set gives the
/// same answers.
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

/// A suite, the digest of its verdicts, and its full digests on `Node16<18>`, `Node4<18>` and [`HalfNode`].
type Golden = (&'static str, u64, [u64; 3]);

#[rustfmt::skip]
const FULL: [Golden; 4] = [
    ("hand", 0x8695b75e697213a5, [0x0a7b41a1d1a3a0aa, 0x6fa1035168ac4135, 0x21cb22fc6fdd6b19]),
    ("cow", 0x8695b75e697213a5, [0x25384bad8aef92e4, 0x54450cfaa3d5531d, 0x656c403a90293799]),
    ("pinion", 0x8695b75e697213a5, [0xedb5db0618c0e56d, 0xcc88251d17dd9018, 0xe01f1a580579ec88]),
    ("unc", 0x37364cf83e5d95a5, [0x1baaaf28ce48bae4, 0x21a1450f4087ecd3, 0x350373d8f8f5c2af]),
];

#[rustfmt::skip]
const SMALL: [Golden; 4] = [
    ("hand", 0x03fad1219b933525, [0x6db053603a352adf, 0x7c6d2afa62e15b3f, 0x600dd7b86a1569ad]),
    ("cow", 0x03fad1219b933525, [0x0a6294135f724db9, 0x176a918028781548, 0x953b401b4a6c7a89]),
    ("pinion", 0x03fad1219b933525, [0x2141c46da089eef4, 0x59cd911428cfc77e, 0x7daf705225fddec0]),
    ("unc", 0x54e24d3ba02a15a5, [0xefa16ccd9086a89e, 0x04e6f541c37a90d7, 0x6d8f183eada57feb]),
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
        let (wide, half) = (check::<Node16<18>>(suite, &poses), check::<HalfNode>(suite, &poses));
        #[cfg(simdop_all_nodes)]
        let narrow = check::<Node4<18>>(suite, &poses);
        #[cfg(not(simdop_all_nodes))]
        let narrow = [want.1, want.2[1]];
        assert!(
            wide[0] == narrow[0] && wide[0] == half[0],
            "{}: verdicts differ between node types",
            suite.name
        );
        let got: Golden = (suite.name, wide[0], [wide[1], narrow[1], half[1]]);
        if got != want {
            same = false;
            let (name, verdicts, [x, y, z]) = got;
            println!("    (\"{name}\", {verdicts:#018x}, [{x:#018x}, {y:#018x}, {z:#018x}]),");
        }
    }
    assert!(same, "digests are not the ones written here, but those above");
}
