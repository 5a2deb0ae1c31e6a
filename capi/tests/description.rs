//! Robots from URDF and SRDF files are those of the library.
#![cfg(feature = "urdf")]

mod support;

use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use simdop::scene::{Body, Scene};
use simdop_capi::*;
use std::ffi::{CStr, c_char, c_int};
use support::{IDENTITY, answer, handle};

const URDF: &str = include_str!("../../examples/arm/arm.urdf");
const SRDF: &str = include_str!("../../examples/arm/arm.srdf");

fn read(urdf: &[u8], is_visual: c_int) -> Result<Box<simdop_description>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|made| unsafe { simdop_description_read(urdf.as_ptr().cast(), urdf.len(), is_visual, made) })
}

fn text(text: *const c_char) -> String {
    // SAFETY: the names live as long as their description.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().into()
}

fn select(
    description: &simdop_description,
    srdf: Option<&[u8]>,
    scene: &mut simdop_scene,
    ids: &[simdop_body_id],
) -> simdop_error {
    let (first, count) = srdf.map_or((std::ptr::null(), 0), |srdf| (srdf.as_ptr().cast(), srdf.len()));
    // SAFETY: the lengths are those of the slices.
    unsafe {
        simdop_description_select_pairs(Some(description), first, count, Some(scene), ids.as_ptr(), ids.len())
    }
}

#[test]
fn a_description_is_the_librarys_robot() {
    let robot = Robot::from_urdf(URDF, LinkShapes::Collision).unwrap();
    let description = read(URDF.as_bytes(), 0).unwrap();
    let size = answer(|size| simdop_description_get_size(Some(&description), size)).unwrap();
    assert_eq!([size.variables, size.bodies], [robot.variables.len(), robot.bodies.len()]);
    for i in 0..size.variables {
        let found = answer(|to| simdop_description_get_variable(Some(&description), i, to)).unwrap();
        assert_eq!(
            (text(found.name), [found.lower, found.upper], found.is_continuous),
            (robot.variables[i].clone(), robot.limits[i], 0)
        );
    }
    let turning = URDF.replacen(r#"name="elbow" type="revolute""#, r#"name="elbow" type="continuous""#, 1);
    let turning = read(turning.as_bytes(), 0).unwrap();
    let is_continuous =
        [0, 1, 2, 3].map(|i| answer(|to| simdop_description_get_variable(Some(&turning), i, to)).unwrap());
    assert_eq!(is_continuous.map(|variable| variable.is_continuous), [0, 0, 1, 0]);
    for i in 0..size.bodies {
        let found = answer(|to| simdop_description_get_body(Some(&description), i, to)).unwrap();
        assert_eq!((text(found.link_name), found.link), (robot.names[i].clone(), robot.bodies[i].link));
        assert_eq!(Pose::from_rows(found.pose.rows).unwrap(), robot.bodies[i].at);
        let body = handle(|body| simdop_description_build_body(Some(&description), i, body));
        match &robot.shapes[i] {
            LinkShape::Shape(_) => assert!(found.mesh_file.is_null() && body.is_ok()),
            LinkShape::Mesh { file, scale } => {
                assert_eq!((text(found.mesh_file), found.mesh_scale), (file.clone(), *scale));
                assert_eq!(body.err(), Some(simdop_error::DescriptionMesh));
            }
        }
    }
}

#[test]
fn a_scene_of_a_description_answers_as_the_librarys() {
    let robot = Robot::from_urdf(URDF, LinkShapes::Collision).unwrap();
    let description = read(URDF.as_bytes(), 0).unwrap();
    let mut moved =
        handle(|to| simdop_description_build_robot(Some(&description), Some(&IDENTITY), to)).unwrap();
    let (mut c, mut rust) = (handle(|scene| simdop_scene_create(scene)).unwrap(), Scene::new());
    let (role, mut ids) = (simdop_role_default(), Vec::new());
    for (i, shape) in robot.shapes.iter().enumerate() {
        let body = handle(|body| simdop_description_build_body(Some(&description), i, body)).unwrap();
        let body: &'static simdop_body = Box::leak(body);
        let id = answer(|id| simdop_scene_insert(Some(&mut c), Some(body), Some(&role), Some(&IDENTITY), id));
        ids.push(id.unwrap());
        let shape = shape.shape().unwrap();
        assert_eq!(
            rust.insert(Body::<simdop::node::Node16<18>>::new(shape), &Pose::IDENTITY).unwrap().to_bits(),
            ids[i]
        );
    }
    let rust_ids: Vec<_> = rust.ids().collect();
    for srdf in [None, Some(SRDF)] {
        let disabled = srdf.map_or_else(Vec::new, |srdf| DisabledPair::from_srdf(srdf).unwrap());
        let pairs = robot.pairs(&disabled).unwrap();
        assert_eq!(select(&description, srdf.map(str::as_bytes), &mut c, &ids), simdop_error::None);
        for i in 0..ids.len() {
            for j in i + 1..ids.len() {
                let is_asked = answer(|to| simdop_scene_is_asked(Some(&c), ids[i], ids[j], to)).unwrap();
                assert_eq!(is_asked != 0, pairs.contains(&(i, j)));
                let _ = if pairs.contains(&(i, j)) {
                    rust.forbid_collision(rust_ids[i], rust_ids[j])
                } else {
                    rust.allow_collision(rust_ids[i], rust_ids[j])
                };
            }
        }
    }
    let kinematics = robot.kinematics().unwrap();
    let mut links = vec![simdop::motion::LinkFrame::EMPTY; kinematics.links()];
    let mut rust_poses = vec![Pose::IDENTITY; ids.len()];
    let mut poses = vec![IDENTITY; ids.len()];
    for step in 0..20 {
        let at = |[low, high]: &[f64; 2]| low + (high - low) * f64::from(step) / 19.0;
        let values: Vec<f64> = robot.limits.iter().map(at).collect();
        // SAFETY: there is a value for each variable, and room for each body.
        let error = unsafe { simdop_robot_poses(Some(&mut moved), values.as_ptr(), poses.as_mut_ptr()) };
        assert_eq!(error, simdop_error::None);
        // SAFETY: there are as many poses as bodies.
        let error = unsafe { simdop_scene_place_all(Some(&mut c), ids.as_ptr(), poses.as_ptr(), ids.len()) };
        assert_eq!(error, simdop_error::None);
        kinematics.go_to(&values, &mut links, &mut rust_poses).unwrap();
        rust_ids.iter().zip(&rust_poses).for_each(|(id, pose)| rust.place(*id, pose).unwrap());
        let found = answer(|to| simdop_scene_clearance(Some(&c), 0.0, 9.0, SIMDOP_NO_BUDGET, to)).unwrap();
        let expected = rust.clearance(&Query::new(Isa::detect()), 0.0, 9.0).unwrap();
        assert_eq!([found.lower, found.upper], [expected.lower, expected.upper]);
    }
    simdop_scene_destroy(Some(c));
    simdop_robot_free(Some(moved));
    simdop_description_destroy(Some(description));
}

/// A robot of two links and a joint.
fn urdf(joint: &str) -> String {
    format!(
        r#"<robot name="r"><link name="a"/><link name="b"><collision><geometry><mesh filename="b.obj"/>
        </geometry></collision></link><joint name="j" {joint}</joint></robot>"#
    )
}

#[test]
fn faulty_descriptions_have_codes() {
    let ends = r#"<parent link="a"/><child link="b"/><axis xyz="0 0 1"/>"#;
    let limits = r#"<limit lower="0" upper="1" effort="1" velocity="1"/>"#;
    let good = urdf(&format!(r#"type="revolute">{ends}{limits}"#));
    let description = read(good.as_bytes(), 0).unwrap();
    for (text, code) in [
        ("<robot".to_owned(), simdop_error::DescriptionFormat),
        (urdf(&format!(r#"type="floating">{ends}{limits}"#)), simdop_error::DescriptionKind),
        (good.replace("link=\"b\"", "link=\"c\""), simdop_error::DescriptionNoSuchLink),
        (good.replace("child link=\"b\"", "child link=\"a\""), simdop_error::DescriptionNoTree),
        (good.replace("<axis", r#"<mimic joint="k"/><axis"#), simdop_error::DescriptionMimic),
        (good.replace(r#"lower="0""#, r#"lower="2""#), simdop_error::MotionLimits),
    ] {
        assert_eq!(read(text.as_bytes(), 0).unwrap_err(), code, "{text}");
    }
    assert_eq!(read(b"\xff\xfe", 0).unwrap_err(), simdop_error::DescriptionFormat);
    let beyond = simdop_error::DescriptionIndex;
    let some = Some(&*description);
    assert_eq!(answer(|to| simdop_description_get_variable(some, 1, to)).err(), Some(beyond));
    assert_eq!(answer(|to| simdop_description_get_body(some, 1, to)).err(), Some(beyond));
    assert_eq!(handle(|to| simdop_description_build_body(some, 1, to)).err(), Some(beyond));
    assert_eq!(
        handle(|to| simdop_description_build_body(some, 0, to)).err(),
        Some(simdop_error::DescriptionMesh)
    );
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    assert_eq!(select(&description, None, &mut scene, &[]), simdop_error::MotionBodies);
    assert_eq!(select(&description, None, &mut scene, &[0]), simdop_error::None, "one body has no pair");
    assert_eq!(select(&description, Some(b"<x"), &mut scene, &[0]), simdop_error::DescriptionFormat);
    let unknown = br#"<robot><disable_collisions link1="b" link2="z"/></robot>"#;
    assert_eq!(select(&description, Some(unknown), &mut scene, &[0]), simdop_error::DescriptionNoSuchName);
}

#[test]
fn null_is_an_error() {
    let description = read(URDF.as_bytes(), 0).unwrap();
    let (some, null, at) = (Some(&*description), simdop_error::Null, Some(&IDENTITY));
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let ids = [0; 9];
    let (no_text, no_ids, text) = (std::ptr::null(), std::ptr::null(), URDF.as_ptr().cast());
    // SAFETY: no text, or one of this length.
    let nothing = handle(|to| unsafe { simdop_description_read(no_text, 3, 0, to) }).unwrap_err();
    // SAFETY: as above.
    let nowhere = unsafe { simdop_description_read(text, URDF.len(), 0, None) };
    // SAFETY: no text, and an item.
    let no_description =
        unsafe { simdop_description_select_pairs(None, no_text, 0, Some(&mut scene), ids.as_ptr(), 1) };
    // SAFETY: as above.
    let no_scene = unsafe { simdop_description_select_pairs(some, no_text, 0, None, ids.as_ptr(), 1) };
    // SAFETY: no text, and no items, which is an error.
    let no_items = unsafe { simdop_description_select_pairs(some, no_text, 0, Some(&mut scene), no_ids, 1) };
    let reads = [nothing, nowhere, no_description, no_scene, no_items];
    let others = [
        answer(|to| simdop_description_get_size(None, to)).unwrap_err(),
        simdop_description_get_size(some, None),
        answer(|to| simdop_description_get_variable(None, 0, to)).unwrap_err(),
        simdop_description_get_variable(some, 0, None),
        answer(|to| simdop_description_get_body(None, 0, to)).unwrap_err(),
        simdop_description_get_body(some, 0, None),
        handle(|to| simdop_description_build_body(None, 0, to)).unwrap_err(),
        simdop_description_build_body(some, 0, None),
        handle(|to| simdop_description_build_robot(None, at, to)).unwrap_err(),
        handle(|to| simdop_description_build_robot(some, None, to)).unwrap_err(),
        simdop_description_build_robot(some, at, None),
    ];
    assert!(reads.iter().chain(&others).all(|error| *error == null), "{reads:?} {others:?}");
    simdop_description_destroy(None);
}
