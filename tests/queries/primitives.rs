//! A kind of primitive that the library does not have, written as a user would, outside the crate: segments get
//! a tree, `verify`, and queries among themselves and with triangles.

use crate::pairs_that_meet;
use crate::support::data::suite_step;
use crate::support::exact::triangles_meet;
use crate::support::rng::Rng;
use crate::support::shapes::wavy_torus;
use crate::support::turns::pose;
use core::ops::ControlFlow;
use simdop::construct::{Builder, Geometry, Mesh, Splitter};
use simdop::hierarchy::{Bvh, BvhRef, FormatError};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::triangle::distance::{nearer, within};
use simdop::primitive::triangle::{Triangle, Triangles, overlap};
use simdop::primitive::{Kind, OWN_DIRECTIONS, Primitive, Separation, Sphere, Spheres, Store};
use simdop::query::{Lanes, PrimitivePair, Query};
use simdop::range::Point;
use std::borrow::Cow;
use std::collections::BTreeSet;

type Segment = [Point; 2];

#[derive(Copy, Clone, PartialEq, Eq, Debug)]
struct Segments;

impl Primitive for Segments {
    const KIND: Kind = Kind::of_user(7);

    type Single = [f32; 3];
    type Double = Point;
    type Record = [u32; 2];
    type Item = Segment;

    fn widen(vertex: [f32; 3]) -> Point {
        vertex.map(f64::from)
    }

    fn narrow(vertex: &Point) -> Option<[f32; 3]> {
        Triangles::narrow(vertex)
    }

    fn balls(vertex: &Point) -> impl Iterator<Item = Sphere> {
        core::iter::once(Sphere { centre: *vertex, radius: 0.0 })
    }

    fn map(vertex: &Point, number: impl Fn(f64) -> f64) -> Point {
        vertex.map(number)
    }

    fn is_among(record: &[u32; 2], vertices: u32) -> bool {
        record.iter().all(|&vertex| vertex < vertices)
    }

    fn item(store: &Store<'_, Self>, index: u32) -> Segment {
        store.record(index).map(|vertex| store.vertex(vertex))
    }

    fn corners(item: &Segment) -> impl Iterator<Item = Point> {
        item.iter().copied()
    }

    fn moved(item: &Segment, pose: &Pose) -> Segment {
        item.map(|p| pose.apply(p))
    }
}

/// A segment is a triangle with two equal corners, which the library decides exactly.
const fn flat([p, q]: &Segment) -> Triangle {
    [*p, *q, *q]
}

macro_rules! as_triangles {
    ($one:ty, $other:ty, $flat_one:expr, $flat_other:expr) => {
        impl PrimitivePair<$other> for $one {
            type Probe<'t> = Triangle;

            fn probe(item: &Self::Item, _margin: f64) -> Triangle {
                $flat_one(item)
            }

            fn meets(probe: &Triangle, other: &<$other as Primitive>::Item, exact: &mut u64) -> bool {
                overlap(probe, &$flat_other(other), exact)
            }

            fn within(
                item: &Self::Item,
                other: &<$other as Primitive>::Item,
                margin: f64,
                exact: &mut u64,
            ) -> bool {
                within(&$flat_one(item), &$flat_other(other), margin, exact)
            }

            fn nearer(
                item: &Self::Item,
                other: &<$other as Primitive>::Item,
                limit: f64,
                tolerance: f64,
                exact: &mut u64,
            ) -> Option<Separation> {
                nearer(&$flat_one(item), &$flat_other(other), limit, tolerance, exact)
            }
        }
    };
}

as_triangles!(Segments, Segments, flat, flat);
as_triangles!(Segments, Triangles, flat, |t: &Triangle| *t);
as_triangles!(Triangles, Segments, |t: &Triangle| *t, flat);

/// Segments over a table of points.
struct Polyline {
    vertices: Vec<Point>,
    segments: Vec<[u32; 2]>,
}

impl Geometry for Polyline {
    type Primitive = Segments;

    fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    fn primitives(&self) -> Cow<'_, [[u32; 2]]> {
        Cow::Borrowed(&self.segments)
    }

    /// The length of the segment.
    fn weight(corners: &[Point], _radius: f64) -> f64 {
        glam::DVec3::from_array(corners[0]).distance(glam::DVec3::from_array(corners[1]))
    }

    fn is_degenerate(corners: &[Point], _radius: f64) -> bool {
        corners[0] == corners[1]
    }
}

/// Short segments between points of a coarse lattice, so that many meet at ends, in the middle, or along an
/// interval.
fn lattice(rng: &mut Rng, count: usize) -> Polyline {
    let mut line = Polyline { vertices: Vec::new(), segments: Vec::new() };
    for _ in 0..count {
        let from: Point = [(); 3].map(|()| rng.int(0, 24) as f64);
        let to = from.map(|x| x + rng.int(-2, 2) as f64);
        let first = line.vertices.len() as u32;
        line.vertices.extend([from, to]);
        line.segments.push([first, first + 1]);
    }
    line
}

fn build<N: Lanes>(line: &Polyline, splitter: Splitter, leaf_size: u32) -> Bvh<N, Segments> {
    let builder = Builder::new().splitter(splitter).leaf_size(leaf_size);
    builder.build_geometry(line, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn pairs_of<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
    query: Query,
    a: &Bvh<N, P>,
    b: &Bvh<N, Q>,
    pose: &Pose,
) -> BTreeSet<(u32, u32)> {
    let (found, stats) = pairs_that_meet(query, a, b, pose);
    assert!(stats.primitive_pairs < (a.view().len() * b.view().len() / 4) as u64, "{stats:?}");
    found
}

fn all_pairs(a: &[Triangle], b: &[Triangle], pose: &Pose) -> BTreeSet<(u32, u32)> {
    let moved: Vec<Triangle> = a.iter().map(|t| t.map(|p| pose.apply(p))).collect();
    let meets = |i: usize, j: usize| triangles_meet(&moved[i], &b[j]).then_some((i as u32, j as u32));
    (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j))).filter_map(|(i, j)| meets(i, j)).collect()
}

fn check<N: Lanes>() {
    let mut rng = Rng::new(11);
    let (a, b) = (lattice(&mut rng, 300), lattice(&mut rng, 280));
    let flat_of = |line: &Polyline| -> Vec<Triangle> {
        line.segments.iter().map(|s| flat(&s.map(|v| line.vertices[v as usize]))).collect()
    };
    let patches: Vec<Triangle> = (0..150)
        .map(|_| [(); 3].map(|()| [(); 3].map(|()| rng.int(0, 24) as f64)))
        .map(|[p, q, r]: [Point; 3]| {
            // Small triangles: corners are at most two steps apart.
            let near = |x: Point| core::array::from_fn(|i| p[i] + (x[i] - p[i]).clamp(-2.0, 2.0));
            [p, near(q), near(r)]
        })
        .collect();
    let vertices: Vec<Point> = patches.iter().flatten().copied().collect();
    let triangles: Vec<[u32; 3]> = (0..patches.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Builder::new().build_as::<N>(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap();
    // Quarter rotations and integer translations preserve the lattice.
    let turned =
        Pose::from_rows([[0.0, -1.0, 0.0, 24.0], [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, -2.0]]).unwrap();
    let wanted = [Pose::IDENTITY, turned].map(|pose| {
        let (flat_a, flat_b) = (flat_of(&a), flat_of(&b));
        let pairs = [
            all_pairs(&flat_a, &flat_b, &pose),
            all_pairs(&flat_a, &patches, &pose),
            all_pairs(&patches, &flat_a, &pose),
        ];
        assert!(pairs.iter().all(|pairs| pairs.len() > 20), "the test would say little");
        (pose, pairs)
    });
    let far = Pose::from_rows([[1.0, 0.0, 0.0, 100.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    let [moved, still] = [&a, &b].map(flat_of);
    let along_x = |corners: &Triangle| corners.map(|p| p[0]);
    let mut least = f64::INFINITY;
    for s in moved.iter().map(|s| s.map(|p| far.apply(p))) {
        let lowest = along_x(&s).into_iter().fold(f64::INFINITY, f64::min);
        for t in &still {
            // An exact distance takes milliseconds in an emulator: only where the gap along x is shorter.
            if along_x(t).iter().any(|x| lowest - x < least) {
                least = least.min(nearer(&s, t, f64::INFINITY, 0.0, &mut 0).unwrap().upper);
            }
        }
    }
    for (splitter, leaf_size) in [(Splitter::MeanWidth, 1), (Splitter::ExtendedLongestAxis, 3)] {
        let (tree_a, tree_b) = (build::<N>(&a, splitter, leaf_size), build::<N>(&b, splitter, leaf_size));
        tree_a.view().verify().unwrap();
        let copied = Bvh::<N, Segments>::from_bytes(tree_a.as_bytes()).unwrap();
        assert_eq!(copied.as_bytes(), tree_a.as_bytes());
        for (pose, [want, onto, under]) in &wanted {
            for isa in Isa::available() {
                let query = Query::new(isa);
                assert_eq!(&pairs_of(query, &tree_a, &tree_b, pose), want, "segments and segments, {isa}");
                assert_eq!(&pairs_of(query, &tree_a, &mesh, pose), onto, "segments and triangles, {isa}");
                assert_eq!(&pairs_of(query, &mesh, &tree_a, pose), under, "triangles and segments, {isa}");
                assert!(query.collide(&tree_a, &tree_b, pose).hit().is_some());
            }
        }
        let distance = Query::new(Isa::detect()).distance(&tree_a, &tree_b, &far, 0.0).unwrap();
        assert!((distance.upper - least).abs() <= 1e-9 * least, "{} {least}", distance.upper);
        assert!(Query::new(Isa::detect()).within(&tree_a, &tree_b, &far, 0.99 * least).unwrap().is_free());
        assert!(
            Query::new(Isa::detect()).within(&tree_a, &tree_b, &far, 1.01 * least).unwrap().hit().is_some()
        );
    }
}

#[test]
fn segments_are_decided_as_brute_force_decides_them() {
    check::<Node16<18>>();
    #[cfg(simdop_all_nodes)]
    check::<simdop::node::Node4<14>>();
}

#[test]
fn a_tree_of_other_primitives_is_refused() {
    let tree = build::<Node16<18>>(&lattice(&mut Rng::new(12), 40), Splitter::MeanWidth, 1);
    let error = BvhRef::<Node16<18>>::from_bytes(tree.as_bytes()).unwrap_err();
    assert_eq!(error, FormatError::OtherPrimitive { kind: Kind::of_user(7).code() });
    assert!(BvhRef::<Node16<18>, Segments>::from_bytes(tree.as_bytes()).is_ok());
}

/// `verify` reads the primitives with their own methods: it finds a plane that is moved in by one step.
#[test]
fn a_plane_that_cuts_a_segment_off_is_found() {
    let tree = build::<Node16<18>>(&lattice(&mut Rng::new(13), 40), Splitter::MeanWidth, 1);
    let mut bytes = tree.as_bytes().to_vec();
    // Plane 0 of lane 0 of the root, after the header's 128 bytes.
    let code = i16::from_le_bytes([bytes[128], bytes[129]]);
    bytes[128..130].copy_from_slice(&(code - 1).to_le_bytes());
    let changed = Bvh::<Node16<18>, Segments>::from_bytes(&bytes).unwrap();
    let error = changed.view().verify().unwrap_err();
    assert_eq!((error.node, error.lane, error.plane), (0, 0, 0));
}

/// Triangles that have a radius each: round, flat and thin at once.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
struct Padded;

impl Primitive for Padded {
    const KIND: Kind = Kind::of_user(8);
    const IS_ROUND: bool = true;

    type Single = [f32; 4];
    type Double = Sphere;
    type Record = [u32; 3];
    type Item = (Triangle, f64);

    fn widen(vertex: [f32; 4]) -> Sphere {
        Spheres::widen(vertex)
    }

    fn narrow(vertex: &Sphere) -> Option<[f32; 4]> {
        Spheres::narrow(vertex)
    }

    fn balls(vertex: &Sphere) -> impl Iterator<Item = Sphere> {
        core::iter::once(*vertex)
    }

    fn map(vertex: &Sphere, number: impl Fn(f64) -> f64) -> Sphere {
        Spheres::map(vertex, number)
    }

    fn is_among(record: &[u32; 3], vertices: u32) -> bool {
        Triangles::is_among(record, vertices)
    }

    fn item(store: &Store<'_, Self>, index: u32) -> (Triangle, f64) {
        let corners = store.record(index).map(|vertex| store.vertex(vertex));
        (corners.map(|ball| ball.centre), corners[0].radius)
    }

    fn corners((corners, _): &(Triangle, f64)) -> impl Iterator<Item = Point> {
        corners.iter().copied()
    }

    fn radius((_, radius): &(Triangle, f64)) -> f64 {
        *radius
    }

    fn moved((corners, radius): &(Triangle, f64), pose: &Pose) -> (Triangle, f64) {
        (Triangles::moved(corners, pose), *radius)
    }

    fn own_directions((corners, _): &(Triangle, f64)) -> [[f64; OWN_DIRECTIONS]; 3] {
        Triangles::own_directions(corners)
    }
}

impl PrimitivePair<Self> for Padded {
    type Probe<'t> = (Triangle, f64);

    fn probe(item: &(Triangle, f64), _margin: f64) -> (Triangle, f64) {
        *item
    }

    fn meets((a, r): &(Triangle, f64), (b, s): &(Triangle, f64), exact: &mut u64) -> bool {
        within(a, b, r + s, exact)
    }

    fn within(a: &(Triangle, f64), b: &(Triangle, f64), margin: f64, exact: &mut u64) -> bool {
        within(&a.0, &b.0, (a.1 + b.1) + margin, exact)
    }

    fn nearer(
        a: &(Triangle, f64),
        b: &(Triangle, f64),
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        let radii = a.1 + b.1;
        let found = nearer(&a.0, &b.0, limit + radii, tolerance, exact)?;
        let [lower, upper] = [found.lower, found.upper].map(|bound| (bound - radii).max(0.0));
        Some(Separation { lower, upper, ..found })
    }
}

struct PaddedMesh {
    vertices: Vec<Sphere>,
    triangles: Vec<[u32; 3]>,
}

impl PaddedMesh {
    fn of(corners: &[Triangle], mut radius: impl FnMut() -> f64) -> Self {
        let with_radius = |t: &Triangle| {
            let radius = radius();
            t.map(|centre| Sphere { centre, radius })
        };
        let vertices: Vec<Sphere> = corners.iter().flat_map(with_radius).collect();
        let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self { vertices, triangles }
    }

    fn items(&self) -> Vec<(Triangle, f64)> {
        let balls = self.triangles.iter().map(|t| t.map(|vertex| self.vertices[vertex as usize]));
        balls.map(|balls| (balls.map(|ball| ball.centre), balls[0].radius)).collect()
    }
}

impl Geometry for PaddedMesh {
    type Primitive = Padded;

    fn vertices(&self) -> &[Sphere] {
        &self.vertices
    }

    fn primitives(&self) -> Cow<'_, [[u32; 3]]> {
        Cow::Borrowed(&self.triangles)
    }

    fn weight(corners: &[Point], radius: f64) -> f64 {
        Mesh::weight(corners, radius)
    }

    fn normal(corners: &[Point]) -> Point {
        Mesh::normal(corners)
    }

    fn is_degenerate(corners: &[Point], radius: f64) -> bool {
        Mesh::is_degenerate(corners, radius)
    }
}

/// Everything that radii enlarge, normal slabs and primitive slabs included: smooth surfaces close to each
/// other, and one large triangle close to a small body.
#[test]
fn padded_triangles_are_decided_as_brute_force_decides_them() {
    let mut rng = Rng::new(14);
    let ring = wavy_torus(800 / suite_step() as u32).corners();
    let wall: Triangle = [[3.3, -40.0, -30.0], [3.3, 40.0, -30.0], [3.35, 0.0, 50.0]];
    let thick = PaddedMesh::of(&ring, || 0.02 * f64::from(rng.below(64) as u32) / 64.0);
    let bodies = [&thick, &PaddedMesh::of(&[wall], || 0.25)];
    let builder = Builder::new();
    let trees = bodies.map(|body| -> Bvh<Node16<18>, Padded> {
        builder.build_geometry(body, &mut |_| ControlFlow::Continue(())).unwrap()
    });
    for tree in &trees {
        tree.view().verify().unwrap();
        assert_eq!(tree.view().header().has_normal_slabs, 1);
        assert_eq!(
            Bvh::<Node16<18>, Padded>::from_bytes(tree.as_bytes()).unwrap().as_bytes(),
            tree.as_bytes()
        );
    }
    let turn = Rng::new(15).rotation();
    for x in [-5.75, -0.3, -0.1, 0.02, 0.05] {
        for (b, tree_b) in bodies.iter().zip(&trees) {
            let t = [x, 0.07, 0.03];
            // As far from a rotation as a pose may be, and rotated.
            for m in [[[1.0, 0.0, 4e-5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], turn] {
                let pose = pose(&m, t);
                let moved: Vec<_> = thick.items().iter().map(|item| Padded::moved(item, &pose)).collect();
                let (mut want, mut least) = (BTreeSet::new(), f64::INFINITY);
                // Pairs that touch, according to the bounds of their distance.
                let mut touching = BTreeSet::new();
                for (i, (p, r)) in moved.iter().enumerate() {
                    for (j, (q, s)) in b.items().iter().enumerate() {
                        if let Some(found) = nearer(p, q, least.max(0.0) + r + s, 0.0, &mut 0) {
                            least = least.min(found.upper - (r + s));
                            if found.upper <= r + s {
                                want.insert((i as u32, j as u32));
                            } else if found.lower <= r + s {
                                touching.insert((i as u32, j as u32));
                            }
                        }
                    }
                }
                for isa in Isa::available() {
                    let query = Query::new(isa);
                    let (found, _) = pairs_that_meet(query, &trees[0], tree_b, &pose);
                    let decided = |pair: &&(u32, u32)| !touching.contains(pair);
                    assert!(found.iter().filter(decided).eq(want.iter()), "{x}, {isa}: {found:?} {want:?}");
                    let distance = query.distance(&trees[0], tree_b, &pose, 0.0).unwrap().upper;
                    assert!((distance - least.max(0.0)).abs() < 1e-9, "{x}, {isa}: {distance} {least}");
                    assert_eq!(query.collide(&trees[0], tree_b, &pose).is_free(), found.is_empty());
                }
            }
        }
    }
}
