//! Hulls of points against polytopes with 100 bits, and against the shapes that they equal.

use super::super::search::tests::double::{self, Double, ZERO, exact};
use super::super::search::tests::samples::Sampled;
use super::super::search::tests::truth;
use crate::pose::Pose;
use crate::primitive::shape::{Convex, Core, Shape, SignedSeparation, signed_separation};
use crate::range::Point;
use crate::rng::Rng;
use crate::vector::{difference, dot, length};
use alloc::format;
use alloc::vec::Vec;

/// A tenth under emulators.
const PAIRS: usize = 400 / if cfg!(simdop_neon) { 10 } else { 1 };

fn corners(core: &Core) -> Vec<Point> {
    match core {
        Core::Point(p) => [*p].into(),
        Core::Segment(ends) => ends.to_vec(),
        Core::Triangle(corners) => corners.to_vec(),
        Core::Cuboid { centre, half } => (0..8)
            .map(|i| {
                (0..3).fold(*centre, |p, k| {
                    let sign = if i >> k & 1 == 1 { 1.0 } else { -1.0 };
                    [0, 1, 2].map(|x: usize| p[x] + sign * half[k][x])
                })
            })
            .collect(),
        _ => unreachable!("no polytope"),
    }
}

/// The distance between two polytopes, or minus their depth.
fn truth_of(a: &Core, b: &Core) -> Double {
    let [p, q] = [a, b].map(|core| truth::polytope(core).unwrap());
    let distance = truth::distance(&p, &q);
    if distance.0 > 0.0 {
        return distance;
    }
    let axes = truth::axes(&p, &q);
    let heights = axes.iter().flat_map(|n| [*n, n.map(|x| -x)]).map(|n| -truth::gap(&p, &q, &n));
    -heights.fold(Double::from(f64::INFINITY), Double::least)
}

fn size(shapes: [&Shape; 2]) -> f64 {
    shapes.iter().flat_map(|s| corners(s.core())).map(|p| length(&p)).fold(0.0, f64::max)
}

/// Checks that the bounds hold. Returns whether they are as tight as rounding allows for bodies other than needles:
/// the normals of a needle's faces are wrong by the rounding of a corner divided by its width.
fn check(found: &SignedSeparation, truth: Double, size: f64, text: &str) -> bool {
    // The corners of a cuboid were rounded when they became those of a hull.
    let slack = 1e-14 * size;
    assert!(Double::from(found.lower - slack) <= truth, "{truth:?} {text}");
    assert!(truth <= Double::from(found.upper + slack), "{truth:?} {text}");
    found.upper - found.lower <= 2e-9 * truth.0.abs() + 1e-12 * size
}

#[test]
fn hulls_of_polytopes_have_their_distances_and_depths() {
    let mut random = Rng::new(31);
    let (mut apart, mut meeting, mut tight, mut all) = (0, 0, 0, 0);
    for i in 0..4 {
        for j in i.max(2)..4 {
            for _ in 0..PAIRS {
                let [a, b] = random.pair([i, j]).map(|s| Shape::new(*s.core(), 0.0).unwrap());
                let truth = truth_of(a.core(), b.core());
                let [p, q] = [&a, &b].map(|s| corners(s.core()));
                let [hull_a, hull_b] = [&p, &q].map(|points| Convex::Hull { points, pose: Pose::IDENTITY });
                for (x, y) in [(hull_a, hull_b), (hull_a, Convex::Shape(b)), (Convex::Shape(a), hull_b)] {
                    let found = signed_separation(&x, &y, 1e-9);
                    let text = format!("{a:?}\n{b:?}\n{found:?}");
                    tight += usize::from(check(&found, truth, size([&a, &b]), &text));
                    all += 1;
                    let back = signed_separation(&y, &x, 1e-9);
                    assert!(back.lower <= found.upper && found.lower <= back.upper, "{back:?} {text}");
                    // The points are as far apart along the normal as the bodies.
                    let ahead = dot(&found.normal, &difference(&found.a, &found.b));
                    let near = if truth > ZERO { found.upper } else { found.lower };
                    assert!((ahead - near).abs() <= 1e-6 * size([&a, &b]), "{ahead} {text}");
                }
                apart += usize::from(truth > ZERO);
                meeting += usize::from(truth < ZERO);
            }
        }
    }
    assert!(apart > PAIRS / 2 && meeting > PAIRS / 2, "{apart} {meeting}");
    assert!(tight * 100 > 98 * all, "{tight} of {all}");
}

#[test]
fn hulls_beside_round_shapes_are_the_cuboids_that_they_equal() {
    let mut random = Rng::new(32);
    let (mut loose, mut all) = (0, 0);
    for j in 4..6 {
        for _ in 0..PAIRS {
            let [a, b] = random.pair([3, j]);
            let a = Shape::new(*a.core(), 0.0).unwrap();
            let points = corners(a.core());
            let hull = Convex::Hull { points: &points, pose: Pose::IDENTITY };
            let found = signed_separation(&hull, &Convex::Shape(b), 1e-6);
            let shape = signed_separation(&Convex::Shape(a), &Convex::Shape(b), 1e-6);
            let text = format!("{a:?}\n{b:?}\n{found:?}\n{shape:?}");
            let slack = 1e-12 * (size([&a, &a]) + found.upper.abs());
            assert!(found.lower <= shape.upper + slack && shape.lower <= found.upper + slack, "{text}");
            loose += usize::from(found.upper - found.lower > 1e-3 * found.lower.abs() + slack);
            all += 1;
        }
    }
    assert!(loose * 10 < all, "{loose} of {all}");
}

#[test]
fn points_beside_a_half_space_are_as_high_as_the_lowest() {
    let mut random = Rng::new(33);
    for _ in 0..PAIRS {
        let points: Vec<Point> = (0..9).map(|_| random.vector(1.0)).collect();
        let space = Shape::half_space(random.vector(1.0), random.range(-2.0, 2.0)).unwrap();
        let Core::HalfSpace { normal, offset } = *space.core() else { unreachable!() };
        let n = exact(&normal);
        let heights = points.iter().map(|p| {
            let p = exact(p);
            ((p[0] * n[0] + p[1] * n[1]) + p[2] * n[2] - Double::from(offset)) / double::length(&n)
        });
        let truth = heights.fold(Double::from(f64::INFINITY), Double::least);
        let hull = Convex::Hull { points: &points, pose: Pose::IDENTITY };
        let (found, back) = (
            signed_separation(&hull, &Convex::Shape(space), 0.0),
            signed_separation(&Convex::Shape(space), &hull, 0.0),
        );
        assert!(Double::from(found.lower) <= truth && truth <= Double::from(found.upper), "{found:?}");
        assert!(found.upper - found.lower < 1e-12, "{found:?}");
        assert_eq!((found.lower, found.upper), (back.lower, back.upper));
        assert_eq!((found.normal, found.a), (back.normal.map(|x| -x), back.b));
    }
}

#[test]
fn poses_scales_and_empty_hulls() {
    let cube: Vec<Point> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    let turned =
        Pose::from_rows([[0.0, -1.0, 0.0, 1.75], [1.0, 0.0, 0.0, 0.25], [0.0, 0.0, 1.0, 0.125]]).unwrap();
    let still = Convex::Hull { points: &cube, pose: Pose::IDENTITY };
    let found = signed_separation(&Convex::Hull { points: &cube, pose: turned }, &still, 0.0);
    assert!((found.lower + 0.25).abs() < 1e-13 && (found.upper + 0.25).abs() < 1e-13, "{found:?}");
    assert_eq!(found.normal, [1.0, 0.0, 0.0]);
    assert!((found.a[0] - 0.75).abs() < 1e-12 && (found.b[0] - 1.0).abs() < 1e-12, "{found:?}");
    for scale in [1e-60, 1e60] {
        let points: Vec<Point> = cube.iter().map(|p| p.map(|x| x * scale)).collect();
        let t = turned.translation().map(|x| x * scale);
        let r = turned.rows();
        let row = |i: usize| [r[i][0], r[i][1], r[i][2], t[i]];
        let pose = Pose::from_rows([row(0), row(1), row(2)]).unwrap();
        let hull = |pose| Convex::Hull { points: &points, pose };
        let found = signed_separation(&hull(pose), &hull(Pose::IDENTITY), 0.0);
        assert!((found.lower / scale + 0.25).abs() < 1e-13, "{found:?}");
    }
    let empty = Convex::Hull { points: &[], pose: Pose::IDENTITY };
    let found = signed_separation(&empty, &still, 0.0);
    assert!(found.lower == f64::INFINITY && found.a[0].is_nan());
    // Flat hulls that cross: a square in another's plane, and two that touch in a corner.
    let square: Vec<Point> = cube.iter().filter(|p| p[2] == 0.0).copied().collect();
    let flat = |x: f64| Convex::Hull { points: &square, pose: Pose::IDENTITY.shifted(&[x, 0.5 * x, 0.0]) };
    let found = signed_separation(&flat(0.25), &flat(0.0), 0.0);
    assert!(found.lower > -1e-12 && found.upper < 1e-12, "{found:?}");
    let found = signed_separation(&flat(2.0), &flat(0.0), 0.0);
    assert!((found.lower - 1.0).abs() < 1e-12 && (found.upper - 1.0).abs() < 1e-12, "{found:?}");
}
