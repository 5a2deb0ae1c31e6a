//! The point of a simplex nearest to the origin, for the algorithm of Gilbert, Johnson and Keerthi (1988).
//!
//! Nothing here is certified: a caller derives certain bounds from the points and directions found.

use super::support::each;
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

/// Corrections of a point that should be the origin.
const CORRECTIONS: usize = 2;

/// The corners of each face of a tetrahedron, and the opposite corner.
const FACES: [[usize; 4]; 4] = [[1, 2, 3, 0], [0, 2, 3, 1], [0, 1, 3, 2], [0, 1, 2, 3]];

/// A simplex of points of the difference A - B.
#[derive(Copy, Clone, Debug)]
pub(super) struct Simplex {
    /// The points.
    pub(super) points: [Point; 4],
    /// The points of A in these differences, relative to its centre.
    of_a: [Point; 4],
    pub(super) len: usize,
}

/// The point of a simplex nearest to the origin.
#[derive(Copy, Clone, Debug)]
pub(super) struct NearestOfSimplex {
    /// The point, as the convex combination.
    pub(super) point: Point,
    /// The point of A.
    pub(super) of_a: Point,
    /// Perpendicular to the face that contains the point, and away from the origin.
    pub(super) direction: Point,
    /// Whether the simplex contains the origin.
    pub(super) inside: bool,
}

impl Simplex {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { points: [[0.0; 3]; 4], of_a: [[0.0; 3]; 4], len: 0 }
    }

    #[inline(always)]
    pub(super) fn has(&self, point: &Point) -> bool {
        self.points[..self.len].contains(point)
    }

    /// Adds a point. The simplex must have at most three.
    #[inline(always)]
    pub(super) fn add(&mut self, point: Point, of_a: Point) {
        self.points[self.len] = point;
        self.of_a[self.len] = of_a;
        self.len += 1;
    }

    /// The point nearest to the origin. Keeps only the corners of the face that contains it.
    #[inline(always)]
    pub(super) fn reduce(&mut self) -> NearestOfSimplex {
        let p = &self.points;
        let found = match self.len {
            1 => SimplexPoint {
                kept: [0, 0, 0],
                weights: [1.0, 0.0, 0.0],
                len: 1,
                direction: p[0],
                square: 0.0,
            },
            2 => on_edge(p, 0, 1),
            3 => on_triangle(p, 0, 1, 2),
            _ => match on_tetrahedron(p) {
                Ok(face) => face,
                Err(weights) => return self.inside(&weights),
            },
        };
        self.keep(&found)
    }

    #[inline(always)]
    fn keep(&mut self, face: &SimplexPoint) -> NearestOfSimplex {
        let (old, of_a) = (self.points, self.of_a);
        let (mut point, mut on_a) = ([0.0; 3], [0.0; 3]);
        self.len = face.len;
        for i in 0..face.len {
            let (from, weight) = (face.kept[i], face.weights[i]);
            self.points[i] = old[from];
            self.of_a[i] = of_a[from];
            for k in 0..3 {
                point[k] += weight * old[from][k];
                on_a[k] += weight * of_a[from][k];
            }
        }
        let direction = if face.len == 1 { point } else { face.direction };
        NearestOfSimplex { point, of_a: on_a, direction, inside: false }
    }

    /// The weights of corners of a needle are inaccurate, and its length multiplies their error. What is left of the
    /// combination corrects them.
    #[cold]
    fn inside(&self, weights: &[f64; 4]) -> NearestOfSimplex {
        let p = &self.points;
        let mut weights = *weights;
        let mut found = self.combination(&weights);
        for _ in 0..CORRECTIONS {
            for [i, j, k, l] in FACES {
                let normal = cross(&difference(&p[j], &p[i]), &difference(&p[k], &p[i]));
                let inner = dot(&normal, &difference(&p[l], &p[i]));
                let rest = dot(&normal, &found.point) / inner;
                weights[l] = if rest.is_finite() { (weights[l] - rest).max(0.0) } else { weights[l] };
            }
            let next = self.combination(&weights);
            let is_nearer = dot(&next.point, &next.point) < dot(&found.point, &found.point);
            if !is_nearer {
                break;
            }
            found = next;
        }
        found
    }

    fn combination(&self, weights: &[f64; 4]) -> NearestOfSimplex {
        let sum = weights.iter().sum::<f64>();
        let (mut point, mut on_a) = ([0.0; 3], [0.0; 3]);
        for (i, weight) in weights.iter().map(|x| x / sum).enumerate() {
            for k in 0..3 {
                point[k] += weight * self.points[i][k];
                on_a[k] += weight * self.of_a[i][k];
            }
        }
        NearestOfSimplex { point, of_a: on_a, direction: point, inside: true }
    }

    /// Whether the tetrahedron still contains the origin if each of its corners moves by at most `slack`.
    ///
    /// If it contains a ball of that radius about the origin, then for every unit d some corner has `d . p >= slack`
    /// before and `d . p >= 0` after the motion; so no plane through the origin has all corners strictly on one side.
    ///
    /// A product `p . (q x r)` is the sum of six products, each with an error of at most 5u of itself: with L the
    /// largest length, below 16u L^3 in all. Computed corners are at most as long as the size S of the pair, so 2^-49
    /// S L^2 is more.
    #[cold]
    pub(super) fn surely_contains_origin(&self, slack: f64, size: f64) -> bool {
        if self.len < 4 {
            return false;
        }
        let p = &self.points;
        let square = (0..4).map(|i| dot(&p[i], &p[i])).fold(0.0, f64::max);
        let mut positive = [false; 4];
        for (i, [j, k, l]) in [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].into_iter().enumerate() {
            let volume = dot(&p[j], &cross(&p[k], &p[l]));
            let normal = cross(&difference(&p[k], &p[j]), &difference(&p[l], &p[j]));
            let area = sqrt(dot(&normal, &normal)) + 4.0 * f64::EPSILON * square;
            if volume.abs() <= 1.001 * slack * area + 8.0 * f64::EPSILON * size * square {
                return false;
            }
            positive[i] = volume > 0.0;
        }
        positive.iter().all(|x| *x == positive[0])
    }
}

/// A point of a face.
struct SimplexPoint {
    kept: [usize; 3],
    weights: [f64; 3],
    len: usize,
    direction: Point,
    /// Its squared distance from the origin; not set for a corner alone.
    square: f64,
}

#[inline(always)]
fn on_edge(p: &[Point; 4], i: usize, j: usize) -> SimplexPoint {
    let edge = difference(&p[j], &p[i]);
    let square = dot(&edge, &edge);
    let along = -dot(&edge, &p[i]);
    if along > 0.0 && along < square {
        let t = along / square;
        let v: Point = each(|k| p[i][k] + t * edge[k]);
        // Remove the component along the edge that rounding leaves: a lower bound would lose that times the edge's
        // length.
        let rest = dot(&v, &edge) / square;
        let direction = each(|k| v[k] - rest * edge[k]);
        SimplexPoint { kept: [i, j, 0], weights: [1.0 - t, t, 0.0], len: 2, direction, square: dot(&v, &v) }
    } else {
        let end = if along > 0.0 { j } else { i };
        let direction = p[end];
        SimplexPoint {
            kept: [end, 0, 0],
            weights: [1.0, 0.0, 0.0],
            len: 1,
            direction,
            square: dot(&p[end], &p[end]),
        }
    }
}

#[inline(always)]
fn on_triangle(p: &[Point; 4], i: usize, j: usize, k: usize) -> SimplexPoint {
    let (a, b, c) = (&p[i], &p[j], &p[k]);
    let normal = cross(&difference(b, a), &difference(c, a));
    // The barycentric coordinates, times the square of the normal.
    let x = dot(&normal, &cross(b, c));
    let y = dot(&normal, &cross(c, a));
    let z = dot(&normal, &cross(a, b));
    if x > 0.0 && y > 0.0 && z > 0.0 {
        let inverse = 1.0 / ((x + y) + z);
        let height = dot(&normal, a);
        let square = height * height / dot(&normal, &normal);
        let sign = 1.0_f64.copysign(height);
        let weights = [x * inverse, y * inverse, z * inverse];
        return SimplexPoint {
            kept: [i, j, k],
            weights,
            len: 3,
            direction: each(|k| sign * normal[k]),
            square,
        };
    }
    // The nearest point is on an edge that separates the origin's projection from the triangle.
    let mut best: Option<SimplexPoint> = None;
    for (coordinate, from, to) in [(x, j, k), (y, k, i), (z, i, j)] {
        if coordinate <= 0.0 || coordinate.is_nan() {
            let face = on_edge(p, from, to);
            if best.as_ref().is_none_or(|best| face.square < best.square) {
                best = Some(face);
            }
        }
    }
    best.unwrap_or_else(|| on_edge(p, i, j))
}

/// The nearest point, or the weights of the corners if the origin is inside.
#[inline(always)]
fn on_tetrahedron(p: &[Point; 4]) -> Result<SimplexPoint, [f64; 4]> {
    let mut best: Option<SimplexPoint> = None;
    let mut weights = [0.0; 4];
    for [i, j, k, l] in FACES {
        let normal = cross(&difference(&p[j], &p[i]), &difference(&p[k], &p[i]));
        let origin = -dot(&normal, &p[i]);
        let inner = dot(&normal, &difference(&p[l], &p[i]));
        weights[l] = if inner == 0.0 { 0.0 } else { origin / inner };
        if (inner > 0.0) != (origin > 0.0) || inner == 0.0 {
            let face = on_triangle(p, i, j, k);
            if best.as_ref().is_none_or(|best| face.square < best.square) {
                best = Some(face);
            }
        }
    }
    best.ok_or(weights)
}
