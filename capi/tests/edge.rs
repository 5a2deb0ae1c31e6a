//! The C functions give the library's answers about motions, for each kind of motion.

mod support;

use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::motion::{CarriedBall, JointMotion, LinkFrame, Motion, Screw, ScrewMotion};
use simdop::node::Node16;
use simdop::pose::{Pose, PoseError};
use simdop::query::Query;
use simdop::scene::{Body, BodyId, MotionAnswer, MotionHit, MotionMemory, MotionVerdict, Scene};
use simdop_capi::*;
use std::ffi::{c_int, c_void};
use std::num::NonZeroU32;
use support::robot::Parts;
use support::{Rng, answer, handle, meshes_of, number, pose, shape_sets_of, single_shapes, sphere_sets_of};

/// Bodies that each move by a screw of their own.
struct Screws(Vec<(Screw, Pose)>);

impl Motion for Screws {
    fn bodies(&self) -> usize {
        self.0.len()
    }

    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError> {
        for (pose, (screw, start)) in poses.iter_mut().zip(&self.0) {
            *pose = screw.at(time, start)?;
        }
        Ok(())
    }

    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64 {
        let (screw, start) = self.0[i];
        ScrewMotion::new(screw, &[start]).motion_bound(0, ball, span)
    }
}

/// A motion that the C callbacks evaluate.
struct User<'m> {
    motion: &'m mut dyn Motion,
    /// Calls of `go_to` until it stops the query.
    left: u32,
}

fn rows(pose: &Pose) -> simdop_pose {
    let (rows, t) = (pose.rows(), pose.translation());
    simdop_pose { rows: [0, 1, 2].map(|i| [rows[i][0], rows[i][1], rows[i][2], t[i]]) }
}

unsafe extern "C" fn go_to(user: *mut c_void, time: f64, poses: *mut simdop_pose) -> c_int {
    // SAFETY: the tests pass such a motion.
    let user = unsafe { &mut *user.cast::<User<'_>>() };
    if user.left == 0 {
        return 7;
    }
    user.left -= 1;
    let mut at = vec![Pose::IDENTITY; user.motion.bodies()];
    user.motion.go_to(time, &mut at).unwrap();
    for (i, pose) in at.iter().enumerate() {
        // SAFETY: there is room for a pose of each body.
        unsafe { poses.wrapping_add(i).write(rows(pose)) };
    }
    0
}

fn ball(centre: *const f64, radius: f64) -> CarriedBall {
    // SAFETY: the library passes three numbers.
    CarriedBall { centre: unsafe { centre.cast::<[f64; 3]>().read() }, radius }
}

unsafe extern "C" fn path(user: *mut c_void, body: usize, centre: *const f64, radius: f64, span: f64) -> f64 {
    // SAFETY: the tests pass such a motion.
    let user = unsafe { &*user.cast::<User<'_>>() };
    user.motion.motion_bound(body, &ball(centre, radius), span)
}

unsafe extern "C" fn motion_bound_between(
    user: *mut c_void,
    a: usize,
    centre_a: *const f64,
    radius_a: f64,
    b: usize,
    centre_b: *const f64,
    radius_b: f64,
    span: f64,
) -> f64 {
    // SAFETY: the tests pass such a motion.
    let user = unsafe { &*user.cast::<User<'_>>() };
    user.motion.motion_bound_between((a, &ball(centre_a, radius_a)), (b, &ball(centre_b, radius_b)), span)
}

fn motion(user: &mut User<'_>) -> simdop_motion {
    let user = (&raw mut *user).cast();
    simdop_motion {
        user,
        go_to: Some(go_to),
        path: Some(path),
        motion_bound_between: Some(motion_bound_between),
    }
}

fn edge(
    scene: &mut simdop_scene,
    ids: &[u64],
    motion: &simdop_motion,
    resolution: f64,
    budget: u64,
) -> Result<simdop_motion_answer, simdop_error> {
    // SAFETY: the ids are those of the slice; the motion is that of `motion`, or does not use `user`.
    answer(|answer| unsafe {
        simdop_scene_check_motion(
            Some(scene),
            ids.as_ptr(),
            ids.len(),
            Some(motion),
            resolution,
            budget,
            answer,
        )
    })
}

fn sampled(
    scene: &mut simdop_scene,
    ids: &[u64],
    motion: &simdop_motion,
    parts: u32,
) -> Result<simdop_motion_answer, simdop_error> {
    let budget = SIMDOP_NO_BUDGET;
    // SAFETY: as for `edge`.
    answer(|answer| unsafe {
        simdop_scene_check_motion_discrete(
            Some(scene),
            ids.as_ptr(),
            ids.len(),
            Some(motion),
            parts,
            budget,
            answer,
        )
    })
}

fn assert_same(c: &simdop_motion_answer, rust: &MotionAnswer) {
    let no_hit = (SIMDOP_NO_BODY, SIMDOP_NO_BODY, SIMDOP_NO_PRIMITIVE, SIMDOP_NO_PRIMITIVE);
    let bits = |numbers: [f64; 3]| numbers.map(f64::to_bits);
    let (verdict, hit, times) = match rust.verdict {
        MotionVerdict::Free => (simdop_motion_verdict::Free, no_hit, [f64::NAN; 3]),
        MotionVerdict::Hit { hit, time } => {
            let hit = (hit.a.to_bits(), hit.b.to_bits(), hit.pair.a, hit.pair.b);
            (simdop_motion_verdict::Hit, hit, [time, f64::NAN, f64::NAN])
        }
        MotionVerdict::Unresolved { from, to } => {
            (simdop_motion_verdict::Unresolved, no_hit, [f64::NAN, from, to])
        }
    };
    assert_eq!((c.verdict, (c.hit.a, c.hit.b, c.hit.pair.a, c.hit.pair.b)), (verdict, hit));
    assert_eq!(bits([c.time, c.from, c.to]), bits(times));
    assert_eq!((c.times, c.pairs, c.stats.visits), (rust.times, rust.pairs, rust.stats.visits));
}

struct Memory {
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
}

impl Memory {
    fn new() -> Self {
        Self { poses: vec![Pose::IDENTITY; 8], waiting: vec![MotionHit::EMPTY; SIMDOP_EDGE_ROOM] }
    }

    fn lend(&mut self) -> MotionMemory<'_> {
        MotionMemory { poses: &mut self.poses, waiting: &mut self.waiting }
    }
}

/// A scene, through both interfaces: three moving bodies, two attached to the last, and others that stand still.
fn scene<S: Storage>(
    rng: &mut Rng,
) -> (Box<simdop_scene>, Scene<'static, Node16<18, S>>, Vec<BodyId>, Vec<Pose>) {
    let (meshes, spheres) = (meshes_of::<S>(rng), sphere_sets_of::<S>(rng));
    let meshes = meshes.into_iter().map(|body| (body.c, Body::new(Box::leak(Box::new(body.rust)).view())));
    let spheres = spheres.into_iter().map(|body| (body.c, Body::new(Box::leak(Box::new(body.rust)).view())));
    let (sets, shapes) = (shape_sets_of::<S>(rng), single_shapes(rng));
    let sets = sets.into_iter().map(|body| (body.c, Body::new(Box::leak(Box::new(body.rust)).view())));
    // A half-space, the last one, certifies no motion.
    let shapes = shapes.into_iter().take(5).map(|body| (body.c, Body::new(body.rust)));
    let bodies: Vec<_> = meshes.chain(spheres).chain(sets).chain(shapes).collect();
    let mut c = handle(|scene| simdop_scene_create_as(number::<S>(), scene)).unwrap();
    let mut rust = Scene::new();
    let (mut ids, mut places) = (Vec::new(), Vec::new());
    for i in 0..8 {
        let (c_body, body) = rng.pick(&bodies).clone();
        let (mut far, _) = pose(rng);
        far.rows.iter_mut().for_each(|row| row[3] *= 3.0);
        let world = Pose::from_rows(far.rows).unwrap();
        let (radius, is_fixed) = (rng.range(0.0, 0.05), i > 4);
        let role = simdop_role { radius, is_fixed: c_int::from(is_fixed), ..simdop_role_default() };
        let body = if is_fixed { body.fixed() } else { body };
        let id = rust.insert(body.with_radius(radius), &world).unwrap();
        let c_id = answer(|id| simdop_scene_insert(Some(&mut c), Some(c_body), Some(&role), Some(&far), id));
        assert_eq!(c_id, Ok(id.to_bits()));
        ids.push(id);
        places.push(world);
    }
    for i in [3, 4] {
        rust.attach(ids[i], ids[2]).unwrap();
        rust.allow_collision(ids[i], ids[2]).unwrap();
        let [held, hand] = [i, 2].map(|i| ids[i].to_bits());
        assert_eq!(simdop_scene_attach(Some(&mut c), held, hand), simdop_error::None);
        assert_eq!(simdop_scene_allow_collision(Some(&mut c), held, hand), simdop_error::None);
    }
    (c, rust, ids, places)
}

#[test]
fn edges_answer_as_the_librarys() {
    edges_of::<Fixed>();
    edges_of::<Half>();
}

fn edges_of<S: Storage>() {
    let mut rng = Rng::new(5);
    let (mut verdicts, mut memory) = ([0; 3], Memory::new());
    for round in 0..120 {
        let (mut c, mut rust, ids, places) = scene::<S>(&mut rng);
        let share = if round % 2 == 0 { 1.0 } else { 0.05 };
        let mut screw = || {
            let mut point = || [0; 3].map(|_| rng.range(-1.0, 1.0));
            let (point, direction) = (point(), point());
            let (angle, advance) = (rng.range(-3.0, 3.0) * share, rng.range(-2.0, 2.0) * share);
            Screw::new(point, direction, angle, advance).unwrap()
        };
        let mut own = Screws(places[..3].iter().map(|&start| (screw(), start)).collect());
        let mut shared = ScrewMotion::new(screw(), &places[..3]);
        let moving = &ids[..3];
        let c_ids: Vec<_> = moving.iter().map(|id| id.to_bits()).collect();
        for budget in [SIMDOP_NO_BUDGET, 5] {
            let query = Query::new(Isa::detect()).with_budget(budget);
            let expected = rust.check_motion(&query, moving, &mut own, 1e-3, &mut memory.lend()).unwrap();
            let mut user = User { motion: &mut own, left: u32::MAX };
            let between = motion(&mut user);
            let sum = simdop_motion { motion_bound_between: None, ..between };
            for motion in [between, sum] {
                assert_same(&edge(&mut c, &c_ids, &motion, 1e-3, budget).unwrap(), &expected);
            }
            verdicts[edge(&mut c, &c_ids, &sum, 1e-3, budget).unwrap().verdict as usize] += 1;

            // Only `motion_bound_between` shows that bodies which move as one do not meet.
            let expected = rust.check_motion(&query, moving, &mut shared, 1e-3, &mut memory.lend()).unwrap();
            let mut user = User { motion: &mut shared, left: u32::MAX };
            assert_same(&edge(&mut c, &c_ids, &motion(&mut user), 1e-3, budget).unwrap(), &expected);
        }

        let parts = NonZeroU32::new(rng.int(1, 20) as u32).unwrap();
        let query = Query::new(Isa::detect());
        let expected =
            rust.check_motion_discrete(&query, moving, &mut own, parts, &mut memory.lend()).unwrap();
        let mut user = User { motion: &mut own, left: u32::MAX };
        let by_poses = simdop_motion { path: None, ..motion(&mut user) };
        assert_same(&sampled(&mut c, &c_ids, &by_poses, parts.get()).unwrap(), &expected);

        let (to, from) = (pose(&mut rng), [places[2]]);
        let mut screw = ScrewMotion::new(Screw::between(&from[0], &to.1).unwrap(), &from);
        let expected = rust.check_motion(&query, &ids[2..3], &mut screw, 1e-3, &mut memory.lend()).unwrap();
        let (from, id) = (rows(&from[0]), ids[2].to_bits());
        let made = answer(|answer| {
            let (from, to) = (Some(&from), Some(&to.0));
            simdop_scene_check_screw(Some(&mut c), id, from, to, 1e-3, SIMDOP_NO_BUDGET, answer)
        });
        let made = made.unwrap();
        assert_same(&made, &expected);
        verdicts[made.verdict as usize] += 1;
        simdop_scene_destroy(Some(c));
    }
    assert!(verdicts.iter().all(|&count| count > 10), "{verdicts:?}");
}

#[test]
fn straight_edges_answer_as_the_librarys() {
    straight_edges_of::<Fixed>();
    straight_edges_of::<Half>();
}

fn straight_edges_of<S: Storage>() {
    let mut rng = Rng::new(6);
    let (mut verdicts, mut memory) = ([0; 3], Memory::new());
    let (mut values, mut links) = ([0.0; 8], [LinkFrame::EMPTY; 8]);
    for round in 0..200 {
        let (mut c, mut rust, ids, _) = scene::<S>(&mut rng);
        let c_ids: Vec<_> = ids[..3].iter().map(|id| id.to_bits()).collect();
        // Robots with more and with fewer joints in one scene.
        for share in [1.0, 0.02] {
            let parts = Parts::random(&mut rng);
            let (from, to) = (parts.values(&mut rng), parts.values(&mut rng));
            let to: Vec<_> = from.iter().zip(to).map(|(from, to)| from + share * (to - from)).collect();
            let robot = parts.robot().unwrap();
            let budget = if round % 4 == 0 { 5 } else { SIMDOP_NO_BUDGET };
            let query = Query::new(Isa::detect()).with_budget(budget);
            let expected = parts.with_kinematics(|kinematics| {
                let ends = [&from[..], &to];
                let mut motion = JointMotion::new(kinematics, ends, &mut values, &mut links).unwrap();
                rust.check_motion(&query, &ids[..3], &mut motion, 1e-3, &mut memory.lend()).unwrap()
            });
            let (c, ids, robot) = (Some(&mut *c), c_ids.as_ptr(), Some(&*robot));
            // SAFETY: there are three ids, and a value for each variable.
            let made = answer(|answer| unsafe {
                let (from, to) = (from.as_ptr(), to.as_ptr());
                simdop_scene_check_joint_motion(c, ids, 3, robot, from, to, 1e-3, budget, answer)
            });
            let made = made.unwrap();
            assert_same(&made, &expected);
            verdicts[made.verdict as usize] += 1;
        }
        simdop_scene_destroy(Some(c));
    }
    assert!(verdicts.iter().all(|&count| count > 10), "{verdicts:?}");
}
