//! Bodies that are hulls, against shapes.

use crate::Point;
use crate::rng::Rng;
use simdop::Builder;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::primitive::shape::{Core, is_within, meets, separation};
use simdop::query::Query;

/// A shape whose lengths are a few quarters, which often touches others of this kind.
fn shape(rng: &mut Rng) -> Shape {
    let mut length = || 0.25 * rng.int(1, 6) as f64;
    let (x, y, z) = (length(), length(), length());
    let shape = match rng.below(6) {
        0 => Shape::sphere(x),
        1 => Shape::capsule(x, y),
        2 => Shape::cuboid([x, y, z]),
        3 => Shape::cylinder(x, y),
        4 => Shape::cone(x, y),
        _ => Shape::new(Core::Triangle([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]), 0.0),
    };
    shape.unwrap()
}

fn pose(rng: &mut Rng) -> Pose {
    let turn =
        if rng.below(2) == 0 { [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] } else { rng.rotation() };
    let t = [(); 3].map(|()| 0.25 * rng.int(-7, 7) as f64);
    Pose::from_rows([0, 1, 2].map(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]])).unwrap()
}

/// The hull of a shape's corners has the shape's verdicts, by the exact tests of pairs of shapes.
fn hull_is_the_shape(points: &[Point], whole: &Shape, is_solid: bool, rng: &mut Rng) {
    let hull = Builder::new().build_convex_hull(points).unwrap();
    assert_eq!(hull.view().header().is_solid, u8::from(is_solid));
    let query = Query::new(Isa::detect());
    let mut counts = [0; 2];
    for _ in 0..3000 {
        let (shape, pose) = (shape(rng), pose(rng));
        let moved = shape.moved(&pose);
        let meets = meets(&moved, whole);
        assert_eq!(query.collide_shape(&shape, &hull, &pose).is_free(), !meets, "{moved:?}");
        let margin = 0.25 * rng.int(0, 2) as f64;
        // Exact for a sphere only; others may be within the rounding of the margin.
        if let Core::Point(_) = moved.core() {
            let near = query.within_shape(&shape, &hull, &pose, margin).unwrap();
            assert_eq!(near.is_free(), !is_within(&moved, whole, margin), "{moved:?} {margin}");
        }
        let found = query.distance_shape(&shape, &hull, &pose, 0.0, f64::INFINITY).unwrap();
        let truth = separation(&moved, whole, f64::INFINITY, 0.0).unwrap();
        assert!(found.lower <= truth.upper && truth.lower <= found.upper, "{moved:?} {found:?} {truth:?}");
        counts[usize::from(meets)] += 1;
    }
    assert!(counts[0] > 500 && counts[1] > 50, "{counts:?}");
}

#[test]
fn the_hull_of_a_cuboids_corners_is_the_cuboid() {
    let mut rng = Rng::new(11);
    let mut corners: Vec<Point> = (0..8)
        .map(|i| [0, 1, 2].map(|k| [1.0, 0.75, 0.5][k] * if i >> k & 1 == 0 { 1.0 } else { -1.0 }))
        .collect();
    // Points inside, in a face or in an edge change nothing.
    corners.extend([[0.0; 3], [1.0, 0.25, 0.0], [1.0, 0.75, 0.0]]);
    let cuboid = Shape::cuboid([2.0, 1.5, 1.0]).unwrap();
    hull_is_the_shape(&corners, &cuboid, true, &mut rng);
    let hull = Builder::new().build_convex_hull(&corners).unwrap();
    assert_eq!(hull.view().len(), 12);
    let speck = Shape::cuboid([0.125; 3]).unwrap();
    let query = Query::new(Isa::detect());
    assert!(query.collide_shape(&speck, &hull, &Pose::IDENTITY).hit().is_some(), "inside");
    let surface =
        Builder::new().build(&simdop::construct::ConvexHull::of(&corners).unwrap().mesh.as_mesh()).unwrap();
    assert!(query.collide_shape(&speck, &surface, &Pose::IDENTITY).is_free());
}

/// Hulls without an inside are triangles, segments or points.
#[test]
fn flat_hulls_are_surfaces() {
    let mut rng = Rng::new(12);
    let corners = [[1.0, 0.0, 0.5], [-0.5, 0.75, 0.25], [0.0, -1.0, -0.25]];
    let middle = [0, 1, 2].map(|k| 0.5 * (corners[0][k] + corners[1][k]));
    let triangle = Shape::new(Core::Triangle(corners), 0.0).unwrap();
    hull_is_the_shape(&[corners[2], middle, corners[0], corners[1]], &triangle, false, &mut rng);
    let segment = Shape::new(Core::Segment([corners[0], corners[1]]), 0.0).unwrap();
    hull_is_the_shape(&[corners[0], middle, corners[1], middle], &segment, false, &mut rng);
    let point = Shape::new(Core::Point(corners[2]), 0.0).unwrap();
    hull_is_the_shape(&[corners[2]; 2], &point, false, &mut rng);
    let none = Builder::new().solid().build_convex_hull(&[]).unwrap();
    assert!(Query::new(Isa::detect()).collide_shape(&triangle, &none, &Pose::IDENTITY).is_free());
}
