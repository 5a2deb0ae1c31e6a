//! Two cuboids by separating axes.
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
//! column are at most `PARALLEL`, that axis is left out: B with these coordinates set to zero has it no more, and its
//! support function differs by at most 3 `PARALLEL` times the sum of the magnitudes of a form, for all three columns
//! together. The greatest such sum of an axis is 1, 2 q or 6 q^2, and the coefficients of the other axes change by
//! `PARALLEL`, 4 q `PARALLEL` and so on. Overlaps of more than 2^-26 q, 2^-25 q^2 and 2^-22 q^3 exceed all of this, so
//! that the difference of A and B contains the origin.

use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, dot};

const PARALLEL: f64 = power_of_two(-30);

/// Whether the parallelepiped about the origin with the half edges `a` meets that about `d` with the half edges `b`.
#[inline]
#[expect(clippy::needless_range_loop, reason = "several arrays share the index")]
pub(super) fn meet(a: &[Point; 3], d: &Point, b: &[Point; 3], q: f64) -> Option<bool> {
    let n = [cross(&a[1], &a[2]), cross(&a[2], &a[0]), cross(&a[0], &a[1])];
    let one = 1.0 / dot(&n[0], &a[0]);
    let row = |n: &Point, v: &Point| one * dot(n, v);
    let t = [row(&n[0], d), row(&n[1], d), row(&n[2], d)];
    // Column j of r is b[j].
    let column = |b: &Point| [row(&n[0], b), row(&n[1], b), row(&n[2], b)];
    let r = [column(&b[0]), column(&b[1]), column(&b[2])];
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
