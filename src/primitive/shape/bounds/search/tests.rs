use super::{Certified, DistanceSearch, Newton, Operands, Places, bounds, newton};
use crate::exact::power_of_two;
use crate::primitive::shape::{Core, Shape};
use crate::range::Point;
use crate::rng::Rng;
use crate::vector::{cross, unit};
use alloc::format;
use alloc::vec::Vec;
use double::{Double, Vector, along, exact, length, minus};
use samples::{Sampled, moved, scaled};

pub(crate) mod double;
pub(crate) mod samples;
pub(crate) mod truth;

/// Pairs of each two kinds; a tenth under emulators.
const PAIRS: usize = 1_500 / if cfg!(simdop_neon) { 10 } else { 1 };

/// Rounding that a test of computed points allows, relative to the coordinates.
const FLOOR: f64 = power_of_two(-45);

fn magnitude(shape: &Shape) -> f64 {
    let most = |p: &Point| p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let core = match shape.core() {
        Core::Point(p) => most(p),
        Core::Segment(ends) => most(&ends[0]).max(most(&ends[1])),
        Core::Triangle(c) => most(&c[0]).max(most(&c[1])).max(most(&c[2])),
        Core::Cuboid { centre, half } => most(centre) + most(&half[0]) + most(&half[1]) + most(&half[2]),
        Core::Cylinder { centre: c, half_axis: h, radius } | Core::Cone { base: c, axis: h, radius } => {
            most(c) + most(h) + radius
        }
        Core::HalfSpace { offset, .. } => offset.abs(),
    };
    core + shape.radius()
}

/// The point of a shape nearest to a point.
fn nearest(shape: &Shape, p: &Vector) -> Vector {
    let foot = truth::nearest(shape.core(), p);
    let out = minus(p, &foot);
    let (far, radius) = (length(&out), Double::from(shape.radius()));
    if far <= radius { *p } else { along(&foot, radius / far, &out) }
}

/// An upper bound of the distance, from these points: alternating projections only come nearer.
fn from_above(a: &Shape, b: &Shape, found: &Certified, rounds: usize) -> Double {
    let mut p = nearest(a, &exact(&found.a));
    let mut q = nearest(b, &exact(&found.b));
    for _ in 0..rounds {
        q = nearest(b, &p);
        p = nearest(a, &q);
    }
    length(&minus(&p, &q))
}

/// Checks what all bounds must satisfy.
fn check(a: &Shape, b: &Shape, tolerance: f64, rounds: usize) -> Certified {
    let found = bounds(a, b, f64::INFINITY, tolerance);
    let text = format!("{a:?}\n{b:?}\n{found:?}");
    assert!(found.lower >= 0.0 && found.lower <= found.upper && found.upper.is_finite(), "{text}");
    assert!(found.a.iter().chain(&found.b).all(|x| x.is_finite()), "{text}");
    let size = magnitude(a).max(magnitude(b));
    let width = found.upper - found.lower;
    assert!(
        width <= 1.001 * tolerance * found.lower || width <= 8.0 * FLOOR * size,
        "{} {text}",
        width / size
    );
    for (shape, p) in [(a, &found.a), (b, &found.b)] {
        let off = length(&minus(&exact(p), &nearest(shape, &exact(p)))).0;
        assert!(off <= FLOOR * size, "{} {text}", off / size);
    }
    let apart = length(&minus(&exact(&found.a), &exact(&found.b))).0;
    // A common point comes from a tetrahedron, which may be thin.
    let floor = if found.upper == 0.0 { power_of_two(-26) } else { 4.0 * FLOOR };
    assert!((apart - found.upper).abs() <= floor * size, "{} {text}", (apart - found.upper) / size);
    let above = from_above(a, b, &found, rounds);
    assert!(Double::from(found.lower) <= above, "{above:?} {text}");
    let back = bounds(b, a, f64::INFINITY, tolerance);
    assert!(back.lower <= found.upper && found.lower <= back.upper, "{back:?} {text}");
    found
}

fn check_polytopes(a: &Shape, b: &Shape, tolerance: f64) -> Certified {
    let found = check(a, b, tolerance, 1);
    let [p, q] = [a, b].map(|s| truth::polytope(s.core()).unwrap());
    let core = truth::distance(&p, &q);
    let distance = core - Double::from(a.radius()) - Double::from(b.radius());
    let distance = if distance.0 > 0.0 { distance } else { double::ZERO };
    let is_inside = Double::from(found.lower) <= distance && distance <= Double::from(found.upper);
    assert!(is_inside, "{distance:?} {a:?}\n{b:?}\n{found:?}");
    found
}

fn scaled_by(v: &Point, by: f64) -> Point {
    v.map(|x| x * by)
}

/// A, moved so that the two touch up to rounding, or nearly.
fn touching(a: &Shape, found: &Certified, random: &mut Rng) -> Shape {
    let share = 1.0 + [0.0, 0.0, 1e-15, 1e-12, -1e-15, -1e-9, 1e-6][random.below(7) as usize];
    let by: Point = [0, 1, 2].map(|k| (found.b[k] - found.a[k]) * share);
    moved(a, &by)
}

fn tolerance(random: &mut Rng) -> f64 {
    power_of_two([-4, -20, -40, -42][random.below(4) as usize])
}

#[test]
fn polytopes_have_their_distances() {
    let mut random = Rng::new(1);
    let mut sure = [0; 2];
    for i in 0..4 {
        for j in i..4 {
            for _ in 0..PAIRS / 5 {
                let [a, b] = random.pair([i, j]);
                let found = check_polytopes(&a, &b, tolerance(&mut random));
                sure[0] += usize::from(found.upper == 0.0 || found.lower > 0.0);
                sure[1] += 1;
                if found.lower > 0.0 {
                    let a = touching(&a, &found, &mut random);
                    check_polytopes(&a, &b, tolerance(&mut random));
                }
            }
        }
    }
    assert!(sure[0] * 100 > sure[1] * 95, "{sure:?}");
}

#[test]
fn round_shapes_have_their_distances() {
    let mut random = Rng::new(2);
    let mut sure = [0; 2];
    for i in 0..6 {
        for j in 4..6 {
            for _ in 0..PAIRS {
                let [a, b] = random.pair([i, j]);
                let found = check(&a, &b, tolerance(&mut random), 4);
                sure[0] += usize::from(found.upper == 0.0 || found.lower > 0.0);
                sure[1] += 1;
                if found.lower > 0.0 {
                    let a = touching(&a, &found, &mut random);
                    check(&a, &b, tolerance(&mut random), 4);
                }
            }
        }
    }
    assert!(sure[0] * 100 > sure[1] * 95, "{sure:?}");
}

/// Two shapes at a small distance along an axis of A. The axes of B are those of A, perhaps permuted, after a rotation
/// by a small angle.
fn nearly_parallel(kinds: [usize; 2], random: &mut Rng) -> [Shape; 2] {
    let frame = random.frame();
    let angle = libm::exp10(-random.range(4.0, 14.0));
    let axis = unit(&random.vector(1.0)).unwrap();
    let mut turned = frame.map(|v| -> Point {
        let by = cross(&axis, &v);
        [0, 1, 2].map(|k| v[k] + angle * by[k])
    });
    turned.rotate_left(random.below(2) as usize);
    let (a, b) =
        (random.shape(kinds[0], &frame, [0.0; 3], 1.0), random.shape(kinds[1], &turned, [0.0; 3], 1.0));
    let (gap, aside, along) =
        (libm::exp10(-random.range(0.0, 9.0)), random.vector(0.3), frame[random.below(3) as usize]);
    let at = |t: f64| moved(&a, &[0, 1, 2].map(|k| aside[k] + t * along[k]));
    let (mut near, mut far) = (0.0, 2.0 * (magnitude(&a) + magnitude(&b)));
    for _ in 0..40 {
        let middle = 0.5 * (near + far);
        let is_far = bounds(&at(middle), &b, f64::INFINITY, 1e-3).lower > gap;
        (near, far) = if is_far { (near, middle) } else { (middle, far) };
    }
    [at(far), b]
}

#[test]
fn faces_that_are_nearly_parallel_have_their_distances() {
    let mut random = Rng::new(12);
    for i in 1..6 {
        for j in 3..6 {
            for _ in 0..PAIRS / 2 {
                let [a, b] = nearly_parallel([i, j], &mut random);
                check(&a, &b, power_of_two(-42), 4);
            }
        }
    }
}

/// The facing sides differ by an angle of 9e-10 and of 5e-10, and are closest at an edge.
#[test]
fn nearly_parallel_faces_are_closest_at_an_edge() {
    let cuboid = |centre, half, radius| Shape::new(Core::Cuboid { centre, half }, radius).unwrap();
    let above = Core::Cylinder {
        centre: [0.0, 8.152766640618949e-16, 9.5433187363065e-7],
        half_axis: [0.0, 0.0, 4.206737532846304e-7],
        radius: 3.3133690487472007e-7,
    };
    let half = [
        [1.3088608102894095e-7, 0.0, 0.0],
        [0.0, 1.9474445578755543e-7, 1.663683406643458e-16],
        [0.0, -2.922156699386219e-16, 3.4205655587805355e-7],
    ];
    let below = cuboid([0.0; 3], half, 1.916006106272823e-7);
    let half = [
        [6.0300484657306075e-58, 3.155080245991791e-67, 0.0],
        [-3.256510045248178e-67, 6.2239029980083035e-58, 0.0],
        [0.0, 0.0, 2.255062215775301e-58],
    ];
    let left = cuboid([0.0; 3], half, 2.4814539890781208e-58);
    let half = [
        [2.799732171744856e-58, 0.0, 0.0],
        [0.0, 1.0311288333579898e-58, -9.435948637134202e-74],
        [0.0, 3.991576379944794e-73, 4.361860851715917e-58],
    ];
    let right = cuboid([1.1311234632925956e-57, -5.91833600524783e-67, 0.0], half, 0.0);
    for [a, b] in [[below, Shape::new(above, 0.0).unwrap()], [left, right]] {
        check(&a, &b, power_of_two(-42), 4);
        check(&b, &a, power_of_two(-42), 4);
    }
}

/// Steps that a short way would stop at its bound, or that raise a lower bound by less than its rounding; and a flat
/// tetrahedron of GJK that seems to contain the origin.
#[test]
fn thin_or_nearly_parallel_shapes_are_closest_at_a_bound() {
    let cylinder = |centre, half_axis, radius| Core::Cylinder { centre, half_axis, radius };
    let segment = [
        [-0.416664030772104, -0.15641759803190275, -0.07939174031639978],
        [0.10122810203627164, 0.19716492600375785, 0.3797933448015919],
    ];
    let coin = [5.054562323475848e-7, 3.450948486643789e-7, 4.4815962645953055e-7];
    let plate = [
        [-0.14238726812013294, -0.0215085552384801, -0.27856205848291865],
        [-0.39945225607341406, 0.7913342132951988, 0.14307928389465932],
        [4.900344271948617e-7, 2.9679359308153244e-7, -2.733978388122145e-7],
    ];
    let beside = [-0.9529872647859474, 1.9059628786327827, 0.34540830120832994];
    let block = [
        [-0.10921105638630785, -0.01649706515049355, -0.21365714138319505],
        [-0.13756203490802804, 0.27251703556074314, 0.049273166309988736],
        [0.5891088004511171, 0.3567988449378687, -0.3286729746531249],
    ];
    let wide = cylinder(
        [0.0; 3],
        [-0.15054011215335494, 0.5231121507898406, 0.6831721667427818],
        0.9665045436398354,
    );
    let narrow = cylinder(
        [-0.5543388999847418, 1.2854536272276853, 1.5174577617406677],
        [-0.02505628850563591, 0.08706814937116555, 0.1137089554709378],
        0.7111086705019131,
    );
    let above = cylinder(
        [0.0; 3],
        [-0.08165919858550016, 0.17908665783328112, 0.10650950038549606],
        0.5290105490862536,
    );
    let below = cylinder(
        [-0.2185233170994238, -0.8116186830824301, 1.2313400961521885],
        [-0.34792056699278984, 0.7630240365548601, 0.45379879143238105],
        0.9535453458598453,
    );
    let pairs = [
        [
            (Core::Segment(segment), 6.033580725973492e-7),
            (cylinder([0.0; 3], coin, 0.20867003620978658), 0.0),
        ],
        [
            (Core::Cuboid { centre: [0.0; 3], half: plate }, 0.9515809299719421),
            (Core::Cuboid { centre: beside, half: block }, 0.0),
        ],
        [(wide, 0.9292931066653006), (narrow, 0.10392807971259588)],
        [(above, 0.0), (below, 0.0)],
    ];
    for pair in pairs {
        let [a, b] = pair.map(|(core, radius)| Shape::new(core, radius).unwrap());
        check(&a, &b, power_of_two(-42), 4);
        check(&b, &a, power_of_two(-42), 4);
    }
}

/// The tetrahedron that contains the common point of a long and a flat shape is a needle.
#[test]
fn long_and_flat_shapes_have_common_points() {
    let mut random = Rng::new(14);
    let mut common = 0;
    for _ in 0..20 * PAIRS {
        let [[long, ..], [flat, ..]] = [random.frame(), random.frame()];
        let half_axis = scaled_by(&long, libm::exp10(random.range(4.0, 6.5)));
        let (far, aside) = (random.range(-0.5, 0.5), random.vector(0.9));
        let centre: Point = [0, 1, 2].map(|k| far * half_axis[k] + aside[k]);
        let a = Core::Cylinder { centre, half_axis, radius: random.range(0.3, 1.0) };
        let b = Core::Cone { base: [0.0; 3], axis: scaled_by(&flat, 3e-7), radius: random.range(0.3, 1.0) };
        let [a, b] = [a, b].map(|core| Shape::new(core, 0.0).unwrap());
        for (a, b) in [(a, b), (b, a)] {
            let found = bounds(&a, &b, f64::INFINITY, 0.5);
            if found.upper == 0.0 {
                let apart = length(&minus(&exact(&found.a), &exact(&found.b))).0;
                assert!(
                    apart <= power_of_two(-27) * magnitude(&a).max(magnitude(&b)),
                    "{a:?} {b:?} {found:?}"
                );
                common += 1;
            }
        }
    }
    assert!(common > 20 * PAIRS, "{common}");
}

/// Two shapes of which A came from a random direction, until the distance is below 2^-15. `None` if it passes B.
fn approach(kinds: [usize; 2], random: &mut Rng) -> Option<[Shape; 2]> {
    let [[x, frame @ ..], other] = [random.frame(), random.frame()];
    let aside: Point = [0, 1].map(|k| frame[k].map(|y| 0.3 * y)).into_iter().fold([0.0; 3], |sum, y| {
        let by = random.range(-1.0, 1.0);
        [0, 1, 2].map(|k| sum[k] + by * y[k])
    });
    let mut a =
        random.shape(kinds[0], &[x, frame[0], frame[1]], [0, 1, 2].map(|k| 4.0 * x[k] + aside[k]), 1.0);
    let b = random.shape(kinds[1], &other, [0.0; 3], 1.0);
    for _ in 0..200 {
        let found = bounds(&a, &b, f64::INFINITY, 1e-6);
        if found.lower < power_of_two(-15) {
            return (found.lower > 0.0).then_some([a, b]);
        }
        a = moved(&a, &x.map(|x| -found.lower * x));
    }
    None
}

/// Newton's method alone, in few steps.
#[test]
fn newton_converges_where_round_shapes_nearly_touch() {
    let mut random = Rng::new(9);
    let (mut solved, mut all, mut steps) = (0, 0, 0);
    for i in 3..6 {
        for j in 4..6 {
            for [a, b] in (0..300).filter_map(|_| approach([i, j], &mut random)).collect::<Vec<_>>() {
                let pair = Operands::of(a.core(), b.core(), 1.0).unwrap();
                let radii = [a.radius(), b.radius()];
                let mut search = DistanceSearch::new(&pair, radii, f64::INFINITY, power_of_two(-42));
                let mut newton = Newton::new(&pair, Places::guess(&pair));
                let (mut is_solved, mut goes_on, mut taken) = (false, true, 0);
                while !is_solved && goes_on && taken < newton::STEPS {
                    is_solved = search.is_solved_by(&mut newton, taken == 0);
                    goes_on = is_solved || newton.step(&pair, search.lower);
                    taken += usize::from(!is_solved);
                }
                solved += usize::from(is_solved);
                steps += taken;
                all += 1;
            }
        }
    }
    assert!(all > 1500 && solved * 100 > all * 96 && steps < 3 * all, "{solved} of {all}, {steps} steps");
}

#[test]
fn a_limit_ends_the_search() {
    let mut random = Rng::new(3);
    for _ in 0..PAIRS {
        let kinds = [random.below(6) as usize, random.below(6) as usize];
        let [a, b] = random.pair(kinds);
        let found = bounds(&a, &b, f64::INFINITY, 1e-9);
        for share in [0.0, 0.5, 0.999, 1.001, 2.0] {
            let limit = share * found.upper;
            let limited = bounds(&a, &b, limit, 1e-9);
            assert!(limited.lower <= found.upper && found.lower <= limited.upper);
            if share > 1.0 && found.lower > 0.0 {
                assert!(
                    limited.upper - limited.lower <= 1e-8 * limited.lower.max(magnitude(&a) + magnitude(&b))
                );
            }
        }
    }
}

#[test]
fn all_scales_give_the_same_bounds() {
    let mut random = Rng::new(4);
    for _ in 0..PAIRS {
        let kinds = [random.below(6) as usize, random.below(6) as usize];
        let [a, b] = random.pair(kinds);
        let found = bounds(&a, &b, 1e300, 1e-6);
        for exponent in [-150, -110, 140, 270] {
            let scale = power_of_two(exponent);
            let other = bounds(&scaled(&a, scale), &scaled(&b, scale), f64::INFINITY, 1e-6);
            let (lower, upper) = (other.lower / scale, other.upper / scale);
            assert!(
                lower <= found.upper && found.lower <= upper,
                "{exponent} {a:?} {b:?} {found:?} {other:?}"
            );
            let size = magnitude(&a).max(magnitude(&b));
            assert!(upper - lower <= (1.001e-6 * lower).max(8.0 * FLOOR * size));
        }
        // One shape is far larger or smaller than the other.
        let scale = power_of_two([-150, 270][random.below(2) as usize]);
        let far = bounds(&scaled(&a, scale), &b, f64::INFINITY, 1e-6);
        assert!(far.lower >= 0.0 && far.lower <= far.upper && far.upper.is_finite(), "{far:?}");
    }
}

#[test]
fn half_spaces_are_planes_to_what_is_above() {
    let mut random = Rng::new(5);
    for _ in 0..PAIRS {
        let kind = random.below(6) as usize;
        let [a, _] = random.pair([kind, 0]);
        let normal = random.vector(1.0);
        let space = Shape::half_space(normal, random.range(-2.0, 2.0)).unwrap();
        let space = if random.below(2) == 0 { space.widened(0.25).unwrap() } else { space };
        let Core::HalfSpace { normal, offset } = *space.core() else { unreachable!() };
        let (n, down) = (exact(&normal), exact(&normal.map(|x| -x)));
        let height = (-truth::support(a.core(), &down) - Double::from(offset)) / length(&n);
        let distance = height - Double::from(a.radius()) - Double::from(space.radius());
        let size = magnitude(&a).max(offset.abs() / length(&n).0);
        for found in [bounds(&a, &space, 0.0, 0.0), bounds(&space, &a, 0.0, 0.0)] {
            let truth = if distance.0 > 0.0 { distance } else { double::ZERO };
            assert!(Double::from(found.lower) <= truth && truth <= Double::from(found.upper));
            assert!(found.upper - found.lower <= 8.0 * FLOOR * size);
            let apart = length(&minus(&exact(&found.a), &exact(&found.b))).0;
            assert!((apart - found.upper).abs() <= 4.0 * FLOOR * size);
        }
    }
}

#[test]
fn half_spaces_meet_unless_they_are_opposite() {
    let space = |normal, offset| Shape::half_space(normal, offset).unwrap();
    let up = space([0.1, 0.2, 0.3], 1.0);
    let down = space([-0.1, -0.2, -0.3], -1.5);
    let gap = 0.5 / 0.14_f64.sqrt();
    let found = bounds(&up, &down, 1.0, 0.0);
    assert!(found.lower <= gap && gap <= found.upper && found.upper - found.lower < 1e-13, "{found:?}");
    let inward = space([-0.1, -0.2, -0.3], 1.0);
    assert_eq!(bounds(&up, &inward, 1.0, 0.0).upper, 0.0);
    // Three times the normal is not exactly opposite.
    let nearly = space([-0.1 * 3.0, -0.2 * 3.0, -0.3 * 3.0], -4.5);
    assert_eq!(bounds(&up, &nearly, 1.0, 0.0).upper, 0.0);
    assert_eq!(bounds(&up, &space([0.1, 0.2, 0.3], -7.0), 1.0, 0.0).upper, 0.0);
    let found = bounds(&up, &space([0.5, -0.25, 0.0], -7.0), 1.0, 0.0);
    assert_eq!((found.upper, found.a), (0.0, found.b));
}
