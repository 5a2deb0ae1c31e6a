//! Cylinders and cones against polytopes: the part of the polytope between the planes of the two ends, projected along
//! the axis for a cylinder, and from the tip on the base for a cone, against the disc.

use super::nearest::square_between;
use super::*;
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

/// Less if they overlap, equal if they touch or one is on the axis of the other, greater if they are apart.
fn compare(round: &Core, polytope: &Core) -> Ordering {
    let number = |x: f64| x as i128;
    let vector = |v: &Point| v.map(number);
    let (base, axis, radius, is_cone) = match round {
        Core::Cylinder { centre, half_axis: h, radius } => {
            (minus(&vector(centre), &vector(h)), vector(&h.map(|x| 2.0 * x)), number(*radius), false)
        }
        Core::Cone { base, axis, radius } => (vector(base), vector(axis), number(*radius), true),
        _ => panic!("{round:?} is not round"),
    };
    let all = corners(polytope, number);
    let end = combined(&1, &base, &1, &axis);
    if square_between(&[base, end], &all).0 == 0 {
        return Ordering::Equal;
    }
    let length = dot(&axis, &axis);
    // Vectors from the base with their denominators.
    let offsets: Vec<[i128; 3]> = all.iter().map(|p| minus(p, &base)).collect();
    let mut section: Vec<([i128; 3], i128)> =
        offsets.iter().filter(|d| (0..=length).contains(&dot(d, &axis))).map(|d| (*d, 1)).collect();
    for (i, j) in edges(polytope) {
        let (p, q) = (&offsets[i], &offsets[j]);
        for plane in [0, length] {
            let (s, t) = (dot(p, &axis) - plane, dot(q, &axis) - plane);
            if s * t < 0 {
                let sign = (t - s).signum();
                section.push((combined(&(t * sign), p, &(-s * sign), q), (t - s) * sign));
            }
        }
    }
    // On the disc: a vector from its middle, and its denominator, which is zero for a direction.
    let project = |(d, weight): &([i128; 3], i128)| {
        let along = dot(d, &axis);
        let on_disc = combined(&length, d, &-along, &axis);
        (on_disc, length * weight - if is_cone { along } else { 0 })
    };
    let images: Vec<_> = section.iter().map(project).collect();
    // The axis does not meet the section, so the nearest point of its image is on an edge.
    let compare_pair = |(p, v): &([i128; 3], i128), (q, w): &([i128; 3], i128)| {
        let edge = combined(v, q, &-w, p);
        let square = radius * radius;
        if *v == 0 && *w == 0 {
            Ordering::Greater
        } else if *v > 0 && -dot(p, &edge) <= 0 {
            dot(p, p).cmp(&(square * v * v))
        } else if *w > 0 && dot(q, &edge) <= 0 {
            dot(q, q).cmp(&(square * w * w))
        } else {
            let moment = cross(p, q);
            dot(&moment, &moment).cmp(&(square * dot(&edge, &edge)))
        }
    };
    let pairs = images.iter().flat_map(|p| images.iter().map(move |q| compare_pair(p, q)));
    pairs.min().unwrap_or(Ordering::Greater)
}

#[test]
fn polytopes_meet_round_solids_where_their_sections_do() {
    let mut rng = Rng::new(72);
    for (round, polytope) in [4, 5].into_iter().flat_map(|round| [0, 1, 2, 3].map(|p| (round, p))) {
        let mut tally = Tally::default();
        let count = 15_000;
        for _ in 0..count {
            let most = rng.int(1, 6);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b) = (draw.core(round), draw.core(polytope));
            let expected = tally.add(compare(&a, &b));
            assert_eq!(verdict(&mut rng, &a, &b, 0.0), Some(expected), "{a:?} {b:?}");
        }
        tally.check(count / 100, &format!("{round} {polytope}"));
    }
}

/// Round solids that meet only the inside of a face, or are inside of a cuboid: the radii are small.
#[test]
fn faces_are_pierced_away_from_their_edges() {
    let mut rng = Rng::new(73);
    let mut tally = Tally::default();
    for i in 0..40_000 {
        let mut draw = Draw { rng: &mut rng, most: 12 };
        let polytope = draw.core(2 + i % 2);
        draw.most = 3;
        let round = draw.core(4 + i / 2 % 2);
        let expected = tally.add(compare(&round, &polytope));
        assert_eq!(verdict(&mut rng, &round, &polytope, 0.0), Some(expected), "{round:?} {polytope:?}");
    }
    tally.check(1000, "pierced");
}
