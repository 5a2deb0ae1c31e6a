use super::super::search::bounds as general;
use super::super::search::tests::double::{self, Double, exact, length, minus};
use super::super::search::tests::samples::{Sampled, moved, scaled};
use super::super::search::tests::truth;
use super::bounds;
use crate::exact::power_of_two;
use crate::primitive::shape::place::InPlace;
use crate::primitive::shape::{Core, Shape};
use crate::range::Point;
use crate::rng::Rng;
use alloc::format;

/// Pairs of each two kinds; a tenth under emulators.
const PAIRS: usize = 500 / if cfg!(simdop_neon) { 10 } else { 1 };

/// The kinds of shapes (point, segment, triangle, cuboid, cylinder, cone) with a closed form.
const KINDS: [[usize; 2]; 9] = [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5], [1, 1], [1, 3], [3, 3]];

fn magnitude(shape: &Shape) -> f64 {
    let most = |p: &Point| p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let core = match shape.core() {
        Core::Point(p) => most(p),
        Core::Segment(ends) => most(&ends[0]).max(most(&ends[1])),
        Core::Triangle([p, q, r]) => most(p).max(most(q)).max(most(r)),
        Core::Cuboid { centre, half } => most(centre) + most(&half[0]) + most(&half[1]) + most(&half[2]),
        Core::Cylinder { centre: c, half_axis: h, radius } | Core::Cone { base: c, axis: h, radius } => {
            most(c) + most(h) + radius
        }
        _ => unreachable!(),
    };
    core + shape.radius()
}

/// The distance between two cores, of which one is a point if the other is round.
fn distance(a: &Core, b: &Core) -> Double {
    if let (Some(p), Some(q)) = (truth::polytope(a), truth::polytope(b)) {
        return truth::distance(&p, &q);
    }
    let ((Core::Point(p), round) | (round, Core::Point(p))) = (a, b) else { unreachable!() };
    length(&minus(&exact(p), &truth::nearest(round, &exact(p))))
}

/// Whether there is a closed form, and the vector from A's witness to B's if they are apart.
fn check(a: &Shape, b: &Shape, tolerance: f64) -> (bool, Option<Point>) {
    let Some(found) = bounds(a, InPlace, b, f64::INFINITY, tolerance) else {
        return (false, None);
    };
    let text = format!("{a:?}\n{b:?}\n{found:?}");
    let distance = distance(a.core(), b.core()) - Double::from(a.radius()) - Double::from(b.radius());
    let distance = if distance.0 > 0.0 { distance } else { double::ZERO };
    assert!(
        Double::from(found.lower) <= distance && distance <= Double::from(found.upper),
        "{distance:?} {text}"
    );
    let other = general(a, b, f64::INFINITY, tolerance);
    assert!(other.lower <= found.upper && found.lower <= other.upper, "{other:?} {text}");
    let size = magnitude(a).max(magnitude(b));
    let floor = power_of_two(-42) * size;
    let width = found.upper - found.lower;
    assert!(width <= 1.001 * tolerance * found.lower || width <= floor, "{text}");
    for (shape, p) in [(a, &found.a), (b, &found.b)] {
        let off = length(&minus(&exact(p), &truth::nearest(shape.core(), &exact(p)))).0 - shape.radius();
        assert!(off <= floor, "{off} {text}");
    }
    let apart = length(&minus(&exact(&found.a), &exact(&found.b))).0;
    let floor = if found.upper == 0.0 { power_of_two(-26) * size } else { floor };
    assert!((apart - found.upper).abs() <= floor, "{apart} {text}");
    let back = bounds(b, InPlace, a, f64::INFINITY, tolerance);
    assert!(
        back.is_none_or(|back| back.lower <= found.upper && found.lower <= back.upper),
        "{back:?} {text}"
    );
    let by = [0, 1, 2].map(|k| found.b[k] - found.a[k]);
    (true, (found.lower > 0.0).then_some(by))
}

#[test]
fn closed_forms_have_the_distances() {
    let mut random = Rng::new(1);
    for kinds in KINDS {
        let mut closed = 0;
        for i in 0..PAIRS {
            let [a, b] = random.pair(kinds);
            let (a, b) = if i % 2 == 0 { (a, b) } else { (b, a) };
            let tolerance = power_of_two([-4, -20, -40, -42][random.below(4) as usize]);
            let (is_closed, gap) = check(&a, &b, tolerance);
            closed += usize::from(is_closed);
            if let Some(gap) = gap {
                // They touch up to rounding, or nearly.
                let share = 1.0 + [0.0, 1e-15, 1e-12, -1e-15, -1e-9, 1e-6][random.below(6) as usize];
                check(&moved(&a, &gap.map(|x| share * x)), &b, tolerance);
            }
        }
        assert!(closed * 10 > PAIRS * 8, "{kinds:?} {closed}");
    }
}

#[test]
fn closed_forms_of_all_scales_hold() {
    let mut random = Rng::new(2);
    for kinds in KINDS {
        for _ in 0..PAIRS / 10 {
            let [a, b] = random.pair(kinds);
            for exponent in [-150, -90, 90, 140, 270] {
                let scale = power_of_two(exponent);
                let [p, q] = [&a, &b].map(|s| scaled(s, scale));
                let (Some(found), other) =
                    (bounds(&p, InPlace, &q, f64::INFINITY, 1e-6), general(&a, &b, 1e300, 1e-6))
                else {
                    continue;
                };
                let (lower, upper) = (found.lower / scale, found.upper / scale);
                assert!(
                    lower <= other.upper && other.lower <= upper,
                    "{exponent} {a:?}\n{b:?}\n{found:?} {other:?}"
                );
            }
        }
    }
}

#[test]
fn a_limit_ends_closed_forms() {
    let mut random = Rng::new(3);
    for kinds in KINDS {
        for _ in 0..PAIRS / 10 {
            let [a, b] = random.pair(kinds);
            let found = general(&a, &b, f64::INFINITY, 1e-9);
            for share in [0.0, 0.5, 0.999, 1.001, 2.0] {
                if let Some(limited) = bounds(&a, InPlace, &b, share * found.upper, 1e-9) {
                    assert!(limited.lower <= found.upper && found.lower <= limited.upper);
                }
            }
        }
    }
}
