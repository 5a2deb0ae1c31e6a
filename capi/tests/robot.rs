//! Robots have the library's poses, allocate nothing after construction, and report faulty descriptions.

mod support;

#[path = "../../tests/support/heap.rs"]
mod heap;

use simdop::construct::OwnedMesh;
use simdop::motion::LinkFrame;
use simdop::pose::Pose;
use simdop_capi::*;
use std::ffi::CStr;
use std::ptr::{null, null_mut};
use support::robot::{Parts, faults, hinge};
use support::{IDENTITY, Rng, answer, handle, solid};

const UNWRITTEN: simdop_pose = simdop_pose { rows: [[7.0; 4]; 3] };

fn message() -> String {
    // SAFETY: it ends with a NUL, and lives until the next failure.
    unsafe { CStr::from_ptr(simdop_last_error()) }.to_str().unwrap().to_owned()
}

fn poses(robot: &mut simdop_robot, values: &[f64]) -> (simdop_error, [simdop_pose; 3]) {
    let mut poses = [UNWRITTEN; 3];
    // SAFETY: the callers pass a value for each variable, and at most three bodies.
    let error = unsafe { simdop_robot_poses(Some(robot), values.as_ptr(), poses.as_mut_ptr()) };
    (error, poses)
}

#[test]
fn bodies_stand_where_the_librarys_do() {
    let mut rng = Rng::new(8);
    for _ in 0..200 {
        let parts = Parts::random(&mut rng);
        let mut robot = parts.robot().unwrap();
        for _ in 0..5 {
            let values = parts.values(&mut rng);
            let mut expected = [Pose::IDENTITY; 3];
            parts.with_kinematics(|kinematics| {
                kinematics.go_to(&values, &mut [LinkFrame::EMPTY; 8], &mut expected).unwrap();
            });
            let (error, poses) = poses(&mut robot, &values);
            assert_eq!(error, simdop_error::None);
            for (pose, expected) in poses.iter().zip(&expected) {
                let (rows, t) = (expected.rows(), expected.translation());
                for (row, (expected, t)) in pose.rows.iter().zip(rows.iter().zip(t)) {
                    let expected = [expected[0], expected[1], expected[2], t];
                    assert_eq!(row.map(f64::to_bits), expected.map(f64::to_bits));
                }
            }
        }
        simdop_robot_free(Some(robot));
    }
}

/// A scene with a bar that a hinge rotates from x towards y.
struct Hall {
    scene: Box<simdop_scene>,
    ids: [simdop_body_id; 1],
    robot: Box<simdop_robot>,
}

impl Hall {
    fn new() -> Self {
        let bar = |sides| Box::leak(solid(&OwnedMesh::cuboid(sides).unwrap().as_mesh()).unwrap());
        let (mut scene, role) = (handle(|scene| simdop_scene_create(scene)).unwrap(), simdop_role_default());
        let mut insert = |body, y: f64| {
            let mut pose = IDENTITY;
            pose.rows[1][3] = y;
            answer(|id| simdop_scene_insert(Some(&mut scene), Some(body), Some(&role), Some(&pose), id))
                .unwrap()
        };
        let ids = [insert(bar([1.0, 0.1, 0.1]), 9.0)];
        let _ = insert(bar([0.1, 0.1, 0.1]), 0.55);
        Self { scene, ids, robot: hinge().robot().unwrap() }
    }

    fn edge(&mut self, count: usize, from: f64, to: f64) -> Result<simdop_motion_verdict, simdop_error> {
        let (scene, ids, robot) = (Some(&mut *self.scene), self.ids.as_ptr(), Some(&*self.robot));
        let (from, to, budget) = (&raw const from, &raw const to, SIMDOP_NO_BUDGET);
        // SAFETY: at most as many ids as there are; the robot has one variable.
        let edge = answer(|answer| unsafe {
            simdop_scene_check_joint_motion(scene, ids, count, robot, from, to, 1e-4, budget, answer)
        });
        edge.map(|edge| edge.verdict)
    }
}

#[test]
fn after_its_first_edge_nothing_is_allocated() {
    let mut hall = Hall::new();
    assert_eq!(hall.edge(1, 0.0, 1.0), Ok(simdop_motion_verdict::Free));
    heap::without_heap("an edge", || {
        assert_eq!(hall.edge(1, 0.0, 2.0), Ok(simdop_motion_verdict::Hit));
        assert_eq!(hall.edge(1, 1.0, -1.0), Ok(simdop_motion_verdict::Free));
    });
    heap::without_heap("forward kinematics", || {
        assert_eq!(poses(&mut hall.robot, &[1.0]).0, simdop_error::None);
    });
}

#[test]
fn what_is_wrong_is_refused() {
    for (error, parts) in faults() {
        assert_eq!(parts.robot().unwrap_err(), error, "{}", message());
    }
    assert!(message().starts_with("body 0: "), "{}", message());

    let mut hall = Hall::new();
    let out = simdop_error::MotionOutOfLimits;
    for value in [-2.1, 2.1, f64::NAN, f64::INFINITY] {
        assert_eq!(poses(&mut hall.robot, &[value]), (out, [UNWRITTEN; 3]));
        assert_eq!(hall.edge(1, value, 0.0), Err(out));
        assert_eq!(hall.edge(1, 0.0, value), Err(out));
    }
    assert_eq!(hall.edge(0, 0.0, 1.0), Err(simdop_error::MotionBodies));
    assert_eq!(hall.edge(1, 0.0, 1.0), Ok(simdop_motion_verdict::Free), "the scene is as good as before");

    // Valid poses each, but their product is out of range.
    let (mut far, mut parts) = (IDENTITY, hinge());
    far.rows[0][3] = 0.75 * 2_f64.powi(300);
    (parts.base, parts.joints[0].origin) = (far, far);
    let mut robot = parts.robot().unwrap();
    assert_eq!(poses(&mut robot, &[0.0]), (simdop_error::PoseTooFar, [UNWRITTEN; 3]));
    hall.robot = robot;
    assert_eq!(hall.edge(1, 0.0, 1.0), Err(simdop_error::PoseTooFar));
}

#[test]
fn without_joints_bodies_stand_on_the_base() {
    let parts = Parts { joints: Vec::new(), limits: Vec::new(), ..hinge() };
    assert_eq!(parts.robot().unwrap_err(), simdop_error::MotionNoSuchLink);
    let bodies = vec![simdop_link_body { link: 0, pose: IDENTITY }];
    let mut robot = Parts { bodies, ..parts }.robot().unwrap();
    assert_eq!(poses(&mut robot, &[]), (simdop_error::None, [IDENTITY, UNWRITTEN, UNWRITTEN]));
}

#[test]
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn null_is_an_error_wherever_it_is_given() {
    let Hall { mut scene, ids, mut robot } = Hall::new();
    let (parts, value, budget) = (hinge(), 0.0, SIMDOP_NO_BUDGET);
    let (base, joints, bodies) = (Some(&parts.base), parts.joints.as_ptr(), parts.bodies.as_ptr());
    let (limits, ids, value) = (parts.limits.as_ptr().cast(), ids.as_ptr(), &raw const value);
    let mut pose = UNWRITTEN;
    let mut errors = Vec::new();
    // SAFETY: what is not NULL has one item, or two numbers; what is misaligned or too large is not read.
    unsafe {
        let new = |base, joints, bodies, limits| {
            handle(|robot| simdop_robot_new(base, joints, 1, bodies, 1, limits, 1, robot)).unwrap_err()
        };
        errors.push(new(None, joints, bodies, limits));
        errors.push(new(base, null(), bodies, limits));
        errors.push(new(base, joints, null(), limits));
        errors.push(new(base, joints, bodies, null()));
        errors.push(simdop_robot_new(base, joints, 1, bodies, 1, limits, 1, None));
        let misaligned = joints.wrapping_byte_add(4);
        assert_eq!(new(base, misaligned, bodies, limits), simdop_error::Misaligned);
        let many = handle(|robot| simdop_robot_new(base, joints, 1, bodies, usize::MAX, limits, 1, robot));
        assert_eq!(many.unwrap_err(), simdop_error::TooLarge);

        errors.push(simdop_robot_poses(None, value, &raw mut pose));
        errors.push(simdop_robot_poses(Some(&mut robot), null(), &raw mut pose));
        errors.push(simdop_robot_poses(Some(&mut robot), value, null_mut()));
        let misaligned = (&raw mut pose).wrapping_byte_add(4);
        let error = simdop_robot_poses(Some(&mut robot), value, misaligned);
        assert_eq!(error, simdop_error::Misaligned);

        let robot = Some(&*robot);
        errors.push(
            answer(|to| simdop_scene_check_joint_motion(None, ids, 1, robot, value, value, 0.1, budget, to))
                .unwrap_err(),
        );
        let mut edge = |ids, robot, a, b| {
            let scene = Some(&mut *scene);
            answer(|to| simdop_scene_check_joint_motion(scene, ids, 1, robot, a, b, 0.1, budget, to))
                .unwrap_err()
        };
        errors.push(edge(null(), robot, value, value));
        errors.push(edge(ids, None, value, value));
        errors.push(edge(ids, robot, null(), value));
        errors.push(edge(ids, robot, value, null()));
        let scene = Some(&mut *scene);
        errors.push(simdop_scene_check_joint_motion(scene, ids, 1, robot, value, value, 0.1, budget, None));
    }
    simdop_robot_free(None);
    for (place, error) in errors.into_iter().enumerate() {
        assert_eq!(error, simdop_error::Null, "{place}");
    }
    assert_eq!(pose, UNWRITTEN);
}
