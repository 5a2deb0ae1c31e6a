//! Cores with a nearest point and a support function.
//!
//! **Error of a nearest point.** Let the point given be within 33 `size` of the reference point. Segments and cuboids:
//! the coordinates along the edges are clamped, so exactly those of a point of the core; to compute the point from them
//! takes at most 4 roundings for each term, which is 8 u `size` with the rounding of the reference point. Triangles:
//! likewise, and the coordinates may add up to 1 + 4 u, which is another 4 u `size`. Cylinders:
//! the part of the given point across the axis has an error of at most 12 roundings of 34 `size`, so the point returned
//! is within 2^9 u `size` of the cylinder. For the difference of two such points that makes at most 2^-43 `size`.
//!
//! **Error of the support function** along n: dot products of three terms and sums of four, so at most 16 u |n| `size`;
//! for a cylinder also a relative error of 8 u of the part across the axis, which is computed as a cross product: its
//! error is 4 u |n| |axis| before the division by |axis|.

use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot};

/// A convex core.
pub(super) trait Supported {
    /// The reference point, which is in the core.
    fn at(&self) -> &Point;
    /// The greatest distance of a point of the core from the reference point, or more.
    fn size(&self) -> f64;
    /// The radius of a ball in the core about the reference point, or less.
    fn inner(&self) -> f64;
    /// The nearest point, up to rounding, of the core shrunk about its centre by the factor `scale`. Segments and
    /// triangles are not shrunk.
    fn nearest_of(&self, p: &Point, scale: f64) -> Point;
    /// The greatest `n . (x - at)` for x in the core.
    fn support(&self, n: &Point) -> f64;
    /// `x - at` for a point x of the core that is about the farthest along `n`.
    fn farthest(&self, n: &Point) -> Point;
}

#[inline(always)]
fn clamp(x: f64, low: f64, high: f64) -> f64 {
    // `low` for NaN.
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

#[inline(always)]
pub(super) fn plus(a: &Point, b: &Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn times(t: f64, v: &Point) -> Point {
    [t * v[0], t * v[1], t * v[2]]
}

#[inline(always)]
fn combination([x, y, z]: &Point, [p, q, r]: &[Point; 3]) -> Point {
    plus(&plus(&times(*x, p), &times(*y, q)), &times(*z, r))
}

#[inline(always)]
fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[inline(always)]
fn norm_1(v: &Point) -> f64 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

#[inline(always)]
fn greatest(v: &Point) -> f64 {
    let larger = |x: f64, y: f64| if x > y { x } else { y };
    larger(larger(v[0].abs(), v[1].abs()), v[2].abs())
}

/// The points `at + t edge` for t in 0 ..= 1.
#[derive(Debug)]
pub(super) struct Segment {
    pub(super) at: Point,
    pub(super) edge: Point,
    pub(super) square: f64,
}

impl Segment {
    #[inline(always)]
    pub(super) fn new(ends: &[Point; 2], at: Point) -> Self {
        let edge = difference(&ends[1], &ends[0]);
        Self { at, edge, square: dot(&edge, &edge) }
    }

    #[inline(always)]
    pub(super) fn point(&self, t: f64) -> Point {
        plus(&self.at, &times(t, &self.edge))
    }

    #[inline(always)]
    pub(super) fn nearest(&self, p: &Point) -> Point {
        // 0 / 0 for a segment that is a point: clamped to 0.
        self.point(clamp(dot(&difference(p, &self.at), &self.edge) / self.square, 0.0, 1.0))
    }
}

impl Supported for Segment {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        norm_1(&self.edge)
    }

    #[inline(always)]
    fn inner(&self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn nearest_of(&self, p: &Point, _: f64) -> Point {
        self.nearest(p)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        let end = dot(n, &self.edge);
        if end > 0.0 { end } else { 0.0 }
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        if dot(n, &self.edge) > 0.0 { self.edge } else { [0.0; 3] }
    }
}

/// The points `at + s edges[0] + t edges[1]` for s and t of at least 0 whose sum is at most 1.
#[derive(Debug)]
pub(super) struct TriangleCore {
    at: Point,
    pub(super) edges: [Point; 2],
}

impl TriangleCore {
    #[inline(always)]
    pub(super) fn new([p, q, r]: &[Point; 3], at: Point) -> Self {
        Self { at, edges: [difference(q, p), difference(r, p)] }
    }
}

impl Supported for TriangleCore {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        norm_1(&self.edges[0]) + norm_1(&self.edges[1])
    }

    #[inline(always)]
    fn inner(&self) -> f64 {
        0.0
    }

    // Of a point beyond an edge, the nearest one of that edge: near an obtuse corner another edge may be nearer.
    #[inline(always)]
    fn nearest_of(&self, p: &Point, _: f64) -> Point {
        let [g, h] = &self.edges;
        let w = difference(p, &self.at);
        let (gg, gh, hh) = (dot(g, g), dot(g, h), dot(h, h));
        let (gw, hw) = (dot(g, &w), dot(h, &w));
        let (s, t, all) = (hh * gw - gh * hw, gg * hw - gh * gw, gg * hh - gh * gh);
        let (s, t) = if s <= 0.0 {
            (0.0, clamp(hw / hh, 0.0, 1.0))
        } else if t <= 0.0 {
            (clamp(gw / gg, 0.0, 1.0), 0.0)
        } else if s + t < all {
            (s / all, t / all)
        } else {
            // From the end of g to that of h.
            let t = clamp(((hw - gw) + (gg - gh)) / ((gg - gh) + (hh - gh)), 0.0, 1.0);
            (1.0 - t, t)
        };
        plus(&plus(&times(s, g), &times(t, h)), &self.at)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        let (x, y) = (dot(n, &self.edges[0]), dot(n, &self.edges[1]));
        let most = if x > y { x } else { y };
        if most > 0.0 { most } else { 0.0 }
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        let (x, y) = (dot(n, &self.edges[0]), dot(n, &self.edges[1]));
        let (most, end) = if x > y { (x, &self.edges[0]) } else { (y, &self.edges[1]) };
        if most > 0.0 { *end } else { [0.0; 3] }
    }
}

/// A parallelepiped whose edges are about perpendicular.
#[derive(Debug)]
pub(super) struct Cuboid<'a> {
    at: Point,
    half: &'a [Point; 3],
    /// About the reciprocals of the squares of `half`.
    inverse: [f64; 3],
}

impl<'a> Cuboid<'a> {
    /// `None` if a half edge is too short or too long for the product of all squares.
    #[inline(always)]
    pub(super) fn new(half: &'a [Point; 3], at: Point) -> Option<Self> {
        let [x, y, z] = [dot(&half[0], &half[0]), dot(&half[1], &half[1]), dot(&half[2], &half[2])];
        // One division for three.
        let (xy, volume) = (x * y, (x * y) * z);
        if !(volume > power_of_two(-1000) && volume < power_of_two(1000)) {
            return None;
        }
        let one = 1.0 / volume;
        Some(Self { at, half, inverse: [one * (y * z), one * (x * z), one * xy] })
    }
}

impl Supported for Cuboid<'_> {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        (norm_1(&self.half[0]) + norm_1(&self.half[1])) + norm_1(&self.half[2])
    }

    // Heights over a face are at least 0.999 of the edge: half of an edge's greatest coordinate is less.
    #[inline(always)]
    fn inner(&self) -> f64 {
        let [x, y, z] = [greatest(&self.half[0]), greatest(&self.half[1]), greatest(&self.half[2])];
        let least = if x < y { x } else { y };
        0.5 * if least < z { least } else { z }
    }

    #[inline(always)]
    fn nearest_of(&self, p: &Point, scale: f64) -> Point {
        let w = difference(p, &self.at);
        let (h, inverse) = (self.half, &self.inverse);
        let x = clamp(dot(&w, &h[0]) * inverse[0], -scale, scale);
        let y = clamp(dot(&w, &h[1]) * inverse[1], -scale, scale);
        let z = clamp(dot(&w, &h[2]) * inverse[2], -scale, scale);
        plus(&combination(&[x, y, z], h), &self.at)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        let h = self.half;
        (dot(n, &h[0]).abs() + dot(n, &h[1]).abs()) + dot(n, &h[2]).abs()
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        let h = self.half;
        let (x, y, z) = (sign(dot(n, &h[0])), sign(dot(n, &h[1])), sign(dot(n, &h[2])));
        combination(&[x, y, z], h)
    }
}

#[derive(Debug)]
pub(super) struct Cylinder<'a> {
    at: Point,
    axis: &'a Point,
    radius: f64,
    /// The reciprocal of the square of `axis`.
    inverse: f64,
}

impl<'a> Cylinder<'a> {
    #[inline(always)]
    pub(super) fn new(axis: &'a Point, radius: f64, at: Point) -> Self {
        Self { at, axis, radius, inverse: 1.0 / dot(axis, axis) }
    }

    /// The part of a vector across the axis.
    #[inline(always)]
    fn across(&self, v: &Point) -> Point {
        let along = dot(v, self.axis) * self.inverse;
        difference(v, &times(along, self.axis))
    }
}

impl Supported for Cylinder<'_> {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        norm_1(self.axis) + self.radius
    }

    #[inline(always)]
    fn inner(&self) -> f64 {
        let half = greatest(self.axis);
        if half < self.radius { half } else { self.radius }
    }

    #[inline(always)]
    fn nearest_of(&self, p: &Point, scale: f64) -> Point {
        let w = difference(p, &self.at);
        let along = dot(&w, self.axis) * self.inverse;
        let across = difference(&w, &times(along, self.axis));
        let (square, radius) = (dot(&across, &across), self.radius * scale);
        let factor = if square > radius * radius { radius / libm::sqrt(square) } else { 1.0 };
        let t = clamp(along, -scale, scale);
        plus(&plus(&times(t, self.axis), &times(factor, &across)), &self.at)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        let across = cross(n, self.axis);
        dot(n, self.axis).abs() + self.radius * libm::sqrt(dot(&across, &across) * self.inverse)
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        let along = dot(n, self.axis);
        let across = self.across(&self.across(n));
        let (t, square) = (sign(along), dot(&across, &across));
        // Twice across, so that its error is relative to itself; for shorter ones the centre of the disc.
        let is_long = square > dot(n, n) * power_of_two(-60);
        let factor = if is_long { self.radius / libm::sqrt(square) } else { 0.0 };
        plus(&times(t, self.axis), &times(factor, &across))
    }
}
