//! Coplanar pairs, and triangles that are only a segment or a point.
//!
//! Rare and never on the fast path, so written with as few cases as possible. A triangle without area is the union of
//! its edges, so its edges represent it everywhere.

use super::sides::{Signs, Triangle, UNIT_ROUNDOFF, sign};
use crate::exact::determinant;
use crate::range::Point;

/// Relative error bound of a 2 by 2 determinant of differences: `ccwerrboundA` of the paper cited at
/// [`DETERMINANT_ERROR`](super::sides::DETERMINANT_ERROR).
pub(super) const AREA_ERROR: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

const EDGES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// The two coordinates that each projection along an axis keeps.
pub(super) const PROJECTIONS: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// The test for a pair in which all vertices of one triangle are on the other's plane, or the other has no plane.
///
/// `a_sides` are the sides of `b`'s plane on which `a`'s vertices lie, and `b_sides` the reverse; neither separates the
/// pair.
#[cold]
pub(super) fn overlap(
    a: &Triangle,
    b: &Triangle,
    a_sides: [i8; 3],
    b_sides: [i8; 3],
    signs: &mut Signs,
) -> bool {
    if b_sides != [0; 3] {
        return some_edge_pierces(b, b_sides, a, signs);
    }
    if a_sides != [0; 3] {
        return some_edge_pierces(a, a_sides, b, signs);
    }
    // Both have an area and share a plane; or one has no area and lies in the other's plane; or neither has an area.
    if has_no_area(a, signs) && has_no_area(b, signs) && skew(a, b, signs) {
        return false;
    }
    overlap_in_plane(a, b, signs)
}

/// Whether `thin`, which has no area, meets `t`. `sides` are the sides of `t`'s plane on which its vertices lie, not
/// all zero.
///
/// An edge of `thin` with both ends in the plane is a single point, since the line through `thin` leaves the plane. A
/// neighbouring edge has this point as an end, so edges that meet the plane in just one point suffice.
fn some_edge_pierces(thin: &Triangle, sides: [i8; 3], t: &Triangle, signs: &mut Signs) -> bool {
    EDGES.iter().any(|&(i, j)| {
        let (s, r) = (sides[i], sides[j]);
        s != r && s * r <= 0 && line_meets(&thin[i], &thin[j], t, signs)
    })
}

/// Whether the line through `p` and `q`, which crosses the plane of `t`, meets `t`: it passes all edges on the same
/// side.
fn line_meets(p: &Point, q: &Point, t: &Triangle, signs: &mut Signs) -> bool {
    let around = EDGES.map(|(i, j)| signs.side(&[*p, *q, t[i]], &t[j]));
    around.iter().all(|s| *s >= 0) || around.iter().all(|s| *s <= 0)
}

/// Whether a triangle has no area: none of its projections has any.
pub(super) fn has_no_area([p, q, r]: &Triangle, signs: &mut Signs) -> bool {
    PROJECTIONS.iter().all(|&plane| signs.area(plane, p, q, r) == 0)
}

/// Whether two triangles without area are not coplanar.
fn skew(a: &Triangle, b: &Triangle, signs: &mut Signs) -> bool {
    let ([p, q], [r, s]) = (extremes(a), extremes(b));
    signs.side(&[*p, *q, *r], s) != 0
}

/// The least and the greatest point in lexicographic order. Of collinear points these are the extreme ones, because the
/// order is monotone along a line.
pub(super) fn extremes([p, q, r]: &Triangle) -> [&Point; 2] {
    [least(least(p, q), r), greatest(greatest(p, q), r)]
}

pub(super) fn least<'a>(p: &'a Point, q: &'a Point) -> &'a Point {
    if q < p { q } else { p }
}

pub(super) fn greatest<'a>(p: &'a Point, q: &'a Point) -> &'a Point {
    if q > p { q } else { p }
}

/// Whether two triangles in one plane meet; each may also be a segment or a point.
fn overlap_in_plane(a: &Triangle, b: &Triangle, signs: &mut Signs) -> bool {
    let ([a_low, a_high], [b_low, b_high]) = (extremes(a), extremes(b));
    let (low, high) = (least(a_low, b_low), greatest(a_high, b_high));
    // A projection of a plane is injective if three of its points do not become collinear.
    let upright = PROJECTIONS
        .into_iter()
        .find(|&plane| a.iter().chain(b).any(|p| signs.area(plane, low, high, p) != 0));
    match upright {
        Some(plane) => Flat { plane, signs }.polygons_meet(a, b),
        // All points lie on one line, or are the same.
        None => a_low <= b_high && b_low <= a_high,
    }
}

/// Predicates within a plane, under an injective projection.
struct Flat<'a> {
    plane: (usize, usize),
    signs: &'a mut Signs,
}

impl Flat<'_> {
    fn area(&mut self, p: &Point, q: &Point, r: &Point) -> i8 {
        self.signs.area(self.plane, p, q, r)
    }

    /// Whether the boundaries meet or one triangle is inside the other.
    fn polygons_meet(&mut self, a: &Triangle, b: &Triangle) -> bool {
        EDGES.iter().any(|&(i, j)| EDGES.iter().any(|&(k, l)| self.segments_meet(&a[i], &a[j], &b[k], &b[l])))
            || self.inside(&a[0], b)
            || self.inside(&b[0], a)
    }

    /// Whether `p` is in the interior of `t`. Always false for a `t` without area.
    fn inside(&mut self, p: &Point, t: &Triangle) -> bool {
        let around = EDGES.map(|(i, j)| self.area(&t[i], &t[j], p));
        around == [1; 3] || around == [-1; 3]
    }

    /// Whether the closed segments `pq` and `rs` meet; each may be a point.
    fn segments_meet(&mut self, p: &Point, q: &Point, r: &Point, s: &Point) -> bool {
        let (of_r, of_s) = (self.area(p, q, r), self.area(p, q, s));
        if of_r * of_s > 0 {
            return false;
        }
        let (of_p, of_q) = (self.area(r, s, p), self.area(r, s, q));
        if [of_r, of_s, of_p, of_q] == [0; 4] {
            // All on one line, or two points.
            return greatest(p, q) >= least(r, s) && greatest(r, s) >= least(p, q);
        }
        of_p * of_q <= 0
    }
}

impl Signs {
    /// The sign of the area of a projected triangle, positive if counterclockwise.
    pub(super) fn area(&mut self, (x, y): (usize, usize), p: &Point, q: &Point, r: &Point) -> i8 {
        let (plus, minus) = ((p[x] - r[x]) * (q[y] - r[y]), (p[y] - r[y]) * (q[x] - r[x]));
        let (determinant, permanent) = (plus - minus, plus.abs() + minus.abs());
        if determinant.abs() > AREA_ERROR * permanent {
            return sign(determinant);
        }
        // Nothing underflows, so products that vanish have a factor that is exactly zero.
        if permanent == 0.0 || p == q {
            return 0;
        }
        self.exact = true;
        determinant::area([p, q, r].map(|p| [p[x], p[y]]))
    }
}
