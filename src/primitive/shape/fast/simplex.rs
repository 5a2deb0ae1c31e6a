//! The point nearest to the origin of a simplex of at most four points.

use super::bodies::{plus, times};
use crate::range::Point;
use crate::vector::{cross, difference, dot};

/// Where a simplex is.
#[derive(Debug)]
pub(super) enum Nearest {
    /// Its nearest point: a convex combination of its corners up to rounding.
    At(Point),
    /// The origin is inside, farther from all planes of the faces than the error given.
    Inside,
    Unknown,
}

#[derive(Debug)]
pub(super) struct Simplex {
    corners: [Point; 4],
    len: usize,
}

impl Simplex {
    pub(super) const EMPTY: Self = Self { corners: [[0.0; 3]; 4], len: 0 };

    /// Whether the corner is new.
    #[inline]
    pub(super) fn add(&mut self, w: &Point) -> bool {
        if self.len == 4 || self.corners[..self.len].contains(w) {
            return false;
        }
        self.corners[self.len] = *w;
        self.len += 1;
        true
    }

    /// Keeps only the corners of the smallest simplex that contains the nearest point.
    #[inline]
    pub(super) fn reduce(&mut self, error: f64) -> Nearest {
        let [a, b, c, d] = self.corners;
        let nearest = match self.len {
            1 => (a, [a; 3], 1),
            2 => on_segment(&a, &b),
            3 => on_triangle(&a, &b, &c),
            _ => match on_tetrahedron(&a, &b, &c, &d, error) {
                Ok(nearest) => nearest,
                Err(is_inside) => {
                    return if is_inside { Nearest::Inside } else { Nearest::Unknown };
                }
            },
        };
        let (point, [x, y, z], len) = nearest;
        self.corners = [x, y, z, z];
        self.len = len;
        Nearest::At(point)
    }
}

/// The nearest point, the corners that span it, and how many they are.
type Found = (Point, [Point; 3], usize);

#[inline]
fn on_segment(a: &Point, b: &Point) -> Found {
    let edge = difference(b, a);
    let (along, square) = (-dot(a, &edge), dot(&edge, &edge));
    if !(along > 0.0) {
        (*a, [*a; 3], 1)
    } else if along >= square {
        (*b, [*b; 3], 1)
    } else {
        let t = along / square;
        (plus(a, &times(t, &edge)), [*a, *b, *b], 2)
    }
}

/// Ericson, *Real-Time Collision Detection*, 5.1.5.
#[inline]
fn on_triangle(a: &Point, b: &Point, c: &Point) -> Found {
    let (x, y) = (difference(b, a), difference(c, a));
    let (d1, d2) = (-dot(&x, a), -dot(&y, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, [*a; 3], 1);
    }
    let (d3, d4) = (-dot(&x, b), -dot(&y, b));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, [*b; 3], 1);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_segment(a, b);
    }
    let (d5, d6) = (-dot(&x, c), -dot(&y, c));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, [*c; 3], 1);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_segment(a, c);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return on_segment(b, c);
    }
    let one = 1.0 / ((va + vb) + vc);
    let (s, t) = (vb * one, vc * one);
    (plus(&plus(a, &times(s, &x)), &times(t, &y)), [*a, *b, *c], 3)
}

/// The nearest point on the faces that the origin is beyond; if there is none, whether the origin is certainly inside.
///
/// A simplex whose faces' planes are all farther than `error` from the origin on the inner side contains the origin
/// also if every corner moves by `error` or less.
#[inline]
fn on_tetrahedron(a: &Point, b: &Point, c: &Point, d: &Point, error: f64) -> Result<Found, bool> {
    let mut found: Option<(f64, Found)> = None;
    let mut is_inside = true;
    for (p, q, r, s) in [(d, a, b, c), (d, b, c, a), (d, c, a, b), (a, c, b, d)] {
        let n = cross(&difference(q, p), &difference(r, p));
        let (height, depth) = (dot(&n, &difference(s, p)), -dot(&n, p));
        let depth = if height < 0.0 { -depth } else { depth };
        if depth <= 0.0 {
            let on = on_triangle(p, q, r);
            let square = dot(&on.0, &on.0);
            if !found.as_ref().is_some_and(|(least, _)| *least <= square) {
                found = Some((square, on));
            }
        }
        is_inside &= depth * depth > (4.0 * error * error) * dot(&n, &n);
    }
    match found {
        Some((_, found)) => Ok(found),
        None => Err(is_inside),
    }
}
