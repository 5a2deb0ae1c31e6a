//! Bodies near the points of a cloud, against all pairs of a primitive and a point.

use crate::data::by_suite;
use crate::scenes::{self, Random};
use core::ops::ControlFlow;
use simdop::cloud::{Contact, PointCloud, RangeSearch, SearchError};
use simdop::construct::{Builder, Mesh, OwnedMesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres, Triangles};
use simdop::query::{Lanes, PrimitivePair};

/// A rotation about an oblique axis, by a matrix whose entries are off by up to `skew`.
fn pose(random: &mut Random, reach: f64, skew: f64) -> Pose {
    let number = |random: &mut Random| f64::from(random.next()) - 0.5;
    let (a, b, c) = (6.0 * number(random), 6.0 * number(random), 6.0 * number(random));
    let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
    let rows = [
        [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
        [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
        [-sb, cb * sc, cb * cc],
    ];
    let row = |i: usize, random: &mut Random| {
        let [x, y, z] = rows[i].map(|x| x * (1.0 + skew * number(random)));
        [x, y, z, 2.0 * reach * number(random)]
    };
    Pose::from_rows([row(0, random), row(1, random), row(2, random)]).unwrap()
}

fn pairs_within<N: Lanes, P: PrimitivePair<Spheres>>(
    body: &Bvh<N, P>,
    points: &[[f32; 3]],
    pose: &Pose,
    margin: f64,
) -> Vec<Contact> {
    let (view, mut found) = (body.view(), Vec::new());
    for i in 0..view.len() as u32 {
        let moved = P::moved(&view.primitive(i), pose);
        for (point, p) in points.iter().enumerate() {
            let at = Sphere { centre: p.map(f64::from), radius: 0.0 };
            let is_near = if margin > 0.0 {
                P::within(&moved, &at, margin, &mut 0)
            } else {
                P::meets(&P::probe(&moved, 0.0), &at, &mut 0)
            };
            if is_near {
                found.push(Contact { primitive: view.source(i), point: point as u32 });
            }
        }
    }
    found
}

fn check<N: Lanes, P: PrimitivePair<Spheres>>(
    body: &Bvh<N, P>,
    points: &[[f32; 3]],
    margins: &[f64],
    reach: f64,
    what: &str,
) {
    let (cloud, random) = (PointCloud::new(points).unwrap(), &mut Random(31));
    let (mut hits, mut free) = (0, 0);
    for step in 0..by_suite(60, 8) {
        let pose = pose(random, reach, if step % 3 == 0 { 1e-9 } else { 0.0 });
        for &margin in margins {
            let want = pairs_within(body, points, &pose, margin);
            let mut first = None;
            for isa in Isa::available() {
                let got = RangeSearch::new(isa).body_within(&cloud.view(), body, &pose, margin).unwrap();
                match got {
                    Some(contact) => {
                        assert!(want.contains(&contact), "{what}, {isa}, pose {step}: {contact:?}");
                    }
                    None => assert!(want.is_empty(), "{what}, {isa}, pose {step}: misses {:?}", want[0]),
                }
                assert_eq!(*first.get_or_insert(got), got, "{what}, {isa}");
            }
            (hits, free) = if want.is_empty() { (hits, free + 1) } else { (hits + 1, free) };
        }
    }
    // A small suite need not have both.
    let few = by_suite(60, 8) < 60;
    assert!(few || hits > 0 && free > 0, "{what}: {hits} hits, {free} free");
}

/// Triangles around the origin, and spheres that overlap like those of a robot.
fn mesh() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let random = &mut Random(37);
    let vertices = (0..60).map(|_| random.point().map(|x| f64::from(x) - 0.5)).collect();
    let corner = |random: &mut Random| ((random.next() * 60.0) as u32).min(59);
    let triangles = (0..by_suite(80, 20)).map(|_| [(); 3].map(|()| corner(random))).collect();
    (vertices, triangles)
}

fn spheres() -> Vec<Sphere> {
    let random = &mut Random(41);
    let sphere = |i: usize| Sphere {
        centre: random.point().map(|x| f64::from(x) - 0.5),
        radius: if i.is_multiple_of(9) { 0.0 } else { 0.05 },
    };
    (0..by_suite(70, 20)).map(sphere).collect()
}

#[test]
fn a_mesh_has_points_within_its_margin_where_a_loop_finds_them() {
    let (vertices, triangles) = mesh();
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    let random = &mut Random(43);
    let points: Vec<_> = (0..by_suite(400, 80)).map(|_| random.point().map(|x| 3.0 * (x - 0.5))).collect();
    let margins = [0.0, 1e-6, 0.01, 0.1];
    check::<_, Triangles>(&Builder::new().build(&mesh).unwrap(), &points, &margins, 1.5, "k = 18");
    check::<_, Triangles>(
        &Builder::balanced().build_as::<Node16<6>>(&mesh).unwrap(),
        &points,
        &margins,
        1.5,
        "k = 6",
    );
    check::<_, Triangles>(
        &Builder::new().build_as::<Node4<32>>(&mesh).unwrap(),
        &points,
        &margins,
        1.5,
        "arity 4",
    );
}

#[test]
fn spheres_have_points_within_their_margin_where_a_loop_finds_them() {
    let spheres = spheres();
    let build = |spheres: &[Sphere]| -> Bvh<Node16<18>, Spheres> {
        Builder::new().build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    for (name, points, _) in scenes::all(by_suite(300, 60)) {
        let widest = points.iter().flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
        if !(1e-3..1e7).contains(&widest) {
            continue;
        }
        // Spheres as large as the scene, near its middle and far from it.
        let (low, high) = (0..3).fold(([0.0; 3], 0.0_f64), |(mut low, high), i| {
            let least = points.iter().map(|p| p[i]).fold(f32::INFINITY, f32::min);
            let most = points.iter().map(|p| p[i]).fold(f32::NEG_INFINITY, f32::max);
            low[i] = f64::from(least);
            (low, high.max(f64::from(most) - f64::from(least)))
        });
        let size = if high > 0.0 { high } else { 1.0 };
        let moved: Vec<_> =
            points.iter().map(|p| [0, 1, 2].map(|i| (f64::from(p[i]) - low[i]) as f32)).collect();
        let scaled: Vec<_> = spheres
            .iter()
            .map(|s| Sphere { centre: s.centre.map(|x| x * size), radius: s.radius * size })
            .collect();
        check::<_, Spheres>(&build(&scaled), &moved, &[0.0, 0.01 * size, 0.3 * size], 2.0 * size, name);
    }
}

/// A point that touches a face, an edge, a corner or a sphere is near. The next number beyond is not.
#[test]
fn what_touches_is_near() {
    let triangle = Mesh { vertices: &[[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], triangles: &[[0, 1, 2]] };
    let triangle: Bvh<Node16<18>> = Builder::new().build_as(&triangle).unwrap();
    let ball = SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 0.75 }] };
    let ball: Bvh<Node16<18>, Spheres> =
        Builder::new().build_geometry(&ball, &mut |_| ControlFlow::Continue(())).unwrap();
    let beyond = 0.25_f32.next_up();
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        let near = |point: [f32; 3]| {
            let cloud = PointCloud::new(&[point]).unwrap();
            let mesh = search.body_within(&cloud.view(), &triangle, &Pose::IDENTITY, 0.25).unwrap();
            mesh.is_some()
        };
        assert!(near([1.0, 1.0, 0.25]) && !near([1.0, 1.0, beyond]), "{isa}: a face");
        assert!(near([1.0, -0.25, 0.0]) && !near([1.0, -beyond, 0.0]), "{isa}: an edge");
        assert!(near([4.25, 0.0, 0.0]) && !near([4.25_f32.next_up(), 0.0, 0.0]), "{isa}: a corner");
        let near = |point: [f32; 3], margin: f64| {
            let cloud = PointCloud::new(&[point]).unwrap();
            search.body_within(&cloud.view(), &ball, &Pose::IDENTITY, margin).unwrap().is_some()
        };
        assert!(
            near([0.0, -0.75, 0.0], 0.0) && !near([0.0, -0.75_f32.next_up(), 0.0], 0.0),
            "{isa}: a sphere"
        );
        assert!(near([1.0, 0.0, 0.0], 0.25) && !near([1.0_f32.next_up(), 0.0, 0.0], 0.25), "{isa}: a margin");
    }
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let cloud = PointCloud::new(&[[0.0; 3]]).unwrap();
    let empty: Bvh<Node16<18>> = Builder::new().build_as(&Mesh { vertices: &[], triangles: &[] }).unwrap();
    let search = RangeSearch::new(Isa::SCALAR);
    for margin in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = search.body_within(&cloud.view(), &empty, &Pose::IDENTITY, margin);
        assert_eq!(refused, Err(SearchError::Radius { query: 0 }));
    }
    assert_eq!(search.body_within(&cloud.view(), &empty, &Pose::IDENTITY, 1e300), Ok(None));
    let nothing = PointCloud::new(&[]).unwrap();
    let ball = SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 1.0 }] };
    let ball: Bvh<Node16<18>, Spheres> =
        Builder::new().build_geometry(&ball, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(search.body_within(&nothing.view(), &ball, &Pose::IDENTITY, 1e30), Ok(None));
    assert!(search.body_within(&cloud.view(), &ball, &Pose::IDENTITY, 1e300).unwrap().is_some());
    for (tolerance, cutoff) in
        [(-1.0, 1.0), (f64::INFINITY, 1.0), (f64::NAN, 1.0), (0.0, -1.0), (0.0, f64::NAN)]
    {
        let refused = search.body_distance(&cloud.view(), &ball, &Pose::IDENTITY, tolerance, cutoff);
        assert_eq!(refused, Err(SearchError::Radius { query: 0 }), "{tolerance} {cutoff}");
    }
    for (body, cloud) in [
        (&ball, &nothing),
        (
            &Builder::new()
                .build_geometry(&SphereSet { spheres: &[] }, &mut |_| ControlFlow::Continue(()))
                .unwrap(),
            &cloud,
        ),
    ] {
        let far = search.body_distance(&cloud.view(), body, &Pose::IDENTITY, 0.0, 1.0).unwrap();
        assert!(far.lower == f64::INFINITY && far.witness.is_none());
    }
}

/// The least distance over all pairs of a primitive and a point.
fn least_distance<N: Lanes, P: PrimitivePair<Spheres>>(
    body: &Bvh<N, P>,
    points: &[[f32; 3]],
    pose: &Pose,
) -> f64 {
    let view = body.view();
    let mut least = f64::INFINITY;
    for i in 0..view.len() as u32 {
        let moved = P::moved(&view.primitive(i), pose);
        for p in points {
            let at = Sphere { centre: p.map(f64::from), radius: 0.0 };
            let between = P::nearer(&moved, &at, f64::INFINITY, 0.0_f64.max(1e-12), &mut 0).unwrap();
            least = least.min(between.upper);
        }
    }
    least
}

fn check_distances<N: Lanes, P: PrimitivePair<Spheres>>(body: &Bvh<N, P>, points: &[[f32; 3]], what: &str) {
    let (cloud, random) = (PointCloud::new(points).unwrap(), &mut Random(47));
    for step in 0..by_suite(40, 6) {
        let pose = pose(random, if step % 4 == 0 { 40.0 } else { 2.0 }, 0.0);
        let want = least_distance(body, points, &pose);
        for (tolerance, cutoff) in [(0.0, f64::INFINITY), (0.1, f64::INFINITY), (0.0, 0.2), (0.5, 0.0)] {
            let mut first = None;
            for isa in Isa::available() {
                let search = RangeSearch::new(isa);
                let got = search.body_distance(&cloud.view(), body, &pose, tolerance, cutoff).unwrap();
                let slack = 1e-9 * (1.0 + want);
                assert!(got.lower <= want + slack, "{what}, {isa}, {step}: {want} {got:?}");
                match got.witness {
                    None => {
                        assert!(want >= cutoff - slack && got.lower == cutoff && got.upper == f64::INFINITY);
                    }
                    Some(witness) => {
                        assert!(
                            want <= got.upper + slack && got.upper <= cutoff + slack,
                            "{what}: {want} {got:?}"
                        );
                        assert!(got.upper <= got.lower * (1.0 + tolerance) + slack, "{what}: {got:?}");
                        let between: f64 = (0..3).map(|i| (witness.a[i] - witness.b[i]).powi(2)).sum();
                        assert!(got.upper == 0.0 || (between.sqrt() - got.upper).abs() < slack);
                    }
                }
                assert_eq!(*first.get_or_insert(got), got, "{what}, {isa}");
            }
        }
    }
}

#[test]
fn distances_are_those_of_a_loop() {
    let (vertices, triangles) = mesh();
    let mesh: Bvh<Node16<18>> =
        Builder::new().build_as(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap();
    let balls: Bvh<Node4<18>, Spheres> = Builder::new()
        .build_geometry(&SphereSet { spheres: &spheres() }, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let random = &mut Random(53);
    for count in [1, 17, by_suite(300, 60)] {
        let points: Vec<_> = (0..count).map(|_| random.point().map(|x| 3.0 * (x - 0.5))).collect();
        check_distances(&mesh, &points, "triangles");
        check_distances(&balls, &points, "spheres");
    }
}

/// A rotated cube of side 2 with a cavity of side 1. In the cube's frame, the points between the two surfaces
/// are inside.
#[test]
fn points_inside_of_a_solid_are_near() {
    let [outer, cavity] = [2.0, 1.0].map(|side| OwnedMesh::cuboid([side; 3]).unwrap());
    let vertices = [outer.vertices, cavity.vertices].concat();
    let triangles: Vec<[u32; 3]> = outer
        .triangles
        .into_iter()
        .chain(cavity.triangles.iter().map(|[a, b, c]| [a + 8, c + 8, b + 8]))
        .collect();
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    let solid: Bvh<Node16<18>> = Builder::new().solid().build_as(&mesh).unwrap();
    let surface: Bvh<Node16<18>> = Builder::new().build_as(&mesh).unwrap();
    let random = &mut Random(59);
    let mut met = [0; 2];
    for step in 0..by_suite(400, 60) {
        let points: Vec<[f32; 3]> =
            (0..1 + step % 20).map(|_| random.point().map(|x| 8.0 * (x - 0.5))).collect();
        let pose = pose(random, 2.0, 0.0);
        let (m, t) = (pose.rows(), pose.translation());
        let depth = |p: &[f32; 3]| {
            let seen = |axis: usize| (0..3).map(|i| m[i][axis] * (f64::from(p[i]) - t[i])).sum::<f64>().abs();
            let most = seen(0).max(seen(1)).max(seen(2));
            (1.0 - most).min(most - 0.5)
        };
        let is_inside = points.iter().any(|p| depth(p) > 0.0);
        met[usize::from(is_inside)] += 1;
        let cloud = PointCloud::new(&points).unwrap();
        for isa in Isa::available() {
            let search = RangeSearch::new(isa);
            let near = search.body_within(&cloud.view(), &solid, &pose, 0.0).unwrap();
            assert_eq!(near.is_some(), is_inside, "{isa}, {step}");
            assert!(near.is_none_or(|near| depth(&points[near.point as usize]) > 0.0 && near.primitive < 24));
            assert_eq!(search.body_within(&cloud.view(), &surface, &pose, 0.0), Ok(None), "{isa}, {step}");
            let distance = search.body_distance(&cloud.view(), &solid, &pose, 0.0, f64::INFINITY).unwrap();
            assert_eq!(distance.upper == 0.0, is_inside, "{isa}, {step}: {distance:?}");
        }
    }
    assert!(met.iter().all(|count| *count > by_suite(10, 1)), "{met:?}");
}
