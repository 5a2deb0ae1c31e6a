//! The caps in the bytes of a tree.

use super::meshes::{Tree, at, capped, open_cube, tunnel};
use crate::support::data::MeshData;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate};
use crate::{aligned, mesh_of};
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::construct::{Builder, SphereSet};
use simdop::hierarchy::{AnyBvh, Bvh, BvhRef, CapStats, FormatError, Header, NodeType};
use simdop::isa::Isa;
use simdop::low_level::key::StorageKind;
use simdop::node::Node16;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::Query;

/// A tunnel, and a cube without a side: three holes.
fn open_bodies() -> (MeshData, Tree) {
    let mut mesh = tunnel();
    append(&mut mesh, &scaled(&open_cube(), 0.25, [0.25, 0.0, 0.0]));
    let tree = capped::<Node16<18>>(&mesh);
    (mesh, tree)
}

/// Flips bytes of the header's fields for caps and of the caps' tree. No accepted bytes make a query panic.
#[test]
fn damaged_caps_are_refused() {
    let (_, tree) = open_bodies();
    let (view, bytes) = (tree.view(), tree.as_bytes());
    let lines = usize::from(view.header().cap_lines);
    let from = bytes.len() - 64 * lines;
    let at_fields = [offset_of!(Header, cap_lines), offset_of!(Header, cap_width)];
    assert_eq!((at_fields, view.cap_stats().holes, view.caps().unwrap().len()), ([122, 124], 3, 6));
    assert_eq!(view.stats().total_bytes, bytes.len());
    let other: Tree = Builder::new().build_as(&mesh_of(&cuboid([-0.1; 3], [0.1; 3], false))).unwrap();
    let (mut refused, mut accepted, mut verified) = (0, 0, 0);
    let mut offer = |bytes: &[u8]| {
        let lines = aligned(bytes);
        let bytes = &bytemuck::cast_slice::<_, u8>(&lines)[..bytes.len()];
        match BvhRef::<Node16<18>>::from_bytes(bytes) {
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
            Ok(view) => {
                accepted += 1;
                let query = Query::new(Isa::detect());
                for x in [0.0, 1.0, 3.0] {
                    let pose = at([x, 0.01, 0.02]);
                    let _ = (query.collide(&view, &other, &pose), query.collide(&other, &view, &pose));
                    let _ = query.distance(&view, &other, &pose, 0.0).unwrap();
                    let _ = (view.cap_stats(), view.stats(), view.caps().map(|caps| caps.verify()));
                }
                verified += usize::from(view.verify().is_ok());
            }
        }
    };
    let places: Vec<usize> = (114..128).chain(from..bytes.len()).collect();
    for &place in places.iter().step_by(if cfg!(miri) { 40 } else { 1 }) {
        for bit in if cfg!(miri) { 0..1 } else { 0..8 } {
            let mut bytes = bytes.to_vec();
            bytes[place] ^= 1 << bit;
            offer(&bytes);
        }
    }
    let mut rng = Rng::new(10);
    for _ in 0..if cfg!(miri) { 4 } else { 2000 } {
        let mut bytes = bytes.to_vec();
        (0..3).for_each(|_| bytes[*rng.pick(&places)] = rng.u64() as u8);
        offer(&bytes);
    }
    (0..=lines).for_each(|i| offer(&bytes[..bytes.len() - 64 * i]));
    println!("{refused} refused, {accepted} accepted, {verified} verified");
    assert!(cfg!(miri) || refused > 1000 && accepted > 100 && verified < accepted);
}

/// Each fault of the caps has its own error.
#[test]
fn faults_of_caps_have_names() {
    let (mesh, tree) = open_bodies();
    let (view, bytes) = (tree.view(), tree.as_bytes());
    let from = bytes.len() - 64 * usize::from(view.header().cap_lines);
    let with = |change: &dyn Fn(&mut [u8])| {
        let mut bytes = bytes.to_vec();
        change(&mut bytes);
        Bvh::<Node16<18>>::from_bytes(&bytes)
    };
    let error = |change: &dyn Fn(&mut [u8])| with(change).err();
    let caps = |problem| Some(FormatError::Caps { problem });
    let field = |field| Some(FormatError::Header { field });
    let inner = |offset: usize| from + offset;
    assert_eq!(error(&|_| ()), None);
    assert_eq!(error(&|b| b[offset_of!(Header, is_solid)] = 0), field("cap_lines"));
    assert_eq!(error(&|b| b[127] = 0x80), field("cap_width"));
    assert_eq!(error(&|b| b[124..128].copy_from_slice(&f32::INFINITY.to_le_bytes())), field("cap_width"));
    assert_eq!(error(&|b| b[from] = 0), caps("it is no tree of the same node type and length"));
    assert_eq!(
        error(&|b| b[inner(offset_of!(Header, k))] = 14),
        caps("it is no tree of the same node type and length")
    );
    assert_eq!(error(&|b| b[inner(offset_of!(Header, is_solid))] = 1), caps("it is a solid, or empty"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, centre))] ^= 1), caps("it has another frame"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, exponent))] ^= 1), caps("it has another frame"));
    assert_eq!(error(&|b| b[inner(offset_of!(Header, depth))] = 9), caps("its contents are invalid"));
    // A surface and a closed solid report no caps.
    for builder in [Builder::new(), Builder::new().solid_with_caps(1.0)] {
        let closed = builder.build(&mesh_of(&cuboid([-1.0; 3], [1.0; 3], false))).unwrap();
        assert_eq!((closed.view().cap_stats(), closed.view().caps().is_none()), (CapStats::default(), true));
        let mut bytes = closed.as_bytes().to_vec();
        bytes[124] = 1;
        assert_eq!(Bvh::<Node16<18>>::from_bytes(&bytes).err(), field("cap_width"));
    }

    // The vertices follow the header and the node, the caps the vertices: three corners each.
    let view = view.caps().unwrap();
    let vertices = inner(128 + size_of_val(view.nodes()));
    let records = vertices + (12 * view.header().vertex_count as usize).next_multiple_of(4);
    assert_eq!(view.header().vertex_size, 12);
    // Caps of a larger solid in the same frame.
    let [large, small] =
        [0.96875, 0.75].map(|size| capped::<Node16<18>>(&scaled(&open_cube(), size, [0.0; 3])));
    assert_eq!(large.view().frame(), small.view().frame());
    let tail = |tree: &Tree| 64 * usize::from(tree.view().header().cap_lines);
    let (from_large, of_small) =
        (large.as_bytes().len() - tail(&large), small.as_bytes().len() - tail(&small));
    let mixed = [&small.as_bytes()[..of_small], &large.as_bytes()[from_large..]].concat();
    assert_eq!(Bvh::<Node16<18>>::from_bytes(&mixed).err(), caps("a vertex is outside of the solid's box"));
    // `verify` finds caps that do not fit: with another corner, and with reversed orientation.
    let changed = |change: &dyn Fn(&mut [u8])| with(change).unwrap().view().verify().unwrap_err();
    let (nodes, k) = (tree.view().header().node_count, 18);
    let swapped = changed(&|b| (0..4).for_each(|i| b.swap(records + i, records + 4 + i)));
    assert_eq!((swapped.node, swapped.lane, swapped.plane), (nodes, 0, k + 4));
    assert!((swapped.primitive as usize) < mesh.triangles.len());
    let lower = changed(&|b| {
        let code = &mut b[inner(128)..][..2];
        let lower = i16::from_le_bytes([code[0], code[1]]) - 9;
        code.copy_from_slice(&lower.to_le_bytes());
    });
    assert!(lower.node >= nodes && lower.plane < k, "{lower:?}");
}

#[test]
fn trees_of_any_node_type_have_caps() {
    let mesh = open_cube();
    for (k, arity, storage) in [
        (18, 16, StorageKind::Half),
        #[cfg(feature = "all-nodes")]
        (6, 16, StorageKind::Fixed),
        #[cfg(feature = "all-nodes")]
        (18, 4, StorageKind::Fixed),
        #[cfg(feature = "all-nodes")]
        (14, 16, StorageKind::Half),
    ] {
        let node = NodeType { k, arity, storage };
        let builder = Builder::new().solid_with_caps(3.0);
        let tree = builder.build_any(&mesh_of(&mesh), node, &mut |_| ControlFlow::Continue(())).unwrap();
        let read: AnyBvh = AnyBvh::from_bytes(tree.as_bytes()).unwrap();
        assert_eq!((read.view().cap_stats(), read.view().verify()), (tree.view().cap_stats(), Ok(())));
        assert_eq!(read.view().cap_stats().triangles, 2);
        let dot = separate([[[0.0; 3]; 3]]);
        let dot = Builder::new().build_any(&mesh_of(&dot), node, &mut |_| ControlFlow::Continue(())).unwrap();
        let query = Query::new(Isa::detect());
        for (x, is_in) in [(0.5, true), (1.0, true), (1.5, false)] {
            let found = query.collide_any(&dot.view(), &read.view(), &at([x, 0.1, 0.2])).unwrap();
            assert_eq!(found.hit().is_some(), is_in);
        }
    }
    // Spheres have neither inside nor caps.
    let set = SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 1.0 }] };
    let build = |builder: Builder| -> Bvh<Node16<18>, Spheres> {
        builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    assert!(build(Builder::new()).as_bytes() == build(Builder::new().solid_with_caps(1.0)).as_bytes());
}
