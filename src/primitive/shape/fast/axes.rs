//! A cuboid against a cuboid or a triangle, by separating axes.
//!
//! In the coordinates along the half edges of A, which is then the cube of all points with coordinates in -1 ..= 1, B
//! is a parallelepiped with the centre t and the half edges r. Axes are linear forms: nothing needs right angles. The
//! 15 axes are the coordinates, the cross products of two columns of r, and those of a coordinate axis and a column.
//!
//! **Errors.** Let q be `size` divided by less than the least height of A over its faces, so that q >= 1 bounds all
//! magnitudes of t and r. They are quotients of triple products: their errors are below 32 u q. A 2 x 2 minor errs by
//! less than 2^8 u q^2, and a triple product by less than 2^11 u q^3. A gap of more than 2^-44 q, 2^-42 q^2 or
//! 2^-40 q^3, by the degree of the axis, separates.
//!
//! **Nearly parallel edges** have an axis along which gap and overlap are both about zero. If two coordinates of a
//! column are at most `PARALLEL`, that axis is left out. Setting these coordinates of B to zero removes the axis, and
//! changes the support function of B by at most 3 `PARALLEL` times the sum of the magnitudes of a form, for all three
//! columns together. The greatest such sum of an axis is 1, 2 q or 6 q^2, and the coefficients of the other axes
//! change by `PARALLEL`, 4 q `PARALLEL` and so on. Overlaps of more than 2^-26 q, 2^-25 q^2 and 2^-22 q^3 exceed all
//! of this, so that the difference of A and B contains the origin.
//!
//! **A triangle** as B has a corner t and two edges from it, whose coordinates err by less than 2^-48 q. The 13 axes
//! are the coordinates, the cross product of two edges, and those of a coordinate axis and an edge. Let w >= 1 bound
//! the magnitudes of the coordinates of all corners and edges. Then the forms of edges err by less than 2^-43 q w, and
//! that of the cross product by less than 2^-42 q w^2. An edge that is nearly parallel to a coordinate axis becomes
//! parallel if one of its corners is moved by at most `PARALLEL` in each coordinate. If the cross product shows an
//! overlap, at most two edges are nearly parallel: another corner is moved for each. That changes the gaps by less than
//! `PARALLEL`, 2^4 `PARALLEL` w and 2^6 `PARALLEL` w^2.

use super::bodies::plus;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot};

const PARALLEL: f64 = power_of_two(-30);

/// Coordinates along the half edges of a cuboid.
struct Coordinates {
    normals: [Point; 3],
    one: f64,
}

impl Coordinates {
    #[inline(always)]
    fn new(a: &[Point; 3]) -> Self {
        let normals = [cross(&a[1], &a[2]), cross(&a[2], &a[0]), cross(&a[0], &a[1])];
        Self { normals, one: 1.0 / dot(&normals[0], &a[0]) }
    }

    #[inline(always)]
    fn of(&self, v: &Point) -> Point {
        let row = |n: &Point| self.one * dot(n, v);
        [row(&self.normals[0]), row(&self.normals[1]), row(&self.normals[2])]
    }
}

/// Whether the parallelepiped about the origin with the half edges `a` meets that about `d` with the half edges `b`.
#[inline]
#[expect(clippy::needless_range_loop, reason = "several arrays share the index")]
pub(super) fn meet(a: &[Point; 3], d: &Point, b: &[Point; 3], q: f64) -> Option<bool> {
    let a = Coordinates::new(a);
    let t = a.of(d);
    // Column j of r is b[j].
    let r = [a.of(&b[0]), a.of(&b[1]), a.of(&b[2])];
    let mut overlaps = true;

    for i in 0..3 {
        let gap = t[i].abs() - (1.0 + ((r[0][i].abs() + r[1][i].abs()) + r[2][i].abs()));
        if gap > power_of_two(-44) * q {
            return Some(false);
        }
        overlaps &= gap < -power_of_two(-26) * q;
    }
    // The cross products of two columns: the first coordinate of the third is that of columns 0 and 1.
    let minors = [cross(&r[1], &r[2]), cross(&r[2], &r[0]), cross(&r[0], &r[1])];
    let volume = dot(&r[0], &minors[0]).abs();
    let (square, cube) = (q * q, (q * q) * q);
    for m in &minors {
        let gap = dot(&t, m).abs() - (((m[0].abs() + m[1].abs()) + m[2].abs()) + volume);
        if gap > power_of_two(-40) * cube {
            return Some(false);
        }
        overlaps &= gap < -power_of_two(-22) * cube;
    }
    for i in 0..3 {
        let (k, l) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            // The form is the coordinate axis i times column j; with the other columns it gives minors.
            let c = &r[j];
            let (x, y) = (c[k].abs(), c[l].abs());
            let others = minors[(j + 1) % 3][i].abs() + minors[(j + 2) % 3][i].abs();
            let gap = (t[l] * c[k] - t[k] * c[l]).abs() - ((x + y) + others);
            if gap > power_of_two(-42) * square {
                return Some(false);
            }
            overlaps &= gap < -power_of_two(-25) * square || x.max(y) <= PARALLEL;
        }
    }
    overlaps.then_some(true)
}

/// Whether the parallelepiped about the origin with the half edges `a` meets the triangle with a corner at `d` and
/// these edges from it.
#[inline]
#[expect(clippy::needless_range_loop, reason = "several arrays share the index")]
pub(super) fn meets_triangle(a: &[Point; 3], d: &Point, edges: &[Point; 2], q: f64) -> Option<bool> {
    let a = Coordinates::new(a);
    let (t, g, h) = (a.of(d), a.of(&edges[0]), a.of(&edges[1]));
    let sum = |i: usize| (t[i].abs() + g[i].abs()) + h[i].abs();
    let w = 1.0 + greater(greater(sum(0), sum(1)), sum(2));
    let (linear, square, cube) =
        (power_of_two(-44) * q, power_of_two(-42) * q * w, power_of_two(-41) * q * (w * w));
    let mut overlaps = true;
    for i in 0..3 {
        let (low, high) = range(t[i], t[i] + g[i], t[i] + h[i]);
        let gap = greater(low, -high) - 1.0;
        if gap > linear {
            return Some(false);
        }
        overlaps &= -gap > linear + power_of_two(-29);
    }
    let m = cross(&g, &h);
    let gap = dot(&t, &m).abs() - ((m[0].abs() + m[1].abs()) + m[2].abs());
    if gap > cube {
        return Some(false);
    }
    overlaps &= -gap > cube + power_of_two(-23) * (w * w);
    let (end, third) = (plus(&t, &g), difference(&h, &g));
    for i in 0..3 {
        let (k, l) = ((i + 1) % 3, (i + 2) % 3);
        // The form is the coordinate axis i times an edge: the same at both ends of it.
        let form = |c: &Point, p: &Point| p[l] * c[k] - p[k] * c[l];
        // An edge, an end of it, and the difference of the form at the other corner.
        for (c, end, by) in [(&g, &t, m[i]), (&h, &t, -m[i]), (&third, &end, m[i])] {
            let (x, y) = (c[k].abs(), c[l].abs());
            let at = form(c, end);
            let (low, high) = if by > 0.0 { (at, at + by) } else { (at + by, at) };
            let gap = greater(low, -high) - (x + y);
            if gap > square {
                return Some(false);
            }
            overlaps &= -gap > square + power_of_two(-25) * w || greater(x, y) <= PARALLEL;
        }
    }
    overlaps.then_some(true)
}

#[inline(always)]
fn greater(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

#[inline(always)]
fn range(x: f64, y: f64, z: f64) -> (f64, f64) {
    let (low, high) = if x < y { (x, y) } else { (y, x) };
    (if z < low { z } else { low }, greater(high, z))
}
