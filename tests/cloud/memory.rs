//! The guarantees for a planner on a robot: only the owning types use the heap, and the stack of a search is
//! bounded for every cloud.

#[path = "../support/heap.rs"]
mod heap;

use crate::data::by_suite;
use crate::scenes::Random;
use core::ops::ControlFlow;
use heap::without_heap;
use simdop::cloud::{
    CloudMut, CloudRef, List, Memory, Neighbour, PointCloud, Policy, Queries, Radii, RangeSearch, Seat,
    Upkeep, buckets_for, nodes_for,
};
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, FormatError};
use simdop::isa::Isa;
use simdop::node::{Aabb16, Bucket, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};

/// Spheres, and triangles that touch points of a lattice: exact arithmetic takes the most stack.
fn bodies() -> (Bvh<Node16<32>, Spheres>, Bvh<Node16<32>>) {
    let at = |i: u32| f64::from(i) * 0.25;
    let spheres: Vec<_> =
        (0..40).map(|i| Sphere { centre: [at(i % 4), at(i / 4 % 4), at(i / 16)], radius: 0.125 }).collect();
    let set = SphereSet { spheres: &spheres };
    let round = Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
    let vertices: Vec<_> = (0..25).map(|i| [at(i % 5), at(i / 5), at(i % 5) + at(i / 5) * 0.5]).collect();
    let quads = (0..20).filter(|i| i % 5 < 4).flat_map(|i| [[i, i + 1, i + 6], [i, i + 6, i + 5]]);
    let triangles: Vec<_> = quads.collect();
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    (round, Builder::new().build_as(&mesh).unwrap())
}

/// The points that the bodies' corners and centres can touch.
fn lattice() -> Vec<[f32; 3]> {
    (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(|x| x as f32 * 0.125)).collect()
}

/// Shifts along the mesh: none, one so small that only exact arithmetic can decide whether it touches, one by a
/// step of the lattice, and one far away.
fn poses() -> [Pose; 4] {
    [0.0, 1e-17, 0.125, 3.0]
        .map(|x| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, x]]).unwrap())
}

#[test]
fn bodies_among_points_stay_off_the_heap() {
    let ((round, mesh), cloud) = (bodies(), PointCloud::new(&lattice()).unwrap());
    for isa in Isa::available() {
        let (search, view) = (RangeSearch::new(isa), cloud.view());
        for pose in &poses() {
            for margin in [0.0, 0.01] {
                let found = without_heap("body_within", || search.body_within(&view, &round, pose, margin));
                let other = without_heap("body_within", || search.body_within(&view, &mesh, pose, margin));
                for body in [
                    without_heap("body_distance", || search.body_distance(&view, &round, pose, margin, 9.0)),
                    without_heap("body_distance", || search.body_distance(&view, &mesh, pose, margin, 9.0)),
                ] {
                    assert!(body.unwrap().witness.is_some());
                }
                let is_far = pose.translation()[0] > 1.0;
                assert_eq!((found.unwrap().is_none(), other.unwrap().is_none()), (is_far, is_far), "{isa}");
            }
        }
    }
}

#[test]
fn nothing_allocates_in_borrowed_memory() {
    let (n, room) = (by_suite(1000, 200), by_suite(1100, 220));
    let random = &mut Random(31);
    let mut points: Vec<_> = (0..room).map(|_| random.point()).collect();
    let count = buckets_for(room, 11);
    let (mut nodes, mut buckets) = (vec![Aabb16::EMPTY; nodes_for(count)], vec![Bucket::EMPTY; count]);
    let (mut places, mut counts, mut lists) = (vec![0; room], vec![0; room], vec![List::default(); room]);
    let (mut indices, mut seats) = (vec![0; 100 * room], vec![Seat::default(); 50]);
    let mut found = [Neighbour::NONE; 20];
    let others: Vec<_> = (0..50).map(|_| random.point()).collect();
    let each = vec![0.1; room];
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        let memory = Memory { nodes: &mut nodes, buckets: &mut buckets, places: &mut places };
        let mut cloud = without_heap("build", || CloudMut::build(memory, &points[..n], 11)).unwrap();
        let mut upkeep = Upkeep::new(Policy::Work);
        for frame in 0..4 {
            points.iter_mut().for_each(|point| point[frame % 3] += 0.05 * random.next());
            let ratio = without_heap("refit", || cloud.refit(&points)).unwrap();
            for index in 0..20 {
                without_heap("remove", || cloud.remove(index)).unwrap();
                without_heap("insert", || cloud.insert(index, points[index as usize])).unwrap();
            }
            assert!(without_heap("insert", || cloud.insert(n as u32 + 1, [f32::NAN; 3])).is_err());
            let view = without_heap("view", || cloud.view());
            let own = Queries::own();
            let counted =
                without_heap("count", || search.count(&view, &own, Radii::Same(0.1), &mut counts)).unwrap();
            let filled = without_heap("fill", || {
                search.fill(&view, &own, Radii::Each(&each), &mut lists, &mut indices)
            });
            assert_eq!(filled, Ok(counted), "{isa}");
            let mut seen = 0;
            let visit = |_, _| {
                seen += 1;
                ControlFlow::Continue(())
            };
            without_heap("visit", || search.visit(&view, &own, Radii::Same(0.1), visit)).unwrap();
            assert_eq!(seen, counted.neighbours);
            let packed = without_heap("seat", || search.seat(&view, &others, &mut seats)).unwrap();
            without_heap("count", || search.count(&view, &packed, Radii::Same(0.3), &mut counts)).unwrap();
            for point in &others {
                let any = without_heap("any_within", || search.any_within(&view, *point, 0.02)).unwrap();
                let nearest = without_heap("nearest", || search.nearest(&view, *point)).unwrap().unwrap();
                assert_eq!(any, nearest.square <= 0.02 * 0.02, "{isa}");
                let count =
                    without_heap("k_nearest", || search.k_nearest(&view, *point, &mut found)).unwrap();
                assert_eq!((count, found[0]), (20, nearest), "{isa}");
                let visit = |_| ControlFlow::Continue(());
                without_heap("each_within", || search.each_within(&view, *point, 0.1, visit)).unwrap();
            }
            without_heap("is_due", || upkeep.is_due(&view, ratio, &counted));
            without_heap("validate", || view.validate()).unwrap();
            without_heap("rebuild", || cloud.rebuild()).unwrap();
        }
    }
}

/// Clouds that own their memory allocate when they are built, and never again.
#[test]
fn an_owned_cloud_keeps_its_memory() {
    let random = &mut Random(33);
    let points: Vec<_> = (0..300).map(|_| random.point()).collect();
    let mut cloud = PointCloud::with_room(&points, 9, 320).unwrap();
    let moved: Vec<_> = (0..320).map(|_| random.point()).collect();
    without_heap("refit", || cloud.refit(&moved)).unwrap();
    without_heap("insert", || cloud.insert(310, [0.5; 3])).unwrap();
    without_heap("remove", || cloud.remove(3)).unwrap();
    without_heap("rebuild", || cloud.rebuild()).unwrap();
    let bytes = cloud.view().to_bytes();
    let mut lines = vec![Bucket::EMPTY; bytes.len().div_ceil(256)];
    bytemuck::cast_slice_mut::<_, u8>(&mut lines)[..bytes.len()].copy_from_slice(&bytes);
    let aligned = &bytemuck::cast_slice(&lines)[..bytes.len()];
    assert_eq!(without_heap("from_bytes", || CloudRef::from_bytes(aligned).map(|view| view.len())), Ok(300));
}

/// The bytes of a cloud whose tree is a chain of `depth` nodes: each has a bucket and the next node, and the
/// last one has two buckets. All points are near the origin.
fn comb(depth: usize) -> Vec<Bucket> {
    let points: Vec<_> = (0..=depth).map(|i| [i as f32 / 128.0, 0.0, 0.0]).collect();
    let mut bytes =
        PointCloud::with_room(&points[..1], 1, depth + 1).unwrap().view().to_bytes()[..64].to_vec();
    let mut put = |at: usize, value: usize| {
        bytes[at..at + 4].copy_from_slice(&(value as u32).to_le_bytes());
    };
    // The numbers of points, nodes and buckets.
    put(16, depth + 1);
    put(24, depth);
    put(28, depth + 1);
    for level in 1..=depth {
        let mut node = Aabb16::EMPTY;
        // The highest bit marks a link to a bucket.
        let leaf = |bucket: usize| bytemuck::cast(1 << 31 | bucket as u32);
        let next = if level < depth { bytemuck::cast(level as u32) } else { leaf(depth) };
        node.child[..2].copy_from_slice(&[leaf(level - 1), next]);
        for i in 0..3 {
            node.lower[i][..2].fill(0.0);
            node.upper[i][..2].fill(1.0);
        }
        bytes.extend(bytemuck::bytes_of(&node));
    }
    for (index, point) in points.iter().enumerate() {
        let mut bucket = Bucket::EMPTY;
        bucket.indices[0] = index as u32;
        bucket.coordinates.iter_mut().zip(point).for_each(|(slots, x)| slots[0] = *x);
        bytes.extend(bytemuck::bytes_of(&bucket));
    }
    let mut lines = vec![Bucket::EMPTY; bytes.len().div_ceil(256)];
    bytemuck::cast_slice_mut::<_, u8>(&mut lines)[..bytes.len()].copy_from_slice(&bytes);
    // No bytes may follow the cloud.
    assert_eq!(bytes.len() % 256, 64);
    lines
}

fn read(lines: &[Bucket]) -> Result<CloudRef<'_>, FormatError> {
    let bytes: &[u8] = bytemuck::cast_slice(lines);
    CloudRef::from_bytes(&bytes[..bytes.len() - 192])
}

/// The deepest clouds that `from_bytes` accepts are searched completely. It rejects deeper ones.
#[test]
fn clouds_too_deep_for_the_stack_are_refused() {
    use simdop::hierarchy::MAX_DEPTH;
    for depth in [1, 2, 3, MAX_DEPTH - 1, MAX_DEPTH] {
        let lines = comb(depth);
        let view = read(&lines).unwrap();
        let mut counts = vec![0; depth + 1];
        for isa in Isa::available() {
            let search = RangeSearch::new(isa);
            search.count(&view, &Queries::own(), Radii::Same(1.0), &mut counts).unwrap();
            assert!(counts.iter().all(|&count| count as usize == depth + 1), "{isa} {depth}");
            for (index, x) in (0..=depth).map(|i| i as f32 / 128.0).enumerate() {
                let found = search.nearest(&view, [x, 0.0, 0.0]).unwrap();
                assert_eq!(found, Some(Neighbour { index: index as u32, square: 0.0 }), "{isa} {depth}");
                assert_eq!(search.any_within(&view, [x, 0.0, 0.001], 0.0), Ok(false), "{isa} {depth}");
            }
        }
    }
    for depth in [MAX_DEPTH + 1, 100] {
        assert_eq!(read(&comb(depth)).err(), Some(FormatError::Header { field: "nodes" }), "depth {depth}");
    }
}

/// Bytes of stack that suffice according to the documentation. A thread needs little less: 25 KiB on Linux.
const STACK: usize = 32 << 10;

fn in_thread<R: Send>(f: impl FnOnce() -> R + Send) -> R {
    std::thread::scope(|scope| {
        std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, f).unwrap().join().unwrap()
    })
}

/// A thread that overflows its stack aborts the process: this test has nothing to assert.
#[test]
fn searches_need_no_more_stack_than_is_documented() {
    let random = &mut Random(37);
    let points: Vec<_> = (0..5000).map(|_| random.point()).collect();
    let mut lists = vec![List::default(); points.len()];
    let mut counts = vec![0; points.len()];
    let mut indices = vec![0; 200 * points.len()];
    let mut seats = vec![Seat::default(); points.len()];
    let mut found = vec![Neighbour::NONE; 100];
    let mut cloud = PointCloud::with_room(&points, 10, points.len()).unwrap();
    let deepest = comb(simdop::hierarchy::MAX_DEPTH);
    let ((round, mesh), poses, grid) = (bodies(), poses(), PointCloud::new(&lattice()).unwrap());
    for isa in Isa::available() {
        in_thread(|| {
            let (view, search) = (cloud.view(), RangeSearch::new(isa));
            for radius in [0.01, 0.1] {
                search.count(&view, &Queries::own(), Radii::Same(radius), &mut counts).unwrap();
                search.fill(&view, &Queries::own(), Radii::Same(radius), &mut lists, &mut indices).unwrap();
                let visit = |_, _| ControlFlow::Continue(());
                search.visit(&view, &Queries::own(), Radii::Same(radius), visit).unwrap();
                let packed = search.seat(&view, &points, &mut seats).unwrap();
                search.count(&view, &packed, Radii::Same(radius), &mut counts).unwrap();
                search.any_within(&view, points[3], radius).unwrap();
                search.each_within(&view, points[3], radius, |_| ControlFlow::Continue(())).unwrap();
            }
            search.k_nearest(&view, points[7], &mut found).unwrap();
            for pose in &poses {
                for margin in [0.0, 0.01] {
                    search.body_within(&grid.view(), &round, pose, margin).unwrap();
                    search.body_within(&grid.view(), &mesh, pose, margin).unwrap();
                }
            }
            let deepest = read(&deepest).unwrap();
            search.k_nearest(&deepest, [0.1; 3], &mut found).unwrap();
            search.nearest(&deepest, [0.1; 3]).unwrap();
        });
    }
    in_thread(|| {
        cloud.rebuild().unwrap();
        cloud.refit(&points).unwrap();
        cloud.remove(5).unwrap();
        cloud.insert(5, points[5]).unwrap();
        cloud.view().validate().unwrap();
    });
}
