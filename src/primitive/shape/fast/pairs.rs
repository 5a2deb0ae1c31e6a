//! The pairs with a cuboid, a cylinder, a cone or a triangle, each compiled once.

use super::axes;
use super::bodies::{Cone, Cuboid, Cylinder, Segment, Supported, TriangleCore};
use super::pair_and_margin::PairAndMargin;
use super::round;
use super::search;
use crate::primitive::shape::core::Core;
use crate::primitive::shape::place::{InPlace, Placement};
use crate::range::Point;
use crate::vector::difference;

const ORIGIN: Point = [0.0; 3];

pub(super) fn decide<P: Placement>(asked: &PairAndMargin<'_, P>) -> Option<bool> {
    let (at, reach) = (asked.at, asked.reach);
    let certain = match (&asked.a.core, &asked.b.core) {
        (Core::Point(p), Core::Cuboid { centre, half }) => point_cuboid(&at.point(p), centre, half, reach),
        (Core::Cuboid { centre, half }, Core::Point(p)) => {
            at.with_vectors(half, |half| point_cuboid(p, &at.point(centre), half, reach))
        }
        (Core::Point(p), Core::Cylinder { centre, half_axis, radius }) => {
            round::cylinder(&difference(&at.point(p), centre), half_axis, *radius, reach)
        }
        (Core::Cylinder { centre, half_axis, radius }, Core::Point(p)) => {
            round::cylinder(&difference(p, &at.point(centre)), &at.vector(half_axis), *radius, reach)
        }
        (Core::Point(p), Core::Cone { base, axis, radius }) => {
            round::cone(&difference(&at.point(p), base), axis, *radius, reach)
        }
        (Core::Cone { base, axis, radius }, Core::Point(p)) => {
            round::cone(&difference(p, &at.point(base)), &at.vector(axis), *radius, reach)
        }
        (Core::Segment([p, q]), Core::Cuboid { centre, half }) => {
            return segment_cuboid(&[at.point(p), at.point(q)], centre, half, asked);
        }
        (Core::Cuboid { centre, half }, Core::Segment(s)) => {
            return at.with_vectors(half, |half| segment_cuboid(s, &at.point(centre), half, asked));
        }
        (Core::Cuboid { .. }, Core::Cuboid { .. }) => return cuboids(asked),
        _ => {
            let PairAndMargin { a, at, b, margin, reach } = *asked;
            return at.with(a, |a| others(&PairAndMargin { a, at: InPlace, b, margin, reach }));
        }
    };
    certain.or_else(|| asked.aligned())
}

/// The pairs whose tests take longer than moving a shape.
#[inline(never)]
fn others(asked: &PairAndMargin<'_, InPlace>) -> Option<bool> {
    match (&asked.a.core, &asked.b.core) {
        (Core::Segment(s), Core::Cylinder { centre, half_axis, radius })
        | (Core::Cylinder { centre, half_axis, radius }, Core::Segment(s)) => {
            let at = difference(&s[0], centre);
            search::decide(&Cylinder::new(half_axis, *radius, ORIGIN), &Segment::new(s, at), asked)
        }
        (Core::Cuboid { centre: c, half }, Core::Cylinder { centre, half_axis, radius })
        | (Core::Cylinder { centre, half_axis, radius }, Core::Cuboid { centre: c, half }) => {
            let cylinder = Cylinder::new(half_axis, *radius, difference(centre, c));
            search::decide(&Cuboid::new(half, ORIGIN)?, &cylinder, asked)
        }
        (
            Core::Cylinder { centre: c, half_axis: axis, radius: r },
            Core::Cylinder { centre, half_axis, radius },
        ) => {
            let b = Cylinder::new(half_axis, *radius, difference(centre, c));
            search::decide(&Cylinder::new(axis, *r, ORIGIN), &b, asked)
        }
        (Core::Triangle(t), other) | (other, Core::Triangle(t)) => triangle(t, other, asked),
        (Core::Cone { base, axis, radius }, other) | (other, Core::Cone { base, axis, radius }) => {
            cone(base, axis, *radius, other, asked)
        }
        _ => None,
    }
}

#[inline(never)]
fn cone(
    base: &Point,
    axis: &Point,
    radius: f64,
    other: &Core,
    asked: &PairAndMargin<'_, InPlace>,
) -> Option<bool> {
    let from = |origin: &Point| Cone::new(axis, radius, Cone::reference(axis, &difference(base, origin)));
    match other {
        Core::Segment(s) => search::decide(&Segment::new(s, ORIGIN), &from(&s[0]), asked),
        Core::Cuboid { centre, half } => search::decide(&Cuboid::new(half, ORIGIN)?, &from(centre), asked),
        Core::Cylinder { centre, half_axis, radius } => {
            search::decide(&Cylinder::new(half_axis, *radius, ORIGIN), &from(centre), asked)
        }
        Core::Cone { base: origin, axis: along, radius: other } => {
            // The reference point of A is the origin. Bases first, which may be far away.
            let between = Cone::reference(axis, &difference(base, origin));
            let at = difference(&between, &Cone::reference(along, &ORIGIN));
            search::decide(&Cone::new(along, *other, ORIGIN), &Cone::new(axis, radius, at), asked)
        }
        _ => None,
    }
}

#[inline(never)]
fn triangle(t: &[Point; 3], other: &Core, asked: &PairAndMargin<'_, InPlace>) -> Option<bool> {
    match other {
        Core::Point(p) => {
            search::from_point(&difference(p, &t[0]), &TriangleCore::new(t, ORIGIN), asked.reach)
        }
        Core::Segment(s) => {
            let segment = Segment::new(s, difference(&s[0], &t[0]));
            search::decide(&TriangleCore::new(t, ORIGIN), &segment, asked)
        }
        Core::Cuboid { centre, half } => {
            let (d, a) = (difference(&t[0], centre), Cuboid::new(half, ORIGIN)?);
            let b = TriangleCore::new(t, d);
            search::decide_with(&a, &b, asked, |size| {
                // At a reach, a gap of 0 does not separate.
                axes::meets_triangle(half, &d, &b.edges, size / a.inner())
                    .filter(|meet| *meet || asked.reach == 0.0)
            })
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let triangle = TriangleCore::new(t, difference(&t[0], centre));
            search::decide(&Cylinder::new(half_axis, *radius, ORIGIN), &triangle, asked)
        }
        Core::Cone { base, axis, radius } => {
            let cone = Cone::new(axis, *radius, Cone::reference(axis, &difference(base, &t[0])));
            search::decide(&TriangleCore::new(t, ORIGIN), &cone, asked)
        }
        _ => None,
    }
}

#[inline(always)]
fn point_cuboid(p: &Point, centre: &Point, half: &[Point; 3], reach: f64) -> Option<bool> {
    search::from_point(&difference(p, centre), &Cuboid::new(half, ORIGIN)?, reach)
}

#[inline(always)]
fn segment_cuboid<P: Placement>(
    s: &[Point; 2],
    centre: &Point,
    half: &[Point; 3],
    asked: &PairAndMargin<'_, P>,
) -> Option<bool> {
    search::decide(&Cuboid::new(half, ORIGIN)?, &Segment::new(s, difference(&s[0], centre)), asked)
}

#[inline(never)]
fn cuboids<P: Placement>(asked: &PairAndMargin<'_, P>) -> Option<bool> {
    let (Core::Cuboid { centre: c, half: g }, Core::Cuboid { centre, half }) = (&asked.a.core, &asked.b.core)
    else {
        return None;
    };
    let d = difference(centre, &asked.at.point(c));
    asked.at.with_vectors(g, |g| {
        let (a, b) = (Cuboid::new(g, ORIGIN)?, Cuboid::new(half, d)?);
        search::decide_with(&a, &b, asked, |size| {
            // At a reach, a gap of 0 does not separate.
            axes::meet(g, &d, half, size / a.inner()).filter(|meet| *meet || asked.reach == 0.0)
        })
    })
}
