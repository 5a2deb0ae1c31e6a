//! The distance of two cores: exactly for polytopes, and between bounds for cylinders and cones, by the algorithm of
//! Gilbert, Johnson & Keerthi (1988) on points with integer coordinates.

use super::body::{Body, Hull, Pair, Round};
use super::numbers::{
    Vector, add, dot, is_zero, negated, over_down, root_down, root_up, shortened, square, sub, times,
};
use super::simplex::{Nearest, nearest};
use dashu_int::IBig;
use dashu_int::ops::Abs;

/// A point of the first core, and one of the second.
type Witness = [Vector; 2];

/// The square of the distance of two polytopes, as numerator and positive denominator. `start` has one to four
/// pairs of corners.
pub(crate) fn square_of_distance(a: &Hull, b: &Hull, start: &[[usize; 2]]) -> (IBig, IBig) {
    let difference = |[i, j]: [usize; 2]| sub(&a.corners[i], &b.corners[j]);
    let mut points: Vec<Vector> = start.iter().map(|&ends| difference(ends)).collect();
    let mut newest = None;
    loop {
        let Nearest { kept, direction, square, .. } = nearest(&points, newest);
        if is_zero(&direction) {
            return square;
        }
        points = kept.into_iter().map(|i| points[i].clone()).collect();
        let lowest = difference([a.farthest(&negated(&direction)), b.farthest(&direction)]);
        if dot(&direction, &lowest) >= dot(&direction, &points[0]) {
            return square;
        }
        newest = Some(points.len());
        points.push(lowest);
    }
}

pub(crate) fn touches_point(hull: &Hull, point: &Vector) -> bool {
    square_of_distance(hull, &Hull::point(point.clone()), &[[0, 0]]).0 == IBig::ZERO
}

/// Bounds of the distance of two cores.
pub(crate) struct Bounds {
    pub(crate) lower: IBig,
    pub(crate) upper: IBig,
    /// Whether a common point is known: then `upper` is 0.
    pub(crate) meets: bool,
}

/// Points of cylinders and cones are rounded: each is at most this many units from the solid.
const ROUNDING: i32 = 4;

/// Bits of a direction.
const DIRECTION: usize = 160;

/// The search stops after this many steps, with the current bounds.
const MAX_STEPS: usize = 2000;

/// Refines bounds of the distance until `is_enough(lower, upper)`, as far as the unit allows. `start` has one to four
/// directions, from the first core to the second.
pub(crate) fn refine(
    pair: &Pair,
    start: &[Vector],
    mut is_enough: impl FnMut(&IBig, &IBig) -> bool,
) -> Bounds {
    let support = |towards: &Vector| -> Witness {
        [pair.a.farthest_point(towards), pair.b.farthest_point(&negated(towards))]
    };
    let mut witnesses: Vec<Witness> = start.iter().map(support).collect();
    let mut bounds = Bounds { lower: IBig::ZERO, upper: IBig::ZERO, meets: false };
    let mut steps = 0;
    let mut newest = None;
    // Two points are rounded, and the root is.
    let slack = IBig::from(2 * ROUNDING + 1);
    loop {
        let points: Vec<Vector> = witnesses.iter().map(|[p, q]| sub(p, q)).collect();
        let Nearest { kept, weights, direction, square: (numerator, denominator) } = nearest(&points, newest);
        bounds.upper = root_down(&(numerator / denominator)) + &slack;
        steps += 1;
        witnesses = kept.iter().map(|&i| witnesses[i].clone()).collect();
        let direction = shortened(&direction, DIRECTION);
        // Zero if the two touch up to rounding.
        let is_over = is_zero(&direction) || bounds.upper <= &slack * 2;
        if !is_over {
            let lower = pair.lower_bound(&direction);
            if lower > bounds.lower {
                bounds.lower = lower;
            }
        }
        if is_over && bounds.lower == IBig::ZERO {
            bounds.meets = pair.has_common_point(&witnesses, &weights);
            if bounds.meets {
                bounds.upper = IBig::ZERO;
            }
        }
        if is_over || steps == MAX_STEPS || is_enough(&bounds.lower, &bounds.upper) {
            return bounds;
        }
        let lowest = support(&negated(&direction));
        if witnesses.contains(&lowest) {
            return bounds;
        }
        newest = Some(witnesses.len());
        let point = sub(&lowest[0], &lowest[1]);
        if dot(&direction, &point) >= dot(&direction, &sub(&witnesses[0][0], &witnesses[0][1])) {
            return bounds;
        }
        witnesses.push(lowest);
    }
}

impl Pair {
    /// A lower bound of the distance: that of the projections on a direction from the second core to the first.
    fn lower_bound(&self, direction: &Vector) -> IBig {
        // In 64 more bits.
        let extent = |body: &Body, towards: &Vector| match body {
            Body::Hull(hull) => dot(towards, &hull.corners[hull.farthest(towards)]) << 64,
            Body::Round(round) => round.extent_up(towards),
            Body::HalfSpace(_) => unreachable!("half-spaces have a closed form"),
        };
        let gap = -(extent(&self.a, &negated(direction)) + extent(&self.b, direction));
        if gap <= IBig::ZERO { IBig::ZERO } else { over_down(&gap, &root_up(&(square(direction) << 128))) }
    }

    /// Whether the points that the weights give, or points near them towards the middles, are in both cores. The
    /// weighted sums of the two cores' points are equal up to rounding.
    fn has_common_point(&self, witnesses: &[Witness], weights: &[IBig]) -> bool {
        let total: IBig = weights.iter().sum();
        let sum = |side: usize| {
            let zero = core::array::from_fn(|_| IBig::ZERO);
            witnesses.iter().zip(weights).fold(zero, |sum, (w, by)| add(&sum, &times(&w[side], by)))
        };
        let point = sum(0);
        // Only as many bits of large numbers as coordinates have, and 64 more.
        let (point, total) = {
            let scaled = point.each_ref().map(|x| over_down(&(x << 64), &total));
            (scaled, IBig::ONE << 64)
        };
        if self.contain(&point, &total) {
            return true;
        }
        let middles = [&self.a, &self.b].map(Body::middle_doubled);
        let both = add(&middles[0], &middles[1]);
        let goals = [add(&middles[0], &middles[0]), add(&middles[1], &middles[1]), both];
        // point + (goal / 4 - point) / 2^k
        (2..self.bits + 32).step_by(3).any(|k| {
            goals.iter().any(|goal| {
                let step = sub(&times(goal, &total), &times(&point, &IBig::from(4)));
                let moved = add(&times(&point, &(IBig::from(4) << k)), &step);
                self.contain(&moved, &(&total << (k + 2)))
            })
        })
    }

    fn contain(&self, point: &Vector, by: &IBig) -> bool {
        [&self.a, &self.b].iter().all(|body| match body {
            Body::Hull(hull) => {
                let corner = |p: &Vector| times(p, by);
                let corners = hull.corners.iter().map(corner).collect();
                let edges = hull.edges.iter().map(corner).collect();
                let is_triangle = hull.is_triangle;
                touches_point(&Hull { corner: corner(&hull.corner), edges, is_triangle, corners }, point)
            }
            Body::Round(round) => round.contains(point, by),
            Body::HalfSpace(_) => unreachable!("half-spaces have a closed form"),
        })
    }
}

impl Body {
    /// A point that is farthest in a direction, for cylinders and cones up to [`ROUNDING`].
    fn farthest_point(&self, towards: &Vector) -> Vector {
        match self {
            Self::Hull(hull) => hull.corners[hull.farthest(towards)].clone(),
            Self::Round(round) => round.farthest_point(towards),
            Self::HalfSpace(_) => unreachable!("half-spaces have a closed form"),
        }
    }

    /// Twice a point in the interior, if there is one.
    fn middle_doubled(&self) -> Vector {
        match self {
            Self::Hull(hull) => {
                let edges = hull.edges.iter();
                edges.fold(add(&hull.corner, &hull.corner), |sum, edge| add(&sum, edge))
            }
            Self::Round(Round { is_cone, middle, axis, .. }) => {
                let twice = add(middle, middle);
                // For a cone, the middle of its height.
                if *is_cone { add(&twice, axis) } else { twice }
            }
            Self::HalfSpace(_) => unreachable!("half-spaces have a closed form"),
        }
    }
}

impl Round {
    fn farthest_point(&self, towards: &Vector) -> Vector {
        let (full, along) = (square(&self.axis), dot(&self.axis, towards));
        let across = sub(&times(towards, &full), &times(&self.axis, &along));
        let rim = {
            // At least 320 bits, so that the quotient is off by less than one unit. A multiple of the vector will do.
            let across = times(&across, &(IBig::ONE << 400));
            let length = root_down(&square(&across));
            if length == IBig::ZERO {
                across
            } else {
                across.each_ref().map(|x| over_down(&(x * &self.radius), &length))
            }
        };
        let is_up = along >= IBig::ZERO;
        if !self.is_cone {
            let disc = if is_up { self.end() } else { sub(&self.middle, &self.axis) };
            return add(&disc, &rim);
        }
        // The tip is higher by the axis, and the rim by r |across| / U.
        let tip_is_farther = is_up && {
            let over = &self.radius * &self.radius * square(&across);
            &along * &along * &full * &full >= over
        };
        if tip_is_farther { self.end() } else { add(&self.middle, &rim) }
    }

    /// The largest `towards . p` of its points, in 64 more bits and rounded up.
    fn extent_up(&self, towards: &Vector) -> IBig {
        let (full, along) = (square(&self.axis), dot(&self.axis, towards));
        let across = square(towards) * &full - &along * &along;
        let rim_square = ((&self.radius * &self.radius * across) << 128) / &full;
        let rim = root_up(&(rim_square + 1));
        let middle = dot(towards, &self.middle) << 64;
        if self.is_cone {
            let tip = &middle + (along << 64);
            tip.max(middle + rim)
        } else {
            middle + (along.abs() << 64) + rim
        }
    }
}
