//! Packings in the bytes of solids.

use crate::support::data::suite_step;
use crate::support::rng::Rng;
use crate::support::shapes::{cuboid, wavy_torus};
use crate::support::turns::pose;
use crate::{Tree, grid_box, solid};
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::{AnyBvh, Bvh, FormatError, Header};
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Packings, Query};

type Node = Node16<18>;

fn query() -> Query {
    Query::new(Isa::detect()).with_budget(1500)
}

/// A ring, its spheres, and the ring with them.
fn ring(triangles: u32, spheres: usize) -> (Tree, Vec<Sphere>, Tree) {
    let mesh = wavy_torus(triangles);
    let tree = solid(&mesh);
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let spheres = Packer::new().spheres(spheres).pack(&mesh).unwrap().spheres;
    let packed = Builder::new().add_packing(&tree, &spheres).unwrap();
    (tree, spheres, packed)
}

/// Depths equal those with the packing as an argument; the other bytes are those of the tree without one.
#[test]
fn a_packing_in_the_bytes_is_one_that_is_given() {
    let (tree, spheres, packed) = ring(400, 40);
    let alone: Bvh<Node, Spheres> = Builder::new()
        .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let packings = Packings { a: alone.view(), b: alone.view() };
    let mut rng = Rng::new(61);
    let mut differ = 0;
    for _ in 0..12 {
        let at = pose(&rng.rotation(), [(); 3].map(|()| rng.range(-1.0, 1.0)));
        let [within, given, without] = [
            query().depth(&packed, &packed, &at, None),
            query().depth(&tree, &tree, &at, Some(&packings)),
            query().depth(&tree, &tree, &at, None),
        ]
        .map(|found| format!("{found:?}"));
        assert_eq!(within, given);
        differ += usize::from(within != without);
    }
    assert!(differ > 4, "{differ}");

    let (bytes, own) = (packed.as_bytes(), tree.as_bytes());
    assert_eq!(offset_of!(Header, has_packing), offset_of!(Header, is_solid) + 1);
    assert_eq!(bytes.len(), own.len() + alone.as_bytes().len());
    assert_eq!(&bytes[own.len()..], alone.as_bytes());
    let other = |i: &usize| bytes[*i] != own[*i];
    assert_eq!((0..own.len()).filter(other).collect::<Vec<_>>(), [offset_of!(Header, has_packing)]);
    assert_eq!(packed.view().stats().total_bytes, bytes.len());
    packed.view().verify().unwrap();

    let read = Bvh::<Node>::from_bytes(bytes).unwrap();
    assert_eq!((read.view().packing().unwrap().len(), tree.view().packing().is_none()), (40, true));
    let any: AnyBvh = AnyBvh::from_bytes(bytes).unwrap();
    assert!(any.view().verify().is_ok());
    // Another packing replaces the first.
    let again = Builder::new().add_packing(&packed, &spheres[..3]).unwrap();
    let direct = Builder::new().add_packing(&tree, &spheres[..3]).unwrap();
    assert_eq!(again.as_bytes(), direct.as_bytes());
    let by_type = Builder::new().add_packing_any(&AnyBvh::from(tree.clone()), &spheres[..3]).unwrap();
    assert_eq!(by_type.as_bytes(), direct.as_bytes());
}

/// A packing beside caps: both are found, and spheres are within the caps, too.
#[test]
fn solids_with_caps_carry_packings() {
    let mut open = cuboid([-1.0; 3], [1.0; 3], false);
    open.triangles.truncate(10);
    let mesh = Mesh { vertices: &open.vertices, triangles: &open.triangles };
    let tree = Builder::new().solid_with_caps(3.0).build(&mesh).unwrap();
    let ball = |centre, radius| Sphere { centre, radius };
    // One sphere touches all faces, exactly.
    let packed = Builder::new().add_packing(&tree, &[ball([0.0; 3], 1.0), ball([0.75; 3], 0.125)]).unwrap();
    let read = Bvh::<Node>::from_bytes(packed.as_bytes()).unwrap();
    assert_eq!((read.view().cap_stats().triangles, read.view().packing().unwrap().len()), (2, 2));
    read.view().verify().unwrap();
    let at = Pose::from_rows([[1.0, 0.0, 0.0, 1.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    let found = query().depth(&packed, &packed, &at, None);
    assert!(found.lower > 0.49 && found.lower <= 0.5, "{found:?}");
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut centre = [0.0; 3];
            centre[axis] = side * f64::EPSILON;
            let out = Builder::new().add_packing(&tree, &[ball([0.0; 3], 0.5), ball(centre, 1.0)]);
            assert_eq!(out.err(), Some(BuildError::NotInside { index: 1 }), "{axis} {side}");
        }
    }
}

#[test]
fn wrong_packings_are_errors() {
    let mesh = grid_box([-1.0; 3], [1.0; 3], 2);
    let (tree, ball) = (solid(&mesh), Sphere { centre: [0.0; 3], radius: 0.5 });
    let add = |tree: &Tree, spheres: &[Sphere]| Builder::new().add_packing(tree, spheres).err();
    let problem = |problem| Some(BuildError::Packing { problem });
    assert_eq!(add(&tree, &[ball]), None);
    assert_eq!(add(&tree, &[]), problem("there are no spheres"));
    assert_eq!(
        add(&tree, &[ball, Sphere { centre: [0.75; 3], ..ball }]),
        Some(BuildError::NotInside { index: 1 })
    );
    // Outside, and not near any triangle.
    assert_eq!(add(&tree, &[Sphere { centre: [3.0; 3], ..ball }]), Some(BuildError::NotInside { index: 0 }));
    assert_eq!(add(&tree, &[Sphere { radius: f64::NAN, ..ball }]), Some(BuildError::Radius { index: 0 }));
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let surface = Builder::new().build(&mesh).unwrap();
    assert_eq!(add(&surface, &[ball]), problem("the tree is not that of a solid"));
    let narrow: Bvh<Node4<18>> = Builder::new().solid().build_as(&mesh).unwrap();
    let error = Builder::new().add_packing(&narrow, &[ball]).err();
    assert_eq!(error, problem("nodes of four lanes have no balls"));
}

/// Each fault has its own error, and no flipped bit in the packing or the flag makes a query panic.
#[test]
fn damaged_packings_are_refused_or_detected() {
    let (tree, _, packed) = ring(72, 20);
    let (bytes, from) = (packed.as_bytes(), tree.as_bytes().len());
    let error = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bytes.to_vec();
        change(&mut bytes);
        Bvh::<Node>::from_bytes(&bytes).err()
    };
    let problem = |problem| Some(FormatError::Packing { problem });
    let no_tree = problem("it is no tree of spheres of the same node type");
    let flag = offset_of!(Header, has_packing);
    let mut small = bytes.to_vec();
    small.truncate(from + 64);
    assert_eq!(error(&|_| ()), None);
    assert_eq!(error(&|b| b[flag] = 0), Some(FormatError::TooLong { have: bytes.len(), need: from }));
    assert_eq!(error(&|b| b[flag] = 2), Some(FormatError::Header { field: "has_packing" }));
    assert_eq!(
        error(&|b| b[offset_of!(Header, is_solid)] = 0),
        Some(FormatError::Header { field: "has_packing" })
    );
    assert_eq!(
        error(&|b| *b = small.clone()),
        Some(FormatError::Truncated { have: from + 64, need: from + 128 })
    );
    assert_eq!(
        error(&|b| b.truncate(b.len() - 64)),
        Some(FormatError::Truncated { have: bytes.len() - 64, need: bytes.len() })
    );
    for field in [offset_of!(Header, k), offset_of!(Header, kind), offset_of!(Header, version), flag] {
        assert_eq!(error(&|b| b[from + field] ^= 1), no_tree, "{field}");
    }
    assert_eq!(error(&|b| b[from + offset_of!(Header, depth)] += 1), problem("its contents are invalid"));
    // The flag alone gives no packing to a surface, nor to a tree without one.
    let mut own = tree.as_bytes().to_vec();
    own[flag] = 1;
    assert_eq!(
        Bvh::<Node>::from_bytes(&own).err(),
        Some(FormatError::Truncated { have: from, need: from + 128 })
    );
    // The packing of a larger body.
    let large = solid(&grid_box([-9.0; 3], [9.0; 3], 1));
    let wide = Builder::new().add_packing(&large, &[Sphere { centre: [5.0; 3], radius: 1.0 }]).unwrap();
    let tail = &wide.as_bytes()[large.as_bytes().len()..];
    own.extend_from_slice(tail);
    let outside = problem("its box is not in the solid's");
    assert_eq!(Bvh::<Node>::from_bytes(&own).err(), outside);

    let (mut refused, mut accepted, mut verified) = (0, 0, 0);
    let places = (flag..=flag).chain(from..bytes.len());
    for place in places.step_by(suite_step()) {
        let mut bytes = bytes.to_vec();
        bytes[place] ^= 1 << (place % 8);
        match Bvh::<Node>::from_bytes(&bytes) {
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
            Ok(changed) => {
                accepted += 1;
                let at = Pose::from_rows([[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.25]]);
                let found = query().with_budget(60).depth(&changed, &packed, &at.unwrap(), None);
                assert!(found.lower <= found.upper);
                verified += usize::from(changed.view().verify().is_ok());
            }
        }
    }
    // In the accepted cases, the sphere is still inside, or a bound is wider than necessary.
    let all = refused + accepted;
    assert!(
        4 * refused > all && 8 * accepted > all && verified < accepted,
        "{refused} {accepted} {verified}"
    );
}

/// A sphere moved out of the solid is accepted, and found by `verify`.
#[test]
fn a_sphere_outside_is_found() {
    let tree = solid(&grid_box([-1.0; 3], [1.0; 3], 1));
    let larger = solid(&grid_box([-1.0, -1.0, -1.0], [1.0, 1.0, 1.5], 1));
    let inside = Sphere { centre: [0.0, 0.0, 0.25], radius: 0.875 };
    let packed = Builder::new().add_packing(&larger, &[inside]).unwrap();
    packed.view().verify().unwrap();
    let tail = &packed.as_bytes()[larger.as_bytes().len()..];
    let mut mixed = tree.as_bytes().to_vec();
    mixed[offset_of!(Header, has_packing)] = 1;
    mixed.extend_from_slice(tail);
    // In the box, within its tolerance or not: the upper end of the sphere is at 1.125.
    assert!(matches!(Bvh::<Node>::from_bytes(&mixed), Err(FormatError::Packing { .. })));
    let hollow = solid(&wavy_torus(400));
    let mut mixed = hollow.as_bytes().to_vec();
    mixed[offset_of!(Header, has_packing)] = 1;
    let middle = Builder::new().add_packing(&tree, &[Sphere { centre: [0.0; 3], radius: 0.125 }]).unwrap();
    mixed.extend_from_slice(&middle.as_bytes()[tree.as_bytes().len()..]);
    // In the hole of the ring.
    let mixed = Bvh::<Node>::from_bytes(&mixed).unwrap();
    let error = mixed.view().verify().unwrap_err();
    assert_eq!((error.plane, error.primitive, error.node), (23, 0, hollow.view().header().node_count));
}
