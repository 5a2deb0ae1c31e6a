//! The C functions give the library's answers about two bodies.

mod support;

use simdop::glam::{DQuat, DVec3};
use simdop::hierarchy::AsBvh;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Distance, PrimitivePair, Query, QueryStats, Verdict};
use simdop_capi::*;
use support::{Node, Rng, Twice, answer, bytes, meshes, open, pose, sphere_sets};

fn assert_counters(c: &simdop_query_stats, rust: &QueryStats) {
    let stats = [c.visits, c.kernels, c.realignments, c.primitive_pairs, c.exact_pairs];
    assert_eq!(stats, [rust.visits, rust.kernels, rust.realignments, rust.primitive_pairs, rust.exact_pairs]);
}

fn assert_answers(c: &simdop_answer, rust: &Answer) {
    let none = SIMDOP_NO_PRIMITIVE;
    let (verdict, pair, bounds) = match rust.verdict {
        Verdict::Free => (simdop_verdict::Free, [none; 2], [0.0, f64::INFINITY]),
        Verdict::Hit(pair) => (simdop_verdict::Hit, [pair.a, pair.b], [0.0, f64::INFINITY]),
        Verdict::Unknown { lower, upper } => (simdop_verdict::Unknown, [none; 2], [lower, upper]),
    };
    assert_eq!((c.verdict, [c.pair.a, c.pair.b], [c.lower, c.upper]), (verdict, pair, bounds));
    assert_counters(&c.stats, &rust.stats);
}

fn assert_distances(c: &simdop_distance_answer, rust: &Distance) {
    let verdict = match rust.verdict() {
        Verdict::Free => simdop_verdict::Free,
        Verdict::Hit(_) => simdop_verdict::Hit,
        Verdict::Unknown { .. } => simdop_verdict::Unknown,
    };
    let completion = match rust.completion {
        Completion::Complete => simdop_completion::Complete,
        Completion::Stopped => simdop_completion::Stopped,
        Completion::OutOfBudget => simdop_completion::OutOfBudget,
    };
    assert_eq!((c.verdict, c.completion), (verdict, completion));
    assert_eq!([c.lower, c.upper], [rust.lower, rust.upper]);
    match rust.witness {
        Some(witness) => {
            assert_eq!([c.pair.a, c.pair.b], [witness.pair.a, witness.pair.b]);
            assert_eq!([c.point_a, c.point_b], [witness.a, witness.b]);
        }
        None => {
            assert_eq!([c.pair.a, c.pair.b], [SIMDOP_NO_PRIMITIVE; 2]);
            assert!(c.point_a.iter().chain(&c.point_b).all(|x| x.is_nan()));
        }
    }
    assert_counters(&c.stats, &rust.stats);
}

/// Queries every body of `a` against every body of `b` through both interfaces, and counts the verdicts.
fn compare<A: AsBvh<Node = Node>, B: AsBvh<Node = Node>>(
    a: &[Twice<A>],
    b: &[Twice<B>],
    rng: &mut Rng,
    verdicts: &mut [u32; 3],
) where
    A::Primitive: PrimitivePair<B::Primitive>,
    B::Primitive: PrimitivePair<A::Primitive>,
{
    for (a, b) in a.iter().flat_map(|a| b.iter().map(move |b| (a, b))) {
        for budget in [SIMDOP_NO_BUDGET, SIMDOP_NO_BUDGET, 1] {
            let (c_pose, rust_pose) = pose(rng);
            let (margin, tolerance) = (rng.range(0.0, 0.5), *rng.pick(&[0.0, 0.1]));
            let query = Query::new(Isa::detect()).with_budget(budget);
            let (ca, cb, c_pose) = (Some(a.c), Some(b.c), Some(&c_pose));

            let c = answer(|answer| simdop_collide(ca, cb, c_pose, budget, answer)).unwrap();
            assert_answers(&c, &query.collide(&a.rust, &b.rust, &rust_pose));
            verdicts[c.verdict as usize] += 1;
            let c = answer(|answer| simdop_within(ca, cb, c_pose, margin, budget, answer)).unwrap();
            assert_answers(&c, &query.within(&a.rust, &b.rust, &rust_pose, margin).unwrap());
            let c = answer(|answer| simdop_distance(ca, cb, c_pose, tolerance, budget, answer)).unwrap();
            assert_distances(&c, &query.distance(&a.rust, &b.rust, &rust_pose, tolerance).unwrap());
        }
    }
}

#[test]
fn answers_are_the_librarys() {
    let mut rng = Rng::new(1);
    let (meshes, spheres, mut verdicts) = (meshes(&mut rng), sphere_sets(&mut rng), [0; 3]);
    for _ in 0..20 {
        compare(&meshes, &meshes, &mut rng, &mut verdicts);
        compare(&meshes, &spheres, &mut rng, &mut verdicts);
        compare(&spheres, &meshes, &mut rng, &mut verdicts);
        compare(&spheres, &spheres, &mut rng, &mut verdicts);
    }
    assert!(verdicts.iter().all(|&count| count > 100), "{verdicts:?}");
}

#[test]
fn bytes_are_the_librarys_and_open_as_the_same_body() {
    let mut rng = Rng::new(2);
    let (meshes, spheres) = (meshes(&mut rng), sphere_sets(&mut rng));
    let built = meshes.iter().map(|body| (body.c, body.rust.as_bytes()));
    for (body, expected) in built.chain(spheres.iter().map(|body| (body.c, body.rust.as_bytes()))) {
        assert_eq!(bytes(body), expected);
        let opened = open(bytes(body)).unwrap();
        assert_eq!(bytes(&opened).as_ptr(), bytes(body).as_ptr(), "opened in place");
        let (at, _) = pose(&mut rng);
        let ask = |a: &simdop_body| {
            answer(|answer| simdop_distance(Some(a), Some(body), Some(&at), 0.0, SIMDOP_NO_BUDGET, answer))
        };
        let [by_opened, by_built] = [ask(&opened).unwrap(), ask(body).unwrap()];
        assert_eq!(by_opened, by_built);
        simdop_body_destroy(Some(opened));
    }
}

#[test]
fn quaternions_are_the_librarys() {
    let (quaternion, translation) = ([0.1, -0.5, 0.5, 0.7], [1.0, -2.0, 3.0]);
    let from = |xyzw: &[f64; 4], t: &[f64; 3]| {
        // SAFETY: four numbers and three.
        answer(|pose| unsafe { simdop_pose_from_quaternion(xyzw.as_ptr(), t.as_ptr(), pose) })
    };
    let c = from(&quaternion, &translation).unwrap();
    let rust = Pose::try_from((DQuat::from_array(quaternion), DVec3::from_array(translation))).unwrap();
    assert_eq!(Pose::from_rows(c.rows), Ok(rust));
    assert_eq!(from(&[0.0; 4], &translation), Err(simdop_error::PoseNotUnit));
}
