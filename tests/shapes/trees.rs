//! Shapes in trees and beside trees: the traversals against brute force over the tests of pairs.

use crate::support::data::MeshData;
use crate::support::rng::Rng;
use crate::support::shapes::{cuboid, soup, torus};
use crate::support::turns::{pose, random_point, rotation};
use core::ops::ControlFlow;
use simdop::construct::{Builder, Mesh, ShapeSet, SphereSet};
use simdop::hierarchy::{Bvh, FormatError};
use simdop::isa::Isa;
#[cfg(simdop_all_nodes)]
use simdop::node::Node4;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::shape::{Core, ShapeError, is_within, meets, separation};
use simdop::primitive::{Primitive, Shape, Shapes, Sphere, Spheres, Triangles};
use simdop::query::{Lanes, PrimitivePair, Query, QueryStats};

/// A random shape of about unit size, of each bounded kind; sometimes widened, thin or far from its origin.
pub(crate) fn shape(rng: &mut Rng) -> Shape {
    let length = |rng: &mut Rng| *rng.pick(&[0.001, 0.3, 1.0]) * rng.range(0.5, 1.0);
    let at = pose(&rng.rotation(), random_point(rng, [0.0, 0.5, 2.0]));
    let shape = match rng.below(7) {
        0 => Shape::sphere(length(rng)),
        1 => Shape::capsule(length(rng), length(rng)),
        2 => Shape::cuboid([length(rng), length(rng), length(rng)]),
        3 => Shape::cylinder(length(rng), length(rng)),
        4 => Shape::cone(length(rng), length(rng)),
        5 => Shape::new(Core::Segment([random_point(rng, [1.0]), random_point(rng, [1.0])]), 0.0),
        _ => Shape::new(Core::Triangle([(); 3].map(|()| random_point(rng, [1.0]))), 0.0),
    };
    let shape = shape.unwrap().moved(&at);
    if rng.below(4) == 0 { shape.widened(0.1).unwrap() } else { shape }
}

pub(crate) fn half_space(rng: &mut Rng) -> Shape {
    Shape::half_space(random_point(rng, [1.0, 100.0]), rng.range(-2.0, 2.0)).unwrap()
}

pub(crate) fn set<N: simdop::node::Dop>(shapes: &[Shape]) -> Bvh<N, Shapes> {
    let set = ShapeSet::new(shapes).unwrap();
    Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap()
}

pub(crate) fn mesh<N: simdop::node::Dop>(data: &MeshData, is_solid: bool) -> Bvh<N> {
    let builder = if is_solid { Builder::new().solid() } else { Builder::new() };
    builder.build_as(&Mesh { vertices: &data.vertices, triangles: &data.triangles }).unwrap()
}

/// All pairs of primitives that meet, or come within a margin, by brute force.
fn pairs<A, B>(a: &[A], b: &[B], meet: impl Fn(&A, &B) -> bool) -> Vec<[u32; 2]> {
    let mut found = Vec::new();
    for (i, p) in a.iter().enumerate() {
        for (j, q) in b.iter().enumerate() {
            if meet(p, q) {
                found.push([i as u32, j as u32]);
            }
        }
    }
    found
}

fn triangle(corners: [[f64; 3]; 3]) -> Shape {
    Shape::new(Core::Triangle(corners), 0.0).unwrap()
}

fn ball(sphere: &Sphere) -> Shape {
    Shape::new(Core::Point(sphere.centre), sphere.radius).unwrap()
}

/// Two trees at a pose: all pairs, near pairs and the distance are those of brute force, on every instruction set.
fn trees_equal_brute_force<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
    a: (&Bvh<N, P>, &[Shape]),
    b: (&Bvh<N, Q>, &[Shape]),
    pose: &Pose,
    margin: f64,
) -> usize {
    // Primitives without a table of points are moved as shapes.
    let moved: Vec<Shape> = a.1.iter().map(|shape| shape.moved(pose)).collect();
    let expected = pairs(&moved, b.1, meets);
    let near = pairs(&moved, b.1, |p, q| is_within(p, q, margin));
    let mut stats: Option<QueryStats> = None;
    for isa in Isa::available() {
        let query = Query::new(isa);
        let mut found = Vec::new();
        let (_, work) = query.for_each_pair(a.0, b.0, pose, |pair| {
            found.push([pair.a, pair.b]);
            ControlFlow::Continue(())
        });
        found.sort_unstable();
        assert_eq!(found, expected, "{isa:?}");
        assert_eq!(*stats.get_or_insert(work), work, "{isa:?}");
        assert_eq!(query.collide(a.0, b.0, pose).is_free(), expected.is_empty(), "{isa:?}");
        assert_eq!(query.within(a.0, b.0, pose, margin).unwrap().is_free(), near.is_empty(), "{isa:?}");
        let distance = query.distance(a.0, b.0, pose, 1e-6).unwrap();
        let least = |bound: fn(&simdop::primitive::Separation) -> f64| {
            let each =
                moved.iter().flat_map(|p| b.1.iter().map(move |q| separation(p, q, f64::INFINITY, 1e-6)));
            each.flatten().map(|s| bound(&s)).fold(f64::INFINITY, f64::min)
        };
        assert!(distance.lower <= least(|s| s.upper), "{isa:?}: {distance:?}");
        assert!(distance.upper >= least(|s| s.lower), "{isa:?}: {distance:?}");
        assert!(distance.upper <= distance.lower * (1.0 + 1e-5) + 1e-12, "{isa:?}: {distance:?}");
        assert_eq!(distance.upper == 0.0, !expected.is_empty(), "{isa:?}: {distance:?}");
    }
    expected.len()
}

fn compounds<N: Lanes>(seed: u64, rounds: usize) {
    let mut rng = Rng::new(seed);
    let (mut hits, mut frees) = (0, 0);
    for round in 0..rounds {
        let shapes: Vec<Shape> = (0..[1, 3, 40][round % 3]).map(|_| shape(&mut rng)).collect();
        let others: Vec<Shape> = (0..[20, 2][round % 2]).map(|_| shape(&mut rng)).collect();
        let (tree, other) = (set::<N>(&shapes), set::<N>(&others));
        tree.view().verify().unwrap();
        assert_eq!(Bvh::<N, Shapes>::from_bytes(tree.as_bytes()).unwrap().as_bytes(), tree.as_bytes());
        let data = soup(&mut rng, 30, 0.7);
        let (soup, triangles) =
            (mesh::<N>(&data, false), data.corners().into_iter().map(triangle).collect::<Vec<_>>());
        let spheres: Vec<Sphere> = (0..30)
            .map(|_| Sphere { centre: random_point(&mut rng, [2.0]), radius: *rng.pick(&[0.0, 0.01, 0.3]) })
            .collect();
        let balls: Vec<Shape> = spheres.iter().map(ball).collect();
        let packing: Bvh<N, Spheres> = Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        for _ in 0..4 {
            let away = *rng.pick(&[0.5, 3.0, 6.0]);
            let at = pose(&rotation(&mut rng), random_point(&mut rng, [away]));
            let margin = *rng.pick(&[1e-9, 0.05, 1.0]);
            for count in [
                trees_equal_brute_force((&tree, &shapes), (&other, &others), &at, margin),
                trees_equal_brute_force((&tree, &shapes), (&soup, &triangles), &at, margin),
                trees_equal_brute_force((&soup, &triangles), (&tree, &shapes), &at, margin),
                trees_equal_brute_force((&tree, &shapes), (&packing, &balls), &at, margin),
                trees_equal_brute_force((&packing, &balls), (&tree, &shapes), &at, margin),
            ] {
                if count > 0 {
                    hits += 1;
                } else {
                    frees += 1;
                }
            }
        }
    }
    assert!(hits > rounds && frees > rounds, "{hits} hits, {frees} free");
}

#[test]
fn compounds_equal_brute_force_16() {
    compounds::<Node16<18>>(1, 20);
}

// Takes a minute to compile.
#[cfg(simdop_all_nodes)]
#[test]
fn compounds_equal_brute_force_4() {
    compounds::<Node4<14>>(2, 10);
}

/// One shape against a tree: verdict, margin and distance are those of brute force.
fn lone_equals_brute_force<N: Lanes, Q: Primitive>(
    tree: &Bvh<N, Q>,
    of: &[Shape],
    rng: &mut Rng,
) -> [usize; 2]
where
    Shapes: PrimitivePair<Q>,
{
    let mut counts = [0; 2];
    for _ in 0..40 {
        let lone = if rng.below(5) == 0 { half_space(rng) } else { shape(rng) };
        // Sometimes so large or so far that it is bounded along one axis.
        let away = *rng.pick(&[0.5, 2.0, 4.0, 1e5, 1e15]);
        let at = pose(&rotation(rng), random_point(rng, [away]));
        let moved = lone.moved(&at);
        let margin = *rng.pick(&[1e-9, 0.05, 1.0, 1e5]);
        let (hit, near) =
            (of.iter().any(|q| meets(&moved, q)), of.iter().any(|q| is_within(&moved, q, margin)));
        let separations: Vec<_> =
            of.iter().filter_map(|q| separation(&moved, q, f64::INFINITY, 1e-6)).collect();
        let lower = separations.iter().map(|s| s.lower).fold(f64::INFINITY, f64::min);
        let upper = separations.iter().map(|s| s.upper).fold(f64::INFINITY, f64::min);
        counts[usize::from(hit)] += 1;
        let mut stats: Option<QueryStats> = None;
        for isa in Isa::available() {
            let query = Query::new(isa);
            let answer = query.collide_shape(&lone, tree, &at);
            assert_eq!(answer.is_free(), !hit, "{isa:?} {lone:?}");
            assert_eq!(*stats.get_or_insert(answer.stats), answer.stats, "{isa:?}");
            let within = query.within_shape(&lone, tree, &at, margin).unwrap();
            assert_eq!(within.is_free(), !near, "{isa:?} {lone:?} {margin}");
            let distance = query.distance_shape(&lone, tree, &at, 1e-6, f64::INFINITY).unwrap();
            assert!(
                distance.lower <= upper && distance.upper >= lower,
                "{isa:?} {distance:?} {lower} {upper}"
            );
            assert_eq!(distance.upper == 0.0, hit, "{isa:?} {distance:?}");
            let cutoff = 0.5 * lower;
            let cut = query.distance_shape(&lone, tree, &at, 1e-6, cutoff).unwrap();
            if cutoff > 0.0 {
                assert!(cut.witness.is_none() && cut.lower >= cutoff, "{cut:?} {cutoff}");
            }
            let none = query.with_budget(0).collide_shape(&lone, tree, &at);
            assert!(!none.is_free() && none.hit().is_none());
        }
    }
    counts
}

#[test]
fn lone_shapes_equal_brute_force() {
    let mut rng = Rng::new(3);
    let mut counts = [0; 2];
    let mut add = |[free, hit]: [usize; 2]| {
        counts[0] += free;
        counts[1] += hit;
    };
    for _ in 0..6 {
        let shapes: Vec<Shape> = (0..50).map(|_| shape(&mut rng)).collect();
        add(lone_equals_brute_force(&set::<Node16<18>>(&shapes), &shapes, &mut rng));
        #[cfg(simdop_all_nodes)]
        add(lone_equals_brute_force(&set::<Node4<14>>(&shapes), &shapes, &mut rng));
        let data = soup(&mut rng, 200, 1.0);
        let triangles: Vec<Shape> = data.corners().into_iter().map(triangle).collect();
        add(lone_equals_brute_force(&mesh::<Node16<26>>(&data, false), &triangles, &mut rng));
        let spheres: Vec<Sphere> = (0..100)
            .map(|_| Sphere { centre: random_point(&mut rng, [2.0]), radius: *rng.pick(&[0.0, 0.01, 0.3]) })
            .collect();
        let balls: Vec<Shape> = spheres.iter().map(ball).collect();
        let packing: Bvh<Node16<18>, Spheres> = Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        add(lone_equals_brute_force(&packing, &balls, &mut rng));
    }
    assert!(counts.into_iter().all(|count| count > 100), "{counts:?}");
}

/// A shape inside a solid meets no triangle, and is a hit at distance 0; inside a surface it is free. A body of any
/// kind inside a shape is a hit.
#[test]
fn solids_hold_shapes_and_shapes_hold_solids() {
    let data = cuboid([-1.0; 3], [1.0; 3], false);
    let (solid, hollow) = (mesh::<Node16<18>>(&data, true), mesh::<Node16<18>>(&data, false));
    let ring = mesh::<Node16<18>>(&torus(40, 20), true);
    let small = [
        Shape::sphere(0.1).unwrap(),
        Shape::capsule(0.1, 0.3).unwrap(),
        Shape::cuboid([0.3; 3]).unwrap(),
        Shape::cylinder(0.1, 0.4).unwrap(),
        Shape::cone(0.1, 0.4).unwrap(),
    ];
    for isa in Isa::available() {
        let query = Query::new(isa);
        for lone in small {
            let at =
                Pose::from_rows([[1.0, 0.0, 0.0, 0.2], [0.0, 1.0, 0.0, 0.1], [0.0, 0.0, 1.0, 0.3]]).unwrap();
            assert!(query.collide_shape(&lone, &solid, &at).hit().is_some(), "{lone:?}");
            let distance = query.distance_shape(&lone, &solid, &at, 0.0, f64::INFINITY).unwrap();
            assert_eq!((distance.lower, distance.upper), (0.0, 0.0));
            assert!(query.collide_shape(&lone, &hollow, &at).is_free());
            let distance = query.distance_shape(&lone, &hollow, &at, 0.0, f64::INFINITY).unwrap();
            assert!(distance.lower > 0.1, "{distance:?}");
            // In the hole of the ring, and in trees.
            assert!(query.collide_shape(&lone, &ring, &Pose::IDENTITY).is_free());
            let compound = set::<Node16<18>>(&[lone]);
            assert!(query.collide(&compound, &solid, &at).hit().is_some());
            assert!(query.collide(&solid, &compound, &at).hit().is_some());
            assert!(query.collide(&compound, &hollow, &at).is_free());
        }
        for large in
            [Shape::sphere(2.0), Shape::cuboid([5.0; 3]), Shape::cylinder(2.0, 5.0)].map(Result::unwrap)
        {
            assert!(query.collide_shape(&large, &hollow, &Pose::IDENTITY).hit().is_some(), "{large:?}");
        }
    }
}

#[test]
fn an_empty_tree_is_free_of_every_shape() {
    let (empty, mut rng) = (set::<Node16<18>>(&[]), Rng::new(3));
    let shapes = [shape(&mut rng), half_space(&mut rng)];
    for (isa, shape) in Isa::available().flat_map(|isa| shapes.map(|shape| (isa, shape))) {
        let query = Query::new(isa);
        assert!(query.collide_shape(&shape, &empty, &Pose::IDENTITY).is_free());
        assert!(query.within_shape(&shape, &empty, &Pose::IDENTITY, 1e9).unwrap().is_free());
        let distance = query.distance_shape(&shape, &empty, &Pose::IDENTITY, 0.0, 5.0).unwrap();
        assert_eq!((distance.lower, distance.upper, distance.witness), (5.0, f64::INFINITY, None));
    }
}

#[test]
fn queries_of_two_shapes_are_those_of_the_pair() {
    let (mut rng, query, mut hits) = (Rng::new(4), Query::new(Isa::detect()), [0; 2]);
    for _ in 0..500 {
        let (a, b, margin) = (shape(&mut rng), shape(&mut rng), rng.range(0.0, 0.5));
        let at = pose(&rotation(&mut rng), random_point(&mut rng, [0.5, 2.0]));
        let moved = a.moved(&at);
        assert_eq!(query.collide_shapes(&a, &b, &at).is_free(), !meets(&moved, &b));
        let near = query.within_shapes(&a, &b, &at, margin).unwrap();
        assert_eq!(near.is_free(), !is_within(&moved, &b, margin));
        let distance = query.distance_shapes(&a, &b, &at, 1e-6, f64::INFINITY).unwrap();
        let found = separation(&moved, &b, f64::INFINITY, 1e-6).unwrap();
        assert_eq!((distance.lower, distance.upper), (found.lower, found.upper));
        let below = query.distance_shapes(&a, &b, &at, 1e-6, found.upper * 0.5).unwrap();
        assert_eq!(below.witness.is_none(), found.upper > 0.0, "{below:?}");
        hits[usize::from(near.is_free())] += 1;
    }
    assert!(hits.iter().all(|&count| count > 50), "{hits:?}");
    let (ball, at) = (Shape::sphere(1.0).unwrap(), Pose::IDENTITY);
    for wrong in [-1.0, f64::NAN] {
        assert!(query.within_shapes(&ball, &ball, &at, wrong).is_err());
        assert!(query.distance_shapes(&ball, &ball, &at, wrong, 1.0).is_err());
        assert!(query.distance_shapes(&ball, &ball, &at, 0.0, wrong).is_err());
    }
}

/// A shape that meets a cap but no triangle is partly inside the solid, wherever its centre is, and free of the
/// surface. Caps do not affect distances.
#[test]
fn shapes_meet_caps() {
    let mut data = cuboid([-1.0; 3], [1.0; 3], false);
    // Without the side at x = 1.
    data.triangles.truncate(10);
    let surface = mesh::<Node16<18>>(&data, false);
    let capped = Builder::new().solid_with_caps(3.0);
    let capped: Bvh<Node16<18>> =
        capped.build_as(&Mesh { vertices: &data.vertices, triangles: &data.triangles }).unwrap();
    for isa in Isa::available() {
        let query = Query::new(isa);
        let at = |x: f64| {
            Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap()
        };
        for lone in
            [Shape::sphere(0.125), Shape::cuboid([0.25; 3]), Shape::cylinder(0.125, 0.25)].map(Result::unwrap)
        {
            for (x, is_hit) in [(0.5, true), (1.0, true), (1.0625, true), (1.125, true), (1.1875, false)] {
                assert_eq!(query.collide_shape(&lone, &capped, &at(x)).is_free(), !is_hit, "{lone:?} {x}");
                assert!(query.collide_shape(&lone, &surface, &at(x)).is_free(), "{lone:?} {x}");
                let distance = |tree| query.distance_shape(&lone, tree, &at(x), 0.0, f64::INFINITY).unwrap();
                let (of_solid, of_surface) = (distance(&capped), distance(&surface));
                assert_eq!(of_solid.upper == 0.0, is_hit, "{lone:?} {x}: {of_solid:?}");
                assert!(of_surface.lower > 0.5, "{lone:?} {x}: {of_surface:?}");
                if !is_hit {
                    assert_eq!((of_solid.lower, of_solid.upper), (of_surface.lower, of_surface.upper));
                }
            }
        }
    }
}

#[test]
fn what_is_no_shape_is_refused() {
    let plane = Shape::half_space([0.0, 0.0, 1.0], 0.0).unwrap();
    assert_eq!(ShapeSet::new(&[plane]).err(), Some(ShapeError::Unbounded));
    for given in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200] {
        assert!(matches!(Shape::sphere(given), Err(ShapeError::Length { .. })), "{given}");
        assert!(matches!(Shape::cuboid([1.0, given, 1.0]), Err(ShapeError::Length { .. })));
        assert!(matches!(Shape::cylinder(1.0, given), Err(ShapeError::Length { .. })));
        assert!(matches!(Shape::cone(given, 1.0), Err(ShapeError::Length { .. })));
        assert!(matches!(Shape::capsule(given, 1.0), Err(ShapeError::Length { .. })));
    }
    assert_eq!(Shape::half_space([0.0; 3], 1.0).err(), Some(ShapeError::NoDirection));
    let skew = Core::Cuboid { centre: [0.0; 3], half: [[1.0, 0.0, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]] };
    assert!(matches!(Shape::new(skew, 0.0), Err(ShapeError::NotPerpendicular { .. })));
    // Numbers of a stored shape that are invalid for every kind.
    let tree = set::<Node16<18>>(&[Shape::cuboid([1.0, 2.0, 3.1]).unwrap(), Shape::cone(0.3, 1.1).unwrap()]);
    let bytes = tree.as_bytes();
    let header = tree.view().header();
    let mut refused = 0;
    for at in 128..bytes.len() {
        let mut damaged = bytes.to_vec();
        damaged[at] ^= 0x80;
        match Bvh::<Node16<18>, Shapes>::from_bytes(&damaged) {
            Err(FormatError::Vertex { .. }) => refused += 1,
            Err(_) => {}
            Ok(tree) => drop(tree.view().verify()),
        }
    }
    assert!(refused > 20, "{refused} of {header:?}");
}

/// Triangles are shapes, too: the same verdicts by both tests.
#[test]
fn triangles_as_shapes_equal_triangles() {
    let mut rng = Rng::new(9);
    let (a, b) = (soup(&mut rng, 100, 1.0), soup(&mut rng, 100, 1.0));
    let of = |data: &MeshData| data.corners().into_iter().map(triangle).collect::<Vec<_>>();
    let (mesh_a, mesh_b) = (mesh::<Node16<18>>(&a, false), mesh::<Node16<18>>(&b, false));
    let (set_a, set_b) = (set::<Node16<18>>(&of(&a)), set::<Node16<18>>(&of(&b)));
    let query = Query::new(Isa::detect());
    for _ in 0..50 {
        let at = pose(&rotation(&mut rng), random_point(&mut rng, [1.0, 3.0]));
        let all = |found: &mut Vec<_>, pair: simdop::query::Pair| {
            found.push((pair.a, pair.b));
            ControlFlow::Continue(())
        };
        let (mut triangles, mut shapes) = (Vec::new(), Vec::new());
        let _ = query.for_each_pair(&mesh_a, &mesh_b, &at, |pair| all(&mut triangles, pair));
        let _ = query.for_each_pair(&set_a, &set_b, &at, |pair| all(&mut shapes, pair));
        triangles.sort_unstable();
        shapes.sort_unstable();
        assert_eq!(triangles, shapes);
    }
    let _: fn(&Bvh<Node16<18>, Triangles>) = |_| ();
}
