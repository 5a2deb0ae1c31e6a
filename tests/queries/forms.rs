//! Trees in every form that a caller can hold: owned in a struct, and in flash; and vertices that no triangle uses.

use crate::mesh_of;
use crate::support::shapes;
use simdop::construct::{BuildError, Builder};
use simdop::hierarchy::{AsBvh, Bvh, FormatError, StaticBvh};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::Query;

/// From separate to deep inside each other.
pub(super) fn poses() -> Vec<Pose> {
    let pose = |i: i32| {
        let x = f64::from(i) * 0.35;
        Pose::from_rows([[0.6, -0.8, 0.0, x], [0.8, 0.6, 0.0, 0.1], [0.0, 0.0, 1.0, 0.05]]).unwrap()
    };
    (0..12).map(pose).collect()
}

/// What a planner holds: the tree and its query, without a lifetime.
struct Link {
    tree: Bvh<Node16<18>>,
    query: Query,
}

impl Link {
    fn is_free_of(&self, other: &impl AsBvh<Node = Node16<18>, Primitive = Triangles>, pose: &Pose) -> bool {
        self.query.collide(&self.tree, other, pose).is_free()
    }
}

#[test]
fn queries_take_owned_and_borrowed_trees_alike() {
    let tree = Builder::new().build(&mesh_of(&shapes::torus(16, 12))).unwrap();
    let link = Link { tree: tree.clone(), query: Query::new(Isa::detect()) };
    let mut verdicts = Vec::new();
    for pose in &poses() {
        let want = link.query.collide(&tree.view(), &tree.view(), pose);
        assert_eq!(link.query.collide(&tree, &tree, pose), want);
        assert_eq!(link.query.collide(&tree, &tree.view(), pose), want);
        assert_eq!(link.is_free_of(&tree, pose), want.is_free());
        assert_eq!(link.is_free_of(&tree.view(), pose), want.is_free());
        verdicts.push(want.is_free());
    }
    assert!(verdicts.contains(&true) && verdicts.contains(&false));
}

fn leaked(bytes: &[u8]) -> &'static [u8] {
    // At a multiple of 64 within a longer slice.
    let run: &'static mut [u8] = vec![0; bytes.len() + 64].leak();
    let start = run.as_ptr().align_offset(64);
    run[start..start + bytes.len()].copy_from_slice(bytes);
    &run[start..start + bytes.len()]
}

#[test]
fn a_tree_in_flash_is_validated_by_its_first_view_and_every_failing_one() {
    let tree = Builder::new().build(&mesh_of(&shapes::torus(12, 8))).unwrap();
    let baked = StaticBvh::<Node16<18>>::new(leaked(tree.as_bytes()));
    let first = baked.view().unwrap();
    let again = baked.view().unwrap();
    assert_eq!(first.nodes().as_ptr(), again.nodes().as_ptr(), "in place");
    assert_eq!((first.stats(), again.stats()), (tree.view().stats(), tree.view().stats()));

    // The root's first link, to a node that does not exist: the header is valid.
    let mut bytes = tree.as_bytes().to_vec();
    let link = 128 + 32 * 18;
    bytes[link..link + 4].copy_from_slice(&0x7fff_ffff_u32.to_le_bytes());
    let damaged = StaticBvh::<Node16<18>>::new(leaked(&bytes));
    let error = damaged.view().err();
    assert!(error.is_some(), "a link out of range was not seen");
    assert_eq!(damaged.view().err(), error, "and is not remembered as sound");
    let off = leaked(&[&[0_u8; 8][..], tree.as_bytes()].concat());
    assert_eq!(StaticBvh::<Node16<18>>::new(&off[8..]).view().err(), Some(FormatError::Misaligned));
}

#[test]
#[should_panic(expected = "another k or arity")]
fn a_tree_in_flash_of_another_node_type_does_not_compile_in_a_constant() {
    let tree = Builder::new().build(&mesh_of(&shapes::torus(6, 4))).unwrap();
    let _ = StaticBvh::<Node16<14>>::new(leaked(tree.as_bytes()));
}

/// A vertex that no triangle uses, a million body sizes away, must not cost the planes precision. Otherwise
/// every query would test all pairs.
#[test]
fn stray_vertices_change_nothing() {
    let mesh = shapes::torus(24, 16);
    let clean = Builder::new().build(&mesh_of(&mesh)).unwrap();
    for stray in [[1e6, 0.0, 0.0], [-1e6, 1e6, 1e6], [1e80, 0.0, -1e80]] {
        for at_front in [false, true] {
            let mut strayed = mesh.clone();
            if at_front {
                strayed.vertices.insert(0, stray);
                strayed.triangles.iter_mut().flatten().for_each(|vertex| *vertex += 1);
            } else {
                strayed.vertices.push(stray);
            }
            let tree = Builder::new().build(&mesh_of(&strayed)).unwrap();
            assert!(tree.as_bytes() == clean.as_bytes(), "{stray:?}");
        }
    }
    // An invalid unused vertex is still an error, because it may have been meant to be used.
    let mut broken = mesh;
    broken.vertices.push([f64::NAN, 0.0, 0.0]);
    let index = broken.vertices.len() - 1;
    let error = Builder::new().build(&mesh_of(&broken)).err();
    assert_eq!(error, Some(BuildError::Vertex { index }));
}
