//! Balls against balls and triangles: compares squared lengths, in integers where rounding could matter.

use super::integers::{cross, difference, dot as exact_dot, integers, sign};
use super::rough::Rough;
use crate::selftest::draw::{add, dot, minus, scaled};
use core::cmp::Ordering;
use dashu_int::IBig;
use simdop::primitive::Sphere;
use simdop::primitive::triangle::Triangle;
use simdop::range::Point;

/// Relative bound, 2^-44, on the effect of rounding on a length, or on a point of a triangle.
const FILTER: f64 = 256.0 * f64::EPSILON;

/// Whether two balls meet: exact, for the given centres and radii.
pub(super) fn balls_meet(a: &Sphere, b: &Sphere) -> bool {
    let [p, q, [r, s, _]] = integers([a.centre, b.centre, [a.radius, b.radius, 0.0]]);
    let (way, reach) = (difference(&p, &q), r + s);
    exact_dot(&way, &way) <= &reach * &reach
}

/// Whether two balls meet, for all positions of a centre within `moved` of the given one, in each coordinate.
pub(super) fn rough_balls(a: &Sphere, b: &Sphere, moved: f64) -> Rough {
    let between = length(&minus(&a.centre, &b.centre));
    let reach = a.radius + b.radius;
    let error = FILTER * (between + reach) + 2.0 * moved;
    decided(between - reach, between - reach, error)
}

/// Exact. The distance of a point from a triangle is the least of its distances from the corners, from the edges
/// between whose ends it projects, and from the plane if it is over the face.
pub(super) fn ball_meets_triangle(ball: &Sphere, t: &Triangle) -> bool {
    let [p, q, r, centre, [radius, _, _]] =
        integers([t[0], t[1], t[2], ball.centre, [ball.radius, 0.0, 0.0]]);
    let (corners, square) = ([p, q, r], &radius * &radius);
    let ways = corners.each_ref().map(|corner| difference(&centre, corner));
    let edges = [0, 1, 2].map(|i| difference(&corners[(i + 1) % 3], &corners[i]));
    for i in 0..3 {
        let to_corner = exact_dot(&ways[i], &ways[i]);
        if to_corner <= square {
            return true;
        }
        let (along, length) = (exact_dot(&ways[i], &edges[i]), exact_dot(&edges[i], &edges[i]));
        let is_between = sign(&along) == Ordering::Greater && along < length;
        if is_between && (to_corner - &square) * length <= &along * &along {
            return true;
        }
    }
    let normal = cross(&edges[0], &edges[1]);
    let is_over = |i: usize| exact_dot(&normal, &cross(&edges[i], &ways[i])) >= IBig::ZERO;
    let height = exact_dot(&normal, &ways[0]);
    let length = exact_dot(&normal, &normal);
    length > IBig::ZERO && (0..3).all(is_over) && &height * &height <= square * length
}

/// Whether a ball meets a triangle, for all positions of the centre, or of the corners, within `moved` of the given
/// ones, in each coordinate.
pub(super) fn rough_ball_and_triangle(ball: &Sphere, t: &Triangle, moved: f64) -> Rough {
    let corners = t.map(|p| minus(&p, &ball.centre));
    let nearest = nearest_to_origin(&corners);
    let size = corners.iter().map(length).fold(ball.radius, f64::max);
    let upper = length(&nearest);
    // The whole triangle is at least this far along the direction to the point that seems nearest.
    let lower = corners.iter().map(|p| dot(p, &nearest)).fold(f64::INFINITY, f64::min) / upper;
    // Treat NaN and infinity as no gap: then only the upper bound can decide.
    let lower = if lower.is_finite() { lower } else { 0.0 };
    decided(lower - ball.radius, upper - ball.radius, FILTER * size + 2.0 * moved)
}

/// Decides by bounds on a gap, each of which may be off by the error.
fn decided(lower: f64, upper: f64, error: f64) -> Rough {
    if lower > error {
        Rough::Apart
    } else if upper < -error {
        Rough::Together
    } else {
        Rough::Doubt
    }
}

fn length(p: &Point) -> f64 {
    dot(p, p).sqrt()
}

/// A point of the triangle, up to rounding: approximately the one nearest to the origin.
fn nearest_to_origin(corners: &Triangle) -> Point {
    let edges = [0, 1, 2].map(|i| minus(&corners[(i + 1) % 3], &corners[i]));
    let [u, v] = [edges[0], scaled(&edges[2], -1.0)];
    let (uu, uv, vv) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
    let (pu, pv) = (-dot(&corners[0], &u), -dot(&corners[0], &v));
    let area = uu * vv - uv * uv;
    let (s, t) = ((pu * vv - pv * uv) / area, (pv * uu - pu * uv) / area);
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return add(&corners[0], &add(&scaled(&u, s), &scaled(&v, t)));
    }
    let on_edge = |i: usize| {
        let share = -dot(&corners[i], &edges[i]) / dot(&edges[i], &edges[i]);
        // For an edge of length zero, its corner.
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        add(&corners[i], &scaled(&edges[i], share))
    };
    let points = [0, 1, 2].map(on_edge);
    points.into_iter().min_by(|p, q| dot(p, p).total_cmp(&dot(q, q))).unwrap_or(corners[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::draw::Draw;

    fn ball(centre: Point, radius: f64) -> Sphere {
        Sphere { centre, radius }
    }

    #[test]
    fn balls_made_by_hand() {
        let unit = ball([0.0; 3], 1.0);
        let meets = |other: Sphere| {
            let answer = balls_meet(&unit, &other);
            assert_eq!(answer, balls_meet(&other, &unit));
            assert_ne!(rough_balls(&unit, &other, 0.0), if answer { Rough::Apart } else { Rough::Together });
            answer
        };
        // 2, 3, 6 and 7 are a box and its diagonal.
        assert!(meets(ball([2.0, 3.0, 6.0], 6.0)) && !meets(ball([2.0, 3.0, 6.0], 6.0_f64.next_down())));
        assert!(!meets(ball([2.0, 3.0, 6.0_f64.next_up()], 6.0)));
        assert!(meets(ball([0.1, 0.0, 0.0], 0.0)), "inside");
        assert!(meets(ball([0.0; 3], 1e9)), "around");
        assert!(meets(ball([1.0, 0.0, 0.0], 0.0)) && !meets(ball([1.0_f64.next_up(), 0.0, 0.0], 0.0)));
    }

    const T: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn meets(centre: Point, radius: f64) -> bool {
        let ball = ball(centre, radius);
        let answer = ball_meets_triangle(&ball, &T);
        let other = [T[1], T[0], T[2]];
        assert_eq!(answer, ball_meets_triangle(&ball, &other), "turned over");
        let wrong = if answer { Rough::Apart } else { Rough::Together };
        assert_ne!(rough_ball_and_triangle(&ball, &T, 0.0), wrong);
        answer
    }

    #[test]
    fn balls_on_a_triangle() {
        let less = |r: f64| r.next_down();
        assert!(meets([1.0, 1.0, 3.0], 3.0) && !meets([1.0, 1.0, 3.0], less(3.0)), "above the face");
        assert!(meets([2.0, -3.0, 4.0], 5.0) && !meets([2.0, -3.0, 4.0], less(5.0)), "beside an edge");
        assert!(meets([-2.0, -3.0, 6.0], 7.0) && !meets([-2.0, -3.0, 6.0], less(7.0)), "beyond a corner");
        assert!(meets([3.0, 3.0, 1.0], 2.0), "beyond the long edge");
        assert!(!meets([3.0, 3.0, 1.0], 1.7), "the root of three away");
        assert!(meets([1.0, 1.0, 0.0], 0.0) && !meets([3.0, 3.0, 0.0], 0.0), "points");
    }

    /// Compares with the smallest distance to points scattered over the triangle.
    #[test]
    fn bounds_are_right_for_any_triangle() {
        let mut draw = Draw::new(7, "", 0, false);
        let mut counts = [0; 3];
        for i in 0..3000 {
            let mut point = || -> Point { core::array::from_fn(|_| draw.range(-1.0, 1.0)) };
            let (mut t, centre) = ([point(), point(), point()], point());
            if i % 10 == 0 {
                t[2] = t[0];
            }
            let ball = ball(centre, draw.range(0.0, 1.0));
            let exact = ball_meets_triangle(&ball, &t);
            let mut least = f64::INFINITY;
            for (i, j) in (0..=40).flat_map(|i| (0..=40 - i).map(move |j| (i, j))) {
                let (s, u) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                let p: Point =
                    core::array::from_fn(|k| t[0][k] * (1.0 - s - u) + t[1][k] * s + t[2][k] * u - centre[k]);
                least = least.min(length(&p));
            }
            // Any point of the triangle has one of these within a fortieth of the longest edge, which is at most the
            // root of 12.
            assert!(if exact { least < ball.radius + 0.09 } else { least > ball.radius }, "{t:?} {ball:?}");
            let moved = draw.pick(&[0.0, 1e-9, 0.01]);
            match rough_ball_and_triangle(&ball, &t, moved) {
                Rough::Doubt => counts[0] += 1,
                certain => {
                    counts[1 + usize::from(exact)] += 1;
                    assert_eq!(certain == Rough::Together, exact);
                    let centre = ball.centre.map(|x| x + draw.range(-moved, moved));
                    assert_eq!(ball_meets_triangle(&Sphere { centre, ..ball }, &t), exact);
                }
            }
        }
        assert!(counts[0] < 200 && counts[1] > 500 && counts[2] > 500, "{counts:?}");
    }
}
