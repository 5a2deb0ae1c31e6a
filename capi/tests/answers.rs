//! The C functions give the library's answers about two bodies.

mod support;

use simdop::construct::OwnedMesh;
use simdop::glam::{DQuat, DVec3};
use simdop::hierarchy::AsBvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Completion, Hint, PrimitivePair, Query};
use simdop_capi::*;
use std::ffi::{c_int, c_void};
use std::ops::ControlFlow;
use support::answers::{assert_answers, assert_distances};
use support::{
    BALL, Rng, Twice, answer, bytes, meshes_of, open, pose, shape_sets_of, shapes, shapes_as, solid,
    sphere_sets_of, spheres, spheres_as, surface, triangles_as,
};

/// Queries every body of `a` against every body of `b` through both interfaces, and counts the verdicts.
fn compare<S: Storage, A: AsBvh<Node = Node16<18, S>>, B: AsBvh<Node = Node16<18, S>>>(
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
            let cutoff = *rng.pick(&[0.1, 0.5, f64::INFINITY]);
            let c = answer(|answer| simdop_distance_up_to(ca, cb, c_pose, tolerance, cutoff, budget, answer));
            let rust = query.distance_up_to(&a.rust, &b.rust, &rust_pose, tolerance, cutoff).unwrap();
            assert_distances(&c.unwrap(), &rust);

            let mut expected = Vec::new();
            let (completion, _) = query.for_each_pair(&a.rust, &b.rust, &rust_pose, |pair| {
                expected.push(simdop_pair { a: pair.a, b: pair.b });
                ControlFlow::Continue(())
            });
            let (found, came_to) = pairs(a.c, b.c, c_pose, budget, usize::MAX);
            assert_eq!((found, came_to.completion), (expected.clone(), completion.into_c()));
            if let [first, _, ..] = expected[..] {
                let (found, came_to) = pairs(a.c, b.c, c_pose, budget, 1);
                assert_eq!((found, came_to.completion), (vec![first], simdop_completion::Stopped));
            }
            compare_with_hints((a, b), (c_pose.unwrap(), &rust_pose), &query, budget);
        }
    }
}

trait IntoC {
    fn into_c(self) -> simdop_completion;
}

impl IntoC for Completion {
    fn into_c(self) -> simdop_completion {
        match self {
            Self::Complete => simdop_completion::Complete,
            Self::Stopped => simdop_completion::Stopped,
            Self::OutOfBudget => simdop_completion::OutOfBudget,
        }
    }
}

/// Up to `most` pairs of primitives.
fn pairs(
    a: &simdop_body,
    b: &simdop_body,
    pose: Option<&simdop_pose>,
    budget: u64,
    most: usize,
) -> (Vec<simdop_pair>, simdop_pairs) {
    unsafe extern "C" fn collect(user: *mut c_void, pair: *const simdop_pair) -> c_int {
        // SAFETY: such a list is passed below.
        let (list, most) = unsafe { &mut *user.cast::<(Vec<simdop_pair>, usize)>() };
        // SAFETY: the library passes a valid pair.
        list.push(unsafe { *pair });
        c_int::from(list.len() == *most)
    }
    let mut found = (Vec::new(), most);
    let user = (&raw mut found).cast();
    // SAFETY: the list is what the callback expects.
    let came_to = answer(|pairs| unsafe {
        simdop_each_pair(Some(a), Some(b), pose, budget, Some(collect), user, pairs)
    });
    (found.0, came_to.unwrap())
}

/// Queries twice with hints, the second time with the hint of the first answer.
fn compare_with_hints<S: Storage, A: AsBvh<Node = Node16<18, S>>, B: AsBvh<Node = Node16<18, S>>>(
    (a, b): (&Twice<A>, &Twice<B>),
    (c_pose, pose): (&simdop_pose, &Pose),
    query: &Query,
    budget: u64,
) where
    A::Primitive: PrimitivePair<B::Primitive>,
    B::Primitive: PrimitivePair<A::Primitive>,
{
    let (ca, cb, c_pose) = (Some(a.c), Some(b.c), Some(c_pose));
    let (mut c_hints, mut hints) = ([SIMDOP_NO_HINT; 3], [Hint::NONE; 3]);
    for _ in 0..2 {
        let [collide, within, distance] = &mut c_hints;
        let hinted = hints.map(|hint| query.with_hint(hint));
        let c = answer(|to| simdop_collide_with_hint(ca, cb, c_pose, budget, Some(collide), to)).unwrap();
        let rust = hinted[0].collide(&a.rust, &b.rust, pose);
        assert_answers(&c, &rust);
        hints[0] = rust.hint;
        let c = answer(|to| simdop_within_with_hint(ca, cb, c_pose, 0.2, budget, Some(within), to)).unwrap();
        let rust = hinted[1].within(&a.rust, &b.rust, pose, 0.2).unwrap();
        assert_answers(&c, &rust);
        hints[1] = rust.hint;
        let infinite = f64::INFINITY;
        let c =
            answer(|to| simdop_distance_with_hint(ca, cb, c_pose, 0.0, infinite, budget, Some(distance), to));
        let rust = hinted[2].distance(&a.rust, &b.rust, pose, 0.0).unwrap();
        assert_distances(&c.unwrap(), &rust);
        hints[2] = rust.hint;
        assert_eq!(c_hints, hints.map(Hint::to_bits));
    }
}

#[test]
fn answers_at_many_poses_are_those_at_each() {
    let mut rng = Rng::new(8);
    let bodies = meshes_of::<Fixed>(&mut rng);
    let poses: Vec<_> = (0..50).map(|_| pose(&mut rng).0).collect();
    let (a, b) = (Some(bodies[0].c), Some(bodies[2].c));
    let mut answers = Vec::with_capacity(50);
    // SAFETY: there are 50 poses, and room for as many answers.
    let error = unsafe { simdop_collide_at_poses(a, b, poses.as_ptr(), 50, 5, answers.as_mut_ptr()) };
    assert_eq!(error, simdop_error::None);
    // SAFETY: all were written.
    unsafe { answers.set_len(50) };
    for (pose, found) in poses.iter().zip(answers) {
        assert_eq!(found, answer(|answer| simdop_collide(a, b, Some(pose), 5, answer)).unwrap());
    }
}

#[test]
fn answers_are_the_librarys() {
    answers_of::<Fixed>();
}

#[test]
fn answers_of_half_floats_are_the_librarys() {
    answers_of::<Half>();
}

fn answers_of<S: Storage>() {
    let mut rng = Rng::new(1);
    let (meshes, spheres, mut verdicts) = (meshes_of::<S>(&mut rng), sphere_sets_of::<S>(&mut rng), [0; 3]);
    let shapes = shape_sets_of::<S>(&mut rng);
    for _ in 0..20 {
        compare(&meshes, &meshes, &mut rng, &mut verdicts);
        compare(&meshes, &spheres, &mut rng, &mut verdicts);
        compare(&spheres, &meshes, &mut rng, &mut verdicts);
        compare(&spheres, &spheres, &mut rng, &mut verdicts);
        compare(&shapes, &meshes, &mut rng, &mut verdicts);
        compare(&meshes, &shapes, &mut rng, &mut verdicts);
        compare(&shapes, &spheres, &mut rng, &mut verdicts);
        compare(&spheres, &shapes, &mut rng, &mut verdicts);
        compare(&shapes, &shapes, &mut rng, &mut verdicts);
    }
    assert!(verdicts.iter().all(|&count| count > 100), "{verdicts:?}");
}

/// Bodies of both storages, made of the same primitives.
fn of_both_storages() -> Vec<[&'static simdop_body; 2]> {
    fn bodies<S: Storage>() -> Vec<&'static simdop_body> {
        let mut rng = Rng::new(4);
        let meshes = meshes_of::<S>(&mut rng);
        let (spheres, shapes) = (sphere_sets_of::<S>(&mut rng), shape_sets_of::<S>(&mut rng));
        let round = spheres.iter().map(|body| body.c).chain(shapes.iter().map(|body| body.c));
        meshes.iter().map(|body| body.c).chain(round).collect()
    }
    bodies::<Fixed>().into_iter().zip(bodies::<Half>()).map(|(fixed, half)| [fixed, half]).collect()
}

/// Verdicts are exact, so that both storages give the same; distances agree within their bounds.
#[test]
fn both_storages_have_one_verdict_and_no_query_mixes_them() {
    let (bodies, mut rng, mut hits) = (of_both_storages(), Rng::new(5), [0; 2]);
    for (a, b) in bodies.iter().flat_map(|a| bodies.iter().map(move |b| (a, b))) {
        for _ in 0..10 {
            let (at, _) = pose(&mut rng);
            let margin = rng.range(0.0, 0.5);
            let collide = |a: &simdop_body, b: &simdop_body| {
                answer(|answer| simdop_collide(Some(a), Some(b), Some(&at), SIMDOP_NO_BUDGET, answer))
            };
            let within = |a: &simdop_body, b: &simdop_body| {
                answer(|answer| simdop_within(Some(a), Some(b), Some(&at), margin, SIMDOP_NO_BUDGET, answer))
            };
            let distance = |a: &simdop_body, b: &simdop_body| {
                answer(|answer| simdop_distance(Some(a), Some(b), Some(&at), 0.0, SIMDOP_NO_BUDGET, answer))
            };
            let [fixed, half] = [0, 1].map(|i| collide(a[i], b[i]).unwrap().verdict);
            assert_eq!(fixed, half);
            hits[fixed as usize] += 1;
            let [fixed, half] = [0, 1].map(|i| within(a[i], b[i]).unwrap().verdict);
            assert_eq!(fixed, half);
            let [fixed, half] = [0, 1].map(|i| distance(a[i], b[i]).unwrap());
            assert!(fixed.lower <= half.upper && half.lower <= fixed.upper, "{fixed:?}, {half:?}");
            for (i, j) in [(0, 1), (1, 0)] {
                assert_eq!(collide(a[i], b[j]).unwrap_err(), simdop_error::OtherStorage);
                assert_eq!(within(a[i], b[j]).unwrap_err(), simdop_error::OtherStorage);
                assert_eq!(distance(a[i], b[j]).unwrap_err(), simdop_error::OtherStorage);
            }
        }
    }
    assert!(hits.iter().all(|&count| count > 50), "{hits:?}");
}

/// Functions without a storage build fixed point.
#[test]
fn fixed_point_is_the_default() {
    let mesh = OwnedMesh::cuboid([1.0; 3]).unwrap();
    let balls = [[0.0, 0.0, 0.0, 1.0], [2.0, 0.0, 0.0, 0.5]];
    let fixed = simdop_storage::Fixed as c_int;
    for (plain, named) in [
        (surface(&mesh.as_mesh()), triangles_as(&mesh.as_mesh(), false, fixed)),
        (solid(&mesh.as_mesh()), triangles_as(&mesh.as_mesh(), true, fixed)),
        (spheres(&balls), spheres_as(&balls, fixed)),
        (shapes(&[BALL; 2]), shapes_as(&[BALL; 2], fixed)),
    ] {
        assert_eq!(bytes(&plain.unwrap()), bytes(&named.unwrap()));
    }
}

#[test]
fn bytes_are_the_librarys_and_open_as_the_same_body() {
    bytes_of::<Fixed>();
    bytes_of::<Half>();
}

fn bytes_of<S: Storage>() {
    let mut rng = Rng::new(2);
    let (meshes, spheres) = (meshes_of::<S>(&mut rng), sphere_sets_of::<S>(&mut rng));
    let shapes = shape_sets_of::<S>(&mut rng);
    let built = meshes.iter().map(|body| (body.c, body.rust.as_bytes()));
    let built = built.chain(spheres.iter().map(|body| (body.c, body.rust.as_bytes())));
    for (body, expected) in built.chain(shapes.iter().map(|body| (body.c, body.rust.as_bytes()))) {
        assert_eq!(bytes(body), expected);
        let opened = open(bytes(body)).unwrap();
        assert_eq!(bytes(&opened).as_ptr(), bytes(body).as_ptr(), "opened in place");
        let (at, _) = pose(&mut rng);
        let ask = |a: &simdop_body| {
            answer(|answer| simdop_distance(Some(a), Some(body), Some(&at), 0.0, SIMDOP_NO_BUDGET, answer))
        };
        let [by_opened, by_built] = [ask(&opened).unwrap(), ask(body).unwrap()];
        // As text, in which NaN equals itself.
        assert_eq!(format!("{by_opened:?}"), format!("{by_built:?}"));
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
