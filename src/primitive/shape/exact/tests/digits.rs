//! Decisions with square roots: spheres against cylinders and cones, and half-spaces, in fixed point with so many
//! digits that only equal numbers are equal. Algebraic numbers of this degree and size differ by more than [`TIE`] or
//! not at all.

use super::sections::parts;
use super::*;
use crate::rng::CASES_STEP;
use alloc::format;
use core::cmp::Ordering;
use dashu_int::IBig;

/// Binary digits after the point.
const DIGITS: usize = 600;

/// Two to this power is less than any difference, and more than any error: square roots halve the digits.
const TIE: usize = DIGITS - 250;

#[derive(Clone, PartialEq, PartialOrd)]
struct Fixed(IBig);

impl Fixed {
    fn new(x: i128) -> Self {
        Self(IBig::from(x) << DIGITS)
    }

    fn plus(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }

    fn minus(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0)
    }

    fn times(&self, other: &Self) -> Self {
        Self((&self.0 * &other.0) >> DIGITS)
    }

    fn over(&self, other: &Self) -> Self {
        Self((&self.0 << DIGITS) / &other.0)
    }

    fn root(&self) -> Self {
        let magnitude = dashu_int::UBig::try_from(&self.0 << DIGITS).unwrap();
        Self(magnitude.nth_root(2).into())
    }

    /// Compares with zero.
    fn order(&self) -> Ordering {
        let tie = IBig::from(1) << TIE;
        if self.0 > tie {
            Ordering::Greater
        } else if self.0 < -tie {
            Ordering::Less
        } else {
            Ordering::Equal
        }
    }
}

type Pair = [Fixed; 2];

/// The distance of a point from a segment in the plane.
fn from_segment(p: &Pair, [q, r]: [&Pair; 2]) -> Fixed {
    let difference = |p: &Pair, q: &Pair| [p[0].minus(&q[0]), p[1].minus(&q[1])];
    let product = |u: &Pair, v: &Pair| u[0].times(&v[0]).plus(&u[1].times(&v[1]));
    let (d, e) = (difference(p, q), difference(r, q));
    let share = product(&d, &e).over(&product(&e, &e));
    let (zero, one) = (Fixed::new(0), Fixed::new(1));
    let share = if share < zero {
        zero
    } else if share > one {
        one
    } else {
        share
    };
    let way = difference(&d, &[share.times(&e[0]), share.times(&e[1])]);
    product(&way, &way).root()
}

/// The distance of a point from a cylinder or cone: that of a point in a half-plane from a rectangle or triangle.
fn from_round(core: &Core, p: &Point) -> Fixed {
    let (base, axis, radius, is_cone) = parts(core, whole);
    let d = minus(&p.map(whole), &base);
    let length = dot(&axis, &axis);
    let moment = cross(&d, &axis);
    let height = Fixed::new(length).root();
    let radius = Fixed::new(radius);
    let rho = Fixed::new(dot(&moment, &moment)).root().over(&height);
    let z = Fixed::new(dot(&d, &axis)).over(&height);
    let zero = Fixed::new(0);
    let at_height = |x: &Fixed, y: &Fixed| [x.clone(), y.clone()];
    let top = at_height(if is_cone { &zero } else { &radius }, &height);
    let corners = [at_height(&zero, &zero), at_height(&radius, &zero), top, at_height(&zero, &height)];
    // The radius at the height of the point.
    let width = if is_cone { radius.minus(&radius.times(&z).over(&height)) } else { radius };
    let point = [rho, z];
    if point[1] >= zero && point[1] <= height && point[0] <= width {
        return zero;
    }
    let sides = if is_cone { 2 } else { 3 };
    let distances = (0..sides).map(|i| from_segment(&point, [&corners[i], &corners[i + 1]]));
    distances.reduce(|x, y| if x < y { x } else { y }).unwrap()
}

#[test]
fn spheres_are_as_near_to_round_solids_as_in_fixed_point() {
    let mut rng = Rng::new(74);
    for round in [4, 5] {
        let mut tally = Tally::default();
        for _ in 0..12_000 / CASES_STEP {
            let most = rng.int(1, 8);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, p) = (draw.core(round), draw.point());
            let reach = rng.int(0, 5);
            let gap = from_round(&a, &p).minus(&Fixed::new(reach.into()));
            let expected = tally.add(gap.order());
            assert_eq!(
                verdict(&mut rng, &a, &Core::Point(p), reach as f64),
                Some(expected),
                "{a:?} {p:?} {reach}"
            );
        }
        tally.check(150 / CASES_STEP, &format!("{round}"));
    }
}

/// The least height of a core over the plane of a half-space, in units of length.
fn least_height(normal: &Point, offset: f64, core: &Core) -> Fixed {
    let n = normal.map(whole);
    let length = Fixed::new(dot(&n, &n)).root();
    let height = |p: &[i128; 3]| Fixed::new(dot(&n, p) - offset as i128).over(&length);
    if !matches!(core, Core::Cylinder { .. } | Core::Cone { .. }) {
        let corners = corners(core, whole);
        return corners.iter().map(height).reduce(|x, y| if x < y { x } else { y }).unwrap();
    }
    let (base, axis, radius, is_cone) = parts(core, whole);
    let end = combined(&1, &base, &1, &axis);
    // The sine of the angle between axis and normal.
    let moment = cross(&n, &axis);
    let sine =
        Fixed::new(dot(&moment, &moment)).root().over(&length).over(&Fixed::new(dot(&axis, &axis)).root());
    let below = Fixed::new(radius).times(&sine);
    let (x, y) = (height(&base).minus(&below), height(&end));
    let y = if is_cone { y } else { y.minus(&below) };
    if x < y { x } else { y }
}

#[test]
fn half_spaces_are_as_near_as_in_fixed_point() {
    let mut rng = Rng::new(75);
    for kind in 0..6 {
        let mut tally = Tally::default();
        for _ in 0..8_000 {
            let most = rng.int(1, 6);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b) = (draw.core(6), draw.core(kind));
            let Core::HalfSpace { normal, offset } = a else { panic!("{a:?}") };
            let reach = rng.int(-2, 5).max(0);
            let gap = least_height(&normal, offset, &b).minus(&Fixed::new(reach.into()));
            let expected = tally.add(gap.order());
            // Any power of two scales normals.
            let scale = power_of_two(rng.int(-3, 1) as i32);
            let a = Core::HalfSpace { normal: normal.map(|x| x * scale), offset: offset * scale };
            assert_eq!(verdict(&mut rng, &a, &b, reach as f64), Some(expected), "{a:?} {b:?} {reach}");
        }
        tally.check(80, &format!("{kind}"));
    }
}

/// Normals that are not opposite, opposite with equal and with different lengths.
#[test]
fn half_spaces_are_apart_only_if_they_are_opposite() {
    let mut rng = Rng::new(76);
    let (mut tally, mut others) = (Tally::default(), 0);
    for _ in 0..20_000 {
        let mut draw = Draw { rng: &mut rng, most: 4 };
        let (normal, offset) = (draw.axis(), draw.number());
        let factor = draw.length();
        let (a, b) = (
            Core::HalfSpace { normal, offset },
            match draw.core(6) {
                Core::HalfSpace { offset, .. } if draw.rng.below(4) > 0 => {
                    Core::HalfSpace { normal: normal.map(|x| -x * factor), offset }
                }
                other => other,
            },
        );
        let reach = rng.int(-2, 5).max(0);
        let Core::HalfSpace { normal: other, offset: p } = b else { panic!("{b:?}") };
        let [n, m] = [normal, other].map(|v| v.map(whole));
        let expected = if cross(&n, &m) == [0; 3] && dot(&n, &m) < 0 {
            let gap = |o: f64, n: &[i128; 3]| Fixed::new(-o as i128).over(&Fixed::new(dot(n, n)).root());
            tally.add(gap(offset, &n).plus(&gap(p, &m)).minus(&Fixed::new(reach.into())).order())
        } else {
            others += 1;
            true
        };
        assert_eq!(verdict(&mut rng, &a, &b, reach as f64), Some(expected), "{a:?} {b:?} {reach}");
    }
    tally.check(200, "half-spaces");
    assert!(others > 1000, "{others}");
}
