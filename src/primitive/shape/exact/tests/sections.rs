//! Cylinders and cones against polytopes: the part of the polytope between the planes of the two ends, projected along
//! the axis for a cylinder, and from the tip on the base for a cone, against the disc.

use super::nearest::square_between;
use super::*;
use crate::rng::CASES_STEP;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Ordering;

/// Corners of edges of polytopes.
fn edges(core: &Core) -> Vec<(usize, usize)> {
    match core {
        Core::Cuboid { .. } => {
            let is_edge = |(i, j): &(usize, usize)| i < j && (i ^ j).is_power_of_two();
            (0..64).map(|i| (i / 8, i % 8)).filter(is_edge).collect()
        }
        Core::Triangle(_) => vec![(0, 1), (1, 2), (2, 0)],
        Core::Segment(_) => vec![(0, 1)],
        _ => vec![],
    }
}

/// The base, axis and radius, and whether it is a cone.
pub(super) fn parts<T: Number>(core: &Core, number: impl Fn(f64) -> T) -> ([T; 3], [T; 3], T, bool) {
    let vector = |v: &Point| v.map(&number);
    match core {
        Core::Cylinder { centre, half_axis: h, radius } => {
            (minus(&vector(centre), &vector(h)), vector(&h.map(|x| 2.0 * x)), number(*radius), false)
        }
        Core::Cone { base, axis, radius } => (vector(base), vector(axis), number(*radius), true),
        _ => panic!("{core:?} is not round"),
    }
}

/// Less if they overlap, equal if they touch or the polytope meets the axis, greater if they are apart.
pub(super) fn compare<T: Number>(round: &Core, polytope: &Core, number: impl Fn(f64) -> T) -> Ordering {
    let (base, axis, radius, is_cone) = parts(round, &number);
    let all = corners(polytope, number);
    let (zero, one) = (T::from(0), T::from(1));
    let negative = |x: &T| zero.clone() - x.clone();
    let product = |x: &T, y: &T| x.clone() * y.clone();
    let end = combined(&one, &base, &one, &axis);
    if square_between(&[base.clone(), end], &all).0 == zero {
        return Ordering::Equal;
    }
    let length = dot(&axis, &axis);
    // Vectors from the base with their denominators.
    let offsets: Vec<[T; 3]> = all.iter().map(|p| minus(p, &base)).collect();
    let is_between = |d: &&[T; 3]| (zero.clone()..=length.clone()).contains(&dot(d, &axis));
    let mut section: Vec<_> = offsets.iter().filter(is_between).map(|d| (d.clone(), one.clone())).collect();
    for (i, j) in edges(polytope) {
        for plane in [&zero, &length] {
            let height = |i: usize| dot(&offsets[i], &axis) - plane.clone();
            let (low, high) = if height(i) < height(j) { (i, j) } else { (j, i) };
            if height(low) < zero && height(high) > zero {
                let (s, t) = (negative(&height(low)), height(high));
                section.push((combined(&t, &offsets[low], &s, &offsets[high]), s + t));
            }
        }
    }
    // On the disc: a vector from its middle, and its denominator, which is zero for a direction.
    let project = |(d, weight): &([T; 3], T)| {
        let along = dot(d, &axis);
        let on_disc = combined(&length, d, &negative(&along), &axis);
        let width = product(&length, weight);
        (on_disc, if is_cone { width - along } else { width })
    };
    let images: Vec<_> = section.iter().map(project).collect();
    let square = product(&radius, &radius);
    let compare_end = |p: &[T; 3], v: &T| dot(p, p).cmp(&product(&square, &product(v, v)));
    // The axis does not meet the section, so the nearest point of its image is on an edge.
    let compare_pair = |(p, v): &([T; 3], T), (q, w): &([T; 3], T)| {
        let edge = combined(v, q, &negative(w), p);
        if *v == zero && *w == zero {
            Ordering::Greater
        } else if *v > zero && dot(p, &edge) >= zero {
            compare_end(p, v)
        } else if *w > zero && dot(q, &edge) <= zero {
            compare_end(q, w)
        } else {
            let moment = cross(p, q);
            dot(&moment, &moment).cmp(&product(&square, &dot(&edge, &edge)))
        }
    };
    let pairs = images.iter().flat_map(|p| images.iter().map(move |q| compare_pair(p, q)));
    pairs.min().unwrap_or(Ordering::Greater)
}

#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn polytopes_meet_round_solids_where_their_sections_do() {
    let mut rng = Rng::new(72);
    for (round, polytope) in [4, 5].into_iter().flat_map(|round| [0, 1, 2, 3].map(|p| (round, p))) {
        let mut tally = Tally::default();
        let count = 5_000 / CASES_STEP;
        for _ in 0..count {
            let most = rng.int(1, 6);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b) = (draw.core(round), draw.core(polytope));
            let expected = tally.add(compare(&a, &b, whole));
            assert_eq!(verdict(&mut rng, &a, &b, 0.0), Some(expected), "{a:?} {b:?}");
        }
        tally.check(count / 100, &format!("{round} {polytope}"));
    }
}

/// Round solids with small radii that meet only the inside of a face, or are inside a cuboid.
#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn faces_are_pierced_away_from_their_edges() {
    let mut rng = Rng::new(73);
    let mut tally = Tally::default();
    for i in 0..20_000 / CASES_STEP {
        let mut draw = Draw { rng: &mut rng, most: 12 };
        let polytope = draw.core(2 + i % 2);
        draw.most = 3;
        let round = draw.core(4 + i / 2 % 2);
        let expected = tally.add(compare(&round, &polytope, whole));
        assert_eq!(verdict(&mut rng, &round, &polytope, 0.0), Some(expected), "{round:?} {polytope:?}");
    }
    tally.check(500 / CASES_STEP, "pierced");
}
