//! The point of a simplex nearest to the origin, in integers.

use core::cmp::Ordering;

use super::numbers::{Vector, cross, dot, is_zero, negated, sign, square, sub, times};
use dashu_int::IBig;

/// The nearest point of a set of at most four points' convex hull.
pub(crate) struct Nearest {
    /// The indices of the points that span the nearest point, in ascending order.
    pub(crate) kept: Vec<usize>,
    /// Their weights, all positive.
    pub(crate) weights: Vec<IBig>,
    /// A positive multiple of the nearest point, or zero.
    pub(crate) direction: Vector,
    /// The square of its distance: numerator and positive denominator.
    pub(crate) square: (IBig, IBig),
}

/// The nearest point of the convex hull of one to four points. `newest` is the index of a point that is known to have a
/// positive weight.
///
/// The nearest point is in the relative interior of the hull of some affinely independent points, where it is the
/// nearest of their affine hull; and a point v of the hull is nearest if and only if `v . p >= v . v` for all points p.
pub(crate) fn nearest(points: &[Vector], newest: Option<usize>) -> Nearest {
    let all = 1_usize << points.len();
    // Triangles first: they are the most frequent.
    for size in [3, 2, 1, 4] {
        for subset in (1..all).filter(|subset| subset.count_ones() == size) {
            if newest.is_some_and(|i| subset & 1 << i == 0) {
                continue;
            }
            let kept: Vec<usize> = (0..points.len()).filter(|i| subset & 1 << i != 0).collect();
            let corners: Vec<&Vector> = kept.iter().map(|&i| &points[i]).collect();
            let Some((weights, direction, square)) = interior(&corners) else { continue };
            let reach = dot(&direction, corners[0]);
            let is_least = |i: usize| kept.contains(&i) || dot(&direction, &points[i]) >= reach;
            if is_zero(&direction) || (0..points.len()).all(is_least) {
                return Nearest { kept, weights, direction, square };
            }
        }
    }
    unreachable!("some face contains the nearest point")
}

/// Weights, direction and squared distance of the nearest point of an affine hull, if the points are independent and
/// the weights positive.
fn interior(p: &[&Vector]) -> Option<(Vec<IBig>, Vector, (IBig, IBig))> {
    let positive = |weights: Vec<IBig>| weights.iter().all(|w| *w > IBig::ZERO).then_some(weights);
    match *p {
        [p] => Some((vec![IBig::ONE], p.clone(), (square(p), IBig::ONE))),
        [p, q] => {
            let edge = sub(q, p);
            let weights = positive(vec![dot(&edge, q), -dot(&edge, p)])?;
            let direction = core::array::from_fn(|k| &weights[0] * &p[k] + &weights[1] * &q[k]);
            Some((weights, direction, (square(&cross(p, q)), square(&edge))))
        }
        [p, q, r] => {
            let normal = cross(&sub(q, p), &sub(r, p));
            if is_zero(&normal) {
                return None;
            }
            let part = |u: &Vector, v: &Vector| dot(&normal, &cross(u, v));
            let weights = positive(vec![part(q, r), part(r, p), part(p, q)])?;
            let height = dot(&normal, p);
            let direction = match sign(&height) {
                Ordering::Greater => normal.clone(),
                Ordering::Less => negated(&normal),
                Ordering::Equal => times(&normal, &IBig::ZERO),
            };
            Some((weights, direction, (&height * &height, square(&normal))))
        }
        [p, q, r, s] => {
            // The volumes of the simplices with one corner replaced by the origin.
            let (pq, rs) = (cross(p, q), cross(r, s));
            let mut weights = vec![dot(q, &rs), -dot(p, &rs), dot(s, &pq), -dot(r, &pq)];
            if weights[0] < IBig::ZERO {
                weights = weights.iter().map(|w| -w).collect();
            }
            let zero = || IBig::ZERO;
            Some((positive(weights)?, [zero(), zero(), zero()], (zero(), IBig::ONE)))
        }
        _ => unreachable!("one to four points"),
    }
}
