//! Signed clearances of scenes, and of bodies of different kinds, against closed forms and sampled translations.

use crate::heap::without_heap;
use crate::support::data::{MeshData, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::cuboid;
use crate::support::turns::pose;
use crate::{grid_box, solid};
use simdop::cloud::PointCloud;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::{Shape, Sphere};
use simdop::query::Query;
use simdop::scene::{Body, BodyTree, Scene, SceneSignedDistance};
use std::ops::ControlFlow;

type Tree<'t> = BodyTree<'t, Node16<18>>;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]).unwrap()
}

fn query() -> Query {
    Query::new(Isa::detect())
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Two cubes of side 2 as every kind of body, 0.5 deep along x.
#[test]
fn every_kind_has_the_depth_of_the_cube_that_it_is() {
    let mesh = solid(&grid_box([-1.0; 3], [1.0; 3], 3));
    let cube = Shape::cuboid([2.0; 3]).unwrap();
    let kinds = [Tree::from(mesh.view()), Tree::from(cube)];
    for (i, a) in kinds.iter().enumerate() {
        for b in &kinds {
            let placed = at(1.5, 0.25, -0.125);
            let found = a.signed_distance(&query(), b, &placed, 0.0).unwrap();
            assert!((found.lower + 0.5).abs() < 1e-9, "{i} {found:?}");
            assert!(found.upper >= found.lower && found.upper < -0.48, "{i} {found:?}");
            assert!(found.normal[0] > 1.0 - 1e-9 && (found.gradient[0] - 1.0).abs() < 1e-9, "{i} {found:?}");
            assert!((found.a[0] - 0.5).abs() < 1e-6 && (found.b[0] - 1.0).abs() < 1e-6, "{i} {found:?}");
            let depth = a.depth(&query(), b, &placed).unwrap();
            assert!((depth.upper - 0.5).abs() < 1e-9 && depth.lower > 0.48, "{i} {depth:?}");
            for (direction, far) in
                [([3.0, 0.0, 0.0], 0.5), ([0.0, 1.0, 0.0], 1.75), ([0.0, 0.0, 2.0], 2.125)]
            {
                let along = a.depth_along(&query(), b, &placed, direction).unwrap();
                assert!((along - far).abs() < 1e-7, "{i} {along} {far}");
            }
            let free = a.signed_distance(&query(), b, &at(0.0, 0.0, 3.0), 0.0).unwrap();
            assert!((free.lower - 1.0).abs() < 1e-12 && free.normal[2] > 1.0 - 1e-12, "{free:?}");
            assert_eq!(a.depth(&query(), b, &at(0.0, 0.0, 3.0)).unwrap().upper, 0.0);
            // Also if the direction leads through the other body.
            for direction in [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]] {
                assert_eq!(a.depth_along(&query(), b, &at(0.0, 0.0, 3.0), direction).unwrap(), 0.0);
            }
        }
    }
    // A cloud has an upper bound, but no known inside; a body of spheres has both.
    let spheres = [Sphere { centre: [0.0; 3], radius: 1.0 }];
    let ball =
        Builder::new().build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()));
    let (ball, cloud) = (ball.unwrap(), PointCloud::new(&[[0.0, 0.0, 0.0], [-0.5, 0.0, 0.0]]).unwrap());
    for other in [Tree::from(ball.view()), Tree::PointCloud(cloud.view())] {
        let reach = if matches!(other, Tree::PointCloud(_)) { 0.0 } else { 1.0 };
        for a in &kinds {
            let found = a.signed_distance(&query(), &other, &at(0.75, 0.0, 0.0), 0.0).unwrap();
            let deep = 0.25 + reach;
            assert!((found.lower + deep).abs() < 1e-8 && found.upper <= 0.0, "{found:?} {deep}");
            assert!(found.normal[0] > 1.0 - 1e-6, "{found:?}");
            let back = other.signed_distance(&query(), a, &at(-0.75, 0.0, 0.0), 0.0).unwrap();
            assert!((back.lower + deep).abs() < 1e-8 && back.normal[0] < -1.0 + 1e-6, "{back:?}");
        }
    }
}

/// A body of any kind below the ground leaves it along the normal.
#[test]
fn half_spaces_are_left_along_their_normal() {
    let mesh = solid(&grid_box([-1.0, -1.0, -0.5], [1.0, 1.0, 1.0], 2));
    let cloud = PointCloud::new(&[[0.0, 0.0, -0.5], [0.25, 0.0, 3.0]]).unwrap();
    let ground = Tree::from(Shape::half_space([0.0, 0.0, 2.0], 0.5).unwrap());
    let cuboid = Tree::from(Shape::cuboid([1.0; 3]).unwrap());
    for (body, lowest) in
        [(Tree::from(mesh.view()), -0.5), (Tree::PointCloud(cloud.view()), -0.5), (cuboid, -0.5)]
    {
        for z in [0.0, -3.0, 0.5, 2.0] {
            // The ground is at z = 0.25.
            let height = lowest + z - 0.25;
            let found = body.signed_distance(&query(), &ground, &at(0.1, 0.2, z), 0.0).unwrap();
            assert!(
                (found.lower - height).abs() < 1e-11 && (found.upper - height).abs() < 1e-11,
                "{found:?}"
            );
            assert!(found.normal[2] > 1.0 - 1e-9 || height.abs() < 1e-12, "{found:?}");
            let back = ground.signed_distance(&query(), &body, &at(-0.1, -0.2, -z), 0.0).unwrap();
            assert!((back.lower - height).abs() < 1e-11 && (back.upper - height).abs() < 1e-11, "{back:?}");
            let deep = if height < 0.0 { -height } else { 0.0 };
            let up = body.depth_along(&query(), &ground, &at(0.1, 0.2, z), [0.0, 0.0, 1.0]).unwrap();
            let aslant = body.depth_along(&query(), &ground, &at(0.1, 0.2, z), [0.0, 1.0, 1.0]).unwrap();
            assert!(
                (up - deep).abs() < 1e-11 && (aslant - deep * 2.0_f64.sqrt()).abs() < 1e-11,
                "{up} {aslant}"
            );
        }
    }
}

/// No translation shorter than the lower bound is free, and the one found is, also with a radius around the bodies.
#[test]
fn bounds_hold_for_sampled_translations() {
    let mesh = solid(&grid_box([-1.0, -0.75, -0.5], [1.0, 0.75, 0.5], 2));
    let mut rng = Rng::new(41);
    let shapes = [
        Shape::capsule(0.3, 1.0).unwrap(),
        Shape::cylinder(0.5, 0.8).unwrap(),
        Shape::cone(0.5, 1.0).unwrap(),
        Shape::sphere(0.6).unwrap(),
    ];
    let (mut tight, mut all) = (0, 0);
    for _ in 0..60 / suite_step() {
        for shape in shapes {
            let placed = pose(&rng.rotation(), [0.9, 0.7, 0.5].map(|far| rng.range(-far, far)));
            let radius = if rng.below(2) == 0 { 0.0 } else { 0.125 };
            let scene_at = |by: [f64; 3]| {
                let mut scene: Scene<'_, Node16<18>> = Scene::new();
                let t = placed.translation();
                let r = placed.rows();
                let row = |i: usize| [r[i][0], r[i][1], r[i][2], t[i] + by[i]];
                let moved = Pose::from_rows([row(0), row(1), row(2)]).unwrap();
                let _ = scene.insert(Body::new(shape).with_radius(radius), &moved).unwrap();
                let _ = scene.insert(Body::new(mesh.view()).with_radius(radius), &Pose::IDENTITY).unwrap();
                scene
            };
            let found = scene_at([0.0; 3]).signed_clearance(&query(), 0.0, f64::INFINITY).unwrap();
            if found.upper > 0.0 {
                continue;
            }
            let witness = found.witness.unwrap();
            let sign = if (witness.hit.a.to_bits() as u32) == 0 { 1.0 } else { -1.0 };
            let out = witness.normal.map(|x| -sign * found.lower * x * (1.0 + 1e-9));
            assert!(scene_at(out).collide(&query()).unwrap().is_free(), "{found:?}");
            for _ in 0..60 {
                let along = rng.rotation()[0].map(|x| x * -found.upper * (1.0 - 1e-9) * rng.range(0.5, 1.0));
                assert!(!scene_at(along).collide(&query()).unwrap().is_free(), "{found:?} {along:?}");
            }
            all += 1;
            tight += usize::from(found.upper < 0.7 * found.lower);
        }
    }
    assert!(all > 100 / suite_step() && 4 * tight > 3 * all, "{tight} of {all}");
}

/// The signed clearance is the least over all pairs, and the witness belongs to the deepest.
#[test]
fn scenes_have_the_least_of_their_pairs() {
    let mut rng = Rng::new(42);
    let mut meeting = 0;
    for _ in 0..200 / suite_step() {
        let spheres: Vec<([f64; 3], f64)> =
            (0..6).map(|_| ([(); 3].map(|()| rng.range(-1.5, 1.5)), rng.range(0.2, 0.6))).collect();
        let mut scene: Scene<'_, Node16<18>> = Scene::new();
        for (centre, radius) in &spheres {
            let _ = scene
                .insert(Body::new(Shape::sphere(*radius).unwrap()), &at(centre[0], centre[1], centre[2]));
        }
        let mut least = (f64::INFINITY, 0, 0);
        for (i, (p, r)) in spheres.iter().enumerate() {
            for (j, (q, s)) in spheres.iter().enumerate().take(i) {
                let d = [0, 1, 2].map(|k| p[k] - q[k]);
                let gap = dot(d, d).sqrt() - r - s;
                if gap < least.0 {
                    least = (gap, i, j);
                }
            }
        }
        let found: SceneSignedDistance = scene.signed_clearance(&query(), 0.0, f64::INFINITY).unwrap();
        assert!((found.lower - least.0).abs() < 1e-12 && (found.upper - least.0).abs() < 1e-12, "{found:?}");
        let witness = found.witness.unwrap();
        let mut pair = [witness.hit.a, witness.hit.b].map(|id| id.to_bits() as usize);
        pair.sort_unstable();
        assert_eq!(pair, [least.2, least.1]);
        meeting += usize::from(least.0 < 0.0);
        let near = scene.signed_clearance(&query(), 0.0, 0.0).unwrap();
        assert!(if least.0 < 0.0 { near.lower < 0.0 } else { near.witness.is_none() && near.lower == 0.0 });
        let none = scene.signed_clearance(&query().with_budget(0), 0.0, 1.0).unwrap();
        assert!(none.lower <= found.lower && none.upper >= found.lower);
        for bad in [(-1.0, 1.0), (f64::NAN, 1.0), (0.0, -1.0), (0.0, f64::NAN)] {
            assert!(scene.signed_clearance(&query(), bad.0, bad.1).is_err());
        }
    }
    assert!(meeting > 50 / suite_step() && meeting < 200 / suite_step());
}

#[test]
fn a_signed_clearance_never_allocates() {
    let mesh = solid(&grid_box([-1.0; 3], [1.0; 3], 2));
    let mut scene: Scene<'_, Node16<18>> = Scene::new();
    for (i, x) in [0.0, 1.5].into_iter().enumerate() {
        let _ = scene.insert(Body::new(mesh.view()), &at(x, 0.0, 0.0)).unwrap();
        let _ = scene.insert(Body::new(Shape::sphere(0.5).unwrap()), &at(x, 1.0, i as f64)).unwrap();
    }
    let query = query();
    let found = without_heap("a signed clearance", || scene.signed_clearance(&query, 0.0, 1.0).unwrap());
    assert!(found.lower < 0.0);
}

/// Bounds of the depth and of the signed distance, and its derivative, as bits: those that Python has
/// (`python/tests/test_depth.py`).
const FIGURES: [[u64; 10]; 3] = [
    [
        0x3fdffffffffff00e,
        0x3fe0000000007f75,
        0xbfe0000000007f75,
        0xbfdffffffffff00e,
        0x3ff0000000000000,
        0x0000000000000000,
        0x0000000000000000,
        0x8000000000000000,
        0x3fd8000000000000,
        0x3fd0000000000000,
    ],
    [
        0x3fe3fffffffff7d2,
        0x3fe4000000009f5e,
        0xbfe4000000009f5e,
        0xbfe3fffffffff7d2,
        0x0000000000000000,
        0x0000000000000000,
        0x3ff0000000000000,
        0xbfd4cccccccccccc,
        0xbfe7333333333334,
        0x0000000000000000,
    ],
    [
        0x0000000000000000,
        0x0000000000000000,
        0x3feb211b1c70c9aa,
        0x3feb211b1c70d072,
        0x3fec4f1128cec2ed,
        0x3fdc4f1128cec2ed,
        0xbfc2df60c5df2c9e,
        0x3fb2df60c5df2c9e,
        0xbfcc4f1128cec2ed,
        0xbfcc4f1128cec2ec,
    ],
];

#[test]
fn figures_are_those_of_python() {
    let half = |half: [f64; 3]| {
        let MeshData { vertices, triangles } = cuboid(half.map(|x| -x), half, false);
        Builder::best().solid().build(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap()
    };
    let (a, b) = (half([0.5; 3]), half([0.75, 0.625, 0.375]));
    let turned =
        Pose::from_rows([[0.6, -0.8, 0.0, 0.625], [0.8, 0.6, 0.0, 0.375], [0.0, 0.0, 1.0, 0.25]]).unwrap();
    let found = [at(0.75, 0.25, 0.125), turned, at(2.0, 1.5, -1.0)].map(|placed| {
        let depth = query().depth(&a, &b, &placed, None);
        let signed = query().signed_distance(&a, &b, &placed, 0.0, None).unwrap();
        let [p, q, r, s, t, u] = signed.gradient;
        [depth.lower, depth.upper, signed.lower, signed.upper, p, q, r, s, t, u].map(f64::to_bits)
    });
    assert_eq!(found, FIGURES, "{found:#018x?}");
}
