//! The same verdicts and the same counters on every instruction set, and on every machine: one digest for each suite of
//! `tests/mesh_poses.rs` and node type, over all poses, equal on all instruction sets here and to the number written below, which
//! x86-64 and aarch64 share.
//!
//! A change of the builder, of the order of the traversal or of the re-alignment changes the counters and so the digests: the failing test
//! prints the new rows. The verdicts have a digest of their own, which only an error can change.

mod support;

use simdop::build::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Answer, Lanes, Query, Verdict};
use support::data::{MeshData, Suite, suite_step, suites};

/// FNV-1a, 64 bits.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
struct Digest(u64);

impl Digest {
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    fn add(&mut self, value: u64) {
        for byte in value.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

/// Digests of the verdicts, and of the verdicts with their witnesses and counters.
type Digests = [u64; 2];

fn digests(answers: &[Answer]) -> Digests {
    let (mut verdicts, mut all) = (Digest::EMPTY, Digest::EMPTY);
    for answer in answers {
        verdicts.add(answer.is_hit().into());
        match answer.verdict {
            Verdict::Hit(pair) => [1, pair.a.into(), pair.b.into()].into_iter().for_each(|x| all.add(x)),
            Verdict::Free => all.add(0),
            Verdict::Unknown { .. } => panic!("a query without a budget knows its answer"),
        }
        let c = answer.counters;
        [c.visits, c.kernels, c.realignments, c.triangle_pairs, c.exact_pairs]
            .into_iter()
            .for_each(|x| all.add(x));
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
    let meets =
        |rows: &[[f64; 4]; 3]| Query::new(Isa::SCALAR).collide(&a.view(), &b.view(), &pose(rows)).is_hit();
    suite.poses(suite_step(), meets).iter().map(pose).collect()
}

/// The digests of a node type on the scalar kernel, once every other instruction set has given the same answers.
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

/// A suite, the digest of its verdicts, and its digests of everything on `Node16<18>`, `Node4<18>` and `Node16<32>`.
type Golden = (&'static str, u64, [u64; 3]);

#[rustfmt::skip]
const FULL: [Golden; 4] = [
    ("hand", 0x8695b75e697213a5, [0x974c2e5b93720da2, 0x1b0a2cfbe964f4ef, 0xf060a6287ba5d5fe]),
    ("cow", 0x8695b75e697213a5, [0xfa80b30e4e3498ff, 0xc0b91c3ba27657ee, 0xeee2e1b5e5c2becf]),
    ("pinion", 0x8695b75e697213a5, [0x453551636f41a905, 0x0b56e731d3bf6392, 0xc57561636d445482]),
    ("unc", 0x37364cf83e5d95a5, [0x6f0525508e0e5f43, 0xc0efddb2ae9cfb83, 0xc404fd877fa26408]),
];

#[rustfmt::skip]
const SMALL: [Golden; 4] = [
    ("hand", 0x03fad1219b933525, [0x210ef4e40e115445, 0x34617d3b582573f1, 0x0d76b9854da2fce2]),
    ("cow", 0x03fad1219b933525, [0x5071bfef62563501, 0xce25eab7dc46c53a, 0xc12e3c950a07a9a7]),
    ("pinion", 0x03fad1219b933525, [0x205cfb7d81d36d9f, 0x250673de30e7ba27, 0xf87dc6bdf18e181b]),
    ("unc", 0x54e24d3ba02a15a5, [0x8b1362d7863e6d42, 0x9de8007c4bc7d99b, 0x9fd478568b10df37]),
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
