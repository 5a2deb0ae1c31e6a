//! Depths, signed distances and contacts give the library's answers, and those of a cube sunk into another.

mod support;

use simdop::construct::{Builder, OwnedMesh};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::query::{Query, TriangleContact};
use simdop_capi::*;
use support::{answer, handle, pose};

type Tree = simdop::hierarchy::Bvh<Node16<18>>;

fn cube(edge: f64) -> (OwnedMesh, Tree) {
    let mesh = OwnedMesh::cuboid([edge; 3]).unwrap();
    let tree = Builder::new().solid().build_as(&mesh.as_mesh()).unwrap();
    (mesh, tree)
}

fn body(mesh: &OwnedMesh) -> Box<simdop_body> {
    let mesh = mesh.as_mesh();
    // SAFETY: the lengths are those of the slices.
    handle(|body| unsafe {
        let (vertices, triangles) = (mesh.vertices.as_ptr().cast(), mesh.triangles.as_ptr().cast());
        simdop_body_build_solid(vertices, mesh.vertices.len(), triangles, mesh.triangles.len(), body)
    })
    .unwrap()
}

#[test]
fn answers_are_the_librarys() {
    let ((small, a), (large, b)) = (cube(1.0), cube(4.0));
    let (c_a, c_b) = (body(&small), body(&large));
    let (c_a, c_b) = (Some(&*c_a), Some(&*c_b));
    let query = Query::new(Isa::detect());
    let mut rng = support::Rng::new(2);
    // The small cube's foot is 0.25 deep in the top of the large one.
    let sunk = [[1.0, 0.0, 0.0, 0.25], [0.0, 1.0, 0.0, -0.5], [0.0, 0.0, 1.0, 2.25]];
    let sunk = (simdop_pose { rows: sunk }, simdop::pose::Pose::from_rows(sunk).unwrap());
    for (i, (c_pose, pose)) in core::iter::once(sunk).chain((0..20).map(|_| pose(&mut rng))).enumerate() {
        let at = Some(&c_pose);
        let depth = answer(|to| simdop_depth(c_a, c_b, at, SIMDOP_NO_BUDGET, to)).unwrap();
        let expected = query.depth(&a, &b, &pose, None);
        assert_eq!(
            (depth.lower, depth.upper, depth.translation),
            (expected.lower, expected.upper, expected.translation)
        );
        let signed = answer(|to| simdop_signed_distance(c_a, c_b, at, 0.01, SIMDOP_NO_BUDGET, to)).unwrap();
        let expected = query.signed_distance(&a, &b, &pose, 0.01, None).unwrap();
        assert_eq!(
            (signed.lower, signed.upper, signed.normal, signed.a, signed.b, signed.gradient),
            (expected.lower, expected.upper, expected.normal, expected.a, expected.b, expected.gradient)
        );

        let (mut c_found, mut found) = (Vec::with_capacity(200), [TriangleContact::default(); 200]);
        // SAFETY: there is room for as many contacts.
        let ended = answer(|to| unsafe {
            simdop_contacts(c_a, c_b, at, SIMDOP_NO_BUDGET, c_found.as_mut_ptr(), 200, to)
        });
        let ended = ended.unwrap();
        // SAFETY: as many were written.
        unsafe { c_found.set_len(ended.count) };
        let c_found: &[simdop_contact] = &c_found;
        let expected = query.contacts(&a, &b, &pose, &mut found);
        assert_eq!(ended.count, expected.count);
        for (c, contact) in c_found.iter().zip(&found) {
            assert_eq!((c.pair.a, c.pair.b), (contact.pair.a, contact.pair.b));
            assert_eq!(&c.points[..c.count], contact.points());
            assert_eq!((c.normal_a, c.normal_b), (contact.normal_a, contact.normal_b));
        }
        if i == 0 {
            assert!(depth.upper >= 0.25 && depth.upper < 0.25 + 1e-9 && depth.lower > 0.24, "{depth:?}");
            assert!(c_found.iter().all(|contact| (contact.points[0][2] - 2.0).abs() < 1e-12), "{c_found:?}");
        }
    }
}

/// Two balls, a ball and spheres of its size, and depths in a half-space, against closed forms.
#[test]
fn bodies_of_every_kind_have_depths() {
    let radius = support::BALL.numbers[0];
    let ball = support::shape(&support::BALL).unwrap();
    let spheres = support::spheres(&[[0.0, 0.0, 0.0, radius]]).unwrap();
    let ground = simdop_shape {
        kind: simdop_shape_kind::HalfSpace as u32,
        numbers: [0.0, 0.0, 1.0, 0.0],
        ..support::BALL
    };
    let ground = support::shape(&ground).unwrap();
    let mesh = body(&cube(1.0).0);
    let at =
        |x: f64, z: f64| simdop_pose { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]] };
    let budget = SIMDOP_NO_BUDGET;
    let depth = |a: &simdop_body, b: &simdop_body, pose: &simdop_pose| {
        answer(|to| simdop_depth(Some(a), Some(b), Some(pose), budget, to)).unwrap()
    };
    let along = |a: &simdop_body, b: &simdop_body, pose: &simdop_pose, direction: [f64; 3]| {
        // SAFETY: there are three numbers.
        answer(|to| unsafe {
            simdop_depth_along(Some(a), Some(b), Some(pose), direction.as_ptr(), budget, to)
        })
        .unwrap()
    };
    let signed = |a: &simdop_body, b: &simdop_body, pose: &simdop_pose| {
        answer(|to| simdop_signed_distance(Some(a), Some(b), Some(pose), 0.0, budget, to)).unwrap()
    };
    let expected = 2.0 * radius - 0.5;
    for (a, b) in [(&ball, &ball), (&ball, &spheres), (&spheres, &ball), (&spheres, &spheres)] {
        let found = depth(a, b, &at(0.5, 0.0));
        let is_near = |bound: f64| (bound - expected).abs() < 1e-4;
        assert!(is_near(found.upper) && found.lower < expected + 1e-9, "{found:?}");
        let found = signed(a, b, &at(0.5, 0.0));
        assert!(is_near(-found.lower) && found.upper <= 0.0, "{found:?}");
        assert!((signed(a, b, &at(9.0, 0.0)).upper - (9.0 - 2.0 * radius)).abs() < 1e-9);
        assert!((along(a, b, &at(0.5, 0.0), [2.0, 0.0, 0.0]) - expected).abs() < 1e-6);
        assert_eq!(along(a, b, &at(9.0, 0.0), [1.0, 0.0, 0.0]), 0.0);
        assert!(along(a, b, &at(0.5, 0.0), [0.0; 3]).is_infinite());
    }
    let balls = depth(&ball, &ball, &at(0.5, 0.0));
    assert!((balls.lower - expected).abs() < 1e-9, "{balls:?}");
    // The foot of the cube is at -1/4.
    for (a, sign) in [(&mesh, 1.0), (&ground, -1.0)] {
        let b = if sign > 0.0 { &ground } else { &mesh };
        let (pose, up) = (at(0.0, sign * 0.25), [0.0, 0.0, sign]);
        let found = depth(a, b, &pose);
        assert!((found.lower - 0.25).abs() < 1e-9 && (found.upper - 0.25).abs() < 1e-9, "{found:?}");
        assert!((along(a, b, &pose, up) - 0.25).abs() < 1e-9);
        assert!(along(a, b, &pose, [0.0, 0.0, -sign]).is_infinite());
    }
    let negative =
        answer(|to| simdop_signed_distance(Some(&mesh), Some(&ball), Some(&at(0.0, 0.0)), -1.0, budget, to));
    assert_eq!(negative.unwrap_err(), simdop_error::Tolerance);
    let (mesh, at) = (Some(&*mesh), at(0.0, 0.0));
    // SAFETY: NULL is an error.
    let null =
        answer(|to| unsafe { simdop_depth_along(mesh, mesh, Some(&at), std::ptr::null(), budget, to) });
    assert_eq!(null.unwrap_err(), simdop_error::Null);
}

#[test]
fn contacts_are_of_triangles() {
    let ball = support::shape(&support::BALL).unwrap();
    let (mesh, mut room) = (body(&cube(1.0).0), Vec::with_capacity(1));
    let (ball, mesh, at) = (Some(&*ball), Some(&*mesh), Some(&support::IDENTITY));
    // SAFETY: there is room for one.
    let contacts =
        answer(|to| unsafe { simdop_contacts(ball, mesh, at, SIMDOP_NO_BUDGET, room.as_mut_ptr(), 1, to) });
    assert_eq!(contacts.unwrap_err(), simdop_error::NotMeshes);
}
