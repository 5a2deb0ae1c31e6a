//! Every error code can occur, and has a text; NULL crashes nothing. `motion.rs` has the NULL tests of motions,
//! `robot.rs` those of robots.

mod support;

use simdop::construct::{Builder, Mesh, OwnedMesh};
use simdop::hierarchy::{Aligned, Bvh, Header};
use simdop::node::{Node4, Node16};
use simdop_capi::*;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::fs;
use std::mem::{MaybeUninit, offset_of};
use std::ptr::null;
use support::robot::{faults, hinge};
use support::{
    BALL, IDENTITY, answer, bytes, capped, handle, hull, open, shape, shapes, shapes_as, solid, spheres,
    spheres_as, surface, triangles_as,
};

const VERTICES: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
const TETRAHEDRON: Mesh<'static> = Mesh { vertices: &VERTICES, triangles: &TRIANGLES };

fn text(text: *const c_char) -> String {
    // SAFETY: all texts end with a NUL, and live until the next failure at least.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

fn last_error() -> String {
    text(simdop_last_error())
}

/// The bytes of a tree with two parts, writable.
fn two_parts() -> (Aligned<[u8; 2048]>, usize) {
    let apart = VERTICES.map(|[x, y, z]| [x + 5.0, y, z]);
    let vertices = [VERTICES, apart].concat();
    let triangles = [TRIANGLES, TRIANGLES.map(|t| t.map(|i| i + 4))].concat();
    let body = surface(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap();
    let (mut copy, count) = (Aligned([0; 2048]), bytes(&body).len());
    copy.0[..count].copy_from_slice(bytes(&body));
    (copy, count)
}

/// The error of opening a tree of two parts after overwriting bytes at one place.
fn opened_with(at: usize, bytes: &[u8]) -> simdop_error {
    let (mut copy, count) = two_parts();
    copy.0[at..at + bytes.len()].copy_from_slice(bytes);
    open(&copy.0[..count]).unwrap_err()
}

/// All errors of opening bytes.
fn of_bytes() -> Vec<simdop_error> {
    // Offsets in that tree: the fields of the header, and what follows the node with its normal slabs.
    let [version, k, kind, leaf_size, node] = [8, 12, 16, 18, 128];
    let storage = offset_of!(Header, storage);
    let vertices = node + size_of::<Node16<18>>() + 16 * 8;
    let [records, sources, parts] = [96, 96 + 96, 96 + 96 + 32].map(|offset| vertices + offset);
    let (copy, count) = two_parts();
    let arity_4: Bvh<Node4<18>> = Builder::new().build_as(&TETRAHEDRON).unwrap();

    assert!(open(&copy.0[..count]).is_ok());
    let body = capped(&Mesh { vertices: &VERTICES, triangles: &TRIANGLES[1..] }, 2.0, 0).unwrap();
    let caps = answer(|caps| simdop_body_caps(Some(&body), caps)).unwrap();
    assert_eq!((caps.holes, caps.triangles), (1, 1));
    let (mut damaged, capped_count) = (Aligned([0; 4096]), bytes(&body).len());
    damaged.0[..capped_count].copy_from_slice(bytes(&body));
    let lines = damaged.0[offset_of!(Header, cap_lines)] as usize;
    damaged.0[capped_count - 64 * lines] = 0;
    let caps_without_magic = open(&damaged.0[..capped_count]).unwrap_err();
    let other_node = open(arity_4.as_bytes()).unwrap_err();
    assert!(last_error().contains("arity 4"), "{}", last_error());
    assert_eq!(opened_with(k, &[14, 0]), other_node);
    let mut shifted = Aligned([0; 2048]);
    shifted.0[8..8 + count].copy_from_slice(&copy.0[..count]);
    for end in 0..count {
        assert!(open(&copy.0[..end]).is_err(), "of {end} bytes of {count}");
    }
    vec![
        other_node,
        open(&shifted.0[8..8 + count]).unwrap_err(),
        open(&copy.0[..count - 1]).unwrap_err(),
        open(&copy.0[..count + 1]).unwrap_err(),
        opened_with(0, b"simdop"),
        opened_with(version, &[99]),
        opened_with(kind, &[7]),
        opened_with(storage, &[7]),
        opened_with(leaf_size, &[0]),
        opened_with(node, &[0xff, 0x7f]),
        opened_with(vertices, &f32::NAN.to_le_bytes()),
        opened_with(records, &[8, 0, 0, 0]),
        opened_with(sources, &[8, 0, 0, 0]),
        opened_with(parts, &[8, 0, 0, 0]),
        caps_without_magic,
    ]
}

/// All errors of building.
fn of_building() -> Vec<simdop_error> {
    let changed = |place: f64| {
        let mut vertices = VERTICES;
        vertices[2][1] = place;
        surface(&Mesh { vertices: &vertices, triangles: &TRIANGLES }).unwrap_err()
    };
    let not_finite = changed(f64::NAN);
    assert!(last_error().contains("vertex 2"), "{}", last_error());
    let open = solid(&Mesh { vertices: &VERTICES, triangles: &TRIANGLES[1..] }).unwrap_err();
    let tiny = VERTICES.map(|p| p.map(|x| x * 1e-100));
    let refused = |first: *const f64, count| {
        // SAFETY: too many, or misaligned, which is detected before any is read.
        handle(|body| unsafe { simdop_body_build_spheres(first, count, body) }).unwrap_err()
    };
    let of_hulls = [hull(&VERTICES, 2), hull(&[[0.0, f64::NAN, 0.0]], 0), hull(&[[1e-80; 3]], 0)];
    let of_hulls = of_hulls.map(Result::unwrap_err);
    let (storage, vertex) = (simdop_error::BuildNoSuchStorage, simdop_error::BuildVertex);
    assert_eq!(of_hulls, [storage, vertex, simdop_error::BuildTooSmall]);
    let third = |i: u32| [3 * i, 3 * i + 1, 3 * i + 2];
    let many = (vec![VERTICES[..3].to_vec(); 16_385].concat(), (0..16_385).map(third).collect::<Vec<_>>());
    let apart: Vec<_> = (0..).zip(&many.0).map(|(i, p)| [p[0], p[1], f64::from(i / 3)]).collect();
    vec![
        not_finite,
        open,
        capped(&Mesh { vertices: &VERTICES, triangles: &TRIANGLES[1..] }, 1.0, 0).unwrap_err(),
        capped(&Mesh { vertices: &apart, triangles: &many.1 }, 9.0, 0).unwrap_err(),
        capped(&TETRAHEDRON, 1.0, 2).unwrap_err(),
        changed(f64::INFINITY),
        spheres(&[[0.0, 0.0, 0.0, -1.0]]).unwrap_err(),
        triangles_as(&TETRAHEDRON, false, 2).unwrap_err(),
        spheres_as(&[], -1).unwrap_err(),
        surface(&Mesh { vertices: &tiny, triangles: &TRIANGLES }).unwrap_err(),
        surface(&Mesh { vertices: &VERTICES[..3], triangles: &TRIANGLES }).unwrap_err(),
        refused([0.0; 4].as_ptr(), usize::MAX),
        refused(null::<f64>().wrapping_byte_add(4), 1),
    ]
}

/// A pose within the tolerance, whose columns are less perpendicular than its rows.
const SKEWED: simdop_pose = simdop_pose {
    rows: [
        [0.9083089, -0.0916911, -0.4082483, 0.0],
        [-0.0916911, 0.9083089, -0.4082483, 0.0],
        [0.4083089, 0.4083089, 0.8164966, 0.0],
    ],
};

/// All errors of shapes.
fn of_shapes() -> Vec<simdop_error> {
    let (huge, length) = (2_f64.powi(300), Err(simdop_error::ShapeLength));
    let of = |kind: simdop_shape_kind, numbers: [f64; 4]| simdop_shape { kind: kind as u32, numbers, ..BALL };
    for (kind, count) in [
        (simdop_shape_kind::Sphere, 1),
        (simdop_shape_kind::Capsule, 2),
        (simdop_shape_kind::Cuboid, 3),
        (simdop_shape_kind::Cylinder, 2),
        (simdop_shape_kind::Cone, 2),
    ] {
        for place in 0..count {
            for number in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-80, 1e100] {
                let mut numbers = [1.0; 4];
                numbers[place] = number;
                assert_eq!(shape(&of(kind, numbers)).map(drop), length, "{kind:?} {numbers:?}");
            }
        }
        assert!(shape(&of(kind, [1.0; 4])).is_ok());
    }
    for radius in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(shape(&simdop_shape { radius, ..BALL }).map(drop), length);
    }
    let half_space = |numbers| of(simdop_shape_kind::HalfSpace, numbers);
    let (ground, cuboid) = (half_space([0.0, 0.0, 2.0, 1.0]), of(simdop_shape_kind::Cuboid, [1.0; 4]));
    assert!(shape(&ground).is_ok());
    let mut far = of(simdop_shape_kind::Capsule, [1.0, huge, 0.0, 0.0]);
    far.pose.rows[2][3] = huge;
    let mut beyond = simdop_shape { numbers: [huge; 4], ..BALL };
    beyond.pose.rows[0][3] = huge;
    let mut nowhere = BALL;
    nowhere.pose.rows[0][0] = 0.0;
    let length = shapes(&[BALL, simdop_shape { radius: -1.0, ..BALL }]).unwrap_err();
    assert!(last_error().starts_with("shape 1: "), "{}", last_error());
    let skewed = shape(&simdop_shape { pose: SKEWED, ..cuboid }).unwrap_err();
    assert!(last_error().contains("perpendicular"), "{}", last_error());
    let ball = shape(&BALL).unwrap();
    let bytes = answer(|count| simdop_body_bytes(Some(&ball), Some(&mut MaybeUninit::uninit()), count));
    vec![
        length,
        skewed,
        bytes.unwrap_err(),
        shape(&simdop_shape { kind: 6, ..BALL }).unwrap_err(),
        shape(&simdop_shape { kind: u32::MAX, ..BALL }).unwrap_err(),
        shape(&half_space([0.0, 0.0, 0.0, 1.0])).unwrap_err(),
        shape(&half_space([0.0, f64::NAN, 1.0, 1.0])).unwrap_err(),
        shape(&half_space([0.0, 0.0, 1.0, f64::INFINITY])).unwrap_err(),
        shape(&far).unwrap_err(),
        shape(&nowhere).unwrap_err(),
        shapes(&[BALL, ground]).unwrap_err(),
        shapes(&[beyond]).unwrap_err(),
        shapes(&[simdop_shape { kind: simdop_shape_kind::Cuboid as u32, ..beyond }]).unwrap_err(),
        shapes_as(&[BALL], 2).unwrap_err(),
        handle(|scene| simdop_scene_create_as(2, scene)).unwrap_err(),
    ]
}

#[test]
fn shapes_have_the_codes_of_their_faults() {
    use simdop_error::*;
    let expected = [
        ShapeLength,
        ShapeNotPerpendicular,
        ShapeNoBytes,
        ShapeNoSuchKind,
        ShapeNoSuchKind,
        ShapeNoDirection,
        ShapeCoordinate,
        ShapeCoordinate,
        ShapeCoordinate,
        PoseNotOrthonormal,
        ShapeUnbounded,
        BuildRadius,
        BuildVertex,
        BuildNoSuchStorage,
        BuildNoSuchStorage,
    ];
    assert_eq!(of_shapes(), expected);
}

/// All errors of poses and margins.
fn of_queries() -> Vec<simdop_error> {
    let body = surface(&TETRAHEDRON).unwrap();
    let placed = |row: usize, column: usize, number: f64| {
        let mut pose = IDENTITY;
        pose.rows[row][column] = number;
        answer(|answer| simdop_collide(Some(&body), Some(&body), Some(&pose), SIMDOP_NO_BUDGET, answer))
            .unwrap_err()
    };
    let not_rigid = placed(0, 0, 1.1);
    assert!(last_error().contains("differs from 1 by"), "{}", last_error());
    let half = triangles_as(&TETRAHEDRON, true, simdop_storage::Half as c_int).unwrap();
    let other_storage =
        answer(|answer| simdop_collide(Some(&body), Some(&half), Some(&IDENTITY), SIMDOP_NO_BUDGET, answer));
    let message =
        "a body of fixed point cannot be tested against one of half floats: build one of them again";
    assert_eq!(last_error(), message);
    let (body, zeros) = (Some(&*body), [0.0; 4]);
    // SAFETY: four numbers, and three.
    let not_unit =
        answer(|pose| unsafe { simdop_pose_from_quaternion(zeros.as_ptr(), zeros.as_ptr(), pose) });
    let margin = answer(|answer| simdop_within(body, body, Some(&IDENTITY), -1.0, SIMDOP_NO_BUDGET, answer));
    let ball = shape(&BALL).unwrap();
    let ball = Some(&*ball);
    for (a, b) in [(body, ball), (ball, body), (ball, ball)] {
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let (pose, no_budget) = (Some(&IDENTITY), SIMDOP_NO_BUDGET);
            let within = answer(|answer| simdop_within(a, b, pose, wrong, no_budget, answer));
            let distance = answer(|answer| simdop_distance(a, b, pose, wrong, no_budget, answer));
            assert_eq!([within.unwrap_err(), distance.unwrap_err()], [simdop_error::Tolerance; 2]);
        }
        // Only a tree against a shape needs the inverse of the pose.
        let skewed = answer(|answer| simdop_collide(a, b, Some(&SKEWED), SIMDOP_NO_BUDGET, answer));
        let is_inverted = std::ptr::eq(a.unwrap(), body.unwrap());
        assert_eq!(skewed.err(), is_inverted.then_some(simdop_error::PoseNotOrthonormal));
    }
    let volume = answer(|volume| simdop_penetration(body, body, Some(&IDENTITY), SIMDOP_NO_BUDGET, volume));
    let mut room = Vec::with_capacity(1);
    // SAFETY: there is room for one.
    let contacts = answer(|to| unsafe {
        simdop_contacts(ball, body, Some(&IDENTITY), SIMDOP_NO_BUDGET, room.as_mut_ptr(), 1, to)
    });
    vec![
        volume.unwrap_err(),
        contacts.unwrap_err(),
        not_rigid,
        placed(0, 3, f64::NAN),
        placed(0, 3, 1e300),
        placed(0, 0, -1.0),
        not_unit.unwrap_err(),
        margin.unwrap_err(),
        other_storage.unwrap_err(),
    ]
}

/// All errors of scenes.
fn of_scenes() -> Vec<simdop_error> {
    let body: &'static simdop_body = Box::leak(surface(&TETRAHEDRON).unwrap());
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let mut insert = |radius: f64| {
        let role = simdop_role { radius, ..simdop_role_default() };
        answer(|id| simdop_scene_insert(Some(&mut scene), Some(body), Some(&role), Some(&IDENTITY), id))
    };
    let (a, b, radius) = (insert(0.0).unwrap(), insert(1.0).unwrap(), insert(f64::NAN).unwrap_err());
    assert_eq!(simdop_scene_attach(Some(&mut scene), a, b), simdop_error::None);
    let mut errors = of_edges(&mut scene, b);
    errors.extend(of_robots(&mut scene, b));
    errors.extend([
        radius,
        simdop_scene_place(Some(&mut scene), a, Some(&IDENTITY)),
        simdop_scene_attach(Some(&mut scene), b, a),
        simdop_scene_allow_collision(Some(&mut scene), a, a),
        simdop_scene_detach(Some(&mut scene), SIMDOP_NO_BODY),
    ]);
    assert_eq!(simdop_scene_remove(Some(&mut scene), b), simdop_error::None);
    assert_eq!(simdop_scene_remove(Some(&mut scene), b), simdop_error::SceneNoSuchBody);
    // Nothing is attached to a removed body.
    assert_eq!(simdop_scene_place(Some(&mut scene), a, Some(&IDENTITY)), simdop_error::None);
    errors
}

/// All errors of clouds and searches.
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn of_clouds() -> Vec<simdop_error> {
    let points: Vec<[f32; 3]> = (0..16_u8).map(|i| [f32::from(i), 0.0, 0.0]).collect();
    let (first, nan) = (points.as_ptr().cast::<f32>(), [f32::NAN, 0.0, 0.0]);
    let mut errors = Vec::new();
    // SAFETY: the lengths are those of the arrays.
    unsafe {
        let build = simdop_cloud_build_with_room;
        errors.push(handle(|cloud| build(nan.as_ptr(), 1, 16, 1, cloud)).unwrap_err());
        errors.push(handle(|cloud| build(first, 16, 0, 16, cloud)).unwrap_err());
        errors.push(handle(|cloud| build(first, 16, 17, 16, cloud)).unwrap_err());
        assert_eq!(
            handle(|cloud| build(first, 16, 16, usize::MAX, cloud)).err(),
            Some(simdop_error::TooLarge)
        );
        let cloud = Box::leak(handle(|cloud| build(first, 16, 16, 20, cloud)).unwrap());
        errors.push(answer(|ratio| simdop_cloud_refit(Some(&mut *cloud), first, 16, ratio)).unwrap_err());
        errors.push(simdop_cloud_insert(Some(&mut *cloud), 0, first));
        errors.push(simdop_cloud_insert(Some(&mut *cloud), 20, first));
        errors.push(simdop_cloud_remove(Some(&mut *cloud), 17));
        errors.push(simdop_cloud_insert(Some(&mut *cloud), 17, first));
        let some = Some(&*cloud);
        for radius in [-1.0, f32::NAN, f32::INFINITY] {
            errors.push(answer(|any| simdop_cloud_any_within(some, first, radius, any)).unwrap_err());
        }
        errors.push(answer(|any| simdop_cloud_any_within(some, nan.as_ptr(), 1.0, any)).unwrap_err());
        let mut counts = [0; 20];
        let mut count = |radii: &[f32], room| {
            let (radii, len, counts) = (radii.as_ptr(), radii.len(), counts.as_mut_ptr());
            answer(|stats| simdop_cloud_count(some, radii, len, counts, room, stats)).unwrap_err()
        };
        errors.push(count(&[1.0], 19));
        errors.push(count(&[1.0; 2], 20));
        let mut nearest = [simdop_neighbour { index: 0, square: 0.0 }; 2];
        let two = [[0.0; 3], nan];
        errors.push(simdop_cloud_nearest(some, two.as_ptr().cast(), 2, 1, nearest.as_mut_ptr()));
        assert!(last_error().contains("query 1"), "{}", last_error());
        let huge = simdop_cloud_nearest(some, first, 16, usize::MAX, nearest.as_mut_ptr());
        assert_eq!(huge, simdop_error::TooLarge);
    }
    let cloud: &'static simdop_cloud =
        // SAFETY: the length is that of the vector.
        Box::leak(handle(|cloud| unsafe { simdop_cloud_build(first, 16, cloud) }).unwrap());
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let role = simdop_role_default();
    let mut insert = || {
        answer(|id| {
            simdop_scene_insert_cloud(Some(&mut scene), Some(cloud), Some(&role), Some(&IDENTITY), id)
        })
    };
    let (a, b) = (insert().unwrap(), insert().unwrap());
    errors.push(simdop_scene_forbid_collision(Some(&mut scene), a, b));
    errors
}

#[test]
fn clouds_have_the_codes_of_their_faults() {
    use simdop_error::*;
    let expected = [
        CloudPoint,
        CloudBucketSize,
        CloudBucketSize,
        CloudPositions,
        CloudIndex,
        CloudIndex,
        CloudIndex,
        CloudFull,
        SearchRadius,
        SearchRadius,
        SearchRadius,
        SearchQuery,
        Buffer,
        Buffer,
        SearchQuery,
        SceneTwoClouds,
    ];
    assert_eq!(of_clouds(), expected);
}

/// Functions for clouds, many configurations, pairs and spheres, with NULL for each pointer in turn.
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn of_null_buffers() -> Vec<simdop_error> {
    unsafe extern "C" fn on_point(_: *mut c_void, _: u32) -> c_int {
        0
    }
    unsafe extern "C" fn on_pair(_: *mut c_void, _: *const simdop_pair) -> c_int {
        0
    }
    let (floats, mut numbers, mut counts) = ([0.5_f32; 12], [0.0; 12], [0_u32; 12]);
    let (some, user) = (floats.as_ptr(), std::ptr::null_mut());
    let (mut seats, mut lists) = ([0_u64; 4], [simdop_list { start: 0, count: 0 }; 4]);
    let mut nearest = [simdop_neighbour { index: 0, square: 0.0 }; 4];
    let into = simdop_neighbour_lists {
        lists: lists.as_mut_ptr(),
        list_count: 4,
        indices: counts.as_mut_ptr(),
        room: 12,
        needed: 0,
    };
    let mut no_lists = simdop_neighbour_lists { lists: std::ptr::null_mut(), ..into };
    let mut no_indices = simdop_neighbour_lists { indices: std::ptr::null_mut(), ..into };
    let (mut into, mut errors) = (into, Vec::new());
    // SAFETY: what is not NULL has enough items.
    unsafe {
        let mut cloud = handle(|cloud| simdop_cloud_build(some, 4, cloud)).unwrap();
        errors.push(handle(|cloud| simdop_cloud_build(null(), 4, cloud)).unwrap_err());
        errors.push(simdop_cloud_build(some, 4, None));
        errors.push(answer(|ratio| simdop_cloud_refit(None, some, 4, ratio)).unwrap_err());
        errors.push(answer(|ratio| simdop_cloud_refit(Some(&mut cloud), null(), 4, ratio)).unwrap_err());
        errors.push(simdop_cloud_refit(Some(&mut cloud), some, 4, None));
        errors.push(simdop_cloud_insert(None, 0, some));
        errors.push(simdop_cloud_insert(Some(&mut cloud), 0, null()));
        let c = Some(&*cloud);
        for (cloud, centre) in [(None, some), (c, null())] {
            errors.push(answer(|any| simdop_cloud_any_within(cloud, centre, 1.0, any)).unwrap_err());
            let each = |stats: Option<&mut MaybeUninit<_>>| {
                simdop_cloud_each_within(cloud, centre, 1.0, Some(on_point), user, stats)
            };
            errors.push(answer(each).unwrap_err());
            errors.push(simdop_cloud_nearest(cloud, centre, 1, 1, nearest.as_mut_ptr()));
            let to = counts.as_mut_ptr();
            errors.push(answer(|stats| simdop_cloud_count(cloud, centre, 1, to, 12, stats)).unwrap_err());
            let lists = Some(&mut into);
            errors.push(answer(|stats| simdop_cloud_neighbours(cloud, centre, 1, lists, stats)).unwrap_err());
            let (lists, memory) = (Some(&mut into), seats.as_mut_ptr());
            let of = simdop_cloud_neighbours_of;
            errors.push(answer(|stats| of(cloud, centre, 4, some, 1, memory, lists, stats)).unwrap_err());
        }
        errors.push(simdop_cloud_any_within(c, some, 1.0, None));
        errors.push(answer(|to| simdop_cloud_each_within(c, some, 1.0, None, user, to)).unwrap_err());
        errors.push(simdop_cloud_each_within(c, some, 1.0, Some(on_point), user, None));
        errors.push(simdop_cloud_nearest(c, some, 1, 1, std::ptr::null_mut()));
        let none = std::ptr::null_mut();
        errors.push(answer(|stats| simdop_cloud_count(c, some, 1, none, 12, stats)).unwrap_err());
        errors.push(simdop_cloud_count(c, some, 1, counts.as_mut_ptr(), 12, None));
        for lists in [None, Some(&mut no_lists), Some(&mut no_indices)] {
            errors.push(answer(|stats| simdop_cloud_neighbours(c, some, 1, lists, stats)).unwrap_err());
        }
        errors.push(simdop_cloud_neighbours(c, some, 1, Some(&mut into), None));
        for (radii, memory) in [(null(), seats.as_mut_ptr()), (some, std::ptr::null_mut())] {
            let (of, into) = (simdop_cloud_neighbours_of, Some(&mut into));
            errors.push(answer(|stats| of(c, some, 4, radii, 1, memory, into, stats)).unwrap_err());
        }

        let body = surface(&TETRAHEDRON).unwrap();
        let (body, at, budget) = (Some(&*body), Some(&IDENTITY), SIMDOP_NO_BUDGET);
        let mut answers = Vec::with_capacity(1);
        errors.push(simdop_collide_at_poses(None, body, &IDENTITY, 1, budget, answers.as_mut_ptr()));
        errors.push(simdop_collide_at_poses(body, body, null(), 1, budget, answers.as_mut_ptr()));
        errors.push(simdop_collide_at_poses(body, body, &IDENTITY, 1, budget, std::ptr::null_mut()));
        for (a, pose, on_pair) in
            [(None, at, Some(on_pair as _)), (body, None, Some(on_pair as _)), (body, at, None)]
        {
            errors.push(answer(|to| simdop_each_pair(a, body, pose, budget, on_pair, user, to)).unwrap_err());
        }
        errors.push(simdop_each_pair(body, body, at, budget, Some(on_pair), user, None));
        let (v, t) = (TETRAHEDRON.vertices.as_ptr().cast(), TETRAHEDRON.triangles.as_ptr().cast());
        let to = numbers.as_mut_ptr();
        for (v, t, to) in [(null(), t, to), (v, null(), to), (v, t, std::ptr::null_mut())] {
            errors.push(answer(|done| simdop_pack(v, 4, t, 4, to, 3, None, user, done)).unwrap_err());
            errors.push(answer(|count| simdop_cover(v, 4, t, 4, 0.1, 0, to, 3, count)).unwrap_err());
        }
        errors.push(simdop_pack(v, 4, t, 4, to, 3, None, user, None));
        errors.push(simdop_cover(v, 4, t, 4, 0.1, 0, to, 3, None));
    }
    errors
}

/// Further functions of scenes and bodies, with NULL for each pointer in turn.
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn of_null_states() -> Vec<simdop_error> {
    let (id, budget, at, mut errors) = (0, SIMDOP_NO_BUDGET, Some(&IDENTITY), Vec::new());
    let (here, plain, mut byte, value, mut room) = (IDENTITY, simdop_role_default(), 0, 0.5, 0.5);
    let (ids, pose) = (&raw const id, &raw const here);
    let (free, values, to) = (&raw mut byte, &raw const value, &raw mut room);
    let robot = hinge().robot().unwrap();
    let robot = Some(&*robot);
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    // SAFETY: what is not NULL has enough items.
    unsafe {
        let check = simdop_scene_check_states;
        errors.push(answer(|done| check(None, ids, 1, pose, 1, budget, free, done)).unwrap_err());
        errors.push(
            answer(|done| check(Some(&mut scene), null(), 1, pose, 1, budget, free, done)).unwrap_err(),
        );
        errors
            .push(answer(|done| check(Some(&mut scene), ids, 1, null(), 1, budget, free, done)).unwrap_err());
        let none = std::ptr::null_mut();
        errors.push(answer(|done| check(Some(&mut scene), ids, 1, pose, 1, budget, none, done)).unwrap_err());
        errors.push(check(Some(&mut scene), ids, 1, pose, 1, budget, free, None));
        let check = simdop_scene_check_joint_states;
        errors.push(answer(|done| check(None, ids, 1, robot, values, 1, budget, free, done)).unwrap_err());
        errors.push(
            answer(|done| check(Some(&mut scene), null(), 1, robot, values, 1, budget, free, done))
                .unwrap_err(),
        );
        errors.push(
            answer(|done| check(Some(&mut scene), ids, 1, None, values, 1, budget, free, done)).unwrap_err(),
        );
        errors.push(
            answer(|done| check(Some(&mut scene), ids, 1, robot, null(), 1, budget, free, done)).unwrap_err(),
        );
        errors.push(
            answer(|done| check(Some(&mut scene), ids, 1, robot, values, 1, budget, none, done)).unwrap_err(),
        );
        errors.push(check(Some(&mut scene), ids, 1, robot, values, 1, budget, free, None));
        let classify = simdop_scene_classify_pair;
        errors.push(answer(|done| classify(None, ids, 1, robot, 0, 1, 9, to, to, done)).unwrap_err());
        errors.push(
            answer(|done| classify(Some(&mut scene), null(), 1, robot, 0, 1, 9, to, to, done)).unwrap_err(),
        );
        errors.push(
            answer(|done| classify(Some(&mut scene), ids, 1, None, 0, 1, 9, to, to, done)).unwrap_err(),
        );
        let none = std::ptr::null_mut();
        errors.push(
            answer(|done| classify(Some(&mut scene), ids, 1, robot, 0, 1, 9, none, to, done)).unwrap_err(),
        );
        errors.push(
            answer(|done| classify(Some(&mut scene), ids, 1, robot, 0, 1, 9, to, none, done)).unwrap_err(),
        );
        errors.push(classify(Some(&mut scene), ids, 1, robot, 0, 1, 9, to, to, None));
        errors.push(simdop_scene_place_all(None, ids, pose, 1));
        errors.push(simdop_scene_place_all(Some(&mut scene), null(), pose, 1));
        errors.push(simdop_scene_place_all(Some(&mut scene), ids, null(), 1));
        let cloud = handle(|cloud| simdop_cloud_build([0.0; 3].as_ptr(), 1, cloud)).unwrap();
        let cloud: &'static simdop_cloud = Box::leak(cloud);
        let (cloud, role) = (Some(cloud), Some(&plain));
        let insert = simdop_scene_insert_cloud;
        errors.push(answer(|id| insert(None, cloud, role, at, id)).unwrap_err());
        errors.push(answer(|id| insert(Some(&mut scene), None, role, at, id)).unwrap_err());
        errors.push(answer(|id| insert(Some(&mut scene), cloud, None, at, id)).unwrap_err());
        errors.push(answer(|id| insert(Some(&mut scene), cloud, role, None, id)).unwrap_err());
        errors.push(insert(Some(&mut scene), cloud, role, at, None));
    }
    let body = surface(&TETRAHEDRON).unwrap();
    let (body, mut hint) = (Some(&*body), SIMDOP_NO_HINT);
    errors.push(answer(|to| simdop_collide_with_hint(body, body, at, budget, None, to)).unwrap_err());
    errors.push(answer(|to| simdop_within_with_hint(body, body, at, 0.0, budget, None, to)).unwrap_err());
    errors.push(
        answer(|to| simdop_distance_with_hint(body, body, at, 0.0, 1.0, budget, None, to)).unwrap_err(),
    );
    errors.push(
        answer(|to| simdop_collide_with_hint(body, None, at, budget, Some(&mut hint), to)).unwrap_err(),
    );
    errors.push(simdop_collide_with_hint(body, body, at, budget, Some(&mut hint), None));
    errors.push(simdop_distance_up_to(body, body, at, 0.0, 1.0, budget, None));
    errors.push(answer(|to| simdop_penetration(body, None, at, budget, to)).unwrap_err());
    errors.push(answer(|to| simdop_penetration(body, body, None, budget, to)).unwrap_err());
    errors.push(simdop_penetration(body, body, at, budget, None));
    errors.push(simdop_body_verify(None));
    errors.push(simdop_cloud_rebuild(None));
    errors.push(simdop_cloud_remove(None, 0));
    errors.push(answer(|size| simdop_cloud_get_size(None, size)).unwrap_err());
    errors.push(answer(|world| simdop_scene_world_pose(None, 0, world)).unwrap_err());
    errors.push(answer(|is_asked| simdop_scene_is_asked(None, 0, 0, is_asked)).unwrap_err());
    simdop_cloud_destroy(None);
    errors
}

#[test]
fn configurations_of_no_body_have_a_code() {
    let (mut scene, none, here) = (handle(|scene| simdop_scene_create(scene)).unwrap(), 0_u64, IDENTITY);
    let mut free = [7_u8; 2];
    // SAFETY: there is room for two configurations of no body.
    let found = answer(|done| unsafe {
        let (ids, poses, free) = (&raw const none, &raw const here, free.as_mut_ptr());
        simdop_scene_check_states(Some(&mut scene), ids, 0, poses, 2, SIMDOP_NO_BUDGET, free, done)
    });
    assert_eq!(found, Err(simdop_error::MotionBodies));
}

/// A motion that stops immediately.
fn motion() -> simdop_motion {
    unsafe extern "C" fn go_to(_: *mut c_void, _: f64, _: *mut simdop_pose) -> c_int {
        1
    }
    unsafe extern "C" fn path(_: *mut c_void, _: usize, _: *const f64, _: f64, _: f64) -> f64 {
        f64::NAN
    }
    let user = std::ptr::null_mut();
    simdop_motion { user, go_to: Some(go_to), path: Some(path), motion_bound_between: None }
}

/// All errors of motions of a body in the scene.
fn of_edges(scene: &mut simdop_scene, id: simdop_body_id) -> Vec<simdop_error> {
    let (budget, mut errors) = (SIMDOP_NO_BUDGET, Vec::new());
    for resolution in [1e-3, 0.0, -1.0, f64::NAN] {
        // SAFETY: there is one id; the motion does not use `user`.
        let edge = answer(|answer| unsafe {
            simdop_scene_check_motion(
                Some(scene),
                &raw const id,
                1,
                Some(&motion()),
                resolution,
                budget,
                answer,
            )
        });
        let stopped = last_error().contains("returned 1 at the time 0.5");
        assert_eq!(stopped, edge == Err(simdop_error::MotionStopped), "{}", last_error());
        errors.push(edge.unwrap_err());
    }
    for parts in [0, 1] {
        // SAFETY: as above.
        let edge = answer(|answer| unsafe {
            simdop_scene_check_motion_discrete(
                Some(scene),
                &raw const id,
                1,
                Some(&motion()),
                parts,
                budget,
                answer,
            )
        });
        errors.push(edge.unwrap_err());
    }
    let mut mirrored = IDENTITY;
    mirrored.rows[0][0] = -1.0;
    for (from, to) in [(&mirrored, &IDENTITY), (&IDENTITY, &mirrored)] {
        let edge = answer(|answer| {
            simdop_scene_check_screw(Some(scene), id, Some(from), Some(to), 0.1, budget, answer)
        });
        assert_eq!(edge, Err(simdop_error::PoseMirrored));
    }
    let no_way = answer(|answer| {
        simdop_scene_check_screw(Some(scene), id, Some(&IDENTITY), Some(&IDENTITY), 0.0, budget, answer)
    });
    assert_eq!(no_way, Err(simdop_error::Tolerance));
    errors
}

/// All errors of robots, and of a robot that moves a body in the scene.
fn of_robots(scene: &mut simdop_scene, id: simdop_body_id) -> Vec<simdop_error> {
    let mut errors: Vec<_> = faults().iter().map(|(_, parts)| parts.robot().unwrap_err()).collect();
    let robot = hinge().robot().unwrap();
    for (count, end) in [(0, 1.0), (1, 3.0)] {
        let (scene, robot, (from, to)) = (Some(&mut *scene), Some(&*robot), (&raw const end, &raw const end));
        // SAFETY: there is one id, and one value for the one variable.
        let edge = answer(|answer| unsafe {
            simdop_scene_check_joint_motion(
                scene,
                &raw const id,
                count,
                robot,
                from,
                to,
                0.1,
                SIMDOP_NO_BUDGET,
                answer,
            )
        });
        errors.push(edge.unwrap_err());
    }
    errors
}

/// Functions with an array or callback that is NULL, or with NULL for the result.
#[expect(clippy::multiple_unsafe_ops_per_block, reason = "one comment covers all of them")]
fn of_null_arrays(scene: &simdop_scene) -> Vec<simdop_error> {
    unsafe extern "C" fn go_on(_: *mut c_void, _: *const simdop_scene_hit) -> c_int {
        0
    }
    let (twelve, three, no_budget) = ([0.0; 12], [0_u32; 3], SIMDOP_NO_BUDGET);
    let (numbers, indices, mut errors) = (twelve.as_ptr(), three.as_ptr(), Vec::new());
    // SAFETY: what is not NULL has enough items.
    unsafe {
        errors.push(handle(|body| simdop_body_open(null(), 0, body)).unwrap_err());
        errors.push(simdop_body_open(numbers.cast(), 96, None));
        for build in [simdop_body_build_surface, simdop_body_build_solid] {
            errors.push(handle(|body| build(null(), 0, indices, 1, body)).unwrap_err());
            errors.push(handle(|body| build(numbers, 4, null(), 0, body)).unwrap_err());
            errors.push(build(numbers, 4, indices, 1, None));
        }
        errors.push(
            handle(|body| simdop_body_build_triangles_as(null(), 0, indices, 1, 0, 1, body)).unwrap_err(),
        );
        errors.push(
            handle(|body| simdop_body_build_triangles_as(numbers, 4, null(), 0, 0, 1, body)).unwrap_err(),
        );
        errors.push(simdop_body_build_triangles_as(numbers, 4, indices, 1, 0, 1, None));
        let build = simdop_body_build_solid_with_caps;
        errors.push(handle(|body| build(null(), 0, indices, 1, 1.0, 0, body)).unwrap_err());
        errors.push(handle(|body| build(numbers, 4, null(), 0, 1.0, 0, body)).unwrap_err());
        errors.push(build(numbers, 4, indices, 1, 1.0, 0, None));
        errors.push(handle(|body| simdop_body_build_hull(null(), 1, body)).unwrap_err());
        errors.push(simdop_body_build_hull(numbers, 4, None));
        errors.push(handle(|body| simdop_body_build_hull_as(null(), 1, 1, body)).unwrap_err());
        errors.push(simdop_body_build_hull_as(numbers, 4, 1, None));
        errors.push(handle(|body| simdop_body_build_spheres_as(null(), 1, 1, body)).unwrap_err());
        errors.push(simdop_body_build_spheres_as(numbers, 3, 1, None));
        errors.push(handle(|packed| simdop_body_build_packed(None, numbers, 1, packed)).unwrap_err());
        let ball = shape(&BALL).unwrap();
        errors.push(handle(|packed| simdop_body_build_packed(Some(&ball), null(), 1, packed)).unwrap_err());
        errors.push(simdop_body_build_packed(Some(&ball), numbers, 1, None));
        errors.push(handle(|body| simdop_body_build_spheres(null(), 1, body)).unwrap_err());
        errors.push(simdop_body_build_spheres(numbers, 3, None));
        errors.push(handle(|body| simdop_body_build_shapes(null(), 1, body)).unwrap_err());
        errors.push(simdop_body_build_shapes([BALL].as_ptr(), 1, None));
        errors.push(handle(|body| simdop_body_build_shapes_as(null(), 1, 1, body)).unwrap_err());
        errors.push(simdop_body_build_shapes_as([BALL].as_ptr(), 1, 1, None));
        errors.push(answer(|pose| simdop_pose_from_quaternion(null(), numbers, pose)).unwrap_err());
        errors.push(answer(|pose| simdop_pose_from_quaternion(numbers, null(), pose)).unwrap_err());
        errors.push(simdop_pose_from_quaternion(numbers, numbers, None));
        let user = std::ptr::null_mut();
        let each = |scene, on_hit| {
            answer(|hits| simdop_scene_each_hit(scene, 0.0, no_budget, on_hit, user, hits)).unwrap_err()
        };
        errors.push(each(None, Some(go_on)));
        errors.push(each(Some(scene), None));
        errors.push(simdop_scene_each_hit(Some(scene), 0.0, no_budget, Some(go_on), user, None));
    }
    errors
}

/// The other functions, with NULL for each pointer.
fn of_null() -> Vec<simdop_error> {
    let body: &'static simdop_body =
        Box::leak(solid(&OwnedMesh::cuboid([1.0; 3]).unwrap().as_mesh()).unwrap());
    let (role, no_budget, some, pose) =
        (simdop_role_default(), SIMDOP_NO_BUDGET, Some(body), Some(&IDENTITY));
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let mut errors = of_null_arrays(&scene);
    let (mut first, mut count) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    errors.push(simdop_body_bytes(None, Some(&mut first), Some(&mut count)));
    errors.push(simdop_body_bytes(some, None, Some(&mut count)));
    errors.push(simdop_body_bytes(some, Some(&mut first), None));
    errors.push(answer(|caps| simdop_body_caps(None, caps)).unwrap_err());
    errors.push(simdop_body_caps(some, None));
    for (a, b, pose) in [(None, some, pose), (some, None, pose), (some, some, None)] {
        errors.push(answer(|answer| simdop_collide(a, b, pose, no_budget, answer)).unwrap_err());
        errors.push(answer(|answer| simdop_within(a, b, pose, 0.0, no_budget, answer)).unwrap_err());
        errors.push(answer(|answer| simdop_distance(a, b, pose, 0.0, no_budget, answer)).unwrap_err());
    }
    errors.push(simdop_collide(some, some, pose, no_budget, None));
    errors.push(simdop_within(some, some, pose, 0.0, no_budget, None));
    errors.push(simdop_distance(some, some, pose, 0.0, no_budget, None));

    errors.push(handle(|body| simdop_body_build_shape(None, body)).unwrap_err());
    errors.push(simdop_body_build_shape(Some(&BALL), None));
    errors.push(simdop_scene_create(None));
    errors.push(simdop_scene_create_as(0, None));
    errors.push(answer(|id| simdop_scene_insert(None, some, Some(&role), pose, id)).unwrap_err());
    for (body, role, pose) in [(None, Some(&role), pose), (some, None, pose), (some, Some(&role), None)] {
        errors.push(answer(|id| simdop_scene_insert(Some(&mut scene), body, role, pose, id)).unwrap_err());
    }
    errors.push(simdop_scene_insert(Some(&mut scene), some, Some(&role), pose, None));
    errors.push(simdop_scene_remove(None, 0));
    errors.push(simdop_scene_place(None, 0, pose));
    errors.push(simdop_scene_place(Some(&mut scene), 0, None));
    errors.push(simdop_scene_attach(None, 0, 0));
    errors.push(simdop_scene_detach(None, 0));
    errors.push(simdop_scene_allow_collision(None, 0, 0));
    errors.push(answer(|answer| simdop_scene_collide(None, no_budget, answer)).unwrap_err());
    errors.push(simdop_scene_collide(Some(&scene), no_budget, None));
    errors.push(answer(|answer| simdop_scene_within(None, 0.0, no_budget, answer)).unwrap_err());
    errors.push(simdop_scene_within(Some(&scene), 0.0, no_budget, None));
    errors.push(answer(|near| simdop_scene_clearance(None, 0.0, 1.0, no_budget, near)).unwrap_err());
    errors.push(simdop_scene_clearance(Some(&scene), 0.0, 1.0, no_budget, None));
    simdop_body_destroy(None);
    simdop_scene_destroy(None);
    errors
}

#[test]
fn null_is_an_error_wherever_it_is_given() {
    assert_eq!(last_error(), "", "of a thread without a failure");
    let all = [of_null(), of_null_buffers(), of_null_states()].concat();
    for (place, error) in all.into_iter().enumerate() {
        assert_eq!(error, simdop_error::Null, "{place}");
    }
    assert!(last_error().ends_with(" is NULL"), "{}", last_error());
}

#[test]
fn every_code_can_be_had_and_has_a_text() {
    let had =
        [of_null(), of_bytes(), of_building(), of_shapes(), of_queries(), of_scenes(), of_clouds()].concat();
    let had: BTreeSet<_> = had.into_iter().map(|error| error as c_int).collect();
    let header = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/include/simdop.h")).unwrap();
    let codes: Vec<(&str, c_int)> = header
        .lines()
        .filter_map(|line| line.trim().strip_prefix("SIMDOP_ERROR_")?.strip_suffix(',')?.split_once(" = "))
        .map(|(name, code)| (name, code.parse().unwrap()))
        .collect();
    let texts: BTreeSet<_> = codes.iter().map(|(_, code)| text(simdop_error_text(*code))).collect();
    assert!(texts.len() == codes.len() && codes.len() > 30, "each has its own: {texts:?}");
    for no_code in [-1, 6, 1000] {
        assert!(!texts.contains(&text(simdop_error_text(no_code))));
    }
    for (name, code) in codes {
        // The crate's unit tests cover the codes that no call can cause.
        let elsewhere = ["NONE", "PANIC", "OTHER", "MOTION_LENGTH"].contains(&name)
            // `packing.rs`, `description.rs` and `planner.rs` cover these.
            || ["BYTES_PACKING", "BYTES_VOLUME", "BUILD_NOT_INSIDE", "BUILD_PACKING", "PACK_", "COVER_", "DESCRIPTION_", "PLANNER_"].iter().any(|of| name.starts_with(of));
        assert!(had.contains(&code) != elsewhere, "{name}");
    }
}
