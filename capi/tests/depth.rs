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

#[test]
fn bodies_of_other_kinds_are_refused() {
    let ball = support::shape(&support::BALL).unwrap();
    let mesh = body(&cube(1.0).0);
    let (ball, mesh) = (Some(&*ball), Some(&*mesh));
    let at = simdop_pose { rows: [[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let at = Some(&at);
    let balls = answer(|to| simdop_depth(ball, ball, at, SIMDOP_NO_BUDGET, to)).unwrap();
    let expected = 2.0 * support::BALL.numbers[0] - 0.5;
    assert!((balls.upper - expected).abs() < 1e-9 && (balls.lower - expected).abs() < 1e-9, "{balls:?}");
    let depth = answer(|to| simdop_depth(ball, mesh, at, SIMDOP_NO_BUDGET, to)).unwrap_err();
    let signed = answer(|to| simdop_signed_distance(ball, ball, at, 0.0, SIMDOP_NO_BUDGET, to)).unwrap_err();
    let mut room = Vec::with_capacity(1);
    // SAFETY: there is room for one.
    let contacts =
        answer(|to| unsafe { simdop_contacts(ball, mesh, at, SIMDOP_NO_BUDGET, room.as_mut_ptr(), 1, to) });
    assert_eq!([depth, signed, contacts.unwrap_err()], [simdop_error::NotMeshes; 3]);
    let negative = answer(|to| simdop_signed_distance(mesh, mesh, at, -1.0, SIMDOP_NO_BUDGET, to));
    assert_eq!(negative.unwrap_err(), simdop_error::Tolerance);
}
