//! Clouds of points: a loop over the points in their buckets decides which are near.

use crate::baked::{put_number, u32_at};
use crate::planes::float;
use crate::{Input, Mode, cached};
use core::ops::ControlFlow;
use simdop::cloud::{
    CLOUD_MAGIC, CLOUD_VERSION, CloudRef, List, Neighbour, PointCloud, Queries, Radii, RangeSearch,
    RangeStats, SearchError, Seat,
};
use simdop::hierarchy::{FormatError, MAX_DEPTH};
use simdop::isa::Isa;
use simdop::node::{Aabb16, Bucket, Link};

type Point = [f32; 3];

/// A finite point; small integers with [`Mode::Grid`].
pub fn point(input: &mut Input, mode: Mode) -> Point {
    [(); 3].map(|()| Some(float(input, mode)).filter(|x| x.is_finite()).unwrap_or(0.5))
}

/// One of these points, a point between two of them, or any point.
fn query(input: &mut Input, mode: Mode, all: &[(u32, Point)]) -> Point {
    match (input.below(4), all) {
        (_, []) | (0, _) => point(input, mode),
        (1, _) => {
            let (p, q) = (input.pick(all).1, input.pick(all).1);
            [0, 1, 2].map(|i| 0.5 * p[i] + 0.5 * q[i])
        }
        _ => input.pick(all).1,
    }
}

/// A radius; half of the time the distance of two of the points.
fn radius(input: &mut Input, mode: Mode, all: &[(u32, Point)]) -> f32 {
    let any = match (input.below(4), all) {
        (_, []) | (0, _) => float(input, mode).abs(),
        (1, _) => [0.0, 1.0, 0.05, 1e-30, 1e20, f32::MAX][input.below(6)],
        _ => square(input.pick(all).1, input.pick(all).1).sqrt(),
    };
    if any.is_finite() { any } else { 2.0 }
}

/// The value compared with the squared radius: these operations in `f32`.
fn square(p: Point, q: Point) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|i| p[i] - q[i]);
    (x * x + y * y) + z * z
}

/// Valid clouds of many kinds.
pub fn clouds() -> &'static Vec<PointCloud> {
    cached(|| {
        let bytes: Vec<u8> = (0..100).collect();
        let mut input = Input::new(&bytes);
        let mut real = |n: usize| (0..n).map(|_| point(&mut input, Mode::Real)).collect::<Vec<_>>();
        let lattice: Vec<_> = (0..64).map(|i| [i % 4, i / 4 % 4, i / 16].map(|x| x as f32)).collect();
        let of = |points: &[Point], size, room| PointCloud::with_room(points, size, room).unwrap();
        let mut holed = of(&real(60), 5, 70);
        (10..30).for_each(|index| holed.remove(index).unwrap());
        let mut emptied = of(&lattice[..6], 2, 9);
        (0..6).for_each(|index| emptied.remove(index).unwrap());
        let zeros: Vec<_> =
            (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { 0.0 } else { -0.0 })).collect();
        let huge: Vec<_> = lattice.iter().map(|p| p.map(|x| (x - 1.5) * 1e38)).collect();
        vec![
            of(&lattice, 16, 64),
            of(&real(40), 16, 40),
            holed,
            of(&real(300), 16, 301),
            of(&lattice, 3, 64),
            of(&real(70), 1, 80),
            of(&[[1.5, -2.0, 3.25]; 20], 7, 20),
            of(&zeros, 3, 8),
            of(&huge, 6, 64),
            of(&[[0.5; 3]], 16, 1),
            of(&[], 16, 3),
            emptied,
        ]
    })
}

/// Writes a coordinate, a link or an index at its place in a node or a bucket, near the previous value or arbitrary.
pub fn put(bytes: &mut [u8], at: usize, nodes_end: usize, input: &mut Input) {
    // Links are the last eighth of a node; indices the last quarter of a bucket.
    let is_link = at >= 64 && at < nodes_end && (at - 64) % 512 >= 448;
    let is_index = at >= nodes_end && (at - nodes_end) % 256 >= 192;
    if is_link || is_index {
        let word = u32::from(input.u8() % 64);
        let word = [word, if is_link { 1 << 31 | word } else { word }, u32::MAX][input.below(3)];
        bytes[at & !3..][..4].copy_from_slice(&word.to_le_bytes());
    } else {
        put_number(bytes, at, 4, input);
    }
}

/// Offset of the end of the nodes of a cloud.
pub fn nodes_end(bytes: &[u8]) -> usize {
    64 + 512 * u32_at(bytes, 24) as usize
}

/// Whether the bytes have the reported error.
pub fn is_true(error: FormatError, bytes: &[u8]) -> bool {
    let field = |at: usize| u32_at(bytes, at);
    let place = |index: u32| {
        let at = nodes_end(bytes) + 256 * (index / 16) as usize + 4 * (index % 16) as usize;
        (index / 16 < field(28)).then(|| [0, 64, 128, 192].map(|part| field(at + part)))
    };
    match error {
        FormatError::Truncated { have, need } => have == bytes.len() && have < need,
        FormatError::TooLong { have, need } => have == bytes.len() && have > need,
        FormatError::NotATree => !bytes.starts_with(&CLOUD_MAGIC),
        FormatError::Version { found } => found == field(8) && found != CLOUD_VERSION,
        FormatError::Node { node, lane, .. } => node < field(24) && lane < 16,
        FormatError::Vertex { index } => place(index).is_some_and(|[x, y, z, index]| {
            let numbers = [x, y, z].map(f32::from_bits);
            if index == u32::MAX {
                numbers.iter().any(|x| !x.is_nan())
            } else {
                numbers.iter().any(|x| !x.is_finite())
            }
        }),
        FormatError::Source { index } => place(index).is_some_and(|[.., index]| index >= field(20)),
        FormatError::Header { field } => !field.is_empty(),
        _ => false,
    }
}

/// Compares the cloud with an independent reader.
pub fn is_what_the_bytes_say(view: &CloudRef<'_>, bytes: &[u8]) {
    let field = |at: usize| u32_at(bytes, at) as usize;
    let (nodes, buckets): (&[u8], &[u8]) =
        (bytemuck::cast_slice(view.nodes()), bytemuck::cast_slice(view.buckets()));
    assert!(bytes[64..] == [nodes, buckets].concat());
    let said =
        [view.bucket_size() as usize, view.len(), view.capacity(), view.nodes().len(), view.buckets().len()];
    assert_eq!(said, [12, 16, 20, 24, 28].map(field));
    assert!(view.to_bytes() == bytes, "encoded again");
    let all = held(view);
    assert!(all.len() == view.len() && all.iter().all(|&(index, _)| (index as usize) < view.capacity()));
}

/// The points in the order of buckets and slots.
pub fn held(view: &CloudRef<'_>) -> Vec<(u32, Point)> {
    let of = |bucket: &Bucket| {
        let [x, y, z] = bucket.coordinates;
        let slots = (0..16).map(|slot| (bucket.indices[slot], [x[slot], y[slot], z[slot]]));
        slots.filter(|(index, _)| *index != Bucket::UNUSED).collect::<Vec<_>>()
    };
    view.buckets().iter().flat_map(of).collect()
}

/// Checks that every node and every bucket is reached once, the buckets in their order, and that each box on the way
/// contains its points, and is the smallest that does if boxes should be tight.
pub fn is_safe_to_search(view: &CloudRef<'_>, tight: bool) {
    let (mut nodes, mut buckets) = (0, 0);
    below(view, 0, 1, tight, &mut nodes, &mut buckets);
    assert_eq!((nodes, buckets), (view.nodes().len(), view.buckets().len()));
}

/// The points below a node.
fn below(
    view: &CloudRef<'_>,
    index: usize,
    level: usize,
    tight: bool,
    nodes: &mut usize,
    buckets: &mut usize,
) -> Vec<Point> {
    let node: &Aabb16 = &view.nodes()[index];
    *nodes += 1;
    assert!(level <= MAX_DEPTH && *nodes <= view.nodes().len());
    let mut all = Vec::new();
    for lane in 0..16 {
        let points = match node.child[lane].link() {
            Link::Empty => Vec::new(),
            Link::Inner(next) => below(view, next as usize, level + 1, tight, nodes, buckets),
            Link::Leaf { first, count } => {
                assert_eq!((first as usize, count), (*buckets, 1));
                *buckets += 1;
                let bucket = &view.buckets()[first as usize];
                let [x, y, z] = bucket.coordinates;
                let used = (0..16).filter(|&slot| bucket.indices[slot] != Bucket::UNUSED);
                used.map(|slot| [x[slot], y[slot], z[slot]]).collect()
            }
        };
        let of = node.lane(lane);
        for i in 0..3 {
            let (low, high) = (of.lower[i], of.upper[i]);
            assert!(points.iter().all(|p| low <= p[i] && p[i] <= high), "{of:?} {points:?}");
            // Zeros of both signs are equal.
            let is_end =
                |end: f32| if points.is_empty() { end.is_nan() } else { points.iter().any(|p| p[i] == end) };
            assert!(!tight || is_end(low) && is_end(high), "{of:?} {points:?}");
        }
        all.extend(points);
    }
    all
}

/// The results of a loop over all points.
struct Found {
    /// For each point in turn, its index and its neighbours. `None` for clouds whose capacity exceeds the memory for
    /// results.
    own: Option<Vec<(u32, Vec<u32>)>>,
    /// For each other query.
    others: Vec<Vec<u32>>,
    /// All points, nearest first.
    nearest: Vec<Vec<(f32, u32)>>,
}

/// Checks that searches of a cloud on every instruction set find the same as a loop, in its order.
pub fn searches_agree(view: &CloudRef<'_>, input: &mut Input, mode: Mode) {
    let all = held(view);
    let asked: Vec<_> = (0..input.below(12)).map(|_| query(input, mode, &all)).collect();
    let each: Vec<_> = asked.iter().map(|_| radius(input, mode, &all)).collect();
    let (same, limit, k) = (radius(input, mode, &all), 1 + input.below(40), input.below(20));
    let sorted = |q: &Point| {
        let mut all: Vec<_> = all.iter().map(|&(index, p)| (square(*q, p), index)).collect();
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all
    };
    let want = Found {
        own: (view.capacity() <= 4096)
            .then(|| all.iter().map(|&(index, p)| (index, near(&all, p, same))).collect()),
        others: asked.iter().zip(&each).map(|(q, r)| near(&all, *q, *r)).collect(),
        nearest: asked.iter().map(sorted).collect(),
    };
    let mut works = Vec::new();
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        let mut work = Vec::new();
        if let Some(own) = &want.own {
            work.extend(own_agree(&search, view, own, same, limit));
        }
        work.extend(others_agree(&search, view, &want.others, &asked, &each));
        for (i, (&q, &r)) in asked.iter().zip(&each).enumerate() {
            assert_eq!(search.any_within(view, q, r), Ok(!want.others[i].is_empty()), "{isa} {q:?} {r:e}");
            let mut found = Vec::new();
            let visit = |index| {
                found.push(index);
                ControlFlow::Continue(())
            };
            work.push(search.each_within(view, q, r, visit).unwrap());
            assert_eq!(found, want.others[i], "{isa} {q:?} {r:e}");
            nearest_agree(&search, view, &want.nearest[i], q, k);
        }
        works.push(work);
    }
    assert!(works.iter().all(|work| *work == works[0]), "the work of every instruction set: {works:?}");
}

fn near(all: &[(u32, Point)], q: Point, r: f32) -> Vec<u32> {
    all.iter().filter(|(_, p)| square(q, *p) <= r * r).map(|(index, _)| *index).collect()
}

fn own_agree(
    search: &RangeSearch,
    view: &CloudRef<'_>,
    lists: &[(u32, Vec<u32>)],
    radius: f32,
    limit: usize,
) -> [RangeStats; 3] {
    let (own, radii, room) = (Queries::own(), Radii::Same(radius), view.capacity());
    let mut want = vec![u32::MAX; room];
    // Damaged clouds may use an index twice: the last one stays.
    lists.iter().for_each(|(index, list)| want[*index as usize] = list.len() as u32);
    let mut counts = vec![u32::MAX; room];
    let counted = search.count(view, &own, radii, &mut counts).unwrap();
    assert_eq!(counts, want, "{search:?} {radius:e}");
    let flat: Vec<_> = lists.iter().flat_map(|(_, list)| list.iter().copied()).collect();
    assert_eq!(counted.neighbours, flat.len() as u64);

    let (mut seen, mut calls) = (Vec::new(), 0);
    let visited = search.visit(view, &own, radii, |query, index| {
        seen.push((query, index));
        ControlFlow::Continue(())
    });
    let pairs = lists.iter().flat_map(|(query, list)| list.iter().map(move |index| (*query, *index)));
    assert!(seen.iter().copied().eq(pairs), "{search:?} {radius:e}");
    let breaking = search.visit(view, &own, radii, |_, _| {
        calls += 1;
        if calls < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!((calls, breaking.is_ok()), (limit.min(flat.len()), true));

    let (mut places, mut buffer) = (vec![List::default(); room], vec![0; flat.len()]);
    if let Some(less) = flat.len().checked_sub(1) {
        let short = search.fill(view, &own, radii, &mut places, &mut buffer[..less]);
        assert_eq!(short, Err(SearchError::Buffer { have: less, need: flat.len() as u64 }));
    }
    let filled = search.fill(view, &own, radii, &mut places, &mut buffer).unwrap();
    assert_eq!(buffer, flat, "{search:?} {radius:e}");
    for (place, count) in places.iter().zip(&want).filter(|(_, count)| **count != u32::MAX) {
        assert_eq!(place.count, *count);
    }
    let mut is_checked = vec![false; room];
    for (index, list) in lists.iter().rev() {
        if !core::mem::replace(&mut is_checked[*index as usize], true) {
            assert!(buffer[places[*index as usize].range()] == list[..], "{search:?} {radius:e}");
        }
    }
    [counted, visited.unwrap(), filled]
}

/// Checks queries that are not points of the cloud, packed.
fn others_agree(
    search: &RangeSearch,
    view: &CloudRef<'_>,
    want: &[Vec<u32>],
    asked: &[Point],
    each: &[f32],
) -> [RangeStats; 2] {
    let mut seats = vec![Seat::default(); asked.len()];
    let packed = search.seat(view, asked, &mut seats).unwrap();
    let (mut counts, mut seen) = (vec![u32::MAX; asked.len()], vec![Vec::new(); asked.len()]);
    let counted = search.count(view, &packed, Radii::Each(each), &mut counts).unwrap();
    let visited = search.visit(view, &packed, Radii::Each(each), |query, index| {
        seen[query as usize].push(index);
        ControlFlow::Continue(())
    });
    for (i, (&q, &r)) in asked.iter().zip(each).enumerate() {
        assert_eq!((counts[i], &seen[i]), (want[i].len() as u32, &want[i]), "{search:?} {q:?} {r:e}");
    }
    [counted, visited.unwrap()]
}

/// Checks the k nearest: the first of all points in order.
fn nearest_agree(search: &RangeSearch, view: &CloudRef<'_>, want: &[(f32, u32)], q: Point, k: usize) {
    let mut found = vec![Neighbour::NONE; k];
    let count = k.min(want.len());
    assert_eq!(search.k_nearest(view, q, &mut found), Ok(count));
    let found: Vec<_> = found[..count].iter().map(|n| (n.square, n.index)).collect();
    assert_eq!(found, want[..count], "{search:?} {q:?}");
    let nearest = search.nearest(view, q).unwrap().map(|n| (n.square, n.index));
    assert_eq!(nearest, want.first().copied(), "{search:?} {q:?}");
}
