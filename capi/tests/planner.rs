//! A planner gives the library's answers, and has its errors' codes.
#![cfg(feature = "planning")]

mod support;

use simdop::planning::{PlanningScene, RobotFiles};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::scene::{Body, MotionVerdict};
use simdop_capi::*;
use std::ffi::{CStr, CString};
use std::ptr::null;
use support::{BALL, IDENTITY, Rng, answer, handle, shape};

const URDF: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/arm/arm.urdf");
const SRDF: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/arm/arm.srdf");

fn load(urdf: &str, srdf: Option<&str>) -> Result<Box<simdop_planner>, simdop_error> {
    let [urdf, srdf] = [Some(urdf), srdf].map(|path| path.map(|path| CString::new(path).unwrap()));
    let srdf = srdf.as_ref().map_or(null(), |path| path.as_ptr());
    // SAFETY: the paths end with a NUL.
    handle(|to| unsafe { simdop_planner_load(urdf.unwrap().as_ptr(), srdf, 0.0, to) })
}

/// The arm beside a ball, through both interfaces.
fn twins() -> (Box<simdop_planner>, PlanningScene, simdop_body_id) {
    let mut c = load(URDF, Some(SRDF)).unwrap();
    let mut rust = PlanningScene::new(RobotFiles::new(URDF).srdf(SRDF).load().unwrap()).unwrap();
    let ball = simdop_shape { numbers: [0.2, 0.0, 0.0, 0.0], ..BALL };
    let body: &'static simdop_body = Box::leak(shape(&ball).unwrap());
    let role = simdop_role { is_fixed: 1, ..simdop_role_default() };
    let mut world = IDENTITY;
    (world.rows[0][3], world.rows[2][3]) = (0.5, 0.4);
    let id =
        answer(|id| simdop_planner_insert(Some(&mut c), Some(body), Some(&role), Some(&world), id)).unwrap();
    let body = Body::new(Shape::sphere(0.2).unwrap()).fixed();
    assert_eq!(rust.insert("", body, &Pose::from_rows(world.rows).unwrap()).unwrap().to_bits(), id);
    (c, rust, id)
}

#[test]
fn answers_are_the_librarys() {
    let (c, rust, _) = twins();
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let mut rust_workspace = rust.workspace();
    let variables = answer(|count| simdop_planner_variables(Some(&c), count)).unwrap();
    assert_eq!(variables, rust.variables());
    let mut limits = vec![[0.0; 2]; variables];
    // SAFETY: there is room for each variable.
    let error = unsafe { simdop_planner_limits(Some(&c), limits.as_mut_ptr().cast()) };
    assert_eq!((error, &*limits), (simdop_error::None, rust.limits()));
    let mut rng = Rng::new(41);
    let values: Vec<f64> =
        (0..100).flat_map(|_| limits.clone()).map(|[low, high]| rng.range(low, high)).collect();
    let mut free = vec![7_u8; 100];
    let count = answer(|count| {
        let (values, free) = (values.as_ptr(), free.as_mut_ptr());
        // SAFETY: the lengths are those of the vectors.
        unsafe { simdop_planner_check_states(Some(&c), Some(&mut workspace), values, 100, free, count) }
    });
    let count = count.unwrap();
    assert!(count > 5 && count < 95, "{count}");
    let points: Vec<[f32; 3]> = (0..300).map(|i| [0.0, 0.01 * (i % 40) as f32, 0.005 * i as f32]).collect();
    let mut near = [2; 300];
    let near_count = answer(|count| {
        let (at, to) = (points.as_ptr().cast(), near.as_mut_ptr());
        // SAFETY: there are three numbers and a byte for each point, and a value for each variable.
        unsafe {
            let (c, workspace) = (Some(&*c), Some(&mut *workspace));
            simdop_planner_near_robot(c, workspace, values.as_ptr(), at, 300, 0.05, to, count)
        }
    });
    let expected = rust.near_robot(&mut rust_workspace, &values[..variables], &points, 0.05).unwrap();
    assert_eq!(near.map(|near| near == 1).to_vec(), expected);
    assert_eq!(near_count.unwrap(), expected.iter().filter(|near| **near).count());
    let mut motions = [0; 3];
    for (i, two) in values.chunks(2 * variables).enumerate() {
        let (from, to) = two.split_at(variables);
        assert_eq!(free[2 * i] == 1, rust.is_free(&mut rust_workspace, from).unwrap());
        // SAFETY: there is a value for each variable, here and below.
        let found = answer(|answer| unsafe {
            simdop_planner_within(Some(&c), Some(&mut workspace), from.as_ptr(), 0.05, answer)
        });
        let expected = rust.within(&mut rust_workspace, from, 0.05).unwrap();
        assert_eq!(found.unwrap().verdict == simdop_verdict::Free, expected.is_free());
        // SAFETY: as above.
        let found = answer(|answer| unsafe {
            let (from, to) = (from.as_ptr(), to.as_ptr());
            simdop_planner_check_motion(Some(&c), Some(&mut workspace), from, to, answer)
        });
        let verdict = match rust.check_motion(&mut rust_workspace, [from, to]).unwrap().verdict {
            MotionVerdict::Free => simdop_motion_verdict::Free,
            MotionVerdict::Hit { .. } => simdop_motion_verdict::Hit,
            MotionVerdict::Unresolved { .. } => simdop_motion_verdict::Unresolved,
        };
        assert_eq!(found.unwrap().verdict, verdict);
        motions[verdict as usize] += 1;
        // SAFETY: as above.
        let near = answer(|answer| unsafe {
            simdop_planner_clearance(Some(&c), Some(&mut workspace), from.as_ptr(), 0.0, 9.0, answer)
        });
        let (near, expected) = (near.unwrap(), rust.clearance(&mut rust_workspace, from, 0.0, 9.0).unwrap());
        assert_eq!([near.lower, near.upper], [expected.lower, expected.upper]);
        let (mut slopes, mut gradient) = (vec![7.0; from.len()], vec![0.0; from.len()]);
        // SAFETY: as above.
        let near = answer(|answer| unsafe {
            let (values, slopes) = (from.as_ptr(), slopes.as_mut_ptr());
            simdop_planner_signed_clearance(Some(&c), Some(&mut workspace), values, 0.0, 9.0, slopes, answer)
        });
        let expected = rust.signed_clearance(&mut rust_workspace, from, 0.0, 9.0, &mut gradient).unwrap();
        let near = near.unwrap();
        assert_eq!([near.lower, near.upper], [expected.lower, expected.upper]);
        assert_eq!(slopes, gradient);
    }
    assert!(motions[0] > 0 && motions[1] > 0, "{motions:?}");
    simdop_workspace_destroy(Some(workspace));
    simdop_planner_destroy(Some(c));
}

#[test]
fn objects_move_and_are_carried() {
    let (mut c, mut rust, id) = twins();
    let rust_id = simdop::scene::BodyId::from_bits(id);
    let (hand, values) = (c"hand", [0.3, 0.4, 0.5, 0.0]);
    let mut above = IDENTITY;
    above.rows[2][3] = 3.0;
    let rust_above = Pose::from_rows(above.rows).unwrap();
    let agree = |c: &simdop_planner, rust: &PlanningScene| {
        let mut workspace = handle(|to| simdop_workspace_create(Some(c), to)).unwrap();
        let mut rust_workspace = rust.workspace();
        for turn in [-1.0, 0.0, 0.7] {
            let values = [turn, 0.4, 0.5, 0.0];
            // SAFETY: there is a value for each variable.
            let near = answer(|answer| unsafe {
                simdop_planner_clearance(Some(c), Some(&mut workspace), values.as_ptr(), 0.0, 9.0, answer)
            });
            let (near, expected) =
                (near.unwrap(), rust.clearance(&mut rust_workspace, &values, 0.0, 9.0).unwrap());
            assert_eq!([near.lower, near.upper], [expected.lower, expected.upper]);
        }
    };
    let copy = handle(|copy| simdop_planner_copy(Some(&c), copy)).unwrap();
    agree(&copy, &rust);
    assert_eq!(simdop_planner_place(Some(&mut c), id, Some(&above)), simdop_error::None);
    rust.place(rust_id, &rust_above).unwrap();
    agree(&c, &rust);
    // SAFETY: the name ends with a NUL, and there is a value for each variable.
    let attached = unsafe { simdop_planner_attach(Some(&mut c), id, hand.as_ptr(), values.as_ptr(), 4) };
    assert_eq!(attached, simdop_error::None);
    rust.attach(rust_id, "hand", &values, &["hand"]).unwrap();
    agree(&c, &rust);
    assert_eq!(simdop_planner_place(Some(&mut c), id, Some(&above)), simdop_error::SceneIsAttached);
    assert_eq!(simdop_planner_detach(Some(&mut c), id, Some(&above)), simdop_error::None);
    rust.detach(rust_id, &rust_above).unwrap();
    // SAFETY: the name ends with a NUL.
    let link = answer(|id| unsafe { simdop_planner_link(Some(&c), hand.as_ptr(), id) }).unwrap();
    assert_eq!(link, rust.link("hand").unwrap().to_bits());
    assert_eq!(simdop_planner_allow_collision(Some(&mut c), id, link), simdop_error::None);
    rust.allow_collision(rust_id, rust.link("hand").unwrap()).unwrap();
    agree(&c, &rust);
    assert_eq!(simdop_planner_forbid_collision(Some(&mut c), id, link), simdop_error::None);
    rust.forbid_collision(rust_id, rust.link("hand").unwrap()).unwrap();
    assert_eq!(simdop_planner_place_base(Some(&mut c), Some(&above)), simdop_error::None);
    rust.place_base(&rust_above).unwrap();
    agree(&c, &rust);
    assert_eq!(simdop_planner_remove(Some(&mut c), id), simdop_error::None);
    assert_eq!(simdop_planner_remove(Some(&mut c), id), simdop_error::SceneNoSuchBody);
}

fn link(planner: &simdop_planner, name: &CStr) -> Result<simdop_body_id, simdop_error> {
    // SAFETY: the name ends with a NUL.
    answer(|id| unsafe { simdop_planner_link(Some(planner), name.as_ptr(), id) })
}

#[test]
fn faults_have_codes() {
    let folder = std::env::temp_dir().join(format!("simdop-planner-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).unwrap();
        folder.join(name).to_str().unwrap().to_owned()
    };
    let of_mesh = r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="a.obj"/></geometry>
        </collision></link></robot>"#;
    let urdf = write("a.urdf", of_mesh);
    assert_eq!(load(&urdf, None).err(), Some(simdop_error::PlannerFile), "the mesh is missing");
    write("a.obj", "v 0 0 x");
    assert_eq!(load(&urdf, None).err(), Some(simdop_error::PlannerMesh));
    assert_eq!(load("/nonexistent", None).err(), Some(simdop_error::PlannerFile));
    assert_eq!(load(URDF, Some(URDF)).err(), Some(simdop_error::DescriptionFormat));
    std::fs::remove_dir_all(&folder).unwrap();

    let (mut c, _, id) = twins();
    assert_eq!(link(&c, c"nothing"), Err(simdop_error::PlannerNoLink));
    let hand = link(&c, c"hand").unwrap();
    assert_eq!(simdop_planner_remove(Some(&mut c), hand), simdop_error::PlannerIsRobot);
    assert_eq!(simdop_planner_place(Some(&mut c), hand, Some(&IDENTITY)), simdop_error::PlannerIsRobot);
    let values = [0.0, 0.0, 0.0, 9.0];
    let (nothing, hand, first) = (c"nothing".as_ptr(), c"hand".as_ptr(), values.as_ptr());
    // SAFETY: the name ends with a NUL, and there are as many values.
    let group = unsafe { simdop_planner_select_group(Some(&mut c), nothing, first, 3) };
    // SAFETY: as above.
    let length = unsafe { simdop_planner_attach(Some(&mut c), id, hand, first, 3) };
    // SAFETY: as above.
    let limits = unsafe { simdop_planner_attach(Some(&mut c), id, hand, first, 4) };
    let expected = [simdop_error::MotionLength, simdop_error::MotionLength, simdop_error::MotionOutOfLimits];
    assert_eq!([group, length, limits], expected);
    let rest = [0.0; 4];
    // SAFETY: the name ends with a NUL, and there is a value for each variable.
    let group = unsafe { simdop_planner_select_group(Some(&mut c), c"nothing".as_ptr(), rest.as_ptr(), 4) };
    assert_eq!(group, simdop_error::PlannerNoGroup);
}

#[test]
fn null_is_an_error() {
    let (mut c, _, id) = twins();
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let (values, mut free, at, mut errors) = ([0.0; 4], [0_u8; 1], Some(&IDENTITY), Vec::new());
    let (v, name) = (values.as_ptr(), c"hand".as_ptr());
    errors.push(handle(|to| simdop_planner_copy(None, to)).unwrap_err());
    errors.push(simdop_planner_copy(Some(&c), None));
    errors.push(handle(|to| simdop_workspace_create(None, to)).unwrap_err());
    errors.push(simdop_workspace_create(Some(&c), None));
    errors.push(answer(|count| simdop_planner_variables(None, count)).unwrap_err());
    errors.push(simdop_planner_place_base(None, at));
    errors.push(simdop_planner_place_base(Some(&mut c), None));
    errors.push(simdop_planner_place(None, id, at));
    errors.push(simdop_planner_place(Some(&mut c), id, None));
    errors.push(simdop_planner_remove(None, id));
    errors.push(simdop_planner_detach(None, id, at));
    errors.push(simdop_planner_detach(Some(&mut c), id, None));
    errors.push(simdop_planner_allow_collision(None, id, id));
    errors.push(simdop_planner_forbid_collision(None, id, id));
    let plain = simdop_role_default();
    let role = Some(&plain);
    errors.push(answer(|to| simdop_planner_insert(Some(&mut c), None, role, at, to)).unwrap_err());
    let memory: *mut simdop_workspace = &mut *workspace;
    for (planner, memory, values) in
        [(None, Some(memory), v), (Some(&*c), None, v), (Some(&*c), Some(memory), null())]
    {
        // SAFETY: it exists until the end of the test, and each reference ends with its call.
        let workspace = || memory.map(|memory| unsafe { &mut *memory });
        let to = free.as_mut_ptr();
        // SAFETY: what is not NULL has enough items, here and below.
        errors.push(
            answer(|a| unsafe { simdop_planner_within(planner, workspace(), values, 0.0, a) }).unwrap_err(),
        );
        // SAFETY: as above.
        let states =
            answer(|a| unsafe { simdop_planner_check_states(planner, workspace(), values, 1, to, a) });
        errors.push(states.unwrap_err());
        // SAFETY: as above.
        let filter = answer(|a| unsafe {
            simdop_planner_near_robot(planner, workspace(), values, null(), 1, 0.0, to, a)
        });
        errors.push(filter.unwrap_err());
        // SAFETY: as above.
        let motion = answer(|a| unsafe { simdop_planner_check_motion(planner, workspace(), values, v, a) });
        errors.push(motion.unwrap_err());
        // SAFETY: as above.
        let near = answer(|a| unsafe { simdop_planner_clearance(planner, workspace(), values, 0.0, 1.0, a) });
        errors.push(near.unwrap_err());
    }
    // SAFETY: as above.
    errors.push(handle(|to| unsafe { simdop_planner_load(null(), null(), 0.0, to) }).unwrap_err());
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_limits(Some(&c), std::ptr::null_mut()) });
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_select_group(Some(&mut c), null(), v, 4) });
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_select_group(Some(&mut c), name, null(), 4) });
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_attach(Some(&mut c), id, null(), v, 4) });
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_attach(Some(&mut c), id, name, null(), 4) });
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_link(Some(&c), name, None) });
    assert!(errors.iter().all(|error| *error == simdop_error::Null), "{errors:?}");
    simdop_workspace_destroy(None);
    simdop_planner_destroy(None);
}
