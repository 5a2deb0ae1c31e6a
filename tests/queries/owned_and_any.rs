//! Trees in every form that a caller can hold: owned in a struct, of any node type, in flash; and vertices that
//! no triangle uses.

use crate::mesh_of;
use crate::support::data::MeshData;
use crate::support::shapes;
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder};
use simdop::hierarchy::{AnyBvh, AnyBvhRef, AsBvh, Bvh, BvhRef, FormatError, NodeType, StaticBvh};
use simdop::isa::Isa;
use simdop::low_level::key::{Half, Storage, StorageKind};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::{AnyError, Pair, Query, ToleranceError};
use simdop::with_bvh;

/// From separate to deep inside each other.
fn poses() -> Vec<Pose> {
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

/// Returns the tree in both types.
fn any_is_built_alike<N: simdop::query::Lanes>(mesh: &MeshData) -> (Bvh<N>, AnyBvh)
where
    for<'a> AnyBvhRef<'a>: From<BvhRef<'a, N>>,
    AnyBvh: From<Bvh<N>>,
{
    let tree = Builder::new().build_as::<N>(&mesh_of(mesh)).unwrap();
    let node = NodeType { k: N::K, arity: N::ARITY, storage: <N::Storage as Storage>::KIND };
    let built = Builder::new().build_any(&mesh_of(mesh), node, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(built.as_bytes(), tree.as_bytes());
    // The bytes of a file have no alignment.
    let mut file = vec![0; tree.as_bytes().len() + 1];
    file[1..].copy_from_slice(tree.as_bytes());
    let any = AnyBvh::<Triangles>::from_bytes(&file[1..]).unwrap();
    assert_eq!(any.as_bytes(), tree.as_bytes());
    let borrowed = AnyBvhRef::<Triangles>::from_bytes(tree.as_bytes()).unwrap();
    let view = tree.view();
    assert_eq!((borrowed.stats(), borrowed.tree_stats()), (view.stats(), view.tree_stats()));
    assert_eq!(borrowed.header(), view.header());
    assert_eq!(borrowed.verify(), Ok(()));
    assert_eq!(with_bvh!(AnyBvhRef::from(view), tree => tree.len()), mesh.triangles.len());
    assert_eq!(AnyBvh::from(tree.clone()).view().header(), view.header());
    (tree, any)
}

fn any_agrees<N: simdop::query::Lanes>(mesh: &MeshData)
where
    for<'a> AnyBvhRef<'a>: From<BvhRef<'a, N>>,
    AnyBvh: From<Bvh<N>>,
{
    let query = Query::new(Isa::detect());
    let (tree, any) = any_is_built_alike::<N>(mesh);
    let borrowed = AnyBvhRef::<Triangles>::from_bytes(tree.as_bytes()).unwrap();
    for pose in &poses() {
        assert_eq!(query.collide_any(&any.view(), &borrowed, pose), Ok(query.collide(&tree, &tree, pose)));
        let within = query.within_any(&any.view(), &borrowed, pose, 0.1).unwrap();
        assert_eq!(within, query.within(&tree, &tree, pose, 0.1).unwrap());
        let distance = query.distance_any(&any.view(), &borrowed, pose, 0.01).unwrap();
        assert_eq!(distance, query.distance(&tree, &tree, pose, 0.01).unwrap());
        // A visitor of another type would compile every node type's query once more.
        let (mut got, mut want) = (Vec::new(), Vec::new());
        let visitor: &mut dyn FnMut(Pair) -> ControlFlow<()> = &mut |pair| {
            got.push(pair);
            ControlFlow::Continue(())
        };
        let done = query.for_each_pair_any(&any.view(), &borrowed, pose, visitor);
        let visitor: &mut dyn FnMut(Pair) -> ControlFlow<()> = &mut |pair| {
            want.push(pair);
            ControlFlow::Continue(())
        };
        let completion = query.for_each_pair(&tree, &tree, pose, visitor);
        assert_eq!((done.unwrap(), got), (completion, want));
    }
}

#[test]
fn trees_of_any_node_type_answer_as_their_own_type_does() {
    let mesh = shapes::torus(12, 8);
    any_agrees::<Node16<18>>(&mesh);
    any_agrees::<Node16<18, Half>>(&mesh);
    #[cfg(all(simdop_all_nodes, feature = "all-nodes"))]
    {
        any_agrees::<Node16<6>>(&mesh);
        any_agrees::<Node16<14>>(&mesh);
        any_agrees::<Node16<26>>(&mesh);
        any_agrees::<Node4<18>>(&mesh);
        any_agrees::<Node16<14, Half>>(&mesh);
        any_agrees::<Node16<26, Half>>(&mesh);
    }
}

/// Compares with the default type: a tree that is not type-erased would compile the queries of its node type once more.
#[test]
fn trees_of_any_node_type_have_the_verdicts_of_the_default_one() {
    let mesh = shapes::torus(12, 8);
    let (tree, _) = any_is_built_alike::<Node16<18>>(&mesh);
    let query = Query::new(Isa::detect());
    let others = [
        any_is_built_alike::<Node16<18, Half>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node16<6>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node16<14>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node16<26>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node4<18>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node16<14, Half>>(&mesh).1,
        #[cfg(feature = "all-nodes")]
        any_is_built_alike::<Node16<26, Half>>(&mesh).1,
    ];
    for (any, pose) in others.iter().flat_map(|any| poses().into_iter().map(|pose| (any.view(), pose))) {
        let found = query.collide_any(&any, &any, &pose).unwrap();
        assert_eq!(found.is_free(), query.collide(&tree, &tree, &pose).is_free());
        let within = query.within_any(&any, &any, &pose, 0.1).unwrap();
        assert_eq!(within.is_free(), query.within(&tree, &tree, &pose, 0.1).unwrap().is_free());
        let (got, want) = (
            query.distance_any(&any, &any, &pose, 0.01).unwrap(),
            query.distance(&tree, &tree, &pose, 0.01).unwrap(),
        );
        assert!(got.lower <= want.upper && want.lower <= got.upper);
    }
}

#[test]
fn what_cannot_be_asked_of_any_trees_has_a_name() {
    let mesh = shapes::torus(6, 4);
    let build = |node| Builder::new().build_any(&mesh_of(&mesh), node, &mut |_| ControlFlow::Continue(()));
    let (usual, narrow) = (NodeType::default(), NodeType { arity: 4, ..NodeType::default() });
    let half = NodeType { storage: StorageKind::Half, ..usual };
    for node in [NodeType { k: 17, ..usual }, NodeType { arity: 8, ..usual }, NodeType { arity: 4, ..half }] {
        assert_eq!(build(node).err(), Some(BuildError::NodeType { node }));
    }
    let a = build(usual).unwrap();
    let query = Query::new(Isa::detect());
    #[cfg(feature = "all-nodes")]
    {
        let (b, other) = (build(narrow).unwrap(), AnyError::OtherNode { a: usual, b: narrow });
        assert_eq!(query.collide_any(&a.view(), &b.view(), &Pose::IDENTITY), Err(other));
        assert_eq!(query.distance_any(&a.view(), &b.view(), &Pose::IDENTITY, 0.0), Err(other));
        assert!(!other.to_string().is_empty());
    }
    #[cfg(not(feature = "all-nodes"))]
    {
        let refused = build(narrow).err();
        assert_eq!(refused, Some(BuildError::NodeType { node: narrow }));
        assert!(refused.is_some_and(|error| error.to_string().contains("`all-nodes`")));
        let tree = Builder::new().build_as::<Node4<18>>(&mesh_of(&mesh)).unwrap();
        let read = AnyBvh::<Triangles>::from_bytes(tree.as_bytes()).err();
        assert_eq!(read, Some(FormatError::OtherNode { k: 18, arity: 4 }));
    }
    let halves = build(half).unwrap();
    let other_storage = AnyError::OtherNode { a: usual, b: half };
    assert_eq!(query.collide_any(&a.view(), &halves.view(), &Pose::IDENTITY), Err(other_storage));
    assert!(other_storage.to_string().contains("half floats"), "{other_storage}");
    let negative = AnyError::Tolerance(ToleranceError { given: -1.0 });
    assert_eq!(query.within_any(&a.view(), &a.view(), &Pose::IDENTITY, -1.0), Err(negative));
    assert!(!negative.to_string().is_empty());

    // A node type that does not exist, in bytes of any length.
    let mut bytes = a.as_bytes().to_vec();
    bytes[12] = 17;
    assert_eq!(
        AnyBvh::<Triangles>::from_bytes(&bytes).err(),
        Some(FormatError::OtherNode { k: 17, arity: 16 })
    );
    bytes[12] = 14;
    assert!(AnyBvh::<Triangles>::from_bytes(&bytes).is_err(), "nodes of another size");
    assert_eq!(AnyBvh::<Triangles>::from_bytes(&bytes[..7]).err(), Some(FormatError::NotATree));
    assert_eq!(
        AnyBvh::<Triangles>::from_bytes(&bytes[..100]).err(),
        Some(FormatError::Truncated { have: 100, need: 128 })
    );
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
