//! The point nearest to the origin of a simplex of at most four points.

use super::bodies::{plus, times};
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot};

/// Where a simplex lies relative to the origin.
#[derive(Debug)]
pub(super) enum NearestPoint {
    /// Its nearest point, a convex combination of its corners up to rounding, and a direction from the origin to it:
    /// for a triangle the normal, which stays accurate if the point is close to the origin.
    At(Point, Point),
    /// The origin is inside, farther from all planes of the faces than the error given.
    Inside,
    Unknown,
}

#[derive(Debug)]
pub(super) struct FilterSimplex {
    corners: [Point; 4],
    len: usize,
}

impl FilterSimplex {
    pub(super) const EMPTY: Self = Self { corners: [[0.0; 3]; 4], len: 0 };

    #[inline]
    pub(super) const fn new(corner: &Point) -> Self {
        Self { corners: [*corner; 4], len: 1 }
    }

    /// Adds a corner. Returns false if it is not new.
    #[inline]
    pub(super) fn add(&mut self, w: &Point) -> bool {
        if self.len == 4 || self.corners[..self.len].contains(w) {
            return false;
        }
        self.corners[self.len] = *w;
        self.len += 1;
        true
    }

    /// `error` bounds the error of the corners, which are at most `size` from the origin.
    ///
    /// Keeps only the corners of the smallest simplex that contains the nearest point.
    #[inline]
    pub(super) fn reduce(&mut self, size: f64, error: f64) -> NearestPoint {
        let [a, b, c, d] = self.corners;
        let nearest = match self.len {
            1 => (a, [a; 3], 1),
            2 => on_segment(&a, &b),
            3 => match on_triangle(&a, &b, &c) {
                Some(nearest) => nearest,
                None => return NearestPoint::Unknown,
            },
            _ => match on_tetrahedron([&a, &b, &c, &d], size, error) {
                Ok(nearest) => nearest,
                Err(is_inside) => {
                    return if is_inside { NearestPoint::Inside } else { NearestPoint::Unknown };
                }
            },
        };
        let (point, [x, y, z], len) = nearest;
        self.corners = [x, y, z, z];
        self.len = len;
        let direction = if len == 3 {
            let normal = cross(&difference(&y, &x), &difference(&z, &x));
            if dot(&normal, &x) < 0.0 { times(-1.0, &normal) } else { normal }
        } else {
            point
        };
        NearestPoint::At(point, direction)
    }
}

/// The nearest point, the corners that span it, and how many they are.
type NearestFeature = (Point, [Point; 3], usize);

#[inline]
fn on_segment(a: &Point, b: &Point) -> NearestFeature {
    let edge = difference(b, a);
    let (along, square) = (-dot(a, &edge), dot(&edge, &edge));
    if along <= 0.0 || along.is_nan() {
        (*a, [*a; 3], 1)
    } else if along >= square {
        (*b, [*b; 3], 1)
    } else {
        let t = along / square;
        (plus(a, &times(t, &edge)), [*a, *b, *b], 2)
    }
}

/// Ericson, *Real-Time Collision Detection*, 5.1.5. `None` if rounding contradicts itself: the triangle is too thin.
#[inline]
fn on_triangle(a: &Point, b: &Point, c: &Point) -> Option<NearestFeature> {
    let (x, y) = (difference(b, a), difference(c, a));
    let (d1, d2) = (-dot(&x, a), -dot(&y, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Some((*a, [*a; 3], 1));
    }
    let (d3, d4) = (-dot(&x, b), -dot(&y, b));
    if d3 >= 0.0 && d4 <= d3 {
        return Some((*b, [*b; 3], 1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return Some(on_segment(a, b));
    }
    let (d5, d6) = (-dot(&x, c), -dot(&y, c));
    if d6 >= 0.0 && d5 <= d6 {
        return Some((*c, [*c; 3], 1));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return Some(on_segment(a, c));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return Some(on_segment(b, c));
    }
    if !(va > 0.0 && vb > 0.0 && vc > 0.0) {
        return None;
    }
    // The weights are positive and their sum is at most 1 up to rounding, even where they are inaccurate.
    let one = 1.0 / ((va + vb) + vc);
    let (s, t) = (vb * one, vc * one);
    Some((plus(&plus(a, &times(s, &x)), &times(t, &y)), [*a, *b, *c], 3))
}

/// The nearest point on the faces that the origin is beyond; if there is none, whether the origin is certainly inside.
///
/// A simplex whose faces' planes are all farther than `error` from the origin on the inner side contains the origin
/// also if every corner moves by `error` or less: its support function is greater than `error` in every direction.
/// Corners are at most `size` from the origin. A triple product of their differences has an error of at most
/// 20 u (2 `size`)^3, which is less than `slack`.
#[inline]
fn on_tetrahedron(corners: [&Point; 4], size: f64, error: f64) -> Result<NearestFeature, bool> {
    let [a, b, c, d] = corners;
    let mut found: Option<(f64, NearestFeature)> = None;
    let slack = power_of_two(-45) * (size * size * size);
    let mut is_inside = true;
    for (p, q, r, s) in [(d, a, b, c), (d, b, c, a), (d, c, a, b), (a, c, b, d)] {
        let n = cross(&difference(q, p), &difference(r, p));
        let (height, depth) = (dot(&n, &difference(s, p)), -dot(&n, p));
        let (height, depth) = if height < 0.0 { (-height, -depth) } else { (height, depth) };
        if depth <= 0.0 {
            is_inside = false;
            if let Some(on) = on_triangle(p, q, r) {
                let square = dot(&on.0, &on.0);
                if !found.as_ref().is_some_and(|(least, _)| *least <= square) {
                    found = Some((square, on));
                }
            }
        }
        let sure = depth - slack;
        is_inside &= height > slack && sure > 0.0 && sure * sure > (4.0 * error * error) * dot(&n, &n);
    }
    found.map(|(_, found)| found).ok_or(is_inside)
}
