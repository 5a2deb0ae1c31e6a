//! The oracle against closed forms in small integers, and against itself: order, permutations of the axes, scale, and
//! its two methods.

use crate::shape_cases::{hard_margin, hard_pair, hard_pairs, kind_pairs, permuted, scaled};
use crate::shape_oracle::Judgement::{self, Apart, Meets, TooCloseToCall};
use crate::shape_oracle::{distance_interval, estimate, is_rational, meets, meets_finely};
use crate::support::data::suite_step;
use crate::support::rng::Rng;
use dashu_int::IBig;
use simdop::primitive::shape::{Core, Shape};

fn cases() -> u32 {
    4000 / suite_step() as u32
}

fn shape(core: Core, radius: f64) -> Shape {
    Shape::new(core, radius).unwrap()
}

fn point(rng: &mut Rng, most: i64) -> [i64; 3] {
    core::array::from_fn(|_| rng.int(-most, most))
}

fn float(p: [i64; 3]) -> [f64; 3] {
    p.map(|x| x as f64)
}

fn cuboid(centre: [i64; 3], half: [i64; 3], radius: i64) -> Shape {
    let [x, y, z] = float(half);
    let half = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
    shape(Core::Cuboid { centre: float(centre), half }, radius as f64)
}

fn cylinder(centre: [i64; 3], half: i64, radius: i64) -> Shape {
    let half_axis = [0.0, 0.0, half as f64];
    shape(Core::Cylinder { centre: float(centre), half_axis, radius: radius as f64 }, 0.0)
}

/// Checks that the distance is at most `margin` if and only if `is_within`, in both orders and for all permutations of
/// the axes.
#[track_caller]
fn check(a: &Shape, b: &Shape, margin: i64, is_within: bool) {
    let want = if is_within { Meets } else { Apart };
    let margin = margin as f64;
    for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
        let (a, b) = (permuted(a, order), permuted(b, order));
        assert_eq!(meets(&a, &b, margin), want, "{a:?} {b:?} {margin}");
        assert_eq!(meets(&b, &a, margin), want, "{b:?} {a:?} {margin}");
    }
}

/// Checks that the square root of `square`, less `less`, is in the interval, which is narrow.
#[track_caller]
fn check_distance(a: &Shape, b: &Shape, square: i64, less: i64) {
    let found = distance_interval(a, b);
    assert!(found.is_narrow(), "{a:?} {b:?} {found:?}");
    // In units of 2^exponent, below 1.
    let unit = usize::try_from(-found.exponent).unwrap();
    let (square, less) = (IBig::from(square) << (2 * unit), IBig::from(less) << unit);
    let is_upper = |x: &IBig| {
        let sum = x + &less;
        &sum * &sum >= square
    };
    let is_lower = |x: &IBig| {
        let sum = x + &less;
        *x == IBig::ZERO || &sum * &sum <= square
    };
    assert!(is_lower(&found.lower) && is_upper(&found.upper), "{a:?} {b:?} {found:?} {square}");
}

fn gap(a: (i64, i64), b: (i64, i64)) -> i64 {
    ((a.0 - b.0).abs() - a.1 - b.1).max(0)
}

#[test]
fn boxes_and_balls() {
    let mut rng = Rng::new(1);
    let mut touching = 0;
    for _ in 0..cases() {
        let (c, d) = (point(&mut rng, 9), point(&mut rng, 9));
        let (mut h, mut k) = ([(); 3].map(|()| rng.int(1, 4)), [(); 3].map(|()| rng.int(1, 4)));
        let (r, s, margin) = (rng.int(0, 3), rng.int(0, 3), rng.int(0, 3) * rng.int(0, 1));
        let mut make = |centre, half: &mut [i64; 3], radius| {
            if rng.below(3) == 0 {
                *half = [0; 3];
                shape(Core::Point(float(centre)), radius as f64)
            } else {
                cuboid(centre, *half, radius)
            }
        };
        let (a, b) = (make(c, &mut h, r), make(d, &mut k, s));
        let gaps: [i64; 3] = core::array::from_fn(|i| gap((c[i], h[i]), (d[i], k[i])));
        let square: i64 = gaps.iter().map(|x| x * x).sum();
        check(&a, &b, margin, square <= (r + s + margin).pow(2));
        check_distance(&a, &b, square, r + s);
        touching += u32::from(square == (r + s + margin).pow(2));
    }
    assert!(touching > cases() / 50, "{touching}");
}

/// A segment along an axis against a ball, and against another one along another axis.
#[test]
fn capsules() {
    let mut rng = Rng::new(2);
    let mut touching = 0;
    for _ in 0..cases() {
        let (p, q) = (point(&mut rng, 4), point(&mut rng, 4));
        let (r, s) = (rng.int(0, 3), rng.int(0, 3));
        let mut segment = |middle: [i64; 3], radius: i64| {
            let (axis, half) = (rng.below(3) as usize, rng.int(0, 4));
            let mut ends = [middle; 2];
            ends[0][axis] -= half;
            ends[1][axis] += half;
            let mut extent = [0; 3];
            extent[axis] = half;
            (shape(Core::Segment(ends.map(float)), radius as f64), extent)
        };
        // Segments along axes are boxes.
        let ((a, h), (b, k)) = (segment(p, r), segment(q, s));
        let gaps: [i64; 3] = core::array::from_fn(|i| gap((p[i], h[i]), (q[i], k[i])));
        let square: i64 = gaps.iter().map(|x| x * x).sum();
        check(&a, &b, 0, square <= (r + s).pow(2));
        check_distance(&a, &b, square, r + s);
        touching += u32::from(square == (r + s).pow(2));
    }
    assert!(touching > cases() / 50, "{touching}");
}

/// An upright cylinder or cone against boxes along the axes: the part of the box at the widest height is nearest to the
/// axis.
#[test]
fn cylinders_and_cones_against_boxes() {
    let mut rng = Rng::new(3);
    let mut touching = 0;
    for _ in 0..cases() {
        let (c, half) = (point(&mut rng, 9), [(); 3].map(|()| rng.int(1, 4)));
        let (r, h) = (rng.int(1, 6), rng.int(1, 6));
        let b = cuboid(c, half, 0);
        let square: i64 = (0..2).map(|i| gap((c[i], half[i]), (0, 0)).pow(2)).sum();
        let is_beside = gap((c[2], half[2]), (0, h)) == 0;
        check(&cylinder([0; 3], h, r), &b, 0, is_beside && square <= r * r);
        touching += u32::from(is_beside && square == r * r);
        // The cone's base is at height 0 and its tip at h.
        let cone = Core::Cone { base: [0.0; 3], axis: [0.0, 0.0, h as f64], radius: r as f64 };
        let (low, high) = ((c[2] - half[2]).max(0), c[2] + half[2]);
        let is_beside = high >= 0 && low <= h;
        check(&shape(cone, 0.0), &b, 0, is_beside && square * h * h <= r * r * (h - low).pow(2));
        touching += u32::from(is_beside && square * h * h == r * r * (h - low).pow(2));
    }
    assert!(touching > cases() / 50, "{touching}");
}

/// Balls around points on the axes' plane, where a cylinder is a rectangle and a cone a triangle.
#[test]
fn balls_against_cylinders_and_cones() {
    let mut rng = Rng::new(4);
    let mut touching = 0;
    for _ in 0..cases() {
        let (x, z, s) = (rng.int(0, 12), rng.int(-12, 12), rng.int(0, 6));
        let ball = shape(Core::Point(float([x, 0, z])), s as f64);
        let (r, h) = (rng.int(1, 6), rng.int(1, 6));
        let square = gap((x, 0), (0, r)).pow(2) + gap((z, 0), (0, h)).pow(2);
        check(&cylinder([0; 3], h, r), &ball, 0, square <= s * s);
        check_distance(&cylinder([0; 3], h, r), &ball, square, s);
        touching += u32::from(square == s * s);
        // A cone of slope 3 : 4, so that all distances are multiples of 1/5.
        let k = rng.int(1, 3);
        let (r, h) = (3 * k, 4 * k);
        let cone = Core::Cone { base: [0.0; 3], axis: [0.0, 0.0, h as f64], radius: r as f64 };
        let cone = shape(cone, 0.0);
        // Five times the height above the slant line, and the place along it from the rim.
        let (above, along) = (4 * (x - r) + 3 * z, -3 * (x - r) + 4 * z);
        let square = if z <= 0 && x <= r {
            25 * z * z
        } else if z >= 0 && above <= 0 {
            0
        } else if along <= 0 {
            25 * ((x - r).pow(2) + z * z)
        } else if along >= 25 * k {
            25 * (x * x + (z - h).pow(2))
        } else {
            above * above
        };
        check(&cone, &ball, 0, square <= 25 * s * s);
        check_distance(&scaled(&cone, 5.0).unwrap(), &scaled(&ball, 5.0).unwrap(), square, 5 * s);
        touching += u32::from(square == 25 * s * s);
    }
    assert!(touching > cases() / 50, "{touching}");
}

/// Upright cylinders side by side: certain bounds around the closed form.
#[test]
fn parallel_cylinders() {
    let mut rng = Rng::new(5);
    for _ in 0..cases() / 16 {
        let c = point(&mut rng, 9);
        let sizes = [(); 4].map(|()| rng.int(1, 4));
        let [h, r, k, s] = sizes;
        let up = gap((c[2], h), (0, k));
        // A Pythagorean offset across.
        let (x, y) = *rng.pick(&[(0, 0), (3, 4), (-4, 3), (6, 8), (5, 0), (0, -5), (5, 12)]);
        let across = (((x * x + y * y) as f64).sqrt() as i64 - r - s).max(0);
        let a = cylinder([x, y, c[2]], h, r);
        let b = cylinder([0; 3], k, s);
        check_distance(&a, &b, across * across + up * up, 0);
        let depth = gap((c[2], h - 1), (0, k)).max(x * x + y * y - (r + s - 1).max(0).pow(2));
        match meets(&a, &b, 0.0) {
            Apart => assert!(across + up > 0, "{a:?} {b:?}"),
            Meets => assert!(across + up == 0, "{a:?} {b:?}"),
            TooCloseToCall => assert!(across + up == 0 && depth > 0, "{a:?} {b:?}"),
        }
    }
}

#[test]
fn half_spaces() {
    let mut rng = Rng::new(6);
    let mut touching = 0;
    for _ in 0..cases() {
        // A normal of length 5 or 3, times a factor.
        let n = *rng.pick(&[[0, 3, 4], [3, -4, 0], [0, 0, -5], [1, 2, 2], [-2, 1, 2]]);
        let length = if n.iter().map(|x| x * x).sum::<i64>() == 25 { 5 } else { 3 };
        let (offset, margin) = (rng.int(-20, 20), rng.int(0, 2));
        let plane = Shape::half_space(float(n), offset as f64).unwrap();
        let (c, half, r) = (point(&mut rng, 9), [(); 3].map(|()| rng.int(1, 4)), rng.int(0, 4));
        let height = |p: [i64; 3]| (0..3).map(|i| n[i] * p[i]).sum::<i64>() - offset;
        let lowest = height(c) - (0..3).map(|i| n[i].abs() * half[i]).sum::<i64>();
        check(&plane, &cuboid(c, half, r), margin, lowest <= (r + margin) * length);
        touching += u32::from(lowest == (r + margin) * length);
        // Against an upright cylinder: its disc is lower by r times the length of (n_x, n_y).
        if n[2] % 4 == 0 || n[2] % 5 == 0 {
            let across = ((length * length - n[2] * n[2]) as f64).sqrt() as i64;
            let lowest = height(c) - half[2] * n[2].abs() - half[0] * across;
            check(&plane, &cylinder(c, half[2], half[0]), margin, lowest <= margin * length);
            touching += u32::from(lowest == margin * length);
        }
        // Against a cone along z, either way up: its tip or its disc is lower.
        if n[2] % 4 == 0 || n[2] % 5 == 0 {
            let across = ((length * length - n[2] * n[2]) as f64).sqrt() as i64;
            let rise = half[1] * (1 - 2 * rng.int(0, 1));
            let axis = float([0, 0, rise]);
            let cone = shape(Core::Cone { base: float(c), axis, radius: half[0] as f64 }, r as f64);
            let lowest = height(c) + (n[2] * rise).min(-half[0] * across);
            check(&plane, &cone, margin, lowest <= (r + margin) * length);
            touching += u32::from(lowest == (r + margin) * length);
        }
        // Opposite half-spaces, with normals of different lengths.
        let k = rng.int(1, 3);
        let below = rng.int(-20, 20);
        let other = Shape::half_space(float(n.map(|x| -k * x)), (k * below) as f64).unwrap();
        check(&plane, &other, margin, -below - offset <= margin * length);
        touching += u32::from(-below - offset == margin * length);
    }
    assert!(touching > cases() / 50, "{touching}");
}

/// The first bounds, in `f64`, do not undercut the distance, also where a direction is parallel to an oblique axis.
#[test]
fn estimates_are_upper_bounds() {
    let check = |a: &Shape, b: &Shape| {
        let found = distance_interval(a, b);
        let (estimate, (lower, _)) = (estimate(a, b), found.to_f64());
        assert!(estimate >= lower - 1e-10 * found.size(), "{estimate:e} {lower:e} {a:?} {b:?}");
    };
    let half_axis = [4.0, 0.0, -4.0];
    let oblique = shape(Core::Cylinder { centre: [-6.0, 0.0, 6.0], half_axis, radius: 1.0 }, 1.0);
    check(&oblique, &Shape::default());
    for (a, b) in hard_pairs(&mut Rng::new(8)).take(cases() as usize) {
        check(&a, &b);
    }
}

/// A widened cylinder and a segment above its rim: their distance exceeds the radius by 2^-103, or not at all. The
/// segment is a point, which the oracle decides exactly, or parallel to the axis.
#[test]
fn apart_by_less_than_the_first_bounds_resolve() {
    let cylinder =
        shape(Core::Cylinder { centre: [-1.0, 2.0, 0.0], half_axis: [0.0, -1.0, 0.0], radius: 5.0 }, 5.0);
    let segment = |z: f64, top: f64| shape(Core::Segment([[-1.0, 8.0, z], [-1.0, top, z]]), 0.0);
    let beyond = -5.0 - 4.0 * f64::EPSILON;
    for (z, top, judgements) in [
        (-5.0, 8.0, [Meets, Meets]),
        (beyond, 8.0, [Apart, Apart]),
        (-5.0, 9.0, [TooCloseToCall, TooCloseToCall]),
        (beyond, 9.0, [TooCloseToCall, Apart]),
    ] {
        let other = segment(z, top);
        assert_eq!([meets, meets_finely].map(|meets| meets(&cylinder, &other, 0.0)), judgements, "{z} {top}");
    }
}

/// Whether two judgements agree, if each is certain.
fn agree(x: Judgement, y: Judgement) -> bool {
    x == y || x == TooCloseToCall || y == TooCloseToCall
}

/// For hard pairs, the judgement and the bounds agree, exact pairs are decided, and order, permutation of the axes and
/// scale change nothing.
#[test]
fn consistent_on_hard_pairs() {
    for kinds in kind_pairs() {
        let mut rng = Rng::new(7);
        let mut count = [0; 3];
        for _ in 0..cases() / 10 {
            let (a, b) = hard_pair(kinds, &mut rng);
            let margin = hard_margin(&a, &b, &mut rng);
            let what = || format!("{a:?} {b:?} {margin:e}");
            let judged = meets(&a, &b, margin);
            count[judged as usize] += 1;
            assert!(judged != TooCloseToCall || !is_rational(&a, &b, margin), "{}", what());
            let bounds = distance_interval(&a, &b);
            assert!(bounds.is_narrow(), "{}", what());
            assert!(agree(judged, bounds.judge(margin)), "{judged:?} {bounds:?} {}", what());
            let other = [meets(&b, &a, margin), {
                let order = *rng.pick(&[[1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1]]);
                meets(&permuted(&a, order), &permuted(&b, order), margin)
            }];
            assert!(other.iter().all(|other| agree(judged, *other)), "{judged:?} {other:?} {}", what());
            if let (Some(a), Some(b)) = (scaled(&a, 0.125), scaled(&b, 0.125)) {
                // Only if nothing was flushed to zero.
                if bounds.size() > 1e-30 && margin == 0.0 {
                    assert!(agree(judged, meets(&a, &b, 0.0)), "{}", what());
                }
            }
        }
        println!("{kinds:?}: apart, meets, too close to call: {count:?}");
        assert!(count[0] * 20 >= cases() / 10 && count[1] * 20 >= cases() / 10, "{kinds:?} {count:?}");
    }
}
