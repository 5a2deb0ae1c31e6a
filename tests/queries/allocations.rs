//! The guarantees for a planner on a robot: no query uses the heap, and the stack of a query is bounded for all
//! trees.

#[path = "../support/heap.rs"]
mod heap;

use crate::each_pair;
use crate::support::data::MeshData;
use crate::support::dyadic::key_value;
use crate::support::shapes;
use core::ops::ControlFlow;
use heap::without_heap;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::{Bvh, BvhRef, FormatError, Header, MAX_DEPTH};
use simdop::isa::Isa;
use simdop::motion::{Screw, ScrewMotion};
use simdop::node::{Child, Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Completion, Lanes, Query, STACK_BYTES, Verdict};
use simdop::scene::{Body, MotionHit, MotionMemory, Scene};

fn tree<N: Lanes>() -> Bvh<N> {
    let mesh = shapes::torus(32, 20);
    Builder::new()
        .leaf_size(3)
        .build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles })
        .unwrap()
}

fn pose(x: f64) -> Pose {
    without_heap("a pose", || {
        Pose::from_rows([[0.6, -0.8, 0.0, x], [0.8, 0.6, 0.0, 0.1], [0.0, 0.0, 1.0, 0.2]]).unwrap()
    })
}

fn queries_stay_off_the_heap<N: Lanes>() {
    let tree = tree::<N>();
    let view: BvhRef<'_, N> = without_heap("view", || tree.view());
    let borrowed: BvhRef<'_, N> = without_heap("from_bytes", || BvhRef::from_bytes(tree.as_bytes())).unwrap();
    without_heap("verify", || view.verify()).unwrap();
    let detected = without_heap("detection", Isa::detect);
    for isa in without_heap("available", || Isa::available().chain([detected])) {
        let query = Query::new(isa);
        // Linked rings: the hulls overlap deeply, whether the surfaces meet or not.
        let (near, close, far) = (pose(1.0), pose(2.6), pose(1000.0));
        let collide = |query: Query, pose: &Pose| {
            without_heap("collide", || query.collide(&view, &borrowed, pose)).verdict
        };
        assert!(matches!(collide(query, &near), Verdict::Hit(_)));
        assert_eq!(collide(query, &far), Verdict::Free);
        let _ = collide(query, &close);
        assert!(matches!(collide(query.with_budget(1), &near), Verdict::Unknown { .. }));
        for pose in [&near, &close, &far] {
            let _ = without_heap("within", || query.within(&view, &borrowed, pose, 0.01)).unwrap();
            let distance = without_heap("distance", || query.distance(&view, &borrowed, pose, 0.0)).unwrap();
            assert!(distance.lower <= distance.upper);
            let hinted = query.with_hint(distance.hint);
            let again = without_heap("hinted", || hinted.distance(&view, &borrowed, pose, 0.0)).unwrap();
            assert!(again.lower <= again.upper);
        }
        let mut count = 0;
        let (completion, _) = without_heap("for_each_pair", || {
            each_pair(query, &view, &borrowed, &near, &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            })
        });
        assert_eq!(completion, Completion::Complete);
        assert!(count > 100, "{count} pairs meet");
    }
}

#[test]
fn a_query_never_allocates() {
    for_each_node!(queries_stay_off_the_heap());
}

#[test]
fn nor_does_one_of_solids() {
    let cube = shapes::cuboid([-1.0; 3], [1.0; 3], false);
    let build = |mesh: &MeshData| -> Bvh<Node16<18>> {
        Builder::new()
            .solid()
            .build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles })
            .unwrap()
    };
    let (large, small) = (build(&shapes::scaled(&cube, 9.0, [0.0; 3])), build(&cube));
    for query in Isa::available().map(Query::new) {
        for (a, b) in [(&large, &small), (&small, &large)] {
            let answer = without_heap("collide", || query.collide(a, b, &pose(1.0)));
            assert!(answer.hit().is_some());
            let distance = without_heap("distance", || query.distance(a, b, &pose(1.0), 0.0)).unwrap();
            assert_eq!(distance.upper, 0.0);
        }
    }
}

#[test]
fn the_stack_of_a_query_is_below_three_kilobytes() {
    assert!((1..=3072).contains(&STACK_BYTES), "{STACK_BYTES} bytes");
}

/// A tilted triangle. Its box is thick, so bodies can overlap as volumes without meeting.
const TILTED: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];

/// The bits of a link to a node that state the width of a volume with these planes.
fn width_bits(planes: &[i16; 6]) -> u32 {
    let sum = planes.iter().map(|&code| key_value(code)).sum::<f64>();
    // The binary logarithm, rounded down.
    let log = (sum.to_bits() >> 52) as i32 - 1023;
    ((log + 14).clamp(0, 31) as u32) << 26
}

/// The bytes of a tree that is a chain: each node has a leaf and the next node, and the last one has only a
/// leaf. All `depth` leaves hold the same triangle of this size, so that all planes are equal.
fn comb(depth: usize, size: f64) -> Vec<u8> {
    let builder = Builder::new();
    let triangle = TILTED.map(|p| p.map(|x| x * size));
    let mesh = shapes::separate([triangle]);
    let tree = builder.build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let view: BvhRef<'_, Node4<6>> = Bvh::view(&tree);
    let planes = view.nodes()[0].planes;
    let width = width_bits(&planes.map(|plane| plane[0]));
    let node = |child: [u32; 2]| {
        let used = |lane: usize, j: usize| if child[lane] == u32::MAX { i16::MIN } else { planes[j][0] };
        let planes = core::array::from_fn(|j| [used(0, j), used(1, j), i16::MIN, i16::MIN]);
        Node4::<6>::new(planes, [child[0], child[1], u32::MAX, u32::MAX].map(bytemuck::cast::<u32, Child>))
    };
    // Lower lanes are visited first: the leaves stay pending until all lower levels have been visited.
    let leaf = |first: usize| 1 << 31 | first as u32;
    let link = |level: usize| {
        if level < depth { [width | level as u32, leaf(level - 1)] } else { [leaf(depth - 1), u32::MAX] }
    };
    let nodes: Vec<_> = (1..=depth).map(|level| node(link(level))).collect();
    let mut header = *view.header();
    (header.depth, header.node_count, header.has_normal_slabs) = (depth as u32, nodes.len() as u32, 0);
    header.primitive_count = depth as u32;
    let mut bytes = bytemuck::bytes_of(&header).to_vec();
    bytes.extend(nodes.iter().flat_map(bytemuck::bytes_of));
    bytes.extend(triangle.as_flattened().iter().flat_map(|&x| (x as f32).to_le_bytes()));
    bytes.extend((0..depth).flat_map(|_| [0_u32, 1, 2]).chain(0..depth as u32).flat_map(u32::to_le_bytes));
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    bytes
}

/// The deepest trees that `from_bytes` accepts are traversed completely. It rejects deeper ones.
#[test]
fn trees_too_deep_for_the_stack_are_refused() {
    let apart = Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1e-3]]).unwrap();
    let read = |depth: usize| Bvh::<Node4<6>>::from_bytes(&comb(depth, 1.0));
    for depth in [1, 2, 3, MAX_DEPTH - 1, MAX_DEPTH] {
        let (tree, flat) = (read(depth).unwrap(), read(1).unwrap());
        tree.view().verify().unwrap();
        for isa in Isa::available() {
            for (a, b) in [(&tree, &tree), (&tree, &flat), (&flat, &tree)] {
                let collide =
                    |pose| without_heap("collide", || Query::new(isa).collide(&a.view(), &b.view(), pose));
                assert!(collide(&Pose::IDENTITY).hit().is_some(), "depth {depth}");
                let answer = collide(&apart);
                assert_eq!(answer.verdict, Verdict::Free, "depth {depth}");
                let pairs = (a.view().len() * b.view().len()) as u64;
                assert_eq!(answer.stats.primitive_pairs, pairs, "all volumes overlap: depth {depth}");
            }
        }
    }
    let too_deep = Some(FormatError::Header { field: "depth" });
    for depth in [MAX_DEPTH + 1, 100] {
        assert_eq!(read(depth).err(), too_deep, "depth {depth}");
    }
    // It also rejects a tree whose header understates the depth.
    let mut bytes = comb(MAX_DEPTH + 1, 1.0);
    let at = core::mem::offset_of!(Header, depth);
    bytes[at..at + 4].copy_from_slice(&(MAX_DEPTH as u32).to_le_bytes());
    assert_eq!(Bvh::<Node4<6>>::from_bytes(&bytes).err(), too_deep);
}

/// For two bodies of very different size, one descends to its leaves before the other does, so the stack holds
/// the levels of both. The small one lies just above the large one's triangle, far from its edges: all volumes
/// overlap, and no slab of a triangle culls a volume.
#[test]
fn the_stack_holds_the_levels_of_both_trees() {
    for small in [1.0 / 1024.0, 1.0 / 1_048_576.0] {
        let read = |size: f64| Bvh::<Node4<6>>::from_bytes(&comb(MAX_DEPTH, size)).unwrap();
        let (one, other) = (read(1.0), read(small));
        // A point of the large triangle, raised by the gap.
        let at = |sign: f64, gap: f64| {
            let t = [0.25, 0.25, 0.1875 + gap * small].map(|x| x * sign);
            Pose::from_rows([[1.0, 0.0, 0.0, t[0]], [0.0, 1.0, 0.0, t[1]], [0.0, 0.0, 1.0, t[2]]]).unwrap()
        };
        for isa in Isa::available() {
            for (a, b, sign) in [(&one, &other, -1.0), (&other, &one, 1.0)] {
                let collide = |gap: f64| {
                    let pose = at(sign, gap);
                    without_heap("collide", || Query::new(isa).collide(&a.view(), &b.view(), &pose))
                };
                assert!(collide(0.0).hit().is_some(), "{isa} {small}");
                let answer = collide(1e-3);
                assert_eq!(answer.verdict, Verdict::Free, "{isa} {small}");
                let pairs = (MAX_DEPTH * MAX_DEPTH) as u64;
                assert_eq!(answer.stats.primitive_pairs, pairs, "{isa} {small}: all volumes overlap");
                // At least one visit for each pair of a node and of a leaf's parent.
                assert!(answer.stats.visits >= pairs, "{isa} {small}: {:?}", answer.stats);
            }
        }
    }
}

/// Nor do queries of scenes use the heap, whatever memory the scene uses. Only an insertion may allocate.
#[test]
fn queries_of_scenes_stay_off_the_heap() {
    let tree = tree::<Node16<18>>();
    let mut scene = Scene::new();
    let ids = [-9.0, -1.0, 2.6, 7.0].map(|x| scene.insert(Body::new(tree.view()), &pose(x)).unwrap());
    scene.attach(ids[3], ids[0]).unwrap();
    for isa in Isa::available() {
        let query = Query::new(isa);
        for x in [-9.0, 0.0] {
            without_heap("scene", || {
                scene.place(ids[0], &pose(x)).unwrap();
                assert_eq!(scene.collide(&query).unwrap().is_free(), x == -9.0);
                let _ = scene.within(&query, 0.01).unwrap();
                let _ = scene.clearance(&query, 0.1, 1.0).unwrap();
                let _ = scene.for_each_hit(&query, 0.0, |_| ControlFlow::Continue(())).unwrap();
            });
            let (starts, mut poses) = ([pose(x)], [Pose::IDENTITY; 2]);
            let mut waiting = [MotionHit::EMPTY; 64];
            let screw = Screw::new([0.0; 3], [0.0, 0.0, 1.0], 0.5, 0.1).unwrap();
            let mut motion = ScrewMotion::new(screw, &starts);
            let mut memory = MotionMemory { poses: &mut poses, waiting: &mut waiting };
            without_heap("edge", || {
                let answer = scene.check_motion(&query, &ids[..1], &mut motion, 1e-3, &mut memory).unwrap();
                assert!(answer.pairs > 0);
            });
        }
    }
}
