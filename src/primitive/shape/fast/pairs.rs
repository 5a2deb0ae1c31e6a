//! The pairs with a cuboid, a cylinder or a triangle, each compiled once.

use super::axes;
use super::bodies::{Cuboid, Cylinder, Segment, Supported, TriangleCore};
use super::search;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::Point;
use crate::vector::difference;

const ORIGIN: Point = [0.0; 3];

pub(super) fn decide(a: &Shape, b: &Shape, reach: f64) -> Option<bool> {
    match (&a.core, &b.core) {
        (Core::Point(p), Core::Cuboid { centre, half }) | (Core::Cuboid { centre, half }, Core::Point(p)) => {
            search::from_point(&difference(p, centre), &Cuboid::new(half, ORIGIN)?, reach)
        }
        (Core::Point(p), Core::Cylinder { centre, half_axis, radius })
        | (Core::Cylinder { centre, half_axis, radius }, Core::Point(p)) => {
            search::from_point(&difference(p, centre), &Cylinder::new(half_axis, *radius, ORIGIN), reach)
        }
        (Core::Segment(s), Core::Cuboid { centre, half })
        | (Core::Cuboid { centre, half }, Core::Segment(s)) => segment_cuboid(s, centre, half, reach),
        (Core::Segment(s), Core::Cylinder { centre, half_axis, radius })
        | (Core::Cylinder { centre, half_axis, radius }, Core::Segment(s)) => {
            let at = difference(&s[0], centre);
            search::decide(&Cylinder::new(half_axis, *radius, ORIGIN), &Segment::new(s, at), reach)
        }
        (Core::Cuboid { centre: c, half: g }, Core::Cuboid { centre, half }) => {
            cuboids(g, &difference(centre, c), half, reach)
        }
        (Core::Cuboid { centre: c, half }, Core::Cylinder { centre, half_axis, radius })
        | (Core::Cylinder { centre, half_axis, radius }, Core::Cuboid { centre: c, half }) => {
            let cylinder = Cylinder::new(half_axis, *radius, difference(centre, c));
            search::decide(&Cuboid::new(half, ORIGIN)?, &cylinder, reach)
        }
        (
            Core::Cylinder { centre: c, half_axis: axis, radius: r },
            Core::Cylinder { centre, half_axis, radius },
        ) => {
            let b = Cylinder::new(half_axis, *radius, difference(centre, c));
            search::decide(&Cylinder::new(axis, *r, ORIGIN), &b, reach)
        }
        (Core::Triangle(t), other) | (other, Core::Triangle(t)) => triangle(t, other, reach),
        _ => None,
    }
}

#[inline(never)]
fn triangle(t: &[Point; 3], other: &Core, reach: f64) -> Option<bool> {
    match other {
        Core::Point(p) => search::from_point(&difference(p, &t[0]), &TriangleCore::new(t, ORIGIN), reach),
        Core::Segment(s) => {
            let segment = Segment::new(s, difference(&s[0], &t[0]));
            search::decide(&TriangleCore::new(t, ORIGIN), &segment, reach)
        }
        Core::Cuboid { centre, half } => {
            let (d, a) = (difference(&t[0], centre), Cuboid::new(half, ORIGIN)?);
            let b = TriangleCore::new(t, d);
            search::decide_with(&a, &b, reach, |size| {
                // At a reach, a gap of 0 does not separate.
                axes::meets_triangle(half, &d, &b.edges, size / a.inner())
                    .filter(|meet| *meet || reach == 0.0)
            })
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let triangle = TriangleCore::new(t, difference(&t[0], centre));
            search::decide(&Cylinder::new(half_axis, *radius, ORIGIN), &triangle, reach)
        }
        _ => None,
    }
}

#[inline(never)]
fn segment_cuboid(s: &[Point; 2], centre: &Point, half: &[Point; 3], reach: f64) -> Option<bool> {
    search::decide(&Cuboid::new(half, ORIGIN)?, &Segment::new(s, difference(&s[0], centre)), reach)
}

#[inline(never)]
fn cuboids(g: &[Point; 3], d: &Point, half: &[Point; 3], reach: f64) -> Option<bool> {
    let (a, b) = (Cuboid::new(g, ORIGIN)?, Cuboid::new(half, *d)?);
    search::decide_with(&a, &b, reach, |size| {
        // At a reach, a gap of 0 does not separate.
        axes::meet(g, d, half, size / a.inner()).filter(|meet| *meet || reach == 0.0)
    })
}
