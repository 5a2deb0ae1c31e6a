//! Dot products of two blocks' half edges, and steps towards the closest points in their coordinates.

use crate::primitive::shape::bounds::support::each;
use crate::range::Point;
use crate::vector::{difference, dot};
use core::array::from_fn;

/// All sums of a centre and multiples of `half` by -1 to 1: a point, a segment, or a cuboid.
pub(super) struct Zonotope<'s, const N: usize> {
    /// The centre, or the end of a segment from which its half edge leads to the centre.
    pub(super) origin: &'s Point,
    pub(super) half: &'s [Point; N],
}

impl<const N: usize> Zonotope<'_, N> {
    /// From the origin to the point with these coordinates.
    #[inline(always)]
    pub(super) fn point(&self, x: &[f64; N]) -> Point {
        let mut p = if N == 1 { self.half[0] } else { [0.0; 3] };
        for i in 0..N {
            p = each(|k| p[k] + x[i] * self.half[i][k]);
        }
        p
    }

    /// The greatest dot product of d with a point relative to the centre.
    #[inline(always)]
    pub(super) fn reach(&self, d: &Point) -> f64 {
        self.half.iter().fold(0.0, |sum, half| sum + dot(half, d).abs())
    }

    /// Whether a ball of this radius about the point with these coordinates is certainly inside. The half edges of a
    /// cuboid are perpendicular within 1e-4, so the distance of a face is at least 1 - 4e-4 times the length of its
    /// half edge.
    #[inline(always)]
    pub(super) fn has_ball(&self, x: &[f64; N], squares: &[f64; N], radius: f64) -> bool {
        let mut is_inside = N == 3;
        for i in 0..N {
            let room = 0.999 * (1.0 - x[i].abs());
            is_inside &= room * room * squares[i] > radius * radius;
        }
        is_inside
    }
}

/// Between `-most` and `most`.
#[inline(always)]
pub(super) fn clamped(x: f64, most: f64) -> f64 {
    let x = if x > -most { x } else { -most };
    if x < most { x } else { most }
}

#[inline(always)]
pub(super) fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// The coordinates of a point of A and one of B.
pub(super) struct BlockPlaces<const N: usize, const M: usize> {
    pub(super) x: [f64; N],
    pub(super) y: [f64; M],
    /// The coordinates of A's point before clamping.
    pub(super) free_x: [f64; N],
}

/// Products of the half edges and the vector between the centres.
pub(super) struct EdgeProducts<const N: usize, const M: usize> {
    /// From the centre of B to that of A.
    pub(super) between: Point,
    pub(super) squares_a: [f64; N],
    pub(super) squares_b: [f64; M],
    pub(super) inverse_a: [f64; N],
    pub(super) inverse_b: [f64; M],
    /// Half edges of A times `between`.
    pub(super) along_a: [f64; N],
    pub(super) along_b: [f64; M],
    /// Half edges of A times those of B.
    pub(super) mixed: [[f64; M]; N],
}

impl<const N: usize, const M: usize> EdgeProducts<N, M> {
    #[inline(always)]
    pub(super) fn new(a: &Zonotope<'_, N>, b: &Zonotope<'_, M>) -> Self {
        let mut t = difference(a.origin, b.origin);
        if N == 1 {
            t = each(|k| t[k] + a.half[0][k]);
        }
        if M == 1 {
            t = each(|k| t[k] - b.half[0][k]);
        }
        let squares_a: [f64; N] = from_fn(|i| dot(&a.half[i], &a.half[i]));
        let squares_b: [f64; M] = from_fn(|j| dot(&b.half[j], &b.half[j]));
        Self {
            between: t,
            squares_a,
            squares_b,
            inverse_a: squares_a.map(inverse),
            inverse_b: squares_b.map(inverse),
            along_a: from_fn(|i| dot(&a.half[i], &t)),
            along_b: from_fn(|j| dot(&b.half[j], &t)),
            mixed: from_fn(|i| from_fn(|j| dot(&a.half[i], &b.half[j]))),
        }
    }

    /// The sum of all squares.
    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        let total = self.squares_a.iter().fold(dot(&self.between, &self.between), |sum, x| sum + x);
        self.squares_b.iter().fold(total, |sum, x| sum + x)
    }

    /// A's point nearest to B's, before it is clamped.
    #[inline(always)]
    pub(super) fn to_a(&self, y: &[f64; M]) -> [f64; N] {
        from_fn(|i| {
            let mut product = -self.along_a[i];
            for j in 0..M {
                product += self.mixed[i][j] * y[j];
            }
            product * self.inverse_a[i]
        })
    }

    /// The dot product of B's half edge with the vector from B's centre to A's point.
    #[inline(always)]
    pub(super) fn along_of_b(&self, j: usize, x: &[f64; N]) -> f64 {
        let mut product = self.along_b[j];
        for i in 0..N {
            product += self.mixed[i][j] * x[i];
        }
        product
    }

    /// The point of A nearest to the centre of B.
    #[inline(always)]
    pub(super) fn near_centre(&self) -> BlockPlaces<N, M> {
        let free_x = self.to_a(&[0.0; M]);
        BlockPlaces { x: free_x.map(|x| clamped(x, 1.0)), y: [0.0; M], free_x }
    }

    /// The closest points of two segments: those of their lines, clamped one after the other (Ericson 2005, "Real-Time
    /// Collision Detection", 5.1.9).
    #[inline(always)]
    pub(super) fn on_lines(&self) -> BlockPlaces<N, M> {
        let (gg, gh, hh) = (self.squares_a[0], self.mixed[0][0], self.squares_b[0]);
        let all = gg * hh - gh * gh;
        // Any point of parallel lines does.
        let on_line = if all > 1e-12 * (gg * hh) {
            (gh * self.along_b[0] - hh * self.along_a[0]) / all
        } else {
            -self.along_a[0] * self.inverse_a[0]
        };
        let on_b = self.along_of_b(0, &[clamped(on_line, 1.0); N]) * self.inverse_b[0];
        let y = [clamped(on_b, 1.0); M];
        let free_x = if y[0] == on_b { [on_line; N] } else { self.to_a(&y) };
        BlockPlaces { x: free_x.map(|x| clamped(x, 1.0)), y, free_x }
    }

    /// Projects A's point to B, and the result to A.
    #[inline(always)]
    pub(super) fn project(&self, places: &mut BlockPlaces<N, M>, [most_a, most_b]: [f64; 2]) {
        places.y = from_fn(|j| clamped(self.along_of_b(j, &places.x) * self.inverse_b[j], most_b));
        places.free_x = self.to_a(&places.y);
        places.x = places.free_x.map(|x| clamped(x, most_a));
    }

    /// Newton's step over B's free coordinates, while A's point follows. If A or B has no free coordinate, a
    /// projection is exact.
    #[inline(always)]
    pub(super) fn step(&self, places: &mut BlockPlaces<N, M>, [most_a, most_b]: [f64; 2]) {
        let (is_free_a, is_free) = (|x: &f64| x.abs() < most_a, |y: &f64| y.abs() < most_b);
        if !(places.x.iter().any(is_free_a) && places.y.iter().any(is_free)) {
            return;
        }
        let (mut h, mut s) = ([[0.0; M]; M], [0.0; M]);
        for j in 0..M {
            let slope = self.along_of_b(j, &places.x) - self.squares_b[j] * places.y[j];
            if !is_free(&places.y[j]) && slope * places.y[j] >= 0.0 {
                continue;
            }
            s[j] = slope;
            h[j][j] = self.squares_b[j];
            for i in 0..N {
                let factor = self.mixed[i][j] * self.inverse_a[i];
                let share = if is_free_a(&places.free_x[i]) { factor } else { 0.0 };
                for k in 0..=j {
                    h[j][k] -= share * self.mixed[i][k];
                }
            }
        }
        solve(&mut h, &mut s, &self.squares_b);
        places.y = from_fn(|j| clamped(places.y[j] + s[j], most_b));
        places.free_x = self.to_a(&places.y);
        places.x = places.free_x.map(|x| clamped(x, most_a));
    }

    /// The bounds of the coordinates in a search for a common point: with one block shrunk by this share, whose points
    /// are centres of balls inside. That is a block that is small, but not thin: its points move less, and the balls
    /// are not too small.
    #[inline(always)]
    pub(super) fn shrunk(&self, by: f64) -> [f64; 2] {
        let of = |squares: &[f64]| squares.iter().fold([f64::INFINITY, 0.0], |[s, t], x| [x.min(s), t + x]);
        let ([least_a, all_a], [least_b, all_b]) = (of(&self.squares_a), of(&self.squares_b));
        let is_b = N < 3 || least_b * (all_a * all_a) >= least_a * (all_b * all_b);
        if is_b { [1.0, 1.0 - by] } else { [1.0 - by, 1.0] }
    }
}

/// Replaces s by the solution x of h x = s for a symmetric h, of which only the lower triangle is used. Omits unknowns
/// that depend on earlier ones: their pivots are below a small fraction of `squares`.
#[inline(always)]
fn solve<const M: usize>(h: &mut [[f64; M]; M], s: &mut [f64; M], squares: &[f64; M]) {
    // L of `L D L^T`, and the reciprocals of D.
    let mut pivots = [0.0; M];
    for j in 0..M {
        let mut d = h[j][j];
        for k in 0..j {
            for m in 0..k {
                h[j][k] -= h[j][m] * h[k][m];
            }
            // L D, until the row is complete.
            let l = h[j][k] * pivots[k];
            d -= h[j][k] * l;
            s[j] -= l * s[k];
        }
        for k in 0..j {
            h[j][k] *= pivots[k];
        }
        pivots[j] = if d > 1e-8 * squares[j] { 1.0 / d } else { 0.0 };
    }
    for j in (0..M).rev() {
        s[j] *= pivots[j];
        for k in j + 1..M {
            s[j] -= h[k][j] * s[k];
        }
    }
}
