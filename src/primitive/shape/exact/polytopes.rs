//! Polytopes against each other.

use super::integers::{
    Degree1, Degree2, Degree3, Degree4, Degree6, cross, difference, dot, is_at_most, is_zero, one,
};
use super::polytope::ExactPolytope;
use crate::exact::wide::Wide;

/// Whether two polytopes have a common point: whether no axis separates them.
///
/// If their projections on some axis have no common point, they have none. It remains to show that the axes tested are
/// enough. Let E be the directions of the edges of both. The two have a common point if and only if the origin is in
/// their Minkowski difference D, a polytope whose edges are parallel to vectors of E. If the origin is not in D, one of
/// these separates:
/// * D has a volume: the normal of a facet, which is the cross product of two edges.
/// * D is in a plane: the plane's normal n, the cross product of two edges; or the normal in the plane of an edge e,
///   which is n x e.
/// * D is on a line along e: e; or, if the origin is not on the line, the perpendicular of the line through it. With d
///   from the origin to a point of D, that is e x (e x d).
/// * D is a point d: d.
#[inline(never)]
pub(super) fn meet(a: &ExactPolytope, b: &ExactPolytope) -> bool {
    let mut directions = [[Degree1::ZERO; 3]; 6];
    let mut count = 0;
    for (place, direction) in directions.iter_mut().zip(a.directions().chain(b.directions())) {
        *place = direction;
        count += 1;
    }
    let directions = &directions[..count];
    let mut is_on_line = true;
    for (i, u) in directions.iter().enumerate() {
        for v in &directions[..i] {
            let normal: [Degree2; 3] = cross(u, v);
            if is_zero(&normal) {
                continue;
            }
            is_on_line = false;
            if separates(&normal, a, b) {
                return false;
            }
            let is_flat = directions.iter().all(|e| dot::<20, 10, 30>(&normal, e).sign() == 0);
            let separates_in_plane = |e: &[Degree1; 3]| separates::<30>(&cross(&normal, e), a, b);
            if is_flat && directions.iter().any(separates_in_plane) {
                return false;
            }
        }
    }
    if is_on_line {
        let between = difference(&a.corners()[0], &b.corners()[0]);
        let separates_on_line = |e: &[Degree1; 3]| {
            let normal: [Degree2; 3] = cross(e, &between);
            separates(e, a, b) || separates::<30>(&cross(e, &normal), a, b)
        };
        if separates(&between, a, b) || directions.iter().any(separates_on_line) {
            return false;
        }
    }
    true
}

/// Whether the projections on an axis, of degree three at most, have no common point.
#[inline(never)]
fn separates<const L: usize>(axis: &[Wide<L>; 3], a: &ExactPolytope, b: &ExactPolytope) -> bool {
    let (a, b) = (projection(axis, a), projection(axis, b));
    !is_at_most(&a[0], &b[1]) || !is_at_most(&b[0], &a[1])
}

/// The least and the greatest of a projection.
#[inline(never)]
fn projection<const L: usize>(axis: &[Wide<L>; 3], p: &ExactPolytope) -> [Degree4; 2] {
    let mut range = [dot(axis, &p.corners()[0]); 2];
    for corner in &p.corners()[1..] {
        let x: Degree4 = dot(axis, corner);
        if is_at_most(&x, &range[0]) {
            range[0] = x;
        } else if is_at_most(&range[1], &x) {
            range[1] = x;
        }
    }
    range
}

/// Whether two polytopes without a common point are at most `reach` apart.
///
/// Each candidate is the distance of a point of one from a point of the other, and the least distance is among them:
/// The nearest points are in corners, inside edges or inside faces, since the polytopes or their surfaces are unions
/// of these. Of all pairs of nearest points, take one whose two features have the least sum of dimensions. The
/// features have no common direction, along which both points could be moved to the border of one. Both features are
/// perpendicular to the line between the points. So they are two corners, a corner and an edge, a corner and a face,
/// or two edges that are not parallel, and the points are the feet of their common perpendicular.
#[inline(never)]
pub(super) fn is_near(a: &ExactPolytope, b: &ExactPolytope, reach: &Degree1) -> bool {
    let square: Degree2 = reach.times(reach);
    let near_corners = a.corners().iter().any(|p| {
        b.corners().iter().any(|q| {
            let between = difference(p, q);
            is_at_most(&dot(&between, &between), &square)
        })
    });
    near_corners
        || has_corner_near_edge(a, b, &square)
        || has_corner_near_edge(b, a, &square)
        || has_corner_near_face(a, b, &square)
        || has_corner_near_face(b, a, &square)
        || has_near_edges(a, b, &square)
}

#[inline(never)]
fn has_corner_near_edge(a: &ExactPolytope, b: &ExactPolytope, square: &Degree2) -> bool {
    b.edges().any(|(from, edge)| {
        let length: Degree2 = dot(&edge, &edge);
        a.corners().iter().any(|p| {
            let to_corner = difference(p, from);
            let along: Degree2 = dot(&to_corner, &edge);
            if along.sign() <= 0 || is_at_most(&length, &along) {
                return false;
            }
            let moment: [Degree2; 3] = cross(&to_corner, &edge);
            is_at_most::<40>(&dot(&moment, &moment), &square.times(&length))
        })
    })
}

#[inline(never)]
fn has_corner_near_face(a: &ExactPolytope, b: &ExactPolytope, square: &Degree2) -> bool {
    b.faces().filter(|face| !is_zero(&face.normal)).any(|face| {
        let length: Degree4 = dot(&face.normal, &face.normal);
        let limit: Degree6 = square.times(&length);
        a.corners().iter().any(|p| {
            let height: Degree3 = dot(&face.normal, &difference(p, face.corner()));
            is_at_most(&height.times(&height), &limit) && face.is_over::<10, 10, 40>(p, &one())
        })
    })
}

#[inline(never)]
fn has_near_edges(a: &ExactPolytope, b: &ExactPolytope, square: &Degree2) -> bool {
    a.edges().any(|(p, u)| {
        b.edges().any(|(q, v)| {
            let normal: [Degree2; 3] = cross(&u, &v);
            if is_zero(&normal) {
                return false;
            }
            let length: Degree4 = dot(&normal, &normal);
            let between = difference(q, p);
            let height: Degree3 = dot(&normal, &between);
            // The feet are `p + s / length u` and `q + t / length v`.
            let share = |e: &[Degree1; 3]| {
                let moment: [Degree2; 3] = cross(&between, e);
                let share: Degree4 = dot(&moment, &normal);
                share.sign() >= 0 && is_at_most(&share, &length)
            };
            is_at_most::<60>(&height.times(&height), &square.times(&length)) && share(&v) && share(&u)
        })
    })
}
