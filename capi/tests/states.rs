//! Many configurations in one call: the answers are those of the library, and of one configuration at a time.

mod support;

use simdop::isa::Isa;
use simdop::low_level::key::Fixed;
use simdop::node::Aabb16;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::scene::{Body, BodyId, PairClass, Scene};
use simdop_capi::*;
use std::mem::MaybeUninit;
use support::robot::Parts;
use support::{IDENTITY, Rng, answer, handle, meshes_of, pose};

/// A scene of three bodies of a robot and two others, in both interfaces.
struct Twins {
    c: Box<simdop_scene>,
    rust: Scene<'static, simdop::node::Node16<18>>,
    moving: Vec<simdop_body_id>,
}

impl Twins {
    fn new(rng: &mut Rng) -> Self {
        let meshes: &'static [_] = Vec::leak(meshes_of::<Fixed>(rng));
        let mut c = handle(|scene| simdop_scene_create(scene)).unwrap();
        let (mut rust, mut moving) = (Scene::new(), Vec::new());
        for (i, mesh) in meshes.iter().take(5).enumerate() {
            let (c_world, world) = pose(rng);
            let role = simdop_role { is_fixed: i32::from(i > 2), ..simdop_role_default() };
            let c_body = Some(mesh.c);
            let id = answer(|id| simdop_scene_insert(Some(&mut c), c_body, Some(&role), Some(&c_world), id))
                .unwrap();
            let body = Body::new(mesh.rust.view());
            let inserted = rust.insert(if i > 2 { body.fixed() } else { body }, &world).unwrap();
            assert_eq!(id, inserted.to_bits());
            if i < 3 {
                moving.push(id);
            }
        }
        Self { c, rust, moving }
    }
}

/// Which configurations are free, by poses.
fn by_poses(
    scene: &mut simdop_scene,
    moving: &[simdop_body_id],
    poses: &[simdop_pose],
    count: usize,
    budget: u64,
) -> Result<(Vec<u8>, simdop_states_answer), simdop_error> {
    let mut free = vec![7; count];
    // SAFETY: the lengths are those of the vectors, and there is a pose of each body for each configuration.
    let found = answer(|answer| unsafe {
        let (scene, free) = (Some(scene), free.as_mut_ptr());
        simdop_scene_check_states(
            scene,
            moving.as_ptr(),
            moving.len(),
            poses.as_ptr(),
            count,
            budget,
            free,
            answer,
        )
    })?;
    Ok((free, found))
}

#[test]
fn configurations_are_free_as_in_the_library_and_one_by_one() {
    let mut rng = Rng::new(11);
    let (mut free_in_all, mut all) = (0, 0);
    for count in [1_usize, 15, 16, 17, 40] {
        for budget in [SIMDOP_NO_BUDGET, 40] {
            let Twins { mut c, mut rust, moving } = Twins::new(&mut rng);
            let spread = |(c, _): (simdop_pose, Pose)| {
                let mut wide = c;
                wide.rows.iter_mut().for_each(|row| row[3] *= 3.0);
                (wide, Pose::from_rows(wide.rows).unwrap())
            };
            let (c_poses, poses): (Vec<_>, Vec<_>) = (0..3 * count).map(|_| spread(pose(&mut rng))).unzip();
            let ids: Vec<_> = moving.iter().map(|id| BodyId::from_bits(*id)).collect();
            let query = Query::new(Isa::detect()).with_budget(budget);
            let mut boxes = vec![Aabb16::EMPTY; rust.room()];
            let mut bits = vec![0; count.div_ceil(16)];
            let expected = rust.check_states(&query, &ids, &poses, &mut boxes, &mut bits).unwrap();

            let (free, found) = by_poses(&mut c, &moving, &c_poses, count, budget).unwrap();
            assert_eq!((found.pairs, found.stats.visits), (expected.pairs, expected.stats.visits));
            let is_complete = expected.completion == simdop::query::Completion::Complete;
            assert_eq!(is_complete, found.completion == simdop_completion::Complete);
            assert_eq!(found.free, free.iter().filter(|free| **free == 1).count());
            for (i, free) in free.iter().enumerate() {
                assert_eq!(u16::from(*free), bits[i / 16] >> (i % 16) & 1);
                if budget != SIMDOP_NO_BUDGET {
                    continue;
                }
                let worlds = &c_poses[3 * i..];
                // SAFETY: there are three of each.
                let error =
                    unsafe { simdop_scene_place_all(Some(&mut c), moving.as_ptr(), worlds.as_ptr(), 3) };
                assert_eq!(error, simdop_error::None);
                let one = answer(|answer| simdop_scene_collide(Some(&c), SIMDOP_NO_BUDGET, answer)).unwrap();
                assert_eq!(one.verdict == simdop_verdict::Free, *free == 1);
                (free_in_all, all) = (free_in_all + usize::from(*free), all + 1);
            }
            simdop_scene_destroy(Some(c));
        }
    }
    assert!(0 < free_in_all && free_in_all < all, "{free_in_all} of {all}");
}

#[test]
fn configurations_of_a_robot_are_those_of_its_poses() {
    let mut rng = Rng::new(12);
    for _ in 0..10 {
        let parts = Parts::random(&mut rng);
        let mut robot = parts.robot().unwrap();
        let Twins { mut c, moving, .. } = Twins::new(&mut rng);
        let values: Vec<f64> = (0..35).flat_map(|_| parts.values(&mut rng)).collect();
        let mut poses = vec![IDENTITY; 3 * 35];
        for (values, poses) in values.chunks(parts.limits.len()).zip(poses.chunks_mut(3)) {
            // SAFETY: there is a value for each variable, and room for three bodies.
            let error = unsafe { simdop_robot_poses(Some(&mut robot), values.as_ptr(), poses.as_mut_ptr()) };
            assert_eq!(error, simdop_error::None);
        }
        let expected = by_poses(&mut c, &moving, &poses, 35, SIMDOP_NO_BUDGET).unwrap();
        let (mut free, count) = (vec![7; 35], moving.len());
        // SAFETY: the lengths are those of the vectors, and there is a value for each variable and configuration.
        let found = answer(|answer| unsafe {
            let (scene, ids, values) = (Some(&mut *c), moving.as_ptr(), values.as_ptr());
            let (robot, to) = (Some(&*robot), free.as_mut_ptr());
            simdop_scene_check_joint_states(
                scene,
                ids,
                count,
                robot,
                values,
                35,
                SIMDOP_NO_BUDGET,
                to,
                answer,
            )
        });
        assert_eq!((free, found.unwrap()), expected);
        simdop_scene_destroy(Some(c));
        simdop_robot_free(Some(robot));
    }
}

#[test]
fn pairs_have_the_librarys_classes_and_poses_are_the_librarys() {
    let (mut rng, mut classes) = (Rng::new(13), [0; 4]);
    for _ in 0..8 {
        let parts = Parts::random(&mut rng);
        let robot = parts.robot().unwrap();
        let Twins { mut c, mut rust, moving } = Twins::new(&mut rng);
        let ids: Vec<_> = rust.ids().collect();
        for (a, b) in [(0, 1), (1, 2), (0, 4)] {
            let (query, moved) = (Query::new(Isa::detect()), ids[..3].to_vec());
            let expected = parts
                .with_kinematics(|robot| rust.classify_pair(&query, &moved, robot, (ids[a], ids[b]), 200))
                .unwrap();
            let variables = parts.limits.len();
            let [mut meeting, mut free] = [(); 2].map(|()| vec![MaybeUninit::new(9.0); variables]);
            // SAFETY: there is room for each variable, and the list has its length.
            let report = answer(|report| unsafe {
                let (a, b) = (ids[a].to_bits(), ids[b].to_bits());
                let (meeting, free) = (meeting.as_mut_ptr().cast(), free.as_mut_ptr().cast());
                let (c, robot) = (Some(&mut *c), Some(&*robot));
                simdop_scene_classify_pair(c, moving.as_ptr(), 3, robot, a, b, 200, meeting, free, report)
            });
            let report = report.unwrap();
            let class = match expected.class {
                PairClass::Never => simdop_pair_class::Never,
                PairClass::Always => simdop_pair_class::Always,
                PairClass::Sometimes => simdop_pair_class::Sometimes,
                PairClass::Undecided => simdop_pair_class::Undecided,
            };
            classes[class as usize] += 1;
            assert_eq!((report.pair_class, report.boxes), (class, expected.boxes));
            assert_eq!(report.samples, expected.samples);
            for (has, found, expected) in
                [(report.has_meeting, meeting, expected.meeting), (report.has_free, free, expected.free)]
            {
                assert_eq!(has != 0, expected.is_some());
                // SAFETY: written before the call at the latest.
                let found: Vec<f64> = found.iter().map(|value| unsafe { value.assume_init() }).collect();
                assert_eq!(found, expected.unwrap_or_else(|| vec![9.0; variables]));
            }
        }
        for id in &ids {
            let found = answer(|world| simdop_scene_world_pose(Some(&c), id.to_bits(), world)).unwrap();
            assert_eq!(&Pose::from_rows(found.rows).unwrap(), rust.world_pose(*id).unwrap());
            for other in &ids {
                let asked =
                    answer(|asked| simdop_scene_is_asked(Some(&c), id.to_bits(), other.to_bits(), asked));
                assert_eq!(asked.map(|asked| asked != 0).ok(), rust.is_asked(*id, *other).ok());
            }
        }
        simdop_scene_destroy(Some(c));
        simdop_robot_free(Some(robot));
    }
    assert!(classes[simdop_pair_class::Sometimes as usize] > 0, "{classes:?}");
}
