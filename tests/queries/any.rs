//! Trees whose node type is known only at run time.
//!
//! With the feature `all-nodes`, which the command's tests enable, each query here is compiled for eight node types,
//! which would take a sixth of this program's compile time. Then only `.ci/sweep nodes` has these tests, and on each
//! commit CI runs them in the emulator, without that feature. The command's tests query all eight.
#![cfg(any(not(feature = "all-nodes"), simdop_all_nodes))]

use crate::forms::poses;
use crate::mesh_of;
use crate::support::data::MeshData;
use crate::support::shapes;
use core::mem::offset_of;
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, SphereSet};
use simdop::hierarchy::{AnyBvh, AnyBvhRef, Bvh, BvhRef, FormatError, Header, NodeType};
use simdop::isa::Isa;
use simdop::low_level::key::{Half, Storage, StorageKind};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres, Triangles};
use simdop::query::{AnyError, Pair, Query, ToleranceError};
use simdop::with_bvh;

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
    #[cfg(feature = "all-nodes")]
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
    let mut unknown = a.as_bytes().to_vec();
    unknown[offset_of!(Header, storage)] = 7;
    assert_eq!(
        AnyBvh::<Triangles>::from_bytes(&unknown).err(),
        Some(FormatError::OtherStorage { storage: 7 })
    );
    bytes[12] = 14;
    assert!(AnyBvh::<Triangles>::from_bytes(&bytes).is_err(), "nodes of another size");
    assert_eq!(AnyBvh::<Triangles>::from_bytes(&bytes[..7]).err(), Some(FormatError::NotATree));
    assert_eq!(
        AnyBvh::<Triangles>::from_bytes(&bytes[..100]).err(),
        Some(FormatError::Truncated { have: 100, need: 128 })
    );
}

#[test]
fn trees_of_any_node_type_have_caps() {
    let mut mesh = shapes::cuboid([-1.0; 3], [1.0; 3], false);
    // Without the side at x = 1.
    mesh.triangles.truncate(10);
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
        let dot = shapes::separate([[[0.0; 3]; 3]]);
        let dot = Builder::new().build_any(&mesh_of(&dot), node, &mut |_| ControlFlow::Continue(())).unwrap();
        let query = Query::new(Isa::detect());
        for (x, is_in) in [(0.5, true), (1.0, true), (1.5, false)] {
            let pose =
                Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.1], [0.0, 0.0, 1.0, 0.2]]).unwrap();
            let found = query.collide_any(&dot.view(), &read.view(), &pose).unwrap();
            assert_eq!(found.hit().is_some(), is_in);
        }
    }
}

#[test]
fn spheres_have_trees_of_any_node_type() {
    let spheres: Vec<Sphere> = (0..90)
        .map(|i| Sphere {
            centre: [0, 3, 5].map(|shift| f64::from((i >> shift) % 8)),
            radius: 0.25 * f64::from(i % 4),
        })
        .collect();
    let set = SphereSet { spheres: &spheres };
    let tree: Bvh<Node16<18>, Spheres> =
        Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
    let any = AnyBvh::<Spheres>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!(any.as_bytes(), tree.as_bytes());
    let again = |k, arity| {
        let node = NodeType { k, arity, ..NodeType::default() };
        Builder::new().build_any(&set, node, &mut |_| ControlFlow::Continue(()))
    };
    let built = again(18, 16).unwrap();
    assert_eq!(built.as_bytes(), tree.as_bytes());
    let query = Query::new(Isa::detect());
    let answer = query.collide_any(&any.view(), &built.view(), &Pose::IDENTITY).unwrap();
    assert_eq!(answer, query.collide(&tree, &tree, &Pose::IDENTITY));
    assert_eq!(
        again(17, 16).unwrap_err(),
        BuildError::NodeType { node: NodeType { k: 17, ..NodeType::default() } }
    );
}
