//! The distance of a half-space: that of the other core's lowest point above its plane.

use core::cmp::Ordering;

use super::body::{Body, Pair, Plane};
use super::numbers::{
    cross, dot, is_zero, negated, over_down, over_up, root_down, root_up, sign_with_root, sign_with_roots,
    square,
};
use dashu_int::IBig;
use dashu_int::ops::Abs;

/// A distance `(a - sqrt(p)) / (d sqrt(n))`, or zero if this is negative. d and n are positive.
struct Height {
    a: IBig,
    p: IBig,
    d: IBig,
    n: IBig,
}

/// Whether the cores are at most the pair's reach apart, if one is a half-space.
pub(crate) fn half_spaces_reach(pair: &Pair) -> Option<bool> {
    heights(pair).map(|heights| heights.iter().any(|height| height.is_within(&pair.reach)))
}

/// Bounds of the distance of the cores, one of which is a half-space. In the pair's unit.
pub(crate) fn half_space_bounds(pair: &Pair) -> (IBig, IBig) {
    let heights = heights(pair).expect("one is a half-space");
    let bounds = heights.iter().map(Height::bounds);
    bounds.reduce(|x, y| (x.0.min(y.0), x.1.min(y.1))).expect("at least one height")
}

/// The heights of some points, one of which is the lowest. None if no core is a half-space.
fn heights(pair: &Pair) -> Option<Vec<Height>> {
    let (plane, other) = match (&pair.a, &pair.b) {
        (Body::HalfSpace(plane), other) | (other, Body::HalfSpace(plane)) => (plane, other),
        _ => return None,
    };
    Some(match other {
        Body::HalfSpace(_) => {
            let (Body::HalfSpace(a), Body::HalfSpace(b)) = (&pair.a, &pair.b) else { unreachable!() };
            vec![between(a, b)]
        }
        Body::Hull(hull) => {
            let lowest = &hull.corners[hull.farthest(&negated(&plane.normal))];
            let a = dot(&plane.normal, lowest) - &plane.offset;
            vec![Height { a, p: IBig::ZERO, d: IBig::ONE, n: square(&plane.normal) }]
        }
        Body::Round(round) => {
            let normal = &plane.normal;
            let (full, along, n) = (square(&round.axis), dot(normal, &round.axis), square(normal));
            let middle = dot(normal, &round.middle) - &plane.offset;
            // A disc of radius r is lowest at r sqrt(n - along^2 / U) below its middle.
            let p = &round.radius * &round.radius * (&n * &full - &along * &along) * &full;
            let disc =
                |middle: IBig| Height { a: middle * &full, p: p.clone(), d: full.clone(), n: n.clone() };
            if round.is_cone {
                let tip = Height { a: &middle + along, p: IBig::ZERO, d: IBig::ONE, n: n.clone() };
                vec![tip, disc(middle)]
            } else {
                vec![disc(middle - along.abs())]
            }
        }
    })
}

/// Half-spaces are apart only if their normals are opposite.
fn between(a: &Plane, b: &Plane) -> Height {
    let along = -dot(&a.normal, &b.normal);
    let n = square(&a.normal);
    if along <= IBig::ZERO || !is_zero(&cross(&a.normal, &b.normal)) {
        return Height { a: IBig::ZERO, p: IBig::ZERO, d: IBig::ONE, n };
    }
    // The normal of b is -along / n times that of a.
    Height { a: -(&b.offset * &n + &a.offset * &along), p: IBig::ZERO, d: along, n }
}

impl Height {
    fn is_within(&self, reach: &IBig) -> bool {
        let Self { a, p, d, n } = self;
        let over_reach = (&(-reach * d), n);
        let order = if *p == IBig::ZERO {
            sign_with_root(a, over_reach.0, n)
        } else {
            sign_with_roots(a, (&IBig::NEG_ONE, p), over_reach)
        };
        order != Ordering::Greater
    }

    fn bounds(&self) -> (IBig, IBig) {
        let Self { a, p, d, n } = self;
        // Roots in 256 more bits.
        let (a, p, n) = (a << 256, p << 512, n << 512);
        let lower = over_down(&(&a - root_up(&p)), &(root_up(&n) * d));
        let upper = over_up(&(a - root_down(&p)), &(root_down(&n) * d));
        (lower.max(IBig::ZERO), upper.max(IBig::ZERO))
    }
}
