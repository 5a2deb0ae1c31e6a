//! The stack of a query in total: it runs in a thread that has no more than the library's documentation states.
//!
//! A thread that overflows its stack aborts the process: these tests have nothing to assert.

use crate::{HalfNode, each_pair};
use core::ops::ControlFlow;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef};
use simdop::isa::Isa;
use simdop::motion::{Screw, ScrewMotion};
use simdop::node::{Aabb16, Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Lanes, PrimitivePair, Query};
use simdop::scene::{Body, MotionHit, MotionMemory, Scene, SceneMemory, Slot, boxes_for, rows_for};

/// Bytes that suffice according to the crate's documentation, for the entry points that decide, and for
/// distances. A thread needs little less: 25 KiB on Linux.
const DECIDING: usize = 32 << 10;
const DISTANCE: usize = 64 << 10;

/// Corners whose coordinates are bits 0, 1 and 2 of their index.
fn cube() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from);
    let quad = |[p, q, r, s]: [u32; 4]| [[p, q, r], [p, r, s]];
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), quads.into_iter().flat_map(quad).collect())
}

/// Separate, near contact, with touching faces, and one inside the other. Nearly flat configurations need exact
/// arithmetic, which takes the most stack.
fn poses() -> Vec<Pose> {
    let moved = |x: f64, off: f64| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, off], [0.0, 0.0, 1.0, 0.1 * off]];
    let turned = |x: f64| [[0.6, -0.8, 0.0, x], [0.8, 0.6, 0.0, 0.3], [0.0, 0.0, 1.0, 0.01]];
    let rows = (0..24).map(|i| f64::from(i) * 0.125);
    let rows = rows.flat_map(|x| [moved(x, 0.0), moved(x, 1e-12), turned(x)]);
    rows.map(|rows| Pose::from_rows(rows).unwrap()).collect()
}

fn in_thread<R: Send>(stack: usize, f: impl FnOnce() -> R + Send) -> R {
    std::thread::scope(|scope| {
        std::thread::Builder::new().stack_size(stack).spawn_scoped(scope, f).unwrap().join().unwrap()
    })
}

/// Spheres whose distances from the cube's faces and edges, and from each other, are often sums of radii.
fn spheres() -> Vec<Sphere> {
    let at = |i: u32| f64::from(i % 5) * 0.25;
    (0..40)
        .map(|i| Sphere { centre: [at(i), at(i / 5), at(3 * i)], radius: f64::from(1 + i % 2) * 0.125 })
        .collect()
}

fn cubes<N: Lanes>() -> Bvh<N> {
    let (vertices, triangles) = cube();
    Builder::new().build_as::<N>(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap()
}

fn check<N: Lanes>() {
    check_trees(&cubes::<N>(), &cubes::<N>());
}

fn check_spheres<N: Lanes>() {
    let set = SphereSet { spheres: &spheres() };
    let tree: Bvh<N, Spheres> =
        Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
    check_trees(&tree, &tree);
    check_trees(&tree, &cubes::<N>());
}

fn check_trees<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(a: &Bvh<N, P>, b: &Bvh<N, Q>) {
    let poses = poses();
    for isa in Isa::available() {
        let query = Query::new(isa);
        let exact = in_thread(DECIDING, || {
            let (a, b) = (BvhRef::<N, P>::from_bytes(a.as_bytes()).unwrap(), b.view());
            a.verify().unwrap();
            let mut exact = 0;
            for pose in &poses {
                exact += query.collide(&a, &b, pose).stats.exact_pairs;
                exact += query.within(&a, &b, pose, 0.01).unwrap().stats.exact_pairs;
                exact += each_pair(query, &a, &b, pose, &mut |_| ControlFlow::Continue(())).1.exact_pairs;
            }
            exact
        });
        assert!(exact > 0, "exact arithmetic takes part");
        let exact = in_thread(DISTANCE, || {
            let exact = |pose: &Pose| query.distance(a, b, pose, 0.0).unwrap().stats.exact_pairs;
            poses.iter().map(exact).sum::<u64>()
        });
        assert!(exact > 0, "exact arithmetic takes part");
    }
}

/// A solid cube, and a small one inside it, whose corners lie on diagonals of its faces in the direction of the
/// ray.
fn check_solids<N: Lanes>() {
    let (mut vertices, triangles) = cube();
    let build = |vertices: &[[f64; 3]]| -> Bvh<N> {
        Builder::new().solid().build_as(&Mesh { vertices, triangles: &triangles }).unwrap()
    };
    let outer = build(&vertices);
    vertices.iter_mut().flatten().for_each(|x| *x = 0.3 + 0.4 * *x);
    let inner = build(&vertices);
    for isa in Isa::available() {
        let query = Query::new(isa);
        let exact = in_thread(DECIDING, || {
            [(&inner, &outer), (&outer, &inner)].map(|(a, b)| {
                let answer = query.collide(a, b, &Pose::IDENTITY);
                assert!(answer.hit().is_some(), "{isa}");
                answer.stats.exact_pairs
            })
        });
        assert!(exact.iter().all(|&exact| exact > 0), "exact arithmetic takes part");
        in_thread(DISTANCE, || {
            for (a, b) in [(&inner, &outer), (&outer, &inner)] {
                assert_eq!(query.distance(a, b, &Pose::IDENTITY, 0.0).unwrap().upper, 0.0, "{isa}");
            }
        });
    }
}

/// Penetration volumes: with a budget, the pending pairs are on the stack, too.
fn check_penetration<N: Lanes>() {
    let set = SphereSet { spheres: &spheres() };
    let tree: Bvh<N, Spheres> =
        Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
    for isa in Isa::available() {
        for (stack, query) in [(DECIDING, Query::new(isa)), (DISTANCE, Query::new(isa).with_budget(3))] {
            let pairs = in_thread(stack, || {
                poses().iter().map(|pose| query.penetration(&tree, &tree, pose).pairs).sum::<u64>()
            });
            assert!(pairs > 0);
        }
    }
}

/// A scene in borrowed memory, many configurations in it, and an edge: only a query and the near pairs are on
/// the stack.
fn check_scenes<N: Lanes>() {
    let cube = cubes::<N>();
    let (mut slots, mut boxes) = ([const { Slot::<N>::EMPTY }; 4], [Aabb16::EMPTY; boxes_for(4)]);
    let mut rows = [0; rows_for(4)];
    let at =
        |x: f64| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    let memory = SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows };
    let mut scene = Scene::in_memory(memory).unwrap();
    let moving = [0.0, 3.0].map(|x| scene.insert(Body::new(cube.view()), &at(x)).unwrap());
    let _ = scene.insert(Body::new(cube.view()).fixed(), &at(9.0)).unwrap();
    let starts = [at(0.0), at(3.0)];
    let mut waiting = [MotionHit::EMPTY; 64];
    let mut poses_on_the_way = [Pose::IDENTITY; 4];
    let lent = &mut [Aabb16::EMPTY; 4];
    for isa in Isa::available() {
        let query = Query::new(isa);
        in_thread(DECIDING, || {
            for pose in &poses() {
                scene.place(moving[1], pose).unwrap();
                let _ = scene.collide(&query).unwrap();
                let _ = scene.within(&query, 0.01).unwrap();
                let both = [at(0.0), *pose];
                let _ = scene.check_states(&query, &moving, &both, lent, &mut [0]).unwrap();
            }
            let screw = Screw::new([1.0, 0.5, 0.0], [1.0, 0.1, 0.0], 0.2, 6.0).unwrap();
            let mut motion = ScrewMotion::new(screw, &starts);
            let mut memory = MotionMemory { poses: &mut poses_on_the_way, waiting: &mut waiting };
            let answer = scene.check_motion(&query, &moving, &mut motion, 1e-3, &mut memory).unwrap();
            assert!(answer.pairs > 0, "{isa}");
        });
        in_thread(DISTANCE, || {
            for pose in &poses() {
                scene.place(moving[1], pose).unwrap();
                let _ = scene.clearance(&query, 0.0, 1.0).unwrap();
            }
        });
    }
}

#[test]
fn queries_need_no_more_stack_than_is_documented() {
    for_each_node!(check());
    check_scenes::<Node16<18>>();
    #[cfg(simdop_all_nodes)]
    check_scenes::<Node4<14>>();
    check_spheres::<HalfNode>();
    #[cfg(simdop_all_nodes)]
    check_spheres::<Node16<32>>();
    for_each_node!(check_solids());
    for_each_node!(check_penetration());
}
