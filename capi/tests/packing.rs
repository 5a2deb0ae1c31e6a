//! Packings, covers, penetration volumes and verification give the library's answers.

mod support;

use simdop::construct::{Builder, Mesh, OwnedMesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::Sphere;
use simdop::query::{Completion, Query};
use simdop_capi::*;
use std::ffi::{c_int, c_void};
use std::ptr::null_mut;
use support::{
    BALL, Rng, answer, bytes, handle, number, open, pose, shape, solid, sphere_sets_of, spheres, surface,
    triangles_as,
};

fn flat(spheres: &[Sphere]) -> Vec<[f64; 4]> {
    spheres.iter().map(|s| [s.centre[0], s.centre[1], s.centre[2], s.radius]).collect()
}

/// The spheres of a packing.
fn pack(
    mesh: &Mesh<'_>,
    room: usize,
    on_filling: simdop_on_filling,
    user: *mut c_void,
) -> Result<(Vec<[f64; 4]>, simdop_packing), simdop_error> {
    let mut found = vec![[0.0; 4]; room];
    // SAFETY: the lengths are those of the slices; the callers pass what the callback expects.
    let packing = answer(|packing| unsafe {
        let (vertices, triangles) = (mesh.vertices.as_ptr().cast(), mesh.triangles.as_ptr().cast());
        let (v, t, to) = (mesh.vertices.len(), mesh.triangles.len(), found.as_mut_ptr().cast());
        simdop_pack(vertices, v, triangles, t, to, room, on_filling, user, packing)
    })?;
    found.truncate(packing.count);
    Ok((found, packing))
}

fn cover(mesh: &Mesh<'_>, error: f64, is_solid: bool, room: usize) -> (simdop_error, Vec<[f64; 4]>, usize) {
    let (mut found, mut count) = (vec![[0.0; 4]; room.max(1)], std::mem::MaybeUninit::new(usize::MAX));
    // SAFETY: the lengths are those of the slices.
    let code = unsafe {
        let (vertices, triangles) = (mesh.vertices.as_ptr().cast(), mesh.triangles.as_ptr().cast());
        let (v, t, to) = (mesh.vertices.len(), mesh.triangles.len(), found.as_mut_ptr().cast());
        simdop_cover(vertices, v, triangles, t, error, is_solid.into(), to, room, Some(&mut count))
    };
    // SAFETY: written before the call at the latest.
    let count = unsafe { count.assume_init() };
    found.truncate(count);
    (code, found, count)
}

#[test]
fn packings_and_covers_are_the_librarys() {
    let cube = OwnedMesh::cuboid([1.0, 2.0, 3.0]).unwrap();
    let mesh = cube.as_mesh();
    let (found, packing) = pack(&mesh, 30, None, null_mut()).unwrap();
    let expected = Packer::new().spheres(30).pack(&mesh).unwrap();
    assert_eq!((found, packing.volume), (flat(&expected.spheres), expected.volume));
    assert_eq!(Some(packing.share), expected.shares().last());
    for is_solid in [false, true] {
        let expected = if is_solid { mesh.cover_solid(0.3) } else { mesh.cover(0.3) }.unwrap();
        let (code, found, count) = cover(&mesh, 0.3, is_solid, 5000);
        assert_eq!((code, found, count), (simdop_error::None, flat(&expected), expected.len()));
        let (code, _, count) = cover(&mesh, 0.3, is_solid, expected.len() - 1);
        assert_eq!((code, count), (simdop_error::Buffer, expected.len()));
    }
}

#[test]
fn a_packing_can_be_stopped() {
    unsafe extern "C" fn stop(user: *mut c_void, placed: usize, asked: usize, _: f64) -> c_int {
        // SAFETY: two numbers are passed below.
        let seen = unsafe { &mut *user.cast::<[usize; 2]>() };
        *seen = [placed, asked];
        1
    }
    let cube = OwnedMesh::cuboid([1.0; 3]).unwrap();
    let mut seen = [usize::MAX; 2];
    let stopped = pack(&cube.as_mesh(), 2000, Some(stop), (&raw mut seen).cast());
    assert_eq!(stopped.unwrap_err(), simdop_error::PackStopped);
    assert!(seen[0] < 2000 && seen[1] == 2000, "{seen:?}");
}

#[test]
fn faulty_meshes_and_errors_have_codes() {
    let cube = OwnedMesh::cuboid([1.0; 3]).unwrap();
    let mesh = cube.as_mesh();
    let of = |mesh: &Mesh<'_>| pack(mesh, 3, None, null_mut()).unwrap_err();
    let open = Mesh { triangles: &mesh.triangles[1..], ..mesh };
    assert_eq!(of(&open), simdop_error::BuildOpen);
    assert_eq!(of(&Mesh { triangles: &[], ..mesh }), simdop_error::PackEmpty);
    assert_eq!(of(&Mesh { triangles: &[[0, 1, 2], [0, 2, 1]], ..mesh }), simdop_error::PackFlat);
    assert_eq!(of(&Mesh { triangles: &[[0, 1, 99]], ..mesh }), simdop_error::BuildPrimitive);
    for error in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(cover(&mesh, error, false, 9).0, simdop_error::CoverError);
    }
    assert_eq!(cover(&mesh, 1e-8, false, 9).0, simdop_error::CoverTooMany);
    assert_eq!(cover(&open, 0.1, true, 9).0, simdop_error::BuildOpen);
}

fn packed(body: &simdop_body, spheres: &[[f64; 4]]) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|packed| unsafe {
        simdop_body_build_packed(Some(body), spheres.as_ptr().cast(), spheres.len(), packed)
    })
}

#[test]
fn packed_bodies_are_the_librarys_and_have_closer_depths() {
    fn check<S: Storage>() {
        let cube = OwnedMesh::cuboid([1.0; 3]).unwrap();
        let (found, _) = pack(&cube.as_mesh(), 30, None, null_mut()).unwrap();
        let plain = triangles_as(&cube.as_mesh(), true, number::<S>()).unwrap();
        let with = packed(&plain, &found).unwrap();
        let tree: Bvh<Node16<18, S>> = Builder::new().solid().build_as(&cube.as_mesh()).unwrap();
        let spheres = Packer::new().spheres(30).pack(&cube.as_mesh()).unwrap().spheres;
        let expected = Builder::new().add_packing(&tree, &spheres).unwrap();
        assert_eq!(bytes(&with), expected.as_bytes());
        // Bytes that were opened in place can be packed, too, and a packing is replaced.
        assert_eq!(bytes(&packed(&open(bytes(&with)).unwrap(), &found).unwrap()), bytes(&with));

        let rows = [[0.8, 0.6, 0.0, 0.875], [-0.6, 0.8, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let (at, pose) = (simdop_pose { rows }, Pose::from_rows(rows).unwrap());
        let lower = |body: &simdop_body| {
            let (body, at) = (Some(body), Some(&at));
            answer(|to| simdop_depth(body, body, at, 60, to)).unwrap().lower
        };
        let query = Query::new(Isa::detect()).with_budget(60);
        assert_eq!(lower(&with), query.depth(&expected, &expected, &pose, None).lower);
        assert!(lower(&with) > lower(&plain), "{} {}", lower(&with), lower(&plain));
    }
    check::<Fixed>();
    check::<Half>();
}

#[test]
fn packings_that_are_none_have_codes() {
    let cube = OwnedMesh::cuboid([1.0; 3]).unwrap();
    let solid = solid(&cube.as_mesh()).unwrap();
    let code = |body: &simdop_body, spheres: &[[f64; 4]]| packed(body, spheres).unwrap_err();
    let inside = [0.0, 0.0, 0.0, 0.25];
    assert_eq!(code(&solid, &[]), simdop_error::BuildPacking);
    assert_eq!(code(&solid, &[inside, [0.0, 0.0, 0.3, 0.25]]), simdop_error::BuildNotInside);
    assert_eq!(code(&solid, &[[0.0, 0.0, 0.0, -1.0]]), simdop_error::BuildRadius);
    assert_eq!(code(&surface(&cube.as_mesh()).unwrap(), &[inside]), simdop_error::BuildPacking);
    assert_eq!(code(&shape(&BALL).unwrap(), &[inside]), simdop_error::BuildPacking);
    assert_eq!(code(&spheres(&[inside]).unwrap(), &[inside]), simdop_error::BuildPacking);

    // The packing, a tree of its own, comes last.
    let with = packed(&solid, &[inside]).unwrap();
    let with = bytes(&with);
    let mut damaged = simdop::hierarchy::Aligned([0; 4096]);
    damaged.0[..with.len()].copy_from_slice(with);
    let start = (64..with.len()).rfind(|&at| with[at..].starts_with(&with[..8])).unwrap();
    damaged.0[start] ^= 0xff;
    assert!(open(&damaged.0[..with.len()]).is_err_and(|error| error == simdop_error::BytesPacking));
}

#[test]
fn penetrations_are_the_librarys() {
    let mut rng = Rng::new(31);
    let sets = sphere_sets_of::<Fixed>(&mut rng);
    let mut met = 0;
    for _ in 0..40 {
        let (c_pose, at) = pose(&mut rng);
        for budget in [SIMDOP_NO_BUDGET, 3] {
            for (a, b) in sets.iter().flat_map(|a| sets.iter().map(move |b| (a, b))) {
                let (c_a, c_b, c_pose) = (Some(a.c), Some(b.c), Some(&c_pose));
                let found = answer(|to| simdop_penetration(c_a, c_b, c_pose, budget, to)).unwrap();
                let query = Query::new(Isa::detect()).with_budget(budget);
                let expected = query.penetration(&a.rust, &b.rust, &at);
                assert_eq!(
                    [found.volume, found.upper, found.estimate],
                    [expected.volume, expected.upper, expected.estimate]
                );
                assert_eq!((found.direction, found.pairs), (expected.direction, expected.pairs));
                match expected.point {
                    Some(point) => assert_eq!(found.point, point),
                    None => assert!(found.point.iter().all(|x| x.is_nan())),
                }
                let is_complete = expected.completion == Completion::Complete;
                assert_eq!(found.completion == simdop_completion::Complete, is_complete);
                met += u32::from(found.volume > 0.0);
            }
        }
    }
    assert!(met > 20, "{met}");
}

#[test]
fn bodies_are_verified_and_damage_is_found() {
    let cube = OwnedMesh::cuboid([1.0; 3]).unwrap();
    let body = surface(&cube.as_mesh()).unwrap();
    for body in
        [Some(&*body), Some(&*shape(&BALL).unwrap()), Some(&*spheres(&[[0.0, 0.0, 0.0, 1.0]]).unwrap())]
    {
        assert_eq!(simdop_body_verify(body), simdop_error::None);
    }
    // Each plane of the first node, lowered by much: opening cannot notice, but verification does.
    let mut copy = simdop::hierarchy::Aligned([0; 4096]);
    let count = bytes(&body).len();
    copy.0[..count].copy_from_slice(bytes(&body));
    let mut found = 0;
    for at in (128..128 + 600).step_by(2) {
        let mut damaged = simdop::hierarchy::Aligned(copy.0);
        let plane = i16::from_le_bytes([damaged.0[at], damaged.0[at + 1]]);
        damaged.0[at..at + 2].copy_from_slice(&plane.saturating_sub(8000).to_le_bytes());
        if let Ok(body) = open(&damaged.0[..count]) {
            found += u32::from(simdop_body_verify(Some(&body)) == simdop_error::BytesVolume);
        }
    }
    assert!(found > 50, "{found}");
}
