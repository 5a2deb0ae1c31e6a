//! The C functions give the library's answers about scenes.

mod support;

use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::query::{Completion, Query};
use simdop::scene::{Body, BodyId, Groups, Scene, SceneHit, SceneVerdict};
use simdop_capi::*;
use std::ffi::{c_int, c_void};
use std::ops::ControlFlow;
use support::{
    BALL, IDENTITY, Rng, answer, handle, meshes_of, number, pose, shape, shape_sets_of, single_shapes,
    sphere_sets_of,
};

/// Adds a hit to the list behind `user`, and stops at the length behind it.
unsafe extern "C" fn collect(user: *mut c_void, hit: *const simdop_scene_hit) -> c_int {
    // SAFETY: the tests pass such a list.
    let (list, most) = unsafe { &mut *user.cast::<(Vec<simdop_scene_hit>, usize)>() };
    // SAFETY: the library passes a valid hit.
    list.push(unsafe { *hit });
    c_int::from(list.len() == *most)
}

fn hits(scene: &simdop_scene, margin: f64, most: usize) -> (Vec<simdop_scene_hit>, simdop_scene_hits) {
    let mut found = (Vec::new(), most);
    let user = (&raw mut found).cast();
    // SAFETY: the list is what the callback expects.
    let came_to = answer(|hits| unsafe {
        simdop_scene_each_hit(Some(scene), margin, SIMDOP_NO_BUDGET, Some(collect), user, hits)
    });
    let came_to = came_to.unwrap();
    (found.0, came_to)
}

fn assert_hits(c: &simdop_scene_hit, rust: Option<SceneHit>) {
    let none = SIMDOP_NO_PRIMITIVE;
    let expected = rust.map_or((SIMDOP_NO_BODY, SIMDOP_NO_BODY, none, none), |hit| {
        (hit.a.to_bits(), hit.b.to_bits(), hit.pair.a, hit.pair.b)
    });
    assert_eq!((c.a, c.b, c.pair.a, c.pair.b), expected);
}

/// Runs every query through both interfaces.
fn compare<S: Storage>(
    c: &simdop_scene,
    rust: &Scene<'_, Node16<18, S>>,
    rng: &mut Rng,
    verdicts: &mut [u32; 3],
) {
    let margin = rng.range(0.0, 0.2);
    for budget in [SIMDOP_NO_BUDGET, 2] {
        let query = Query::new(Isa::detect()).with_budget(budget);
        for (answer, expected) in [
            (answer(|answer| simdop_scene_collide(Some(c), budget, answer)), rust.collide(&query)),
            (
                answer(|answer| simdop_scene_within(Some(c), margin, budget, answer)),
                rust.within(&query, margin),
            ),
        ] {
            let (answer, expected) = (answer.unwrap(), expected.unwrap());
            let verdict = match expected.verdict {
                SceneVerdict::Free => simdop_verdict::Free,
                SceneVerdict::Hit(_) => simdop_verdict::Hit,
                SceneVerdict::Unknown => simdop_verdict::Unknown,
            };
            assert_eq!(answer.verdict, verdict);
            assert_hits(&answer.hit, expected.hit());
            assert_eq!((answer.pairs, answer.stats.visits), (expected.pairs, expected.stats.visits));
            verdicts[verdict as usize] += 1;
        }
        let (tolerance, cutoff) = (*rng.pick(&[0.0, 0.1]), *rng.pick(&[0.5, f64::INFINITY]));
        let near = answer(|near| simdop_scene_clearance(Some(c), tolerance, cutoff, budget, near)).unwrap();
        let expected = rust.clearance(&query, tolerance, cutoff).unwrap();
        assert_eq!([near.lower, near.upper], [expected.lower, expected.upper]);
        let is_complete = near.completion == simdop_completion::Complete;
        assert_eq!(is_complete, expected.completion == Completion::Complete);
        assert_hits(&near.hit, expected.witness.map(|witness| witness.hit));
        let points = expected.witness.map(|witness| [witness.a, witness.b]);
        assert!(points.is_none_or(|points| points == [near.point_a, near.point_b]));
        assert_eq!((near.pairs, near.stats.visits), (expected.pairs, expected.stats.visits));
        // A depth without a budget takes long where nothing is optimised.
        let budget = budget.min(200);
        let near =
            answer(|near| simdop_scene_signed_clearance(Some(c), tolerance, cutoff, budget, near)).unwrap();
        let expected = rust.signed_clearance(&query.with_budget(budget), tolerance, cutoff).unwrap();
        assert_eq!([near.lower, near.upper], [expected.lower, expected.upper]);
        assert_hits(&near.hit, expected.witness.map(|witness| witness.hit));
        let points = expected.witness.map(|witness| [witness.a, witness.b, witness.normal]);
        assert!(points.is_none_or(|points| points == [near.point_a, near.point_b, near.normal]));
    }

    let mut expected = Vec::new();
    let visit = |hit| {
        expected.push(hit);
        ControlFlow::Continue(())
    };
    let _ = rust.for_each_hit(&Query::new(Isa::detect()), margin, visit).unwrap();
    let (all, came_to) = hits(c, margin, usize::MAX);
    assert_eq!((all.len(), came_to.completion), (expected.len(), simdop_completion::Complete));
    all.iter().zip(&expected).for_each(|(hit, expected)| assert_hits(hit, Some(*expected)));
    if let [first, ..] = all[..] {
        let (some, came_to) = hits(c, margin, 1);
        assert_eq!((some, came_to.completion), (vec![first], simdop_completion::Stopped));
    }
}

#[test]
fn scenes_answer_as_the_librarys() {
    scenes_of::<Fixed>();
    scenes_of::<Half>();
}

fn scenes_of<S: Storage>() {
    let mut rng = Rng::new(3);
    let (meshes, spheres) = (meshes_of::<S>(&mut rng), sphere_sets_of::<S>(&mut rng));
    let meshes = meshes.iter().map(|body| (body.c, Body::new(body.rust.view())));
    let spheres = spheres.iter().map(|body| (body.c, Body::new(body.rust.view())));
    let (sets, shapes) = (shape_sets_of::<S>(&mut rng), single_shapes(&mut rng));
    let sets = sets.iter().map(|body| (body.c, Body::new(body.rust.view())));
    let shapes = shapes.iter().map(|body| (body.c, Body::new(body.rust)));
    let bodies: Vec<_> = meshes.chain(spheres).chain(sets).chain(shapes).collect();
    let mut verdicts = [0; 3];
    for _ in 0..30 {
        let mut c = handle(|scene| simdop_scene_create_as(number::<S>(), scene)).unwrap();
        let mut rust = Scene::new();
        for step in 0..60 {
            let ids: Vec<BodyId> = rust.ids().collect();
            let [id, other] = [0; 2].map(|_| match ids[..] {
                [] => BodyId::from_bits(rng.u64()),
                _ => *rng.pick(&ids),
            });
            let [c_id, c_other] = [id, other].map(BodyId::to_bits);
            let (c_world, world) = pose(&mut rng);
            let (scene, choice) = (Some(&mut *c), rng.below(10));
            // Both succeed, or both fail.
            let (error, expected) = match if step < 5 { 0 } else { choice } {
                0..=2 => {
                    let (c_body, body) = rng.pick(&bodies).clone();
                    let (radius, is_fixed) = (rng.range(0.0, 0.1), rng.below(4) == 0);
                    let groups = Groups { of: rng.u64() as u32 & 7, against: rng.u64() as u32 & 7 };
                    let role = simdop_role {
                        radius,
                        is_fixed: c_int::from(is_fixed),
                        groups: groups.of,
                        against: groups.against,
                    };
                    let body = body.with_radius(radius).with_groups(groups);
                    let body = if is_fixed { body.fixed() } else { body };
                    let inserted = rust.insert(body, &world).unwrap();
                    let id = answer(|id| {
                        simdop_scene_insert(scene, Some(c_body), Some(&role), Some(&c_world), id)
                    });
                    assert_eq!(id, Ok(inserted.to_bits()));
                    continue;
                }
                3..=5 => (simdop_scene_place(scene, c_id, Some(&c_world)), rust.place(id, &world).is_ok()),
                6 => (simdop_scene_attach(scene, c_id, c_other), rust.attach(id, other).is_ok()),
                7 => (simdop_scene_detach(scene, c_id), rust.detach(id).is_ok()),
                8 => {
                    let is_asked = rng.below(2) == 0;
                    if is_asked {
                        (
                            simdop_scene_forbid_collision(scene, c_id, c_other),
                            rust.forbid_collision(id, other).is_ok(),
                        )
                    } else {
                        (
                            simdop_scene_allow_collision(scene, c_id, c_other),
                            rust.allow_collision(id, other).is_ok(),
                        )
                    }
                }
                _ => (simdop_scene_remove(scene, c_id), rust.remove(id).is_ok()),
            };
            assert_eq!(error == simdop_error::None, expected, "{error:?}");
            compare(&c, &rust, &mut rng, &mut verdicts);
        }
        simdop_scene_destroy(Some(c));
    }
    assert!(verdicts.iter().all(|&count| count > 100), "{verdicts:?}");
}

fn insert(
    scene: &mut simdop_scene,
    body: &'static simdop_body,
    radius: f64,
) -> Result<simdop_body_id, simdop_error> {
    let role = simdop_role { radius, ..simdop_role_default() };
    answer(|id| simdop_scene_insert(Some(scene), Some(body), Some(&role), Some(&IDENTITY), id))
}

/// A shape has no storage: it goes into each scene, and is of fixed point where nothing else decides.
#[test]
fn a_scene_of_a_chosen_storage_takes_shapes_first() {
    let (fixed, half) = (meshes_of::<Fixed>(&mut Rng::new(6))[0].c, meshes_of::<Half>(&mut Rng::new(6))[0].c);
    let shape: &'static simdop_body = Box::leak(shape(&BALL).unwrap());
    for (chosen, same, other) in [
        (None, fixed, half),
        (Some(simdop_storage::Fixed), fixed, half),
        (Some(simdop_storage::Half), half, fixed),
    ] {
        let mut scene = handle(|scene| match chosen {
            None => simdop_scene_create(scene),
            Some(storage) => simdop_scene_create_as(storage as c_int, scene),
        });
        let scene = scene.as_mut().unwrap();
        if chosen.is_some() {
            assert_eq!(insert(scene, other, 0.0), Err(simdop_error::OtherStorage));
        }
        insert(scene, shape, 0.0).unwrap();
        assert_eq!(insert(scene, other, 0.0), Err(simdop_error::OtherStorage));
        insert(scene, same, 0.0).unwrap();
        insert(scene, shape, 0.0).unwrap();
    }
    // After a body of half floats, too.
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    insert(&mut scene, half, 0.0).unwrap();
    insert(&mut scene, shape, 0.0).unwrap();
    assert_eq!(insert(&mut scene, fixed, 0.0), Err(simdop_error::OtherStorage));
    simdop_scene_destroy(Some(scene));
}

/// The first body decides the storage of a scene for good, since ids outlive their bodies.
#[test]
fn a_scene_has_bodies_of_one_storage() {
    let fixed = meshes_of::<Fixed>(&mut Rng::new(6))[0].c;
    let half = meshes_of::<Half>(&mut Rng::new(6))[0].c;
    let other = Err(simdop_error::OtherStorage);
    for [first, second] in [[fixed, half], [half, fixed]] {
        let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
        // What is refused decides nothing.
        assert_eq!(insert(&mut scene, second, f64::NAN), Err(simdop_error::SceneRadius));
        let id = insert(&mut scene, first, 0.0).unwrap();
        assert_eq!(insert(&mut scene, second, 0.0), other);
        assert_eq!(simdop_scene_remove(Some(&mut scene), id), simdop_error::None);
        assert_eq!(insert(&mut scene, second, 0.0), other);
        let again = insert(&mut scene, first, 0.0).unwrap();
        assert_ne!(again, id);
        assert_eq!(simdop_scene_remove(Some(&mut scene), id), simdop_error::SceneNoSuchBody);
        simdop_scene_destroy(Some(scene));
    }
}

#[test]
fn the_default_role_is_asked_against_all() {
    let role = simdop_role_default();
    assert_eq!((role.radius, role.is_fixed), (0.0, 0));
    assert_eq!(Groups { of: role.groups, against: role.against }, Groups::ALL);
}

/// The code of a world pose, by loops over its entries.
fn code_of(world: &simdop_pose) -> simdop_error {
    let rows = &world.rows;
    let product =
        |i: usize, j: usize| (rows[i][0] * rows[j][0] + rows[i][1] * rows[j][1]) + rows[i][2] * rows[j][2];
    let is_rotation = |tolerance: f64| {
        (0..9).all(|at| {
            let (i, j) = (at / 3, at % 3);
            (product(i, j) - if i == j { 1.0 } else { 0.0 }).abs() <= tolerance
        })
    };
    let is_near = |most: f64| rows.iter().all(|row| row[3].abs() <= most);
    let minor = |j: usize, k: usize| rows[1][j] * rows[2][k] - rows[1][k] * rows[2][j];
    let determinant = rows[0][0] * minor(1, 2) + rows[0][1] * minor(2, 0) + rows[0][2] * minor(0, 1);
    if !rows.iter().flatten().all(|x| x.is_finite()) {
        simdop_error::PoseNotFinite
    } else if !is_near(2_f64.powi(300)) {
        simdop_error::PoseTooFar
    } else if !is_rotation(1e-4) {
        simdop_error::PoseNotOrthonormal
    } else if determinant < 0.0 {
        simdop_error::PoseMirrored
    } else if !is_rotation(1.5e-5) {
        simdop_error::PoseNotOrthonormal
    } else if !is_near(2_f64.powi(298)) {
        simdop_error::PoseTooFar
    } else {
        simdop_error::None
    }
}

#[test]
fn poses_are_accepted_one_by_one_as_by_all() {
    let body: &'static simdop_body = Box::leak(shape(&BALL).unwrap());
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let ids = [0, 1].map(|_| insert(&mut scene, body, 0.0).unwrap());
    let (mut rng, mut seen) = (Rng::new(45), std::collections::BTreeMap::new());
    let entries = [f64::NAN, f64::INFINITY, -f64::INFINITY, 0.0, -0.0, 1.0, -1.0, 1e200, 1e-320];
    let scales = [0.0, 1e-16, 7e-6, 7.5e-6, 8e-6, 1e-5, 4.9e-5, 5e-5, 5.1e-5, 1e-4, 0.3];
    let translations = [300, 298, 297].map(|power| 2_f64.powi(power));
    for _ in 0..20_000 {
        let (good, (mut world, _)) = (pose(&mut rng).0, pose(&mut rng));
        let scale = *rng.pick(&scales);
        match rng.below(8) {
            0 => world.rows[rng.below(3) as usize][rng.below(4) as usize] = *rng.pick(&entries),
            1 => world.rows[rng.below(3) as usize][3] = *rng.pick(&translations) * rng.range(0.9, 1.1),
            2 => world.rows[rng.below(3) as usize][3] = *rng.pick(&translations),
            3 => {
                let row = &mut world.rows[rng.below(3) as usize];
                (row[0], row[1], row[2]) = (-row[0], -row[1], -row[2]);
            }
            4 => world.rows.iter_mut().for_each(|row| (0..3).for_each(|j| row[j] *= 1.0 + scale)),
            _ => world.rows[rng.below(3) as usize][rng.below(3) as usize] += rng.range(-1.0, 1.0) * scale,
        }
        let expected = code_of(&world);
        *seen.entry(expected as i32).or_insert(0) += 1;
        let one = simdop_scene_place(Some(&mut scene), ids[1], Some(&world));
        let worlds = [good, world];
        // SAFETY: there are two of each.
        let all = unsafe { simdop_scene_place_all(Some(&mut scene), ids.as_ptr(), worlds.as_ptr(), 2) };
        assert_eq!([one, all], [expected; 2], "{world:?}");
        let [first, second] =
            ids.map(|id| answer(|to| simdop_scene_world_pose(Some(&scene), id, to)).unwrap());
        assert_eq!(first, good);
        assert!(expected != simdop_error::None || second == world);
    }
    assert!(seen.len() == 5 && seen.values().all(|&count| count > 500), "{seen:?}");
}
