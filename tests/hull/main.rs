//! Convex hulls of points against an oracle in integers, and queries of bodies that are hulls against shapes.

#[path = "../support/data.rs"]
mod data;
#[path = "../support/rng.rs"]
mod rng;

mod bodies;
mod oracle;
mod sets;

use data::suite_step;
use oracle::{check, exact, integers};
use rng::Rng;
use sets::{KINDS, random_set};
use simdop::construct::{BuildError, ConvexHull};
use simdop::range::{MAX_COORDINATE, MIN_COORDINATE};

type Point = [f64; 3];

fn shuffle(points: &mut [Point], rng: &mut Rng) {
    for last in (1..points.len()).rev() {
        points.swap(last, rng.below(last as u64 + 1) as usize);
    }
}

/// 10,000 small sets of all kinds: in space, in planes, on lines and at one place. The facets equal those found by a
/// search through all planes of three points, whatever the order and the duplicates of points.
#[test]
fn hulls_of_small_sets_are_those_of_integers() {
    let mut rng = Rng::new(1);
    let mut dimensions = [0; 4];
    for i in 0..10_000 / suite_step() as u32 {
        let mut points = random_set(i % KINDS, &mut rng);
        let hull = ConvexHull::of(&points).unwrap();
        dimensions[check(&exact(&points), &points, &hull)] += 1;
        for _ in 0..rng.below(4) {
            points.push(*rng.pick(&points));
        }
        shuffle(&mut points, &mut rng);
        assert_eq!(ConvexHull::of(&points), Ok(hull), "{points:?}");
    }
    assert!(dimensions.iter().all(|count| *count * suite_step() > 300), "{dimensions:?}");
}

/// Thousands of points: on a sphere, in a ball, on the sides of a cube, on a grid, on a double cone, and on spheres far
/// from each other.
#[test]
fn hulls_of_large_sets_are_those_of_integers() {
    let mut rng = Rng::new(2);
    let mut ball = |radius: f64, is_full: bool| loop {
        let p: Point = [(); 3].map(|()| rng.range(-1.0, 1.0));
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        if length < 1.0 && length > 0.1 {
            break p.map(|x| (radius * x / if is_full { 1.0 } else { length }).round());
        }
    };
    let sphere: Vec<Point> = (0..2000).map(|_| ball(1e6, false)).collect();
    let full: Vec<Point> = (0..20_000).map(|_| ball(1e6, true)).collect();
    let side =
        |i: usize| move |p: Point| [0, 1, 2].map(|k| if k == i % 3 { 30.0 * (i % 2) as f64 } else { p[k] });
    let cube: Vec<Point> = (0..6000).map(|i| side(i)(ball(14.0, true).map(|x| x + 15.0))).collect();
    let grid: Vec<Point> = (0..8000).map(|i| [i % 20, i / 20 % 20, i / 400].map(f64::from)).collect();
    let rim = (0..1500).map(|_| ball(1e6, false)).map(|[x, y, _]| {
        let length = x.hypot(y);
        [(1e6 * x / length).round(), (1e6 * y / length).round(), 0.0]
    });
    let cones: Vec<Point> = rim.chain([[0.0, 0.0, 5e5], [0.0, 0.0, -1.0]]).collect();
    let far: Vec<Point> =
        (0..2000).map(|i| ball(20.0, false).map(|x| x + if i % 2 == 0 { 1e6 } else { -1e6 })).collect();
    for (name, points, least) in [
        ("sphere", sphere, 1900),
        ("ball", full, 500),
        ("cube", cube, 100),
        ("grid", grid, 8),
        ("cones", cones, 1000),
        ("far", far, 100),
    ] {
        let hull = ConvexHull::of(&points).unwrap();
        assert_eq!(check(&integers(&points), &points, &hull), 3);
        let corners = hull.mesh.vertices.len();
        assert!(corners >= least && (name != "grid" || corners == 8), "{name}: {corners} corners");
    }
}

#[test]
fn scale_changes_nothing() {
    let mut rng = Rng::new(3);
    for i in 0..500 {
        // The first kinds have small integer coordinates.
        let points = random_set(i % 4, &mut rng);
        let hull = ConvexHull::of(&points).unwrap();
        for factor in [MIN_COORDINATE, MAX_COORDINATE / 1024.0] {
            let scaled =
                |points: &[Point]| -> Vec<Point> { points.iter().map(|p| p.map(|x| factor * x)).collect() };
            let other = ConvexHull::of(&scaled(&points)).unwrap();
            assert_eq!(other.mesh.triangles, hull.mesh.triangles);
            assert_eq!(other.mesh.vertices, scaled(&hull.mesh.vertices));
        }
    }
}

#[test]
fn points_out_of_range_are_named() {
    let mut points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * MAX_COORDINATE] {
        for axis in 0..3 {
            points[4] = [0.0; 3];
            points[4][axis] = wrong;
            assert_eq!(ConvexHull::of(&points), Err(BuildError::Vertex { index: 4 }));
        }
    }
    assert_eq!(ConvexHull::of(&[[0.5 * MIN_COORDINATE; 3]]), Err(BuildError::TooSmall));
    // A coordinate below the range counts as zero.
    points[4] = [0.5 * MIN_COORDINATE; 3];
    assert_eq!(ConvexHull::of(&points), ConvexHull::of(&points[..4]));
    let none = ConvexHull::of(&[]).unwrap();
    assert!(!none.is_solid && none.mesh.vertices.is_empty() && none.mesh.triangles.is_empty());
}
