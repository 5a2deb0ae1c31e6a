use super::super::search::tests::double::{Double, Vector, ZERO, exact, length};
use super::super::search::tests::samples::{Sampled, scaled};
use super::super::search::tests::truth::{self, gap_of_shapes};
use super::{Depth, depth};
use crate::exact::power_of_two;
use crate::primitive::shape::{Core, Shape};
use crate::range::Point;
use crate::rng::Rng;
use alloc::format;

/// A tenth under emulators.
const PAIRS: usize = 500 / if cfg!(simdop_neon) { 10 } else { 1 };

const FLOOR: f64 = power_of_two(-42);

fn magnitude(shape: &Shape) -> f64 {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let most = axes
        .iter()
        .flat_map(|d| [*d, d.map(|x| -x)])
        .map(|d| truth::support(shape.core(), &exact(&d)).0.abs());
    most.fold(0.0, f64::max) + shape.radius()
}

fn unit(v: &Vector) -> Vector {
    let length = length(v);
    v.map(|x| x / length)
}

/// Checks all bounds: a translation along the direction separates, and none shorter than the lower bound does.
fn check(a: &Shape, b: &Shape, tolerance: f64, random: &mut Rng) -> (Depth, f64) {
    let found = depth(a, b, tolerance);
    let text = format!("{a:?}\n{b:?}\n{found:?}");
    let size = magnitude(a).max(magnitude(b));
    assert!(found.lower >= 0.0 && found.lower <= found.upper && found.upper.is_finite(), "{text}");
    let direction = exact(&found.direction);
    assert!((length(&direction) - Double::from(1.0)).0.abs() < 1e-15, "{text}");
    let gap = gap_of_shapes(a, b, &unit(&direction)).0;
    assert!(gap + found.upper >= -1e-15 * size, "{gap} {text}");
    for i in 0..40 {
        let v = if i < 30 {
            random.vector(1.0)
        } else {
            let v = random.vector(1e-3);
            [0, 1, 2].map(|k| found.direction[k] + v[k])
        };
        let gap = gap_of_shapes(a, b, &unit(&exact(&v)));
        assert!(
            Double::from(found.lower) + gap <= ZERO || gap.0 > 0.0 && found.lower == 0.0,
            "{gap:?} {text}"
        );
    }
    (found, (found.upper - found.lower) / size)
}

#[test]
fn polytopes_have_their_depths() {
    let mut random = Rng::new(11);
    for i in 0..4 {
        for j in i.max(2)..4 {
            for _ in 0..PAIRS {
                let [a, b] = random.pair([i, j]);
                let (found, width) = check(&a, &b, 1e-9, &mut random);
                let text = format!("{a:?}\n{b:?}\n{found:?}");
                assert!(width <= FLOOR || found.upper - found.lower <= 2e-9 * found.upper, "{width} {text}");
                let [p, q] = [a, b].map(|s| truth::polytope(s.core()).unwrap());
                let core = truth::distance(&p, &q);
                let radii = Double::from(a.radius()) + Double::from(b.radius());
                let truth = if core.0 > 0.0 {
                    radii - core
                } else {
                    let axes = truth::axes(&p, &q);
                    let heights =
                        axes.iter().flat_map(|n| [*n, n.map(|x| -x)]).map(|n| -truth::gap(&p, &q, &n));
                    heights.fold(Double::from(f64::INFINITY), Double::least) + radii
                };
                let truth = if truth.0 > 0.0 { truth } else { ZERO };
                let is_inside = Double::from(found.lower) <= truth && truth <= Double::from(found.upper);
                assert!(is_inside, "{truth:?} {text}");
            }
        }
    }
}

#[test]
fn round_shapes_have_their_depths() {
    let mut random = Rng::new(12);
    let (mut loose, mut poor, mut all) = (0, 0, 0);
    for i in 0..6 {
        for j in 4..6 {
            for _ in 0..PAIRS {
                let [a, b] = random.pair([i, j]);
                let (found, width) = check(&a, &b, 1e-6, &mut random);
                let back = depth(&b, &a, 1e-6);
                assert!(back.lower <= found.upper && found.lower <= back.upper);
                all += 1;
                let off = if width > FLOOR { (found.upper - found.lower) / found.upper } else { 0.0 };
                // Coaxial shapes have a circle of faces to refine.
                loose += usize::from(off > 1e-3);
                poor += usize::from(off > 0.05);
            }
        }
    }
    assert!(loose * 10 < all && poor * 100 < all, "{loose} {poor} of {all}");
}

#[test]
fn spheres_and_segments_have_closed_forms() {
    let sphere = |p: Point, r| Shape::new(Core::Point(p), r).unwrap();
    let found = depth(&sphere([0.0; 3], 1.0), &sphere([1.5, 0.0, 0.0], 2.0), 1e-9);
    assert!(found.lower <= 1.5 && found.upper >= 1.5 && found.upper - found.lower < 1e-13);
    assert_eq!(found.direction, [-1.0, 0.0, 0.0]);
    let found = depth(&sphere([2.0; 3], 1.0), &sphere([2.0; 3], 2.0), 1e-9);
    assert!(found.lower <= 3.0 && found.upper >= 3.0 && found.upper - found.lower < 1e-13, "{found:?}");
    // Crossing segments, parallel ones on one line, and one through a point.
    let capsule = |p: Point, q: Point| Shape::new(Core::Segment([p, q]), 0.5).unwrap();
    let x = capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let others = [
        capsule([0.0, -1.0, 0.0], [0.5, 1.0, 0.0]),
        capsule([0.5, 0.0, 0.0], [3.0, 0.0, 0.0]),
        sphere([0.25, 0.0, 0.0], 0.5),
        x,
    ];
    for b in others {
        let found = depth(&x, &b, 1e-9);
        assert!(
            found.lower <= 1.0 && found.upper >= 1.0 && found.upper - found.lower < 1e-13,
            "{b:?} {found:?}"
        );
        let gap = gap_of_shapes(&x, &b, &exact(&found.direction)).0;
        assert!(gap >= -found.upper - 1e-15);
    }
}

#[test]
fn half_spaces_are_left_along_their_normal() {
    let mut random = Rng::new(13);
    for _ in 0..PAIRS {
        let kind = random.below(6) as usize;
        let [a, _] = random.pair([kind, 0]);
        let space = Shape::half_space(random.vector(1.0), random.range(-2.0, 2.0)).unwrap();
        let Core::HalfSpace { normal, offset } = *space.core() else { unreachable!() };
        let n = exact(&normal);
        let low = -truth::support(a.core(), &n.map(|x| -x));
        let truth = (Double::from(offset) - low) / length(&n) + Double::from(a.radius());
        let truth = if truth.0 > 0.0 { truth } else { ZERO };
        let (found, back) = (depth(&a, &space, 0.0), depth(&space, &a, 0.0));
        assert!(Double::from(found.lower) <= truth && truth <= Double::from(found.upper));
        assert!(found.upper - found.lower <= FLOOR * magnitude(&a).max(offset.abs() / length(&n).0));
        assert_eq!(
            (found.lower, found.upper, found.direction),
            (back.lower, back.upper, back.direction.map(|x| -x))
        );
    }
    let space = |normal: Point, offset| Shape::half_space(normal, offset).unwrap();
    assert_eq!(depth(&space([0.0, 0.0, 1.0], 0.0), &space([0.0, 0.1, -1.0], 0.0), 0.0).lower, f64::INFINITY);
    let found = depth(&space([0.0, 0.0, 1.0], 1.0), &space([0.0, 0.0, -1.0], 1.0), 0.0);
    assert!(found.lower <= 2.0 && 2.0 <= found.upper && found.upper < 2.0 + 1e-13);
}

#[test]
fn all_scales_give_the_same_depths() {
    let mut random = Rng::new(14);
    for _ in 0..PAIRS {
        let kinds = [random.below(6) as usize, random.below(6) as usize];
        let [a, b] = random.pair(kinds);
        let found = depth(&a, &b, 1e-6);
        for exponent in [-150, -110, 140, 270] {
            let scale = power_of_two(exponent);
            let other = depth(&scaled(&a, scale), &scaled(&b, scale), 1e-6);
            let (lower, upper) = (other.lower / scale, other.upper / scale);
            assert!(
                lower <= found.upper && found.lower <= upper,
                "{exponent} {a:?} {b:?} {found:?} {other:?}"
            );
        }
    }
}

#[test]
fn edges_of_one_direction_are_parallel() {
    // The cross products of edges that are parallel up to rounding have arbitrary directions.
    let mut random = Rng::new(15);
    for _ in 0..PAIRS {
        let frame = random.frame();
        let mut cuboid = |at: Point| {
            let half = frame.map(|v| {
                let by = random.range(0.2, 1.0);
                v.map(|x| x * by)
            });
            Shape::new(Core::Cuboid { centre: at, half }, 0.0).unwrap()
        };
        let (a, b) = (cuboid([0.0; 3]), cuboid([0.3, 0.2, 0.1]));
        let found = depth(&a, &b, 1e-9);
        assert!(found.upper - found.lower <= 1e-12, "{a:?} {b:?} {found:?}");
    }
}
