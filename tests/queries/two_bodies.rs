//! Two bodies of any kind: each has its primitives along x, so that distances and nearest primitives are known.

use alloc::sync::Arc;
use core::ops::ControlFlow;
use simdop::cloud::PointCloud;
use simdop::construct::{Builder, OwnedMesh, ShapeSet, SphereSet};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::{Shape, Sphere};
use simdop::query::{Completion, Pair, Query, ToleranceError, Verdict};
use simdop::scene::{BodyTree, SceneError, SharedTree};

type Node = Node16<18>;
type Tree = BodyTree<'static, Node>;

/// A body from -1 to 1 along x, with the primitives at its ends.
struct Model {
    tree: Tree,
    /// The index of the only primitive at x = -1 and at x = 1. A mesh has two triangles at each.
    ends: Option<[u32; 2]>,
}

fn placed(x: f64) -> Pose {
    Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap()
}

fn models() -> Vec<Model> {
    let cube = OwnedMesh::cuboid([2.0; 3]).unwrap();
    let mesh = Builder::new().build_as(&cube.as_mesh()).unwrap();
    let spheres = [0.5, 0.0, -0.5].map(|x| Sphere { centre: [x, 0.0, 0.0], radius: 0.5 });
    let spheres =
        Builder::new().build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()));
    let half = Shape::cuboid([1.0; 3]).unwrap();
    let shapes = [-0.5, 0.5].map(|x| half.moved(&placed(x)));
    let shapes =
        Builder::new().build_geometry(&ShapeSet::new(&shapes).unwrap(), &mut |_| ControlFlow::Continue(()));
    let cloud = PointCloud::new(&[[0.0; 3], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).unwrap();
    vec![
        Model { tree: SharedTree::Mesh(Arc::new(mesh)).into(), ends: None },
        Model { tree: SharedTree::Spheres(Arc::new(spheres.unwrap())).into(), ends: Some([2, 0]) },
        Model { tree: SharedTree::Shapes(Arc::new(shapes.unwrap())).into(), ends: Some([0, 1]) },
        Model { tree: Shape::sphere(1.0).unwrap().into(), ends: Some([0, 0]) },
        Model { tree: SharedTree::PointCloud(Arc::new(cloud)).into(), ends: Some([2, 1]) },
    ]
}

const GAPS: [f64; 4] = [1e-6, 0.25, 1.0, 1e3];

#[test]
fn bodies_of_every_kind_answer_by_their_ends() {
    let (query, models) = (Query::new(Isa::detect()), models());
    for (i, a) in models.iter().enumerate() {
        for (j, b) in models.iter().enumerate().filter(|(j, _)| (i, *j) != (4, 4)) {
            for gap in GAPS {
                let pose = placed(2.0 + gap);
                assert!(a.tree.collide(&query, &b.tree, &pose).unwrap().is_free(), "{i} {j} {gap}");
                let within = |margin: f64| a.tree.within(&query, &b.tree, &pose, margin).unwrap().verdict;
                assert_eq!(within(0.999 * gap), Verdict::Free, "{i} {j} {gap}");
                let Verdict::Hit(hit) = within((1.0 + 1e-6) * gap) else { panic!("{i} {j} {gap}") };
                let near = a.tree.distance_up_to(&query, &b.tree, &pose, 0.0, f64::INFINITY).unwrap();
                assert!(
                    (near.lower - gap).abs() < 1e-9 && (near.upper - gap).abs() < 1e-9,
                    "{i} {j} {near:?}"
                );
                let witness = near.witness.unwrap();
                assert!((witness.a[0] - (1.0 + gap)).abs() < 1e-9 && (witness.b[0] - 1.0).abs() < 1e-9);
                for pair in [hit, witness.pair] {
                    assert!(a.ends.is_none_or(|[left, _]| pair.a == left), "{i} {j} {pair:?}");
                    assert!(b.ends.is_none_or(|[_, right]| pair.b == right), "{i} {j} {pair:?}");
                }
                let far = a.tree.distance_up_to(&query, &b.tree, &pose, 0.0, 0.5 * gap).unwrap();
                assert!(far.witness.is_none() && far.lower <= 0.5 * gap);
            }
            let deep = a.tree.collide(&query, &b.tree, &placed(1.9)).unwrap();
            let both_have_points = i != 4 && j != 4;
            assert!(!deep.is_free() || !both_have_points, "{i} {j}");
        }
    }
}

fn pairs(query: &Query, a: &Tree, b: &Tree, pose: &Pose) -> Vec<[u32; 2]> {
    let mut found = Vec::new();
    let (completion, _) = a
        .for_each_pair(query, b, pose, |Pair { a, b }| {
            found.push([a, b]);
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(completion, Completion::Complete);
    found.sort_unstable();
    found
}

/// The primitives that meet are those at the ends, for the cube both triangles of the face. Points meet a surface only
/// if they lie on it.
#[test]
fn pairs_of_primitives_are_those_at_the_ends() {
    let (query, models) = (Query::new(Isa::detect()), models());
    let cube = OwnedMesh::cuboid([2.0; 3]).unwrap();
    let face = |x: f64| {
        let is_of_face =
            |triangle: &&[u32; 3]| triangle.iter().all(|&corner| cube.vertices[corner as usize][0] == x);
        let all = cube.triangles.iter().enumerate().filter(|(_, triangle)| is_of_face(triangle));
        all.map(|(i, _)| i as u32).collect::<Vec<_>>()
    };
    for (i, a) in models.iter().enumerate() {
        for (j, b) in models.iter().enumerate().filter(|(j, _)| !matches!((i, *j), (0, 0) | (4, 4))) {
            let of_a = a.ends.map_or_else(|| face(-1.0), |[left, _]| vec![left]);
            let of_b = b.ends.map_or_else(|| face(1.0), |[_, right]| vec![right]);
            let mut expected: Vec<_> = of_a.iter().flat_map(|a| of_b.iter().map(|b| [*a, *b])).collect();
            expected.sort_unstable();
            let is_on_surface = matches!((i, j), (0, 4) | (4, 0));
            let pose = placed(if is_on_surface { 2.0 } else { 1.9 });
            assert_eq!(pairs(&query, &a.tree, &b.tree, &pose), expected, "{i} {j}");
            assert_eq!(pairs(&query, &a.tree, &b.tree, &placed(2.5)), [[0; 2]; 0], "{i} {j}");
            let (mut count, stop) = (0, |count: &mut u32| {
                *count += 1;
                ControlFlow::Break(())
            });
            let ended = a.tree.for_each_pair(&query, &b.tree, &pose, |_| stop(&mut count)).unwrap();
            assert_eq!((ended.0, count), (Completion::Stopped, 1), "{i} {j}");
        }
    }
    let cloud = &models[4].tree;
    let clouds = cloud.for_each_pair(&query, cloud, &placed(0.0), |_| ControlFlow::Continue(()));
    assert!(matches!(clouds, Err(SceneError::TwoClouds { .. })));
}

#[test]
fn what_cannot_be_asked_is_an_error() {
    let (query, models) = (Query::new(Isa::detect()), models());
    let cloud = &models[4].tree;
    assert!(matches!(cloud.collide(&query, cloud, &Pose::IDENTITY), Err(SceneError::TwoClouds { .. })));
    for (i, a) in models.iter().enumerate() {
        for (_, b) in models.iter().enumerate().filter(|(j, _)| (i, *j) != (4, 4)) {
            let pose = placed(3.0);
            let negative = Err(SceneError::Tolerance(ToleranceError { given: -1.0 }));
            assert_eq!(a.tree.within(&query, &b.tree, &pose, -1.0), negative);
            let tolerance = a.tree.distance_up_to(&query, &b.tree, &pose, -1.0, 9.0);
            assert!(matches!(tolerance, Err(SceneError::Tolerance(_))));
        }
    }
}
