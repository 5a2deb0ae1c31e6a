//! A planner gives the library's answers, and has its errors' codes.
#![cfg(feature = "planning")]

mod support;

use simdop::isa::Isa;
use simdop::planning::{PlanSettings, PlanningScene, RobotFiles};
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::query::Query;
use simdop::scene::{Body, MotionVerdict};
use simdop_capi::*;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
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

unsafe extern "C" fn next(user: *mut c_void) -> f64 {
    // SAFETY: every caller passes this.
    unsafe { &mut *user.cast::<Rng>() }.range(0.0, 1.0)
}

unsafe extern "C" fn collect(user: *mut c_void, hit: *const simdop_scene_hit) -> c_int {
    // SAFETY: every caller passes this.
    let hits = unsafe { &mut *user.cast::<Vec<simdop_scene_hit>>() };
    // SAFETY: the library passes a hit.
    hits.push(unsafe { *hit });
    0
}

/// Paths, motions, hits, gradients and free configurations.
#[test]
fn plans_and_motions_are_the_librarys() {
    let (c, rust, _) = twins();
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let (mut rust_workspace, n) = (rust.workspace(), rust.variables());
    let (mut rng, mut twin) = (Rng::new(42), Rng::new(42));
    let user: *mut c_void = (&raw mut rng).cast();
    let mut free_values = || {
        let mut values = vec![7.0; n];
        // SAFETY: there is room for each variable, and the callback gets its generator.
        let found = answer(|found| unsafe {
            let (w, to) = (Some(&mut *workspace), values.as_mut_ptr());
            simdop_planner_random_free(Some(&c), w, Some(next), user, 1000, to, found)
        });
        assert_eq!(found, Ok(1));
        let expected = rust.random_free(&mut rust_workspace, || twin.range(0.0, 1.0), 1000).unwrap();
        assert_eq!(values, expected.unwrap());
        values
    };
    let configurations: Vec<Vec<f64>> = (0..40).map(|_| free_values()).collect();
    let motions = configurations.concat();
    let mut free = vec![7_u8; 20];
    let count = answer(|count| {
        let (w, ends, free) = (Some(&mut *workspace), motions.as_ptr(), free.as_mut_ptr());
        // SAFETY: the lengths are those of the vectors.
        unsafe { simdop_planner_check_motions(Some(&c), w, ends, 20, free, count) }
    });
    let expected = rust.free_motions(&motions).unwrap();
    assert_eq!(free, expected.iter().map(|free| u8::from(*free)).collect::<Vec<_>>());
    assert_eq!(count, Ok(expected.iter().filter(|free| **free).count()));
    assert!(expected.contains(&true) && expected.contains(&false));
    let mut counts = [0; 2];
    for ends in configurations.chunks(2) {
        let (from, to) = (ends[0].as_ptr(), ends[1].as_ptr());
        // SAFETY: there is a value for each variable, here and below.
        let share = answer(|share| unsafe {
            simdop_planner_free_share(Some(&c), Some(&mut workspace), from, to, share)
        });
        let ends = [&ends[0][..], &ends[1][..]];
        assert_eq!(share, Ok(rust.free_share(&mut rust_workspace, ends).unwrap()));
        // SAFETY: as above.
        let sampled = answer(|answer| unsafe {
            simdop_planner_check_motion_discrete(Some(&c), Some(&mut workspace), from, to, 7, answer)
        });
        let parts = std::num::NonZeroU32::new(7).unwrap();
        let expected = rust.check_motion_discrete(&mut rust_workspace, ends, parts).unwrap();
        let is_hit = matches!(expected.verdict, MotionVerdict::Hit { .. });
        assert_eq!(sampled.unwrap().verdict == simdop_motion_verdict::Hit, is_hit);
        counts[usize::from(is_hit)] += 1;
        // SAFETY: as above.
        let none = answer(|answer| unsafe {
            simdop_planner_check_motion_discrete(Some(&c), Some(&mut workspace), from, to, 0, answer)
        });
        assert_eq!(none.unwrap_err(), simdop_error::MotionNoParts);
    }
    assert!(counts[0] > 0 && counts[1] > 0, "{counts:?}");
    for values in &configurations {
        let (mut hits, v) = (Vec::<simdop_scene_hit>::new(), values.as_ptr());
        // SAFETY: as above; the callback gets its list.
        let ended = answer(|ended| unsafe {
            let (w, user) = (Some(&mut *workspace), (&raw mut hits).cast());
            simdop_planner_each_hit(Some(&c), w, v, 0.2, Some(collect), user, ended)
        });
        assert_eq!(ended.unwrap().completion, simdop_completion::Complete);
        let expected = rust.hits(&mut rust_workspace, values, 0.2).unwrap();
        let ids = |a: u64, b: u64, pair: [u32; 2]| (a, b, pair);
        let c_hits: Vec<_> = hits.iter().map(|hit| ids(hit.a, hit.b, [hit.pair.a, hit.pair.b])).collect();
        let rust_hits = expected.iter().map(|it| ids(it.a.to_bits(), it.b.to_bits(), [it.pair.a, it.pair.b]));
        assert_eq!(c_hits, rust_hits.collect::<Vec<_>>());
        let mut gradient = vec![7.0; n];
        for cutoff in [9.0, 1e-9] {
            // SAFETY: as above.
            let near = answer(|answer| unsafe {
                simdop_planner_clearance(Some(&c), Some(&mut workspace), v, 0.0, cutoff, answer)
            });
            // SAFETY: as above.
            let error = unsafe {
                let (w, near, to) = (Some(&mut *workspace), near.as_ref().ok(), gradient.as_mut_ptr());
                simdop_planner_clearance_gradient(Some(&c), w, near, to)
            };
            assert_eq!(error, simdop_error::None);
            let mut expected = vec![0.0; n];
            let near = rust.clearance(&mut rust_workspace, values, 0.0, cutoff).unwrap();
            if let Some(witness) = near.witness {
                rust.clearance_gradient(&mut rust_workspace, &witness, &mut expected).unwrap();
            }
            assert_eq!(gradient, expected);
            assert_eq!(near.witness.is_some(), cutoff > 1.0);
        }
        let (id, point, mut world) = (rust.link("hand").unwrap(), [0.1, 0.2, 0.3], [0.0; 3]);
        // SAFETY: there are three numbers of each.
        let error = unsafe {
            simdop_planner_to_world(
                Some(&c),
                Some(&workspace),
                id.to_bits(),
                point.as_ptr(),
                world.as_mut_ptr(),
            )
        };
        assert_eq!(error, simdop_error::None);
        assert_eq!(world, rust.to_world(&rust_workspace, id, point).unwrap());
    }
    classes(&c, &rust);
    paths(&c, &rust, &configurations);
}

fn classes(c: &simdop_planner, rust: &PlanningScene) {
    let [a, b] = [rust.link("hand").unwrap(), rust.objects()[0].0];
    let n = rust.variables();
    let (mut meeting, mut free) = (vec![7.0; n], vec![7.0; n]);
    let mut workspace = handle(|to| simdop_workspace_create(Some(c), to)).unwrap();
    // SAFETY: there is room for each variable.
    let report = answer(|report| unsafe {
        let (w, meeting, free) = (Some(&mut *workspace), meeting.as_mut_ptr(), free.as_mut_ptr());
        simdop_planner_classify_pair(Some(c), w, a.to_bits(), b.to_bits(), 1000, meeting, free, report)
    });
    let (report, expected) =
        (report.unwrap(), rust.classify_pair(&mut rust.workspace(), (a, b), 1000).unwrap());
    assert_eq!((report.boxes, Some(meeting), Some(free)), (expected.boxes, expected.meeting, expected.free));
}

fn paths(c: &simdop_planner, rust: &PlanningScene, configurations: &[Vec<f64>]) {
    let mut workspace = handle(|to| simdop_workspace_create(Some(c), to)).unwrap();
    let n = rust.variables();
    let mut longest = 0;
    for ends in configurations.chunks(3) {
        let [start, goals @ ..] = ends else { unreachable!() };
        let both = goals.concat();
        let mut plan = |settings: &simdop_plan_settings, room: usize| {
            let mut path = vec![7.0; room * n];
            let mut found = MaybeUninit::<simdop_planned_path>::uninit();
            // SAFETY: the lengths are those of the vectors.
            let error = unsafe {
                let (w, start, goals) = (Some(&mut *workspace), start.as_ptr(), both.as_ptr());
                let (goal_count, to) = (both.len() / n, path.as_mut_ptr());
                simdop_planner_plan(
                    Some(c),
                    w,
                    start,
                    goals,
                    goal_count,
                    Some(settings),
                    to,
                    room,
                    Some(&mut found),
                )
            };
            // SAFETY: the caller looks at it where the call wrote it.
            (error, unsafe { found.assume_init() }, path)
        };
        let settings = simdop_plan_settings_default();
        let goals: Vec<&[f64]> = goals.iter().map(|goal| &goal[..]).collect();
        let expected = rust.plan(&mut rust.workspace(), start, &goals, &PlanSettings::default()).unwrap();
        let (error, found, path) = plan(&settings, 64);
        assert_eq!(error, simdop_error::None);
        assert_eq!(
            (found.count, found.length, found.motions, found.nodes),
            (expected.path.len(), expected.length, expected.motions, expected.nodes)
        );
        assert_eq!(path[..found.count * n], expected.path.concat());
        longest = longest.max(found.count);
        if found.count > 1 {
            let (error, needed, _) = plan(&settings, found.count - 1);
            assert_eq!((error, needed.count), (simdop_error::Buffer, found.count));
        }
    }
    assert!(longest > 2, "{longest}");
}

/// Names and groups are those of the files; bounds, budgets and resolutions are those of the library.
#[test]
fn settings_are_the_librarys() {
    let (mut c, mut rust, _) = twins();
    let text = |name: *const c_char| {
        // SAFETY: it ends with a NUL.
        unsafe { CStr::from_ptr(name) }.to_str().unwrap().to_owned()
    };
    let count = answer(|count| simdop_planner_groups(Some(&c), count)).unwrap();
    let groups = rust.robot().groups().to_vec();
    assert!(count == groups.len() && count > 0, "{count}");
    for (i, group) in groups.iter().enumerate() {
        let name = answer(|name| simdop_planner_get_group(Some(&c), i, name)).unwrap();
        assert_eq!(text(name), group.name);
    }
    assert_eq!(
        answer(|name| simdop_planner_get_group(Some(&c), count, name)),
        Err(simdop_error::DescriptionIndex)
    );
    let values: Vec<f64> = {
        let mut rng = Rng::new(4);
        (0..500).flat_map(|_| rust.random(|| rng.range(0.0, 1.0))).collect()
    };
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let mut free = |c: &simdop_planner| {
        let mut free = vec![7_u8; 500];
        // SAFETY: the lengths are those of the vectors.
        let count = answer(|count| unsafe {
            let (w, values, free) = (Some(&mut *workspace), values.as_ptr(), free.as_mut_ptr());
            simdop_planner_check_states(Some(c), w, values, 500, free, count)
        });
        assert_eq!(count.unwrap(), free.iter().filter(|free| **free == 1).count());
        free.iter().map(|free| *free == 1).collect::<Vec<_>>()
    };
    let expected = rust.free(&values).unwrap();
    assert_eq!(free(&c), expected);
    assert_eq!(answer(|bytes| simdop_planner_bound_bytes(Some(&c), bytes)), Ok(0));
    assert_eq!(simdop_planner_use_bounds(Some(&mut c), 0.05), simdop_error::None);
    rust.use_bounds(0.05).unwrap();
    assert_eq!(answer(|bytes| simdop_planner_bound_bytes(Some(&c), bytes)).ok(), rust.bound_bytes());
    assert_eq!([free(&c), free(&c)], [expected.clone(), expected]);
    assert_eq!(simdop_planner_use_bounds(Some(&mut c), 0.0), simdop_error::PlannerCell);
    assert_eq!(simdop_planner_set_budget(Some(&mut c), 0), simdop_error::None);
    let rust = rust.with_query(Query::new(Isa::detect()).with_budget(0));
    let expected = rust.free(&values).unwrap();
    assert_eq!(free(&c), expected);
    assert_eq!(simdop_planner_set_budget(Some(&mut c), SIMDOP_NO_BUDGET), simdop_error::None);
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let mut motion = |c: &simdop_planner| {
        let (from, to) = (values.as_ptr(), values[rust.variables()..].as_ptr());
        // SAFETY: there is a value for each variable.
        answer(|answer| unsafe {
            simdop_planner_check_motion(Some(c), Some(&mut workspace), from, to, answer)
        })
    };
    assert!(motion(&c).is_ok());
    assert_eq!(simdop_planner_set_resolution(Some(&mut c), -1.0), simdop_error::None);
    assert_eq!(motion(&c).unwrap_err(), simdop_error::Tolerance);
    // Of a group, names and limits are those of its variables.
    let (group, rest) = (CString::new(&*groups[0].name).unwrap(), vec![0.0; rust.variables()]);
    // SAFETY: the name ends with a NUL, and there is a value for each variable.
    let error =
        unsafe { simdop_planner_select_group(Some(&mut c), group.as_ptr(), rest.as_ptr(), rest.len()) };
    assert_eq!(error, simdop_error::None);
    let mut rust = rust;
    rust.select_group(&groups[0].name, &rest).unwrap();
    for (i, (name, [lower, upper])) in rust.variable_names().zip(rust.limits()).enumerate() {
        let found = answer(|variable| simdop_planner_get_variable(Some(&c), i, variable)).unwrap();
        assert_eq!((&*text(found.name), found.lower, found.upper), (name, *lower, *upper));
        assert_eq!(found.is_continuous != 0, rust.is_continuous(i));
    }
    let beyond = answer(|variable| simdop_planner_get_variable(Some(&c), rust.variables(), variable));
    assert_eq!(beyond.unwrap_err(), simdop_error::DescriptionIndex);
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
    let mut workspace = handle(|to| simdop_workspace_create(Some(&c), to)).unwrap();
    let (mut path, still) = ([0.0; 8], simdop_plan_settings { step: 0.0, ..simdop_plan_settings_default() });
    let mut found = MaybeUninit::uninit();
    // SAFETY: there is a value for each variable, and room for two configurations.
    let step = unsafe {
        let (w, ends, path) = (Some(&mut *workspace), rest.as_ptr(), path.as_mut_ptr());
        simdop_planner_plan(Some(&c), w, ends, ends, 1, Some(&still), path, 2, Some(&mut found))
    };
    assert_eq!(step, simdop_error::PlannerStep);
    let states = [[0.0, 0.0, 0.0, 0.0], values, [0.0, 0.0, 9.0, 0.0]];
    // SAFETY: there are three configurations.
    let states = answer(|count| unsafe {
        let (w, values) = (Some(&mut *workspace), states.as_ptr().cast());
        simdop_planner_check_states(Some(&c), w, values, 3, path.as_mut_ptr().cast(), count)
    });
    assert_eq!(states, Err(simdop_error::MotionOutOfLimits));
    // SAFETY: the text ends with a NUL.
    let message = unsafe { CStr::from_ptr(simdop_last_error()) }.to_str().unwrap();
    assert!(message.starts_with("configuration 1: "), "{message}");
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
    nulls_of_plans(&c, &mut workspace, &mut errors);
    // SAFETY: as above.
    errors.push(handle(|to| unsafe { simdop_planner_load(null(), null(), 0.0, to) }).unwrap_err());
    // SAFETY: as above.
    errors.push(unsafe { simdop_planner_limits(Some(&c), null_mut()) });
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

fn nulls_of_plans(c: &simdop_planner, workspace: &mut simdop_workspace, errors: &mut Vec<simdop_error>) {
    let (mut values, settings, mut free) = ([0.0_f64; 8], simdop_plan_settings_default(), [0_u8]);
    let (to, free, user, id) = (values.as_mut_ptr(), free.as_mut_ptr(), null_mut(), 0);
    let (v, memory): (*const f64, *mut simdop_workspace) = (to, workspace);
    errors.push(answer(|count| simdop_planner_groups(None, count)).unwrap_err());
    errors.push(answer(|name| simdop_planner_get_group(None, 0, name)).unwrap_err());
    errors.push(answer(|variable| simdop_planner_get_variable(None, 0, variable)).unwrap_err());
    errors.push(answer(|bytes| simdop_planner_bound_bytes(None, bytes)).unwrap_err());
    errors.push(simdop_planner_use_bounds(None, 0.1));
    errors.push(simdop_planner_set_budget(None, 0));
    errors.push(simdop_planner_set_resolution(None, 0.1));
    for (memory, v) in [(None, v), (Some(memory), null())] {
        // SAFETY: it exists until the end of the function, and each reference ends with its call.
        let w = || memory.map(|memory| unsafe { &mut *memory });
        // SAFETY: what is not NULL has enough items, here and below.
        let motions = answer(|a| unsafe { simdop_planner_check_motions(Some(c), w(), v, 1, free, a) });
        // SAFETY: as above.
        let share = answer(|a| unsafe { simdop_planner_free_share(Some(c), w(), v, v, a) });
        // SAFETY: as above.
        let parts = answer(|a| unsafe { simdop_planner_check_motion_discrete(Some(c), w(), v, v, 1, a) });
        // SAFETY: as above.
        let hits =
            answer(|a| unsafe { simdop_planner_each_hit(Some(c), w(), v, 0.0, Some(collect), user, a) });
        // SAFETY: as above.
        let plan =
            answer(|a| unsafe { simdop_planner_plan(Some(c), w(), v, v, 1, Some(&settings), to, 2, a) });
        errors.extend([motions.unwrap_err(), share.unwrap_err(), parts.unwrap_err(), hits.unwrap_err()]);
        errors.push(plan.unwrap_err());
    }
    // SAFETY: as above.
    let w = || Some(unsafe { &mut *memory });
    // SAFETY: as above.
    let random =
        answer(|a| unsafe { simdop_planner_random_free(Some(c), w(), None, user, 1, to, a) }).unwrap_err();
    // SAFETY: as above.
    let hits = answer(|a| unsafe { simdop_planner_each_hit(Some(c), w(), v, 0.0, None, user, a) });
    // SAFETY: as above.
    let plan = answer(|a| unsafe { simdop_planner_plan(Some(c), w(), v, v, 1, None, to, 2, a) });
    // SAFETY: as above.
    let near = unsafe { simdop_planner_clearance_gradient(Some(c), w(), None, to) };
    // SAFETY: as above.
    let world = unsafe { simdop_planner_to_world(Some(c), None, id, v, to) };
    // SAFETY: as above.
    let class = answer(|a| unsafe { simdop_planner_classify_pair(None, w(), id, id, 1, to, to, a) });
    errors.extend([random, hits.unwrap_err(), plan.unwrap_err(), near, world, class.unwrap_err()]);
}
