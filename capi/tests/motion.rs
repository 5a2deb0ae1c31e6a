//! Faulty motions given by callbacks: never free, and an error where one can be detected. The bodies keep their poses.

mod support;

use simdop::construct::OwnedMesh;
use simdop_capi::*;
use std::ffi::{CStr, c_int, c_void};
use std::ptr::null;
use support::{IDENTITY, answer, handle, solid, spheres};

/// Bodies that slide along x in a row, by 4 from -2 on, and a fault in the motion.
#[derive(Copy, Clone)]
struct Slide {
    bodies: usize,
    /// What `path` returns. 0 stands for a valid bound.
    path: f64,
    /// From this time on, `go_to` returns 7.
    stop: f64,
    /// From this time on, the last pose is this one, or is not written.
    fault: (f64, Option<simdop_pose>),
}

const SLIDE: Slide = Slide { bodies: 1, path: f64::NAN, stop: 2.0, fault: (2.0, None) };

fn at(x: f64, y: f64) -> simdop_pose {
    let mut pose = IDENTITY;
    (pose.rows[0][3], pose.rows[1][3]) = (x, y);
    pose
}

unsafe extern "C" fn go_to(user: *mut c_void, time: f64, poses: *mut simdop_pose) -> c_int {
    // SAFETY: the tests pass such a motion.
    let slide = unsafe { &*user.cast::<Slide>() };
    for i in 0..slide.bodies {
        let (from, fault) = slide.fault;
        let is_faulty = time >= from && i + 1 == slide.bodies;
        let pose = if is_faulty { fault } else { Some(at(4.0 * time - 2.0 - 3.0 * i as f64, 0.0)) };
        if let Some(pose) = pose {
            // SAFETY: there is room for a pose of each body.
            unsafe { poses.wrapping_add(i).write(pose) };
        }
    }
    if time >= slide.stop { 7 } else { 0 }
}

unsafe extern "C" fn path(user: *mut c_void, _: usize, _: *const f64, _: f64, span: f64) -> f64 {
    // SAFETY: the tests pass such a motion.
    let slide = unsafe { &*user.cast::<Slide>() };
    if slide.path == 0.0 { 4.0 * span + 1e-12 } else { slide.path }
}

unsafe extern "C" fn motion_bound_between(
    user: *mut c_void,
    _: usize,
    _: *const f64,
    _: f64,
    _: usize,
    _: *const f64,
    _: f64,
    _: f64,
) -> f64 {
    // SAFETY: the tests pass such a motion.
    unsafe { &*user.cast::<Slide>() }.path
}

fn motion(slide: &Slide) -> simdop_motion {
    let user = (&raw const *slide).cast_mut().cast();
    simdop_motion { user, go_to: Some(go_to), path: Some(path), motion_bound_between: None }
}

/// A scene with one body three times: two that move, and one that stands halfway along their path, `above` it.
struct Hall {
    scene: Box<simdop_scene>,
    moving: [simdop_body_id; 2],
    still: simdop_body_id,
}

impl Hall {
    fn new(body: &'static simdop_body, above: f64) -> Self {
        let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
        let role = simdop_role_default();
        let mut insert = |x: f64, y: f64| {
            let pose = at(x, y);
            answer(|id| simdop_scene_insert(Some(&mut scene), Some(body), Some(&role), Some(&pose), id))
                .unwrap()
        };
        let (moving, still) = ([insert(10.0, 0.0), insert(-10.0, 0.0)], insert(0.0, above));
        Self { scene, moving, still }
    }

    fn edge(&mut self, slide: &Slide, motion: &simdop_motion) -> Result<simdop_motion_answer, simdop_error> {
        let (ids, count, budget) = (self.moving.as_ptr(), slide.bodies, SIMDOP_NO_BUDGET);
        let scene = Some(&mut *self.scene);
        // SAFETY: at most as many ids as `moving` has; the motion is that of a slide, which lives during the call.
        answer(|answer| unsafe {
            simdop_scene_check_motion(scene, ids, count, Some(motion), 0.05, budget, answer)
        })
    }

    fn verdict(&mut self, slide: &Slide) -> simdop_motion_verdict {
        self.edge(slide, &motion(slide)).unwrap().verdict
    }

    fn sampled(&mut self, slide: &Slide, parts: u32) -> Result<simdop_motion_answer, simdop_error> {
        let (ids, count, budget) = (self.moving.as_ptr(), slide.bodies, SIMDOP_NO_BUDGET);
        let (scene, motion) = (Some(&mut *self.scene), motion(slide));
        // SAFETY: as for `edge`.
        answer(|answer| unsafe {
            simdop_scene_check_motion_discrete(scene, ids, count, Some(&motion), parts, budget, answer)
        })
    }

    /// Whether the moving bodies are at their original poses, 10 away from the middle.
    fn is_as_before(&self) -> bool {
        let near = answer(|near| {
            simdop_scene_clearance(Some(&self.scene), 0.0, f64::INFINITY, SIMDOP_NO_BUDGET, near)
        })
        .unwrap();
        near.lower > 8.0
    }
}

fn message() -> String {
    // SAFETY: it ends with a NUL, and lives until the next failure.
    unsafe { CStr::from_ptr(simdop_last_error()) }.to_str().unwrap().to_owned()
}

fn cube() -> &'static simdop_body {
    Box::leak(solid(&OwnedMesh::cuboid([1.0; 3]).unwrap().as_mesh()).unwrap())
}

#[test]
fn what_is_no_bound_is_never_free() {
    let point: &'static simdop_body = Box::leak(spheres(&[[0.0; 4]]).unwrap());
    let right = Slide { path: 0.0, ..SLIDE };
    for body in [cube(), point] {
        let (mut apart, mut meeting) = (Hall::new(body, 2.0), Hall::new(body, 0.0));
        assert_eq!(apart.verdict(&right), simdop_motion_verdict::Free);
        assert_eq!(meeting.verdict(&right), simdop_motion_verdict::Hit);
        for path in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -5e-324, 1e300] {
            for bodies in [1, 2] {
                let slide = Slide { path, bodies, ..SLIDE };
                assert_eq!(apart.verdict(&slide), simdop_motion_verdict::Unresolved, "{path}");
                assert_ne!(meeting.verdict(&slide), simdop_motion_verdict::Free, "{path}");
                let between =
                    simdop_motion { motion_bound_between: Some(motion_bound_between), ..motion(&slide) };
                let verdict = apart.edge(&slide, &between).unwrap().verdict;
                assert_eq!(verdict, simdop_motion_verdict::Unresolved, "{path}");
            }
        }
        // Only `motion_bound_between` certifies bodies that move as one: -0 is a valid bound, too.
        let two = Slide { path: -0.0, bodies: 2, ..SLIDE };
        let between = simdop_motion { motion_bound_between: Some(motion_bound_between), ..motion(&two) };
        assert_eq!(apart.edge(&two, &between).unwrap().verdict, simdop_motion_verdict::Free);
        assert!(apart.is_as_before() && meeting.is_as_before());
    }
}

#[test]
fn a_motion_can_stop_a_query() {
    let mut hall = Hall::new(cube(), 1.2);
    for stop in [0.0, 0.4, 0.9] {
        let slide = Slide { stop, ..SLIDE };
        assert_eq!(hall.edge(&slide, &motion(&slide)), Err(simdop_error::MotionStopped));
        assert!(message().starts_with("go_to returned 7 at the time "), "{}", message());
        assert_eq!(hall.sampled(&slide, 8), Err(simdop_error::MotionStopped));
        assert!(hall.is_as_before());
    }
    let slide = Slide { path: 0.0, ..SLIDE };
    assert_eq!(hall.verdict(&slide), simdop_motion_verdict::Free, "the scene is as good as before");
}

#[test]
fn poses_of_a_motion_are_checked() {
    let with = |row: usize, column: usize, number: f64| {
        let mut pose = IDENTITY;
        pose.rows[row][column] = number;
        Some(pose)
    };
    let mut hall = Hall::new(cube(), 1.2);
    for bodies in [1, 2] {
        for (fault, expected) in [
            (None, simdop_error::PoseNotFinite),
            (with(1, 1, f64::INFINITY), simdop_error::PoseNotFinite),
            (with(0, 3, 1e300), simdop_error::PoseTooFar),
            (with(2, 2, -1.0), simdop_error::PoseMirrored),
            (with(0, 0, 1.1), simdop_error::PoseNotOrthonormal),
            // A valid pose, but not in a scene.
            (with(0, 0, 1.00003), simdop_error::PoseNotOrthonormal),
        ] {
            for from in [0.0, 0.3, 0.9] {
                let slide = Slide { bodies, fault: (from, fault), ..SLIDE };
                assert_eq!(hall.edge(&slide, &motion(&slide)), Err(expected));
                assert_eq!(hall.sampled(&slide, 8), Err(expected));
                assert!(hall.is_as_before());
            }
        }
    }
    let slide = Slide { bodies: 2, fault: (0.0, None), ..SLIDE };
    let _ = hall.edge(&slide, &motion(&slide)).unwrap_err();
    assert!(message().starts_with("pose 1 of a motion at the time 0.5: "), "{}", message());
}

#[test]
fn bodies_that_cannot_move_are_refused() {
    let mut hall = Hall::new(cube(), 1.2);
    let slide = Slide { path: 0.0, ..SLIDE };
    assert_eq!(simdop_scene_attach(Some(&mut hall.scene), hall.moving[0], hall.still), simdop_error::None);
    assert_eq!(hall.edge(&slide, &motion(&slide)), Err(simdop_error::SceneIsAttached));
    assert_eq!(simdop_scene_remove(Some(&mut hall.scene), hall.moving[0]), simdop_error::None);
    assert_eq!(hall.edge(&slide, &motion(&slide)), Err(simdop_error::SceneNoSuchBody));
    let to = at(1.0, 0.0);
    let screw = answer(|answer| {
        let (scene, id) = (Some(&mut *hall.scene), hall.moving[0]);
        simdop_scene_check_screw(scene, id, Some(&IDENTITY), Some(&to), 0.1, SIMDOP_NO_BUDGET, answer)
    });
    assert_eq!(screw, Err(simdop_error::SceneNoSuchBody));
    let none = Slide { bodies: 0, ..slide };
    assert_eq!(hall.verdict(&none), simdop_motion_verdict::Free, "nothing moves, and nothing meets");
}

#[test]
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn null_is_an_error_wherever_it_is_given() {
    let mut hall = Hall::new(cube(), 1.2);
    let (id, still, budget) = (hall.moving[0], motion(&SLIDE), SIMDOP_NO_BUDGET);
    let scene = &mut *hall.scene;
    let (ids, some, pose) = (&raw const id, Some(&still), Some(&IDENTITY));
    let without_go_to = simdop_motion { go_to: None, ..still };
    let without_path = simdop_motion { path: None, ..still };
    let mut errors = Vec::new();
    // SAFETY: there is one id, unless they are NULL; the motion is that of a slide.
    unsafe {
        errors.push(answer(|to| simdop_scene_check_motion(None, ids, 1, some, 0.1, budget, to)).unwrap_err());
        errors.push(
            answer(|to| simdop_scene_check_motion_discrete(None, ids, 1, some, 1, budget, to)).unwrap_err(),
        );
        errors.push(simdop_scene_check_motion(Some(scene), ids, 1, some, 0.1, budget, None));
        errors.push(simdop_scene_check_motion_discrete(Some(scene), ids, 1, some, 1, budget, None));
        let mut edge = |ids, motion| {
            answer(|to| simdop_scene_check_motion(Some(scene), ids, 1, motion, 0.1, budget, to)).unwrap_err()
        };
        errors.extend([edge(null(), some), edge(ids, None), edge(ids, Some(&without_path))]);
        errors.push(edge(ids, Some(&without_go_to)));
        let mut sampled = |ids, motion| {
            answer(|to| simdop_scene_check_motion_discrete(Some(scene), ids, 1, motion, 1, budget, to))
                .unwrap_err()
        };
        errors.extend([sampled(null(), some), sampled(ids, None), sampled(ids, Some(&without_go_to))]);
    }
    errors.push(answer(|to| simdop_scene_check_screw(None, id, pose, pose, 0.1, budget, to)).unwrap_err());
    for (a, b) in [(None, pose), (pose, None)] {
        let edge = answer(|to| simdop_scene_check_screw(Some(scene), id, a, b, 0.1, budget, to));
        errors.push(edge.unwrap_err());
    }
    errors.push(simdop_scene_check_screw(Some(scene), id, pose, pose, 0.1, budget, None));
    for (place, error) in errors.into_iter().enumerate() {
        assert_eq!(error, simdop_error::Null, "{place}");
    }
    assert!(message().ends_with(" is NULL"), "{}", message());
}
