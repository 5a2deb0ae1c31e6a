//! Cores with a nearest point and a support function.
//!
//! **Error of a nearest point.** Let the point given be within 33 `size` of the reference point. Segments and cuboids:
//! the coordinates along the edges are clamped, so they are exactly those of a point of the core. Computing the point
//! takes at most 4 roundings per term, which is 8 u `size` with the rounding of the reference point. Triangles:
//! likewise, and the coordinates may add up to 1 + 4 u, which is another 4 u `size`. Cylinders: the part of the given
//! point across the axis has an error of at most 12 roundings of 34 `size`, so the point returned is within 2^9 u
//! `size` of the cylinder. Cones: let the point given be within 2 `size`. Its part across the axis and its height have
//! errors of at most 40 u `size`, so a point that is not moved is that near to the cone. A point that is moved lies on
//! the base or the side, up to the same error in its height and its distance from the axis. So the difference of two
//! such points has an error of at most 2^-43 `size`.
//!
//! **Error of the support function** along n: dot products of three terms and sums of four, so at most 16 u |n| `size`;
//! for a disc also a relative error of 8 u of the part across the axis, which is computed as a cross product: its
//! error is 4 u |n| |axis| before the division by |axis|.

use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

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
pub(super) fn clamp(x: f64, low: f64, high: f64) -> f64 {
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
pub(super) fn norm_1(v: &Point) -> f64 {
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

    // For a point beyond an edge, the nearest point of that edge, though near an obtuse corner another edge may be
    // nearer.
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
    /// Of `half`.
    squares: [f64; 3],
}

impl<'a> Cuboid<'a> {
    /// `None` if a half edge is too short or too long for the product of all squares.
    #[inline(always)]
    pub(super) fn new(half: &'a [Point; 3], at: Point) -> Option<Self> {
        let squares = [dot(&half[0], &half[0]), dot(&half[1], &half[1]), dot(&half[2], &half[2])];
        let product = (squares[0] * squares[1]) * squares[2];
        let is_in_range = product > power_of_two(-1000) && product < power_of_two(1000);
        is_in_range.then_some(Self { at, half, squares })
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
        let (h, [xx, yy, zz]) = (self.half, self.squares);
        // One division for three.
        let one = 1.0 / ((xx * yy) * zz);
        let x = clamp(dot(&w, &h[0]) * (one * (yy * zz)), -scale, scale);
        let y = clamp(dot(&w, &h[1]) * (one * (xx * zz)), -scale, scale);
        let z = clamp(dot(&w, &h[2]) * (one * (xx * yy)), -scale, scale);
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

/// The data that cylinders and cones share: a reference point, an axis and the radius of a disc across it.
#[derive(Debug)]
struct Disc<'a> {
    at: Point,
    axis: &'a Point,
    radius: f64,
    /// Of `axis`.
    square: f64,
    inverse: f64,
}

impl<'a> Disc<'a> {
    #[inline(always)]
    fn new(axis: &'a Point, radius: f64, at: Point) -> Self {
        let square = dot(axis, axis);
        Self { at, axis, radius, square, inverse: 1.0 / square }
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        norm_1(self.axis) + self.radius
    }

    /// The component of a vector along the axis, in units of the axis, and the component across it.
    #[inline(always)]
    fn split(&self, v: &Point) -> (f64, Point) {
        let along = dot(v, self.axis) * self.inverse;
        (along, difference(v, &times(along, self.axis)))
    }

    /// How far the rim reaches along a vector beyond the disc's middle.
    #[inline(always)]
    fn rim(&self, n: &Point) -> f64 {
        let across = cross(n, self.axis);
        self.radius * sqrt(dot(&across, &across) * self.inverse)
    }

    /// A vector across the axis, and its multiple that leads from the disc's middle to the point of the rim farthest
    /// along `n`.
    #[inline(always)]
    fn to_rim(&self, n: &Point) -> (Point, f64) {
        // Project twice, so that the error is relative to the result; if that is too short, the middle of the disc
        // will do.
        let across = self.split(&self.split(n).1).1;
        let square = dot(&across, &across);
        let is_long = square > dot(n, n) * power_of_two(-60);
        (across, if is_long { self.radius / sqrt(square) } else { 0.0 })
    }
}

#[derive(Debug)]
pub(super) struct Cylinder<'a>(Disc<'a>);

impl<'a> Cylinder<'a> {
    #[inline(always)]
    pub(super) fn new(axis: &'a Point, radius: f64, at: Point) -> Self {
        Self(Disc::new(axis, radius, at))
    }
}

impl Supported for Cylinder<'_> {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.0.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        self.0.size()
    }

    #[inline(always)]
    fn inner(&self) -> f64 {
        let half = greatest(self.0.axis);
        if half < self.0.radius { half } else { self.0.radius }
    }

    #[inline(always)]
    fn nearest_of(&self, p: &Point, scale: f64) -> Point {
        let disc = &self.0;
        let (along, across) = disc.split(&difference(p, &disc.at));
        let (square, radius) = (dot(&across, &across), disc.radius * scale);
        let factor = if square > radius * radius { radius / sqrt(square) } else { 1.0 };
        let t = clamp(along, -scale, scale);
        plus(&plus(&times(t, disc.axis), &times(factor, &across)), &disc.at)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        dot(n, self.0.axis).abs() + self.0.rim(n)
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        let (across, factor) = self.0.to_rim(n);
        let t = sign(dot(n, self.0.axis));
        plus(&times(t, self.0.axis), &times(factor, &across))
    }
}

/// The reference point is a quarter of the axis above the base.
#[derive(Debug)]
pub(super) struct Cone<'a> {
    disc: Disc<'a>,
    /// The reciprocal of the squared length of the side.
    inverse_side: f64,
}

/// The height of the reference point, in units of the axis.
const FROM_BASE: f64 = 0.25;

impl<'a> Cone<'a> {
    /// The reference point of a cone with the middle of its disc at `base`.
    #[inline(always)]
    pub(super) fn reference(axis: &Point, base: &Point) -> Point {
        plus(base, &times(FROM_BASE, axis))
    }

    #[inline(always)]
    pub(super) fn new(axis: &'a Point, radius: f64, at: Point) -> Self {
        let disc = Disc::new(axis, radius, at);
        let inverse_side = 1.0 / (disc.square + radius * radius);
        Self { disc, inverse_side }
    }
}

impl Supported for Cone<'_> {
    #[inline(always)]
    fn at(&self) -> &Point {
        &self.disc.at
    }

    #[inline(always)]
    fn size(&self) -> f64 {
        self.disc.size()
    }

    // The side is at least 3/4 sqrt(1/2) of the smaller one of height and radius away.
    #[inline(always)]
    fn inner(&self) -> f64 {
        let (half, height) = (0.5 * self.disc.radius, FROM_BASE * greatest(self.disc.axis));
        if half < height { half } else { height }
    }

    // In the half plane through the axis and the point, in units of the axis and of length.
    #[inline(always)]
    fn nearest_of(&self, p: &Point, scale: f64) -> Point {
        let Disc { at, axis, radius, square, .. } = &self.disc;
        let (along, across) = self.disc.split(&difference(p, at));
        let out = sqrt(dot(&across, &across));
        let (up, beyond) = (along + FROM_BASE * scale, out - radius * scale);
        let (height, out_to) = if up < 0.0 && beyond <= 0.0 {
            (0.0, out)
        } else if up >= 0.0 && up * radius + beyond <= 0.0 {
            (up, out)
        } else {
            // Between the rim and the tip.
            let height = (up * square - beyond * radius) * self.inverse_side;
            let height = clamp(height, 0.0, scale);
            (height, radius * (scale - height))
        };
        let factor = if out_to < out { out_to / out } else { 1.0 };
        plus(&plus(&times(height - FROM_BASE * scale, axis), &times(factor, &across)), at)
    }

    #[inline(always)]
    fn support(&self, n: &Point) -> f64 {
        let along = dot(n, self.disc.axis);
        let rim = self.disc.rim(n) - FROM_BASE * along;
        let tip = (1.0 - FROM_BASE) * along;
        if tip > rim { tip } else { rim }
    }

    #[inline(always)]
    fn farthest(&self, n: &Point) -> Point {
        let along = dot(n, self.disc.axis);
        let (across, factor) = self.disc.to_rim(n);
        if along > factor * dot(&across, &across) {
            times(1.0 - FROM_BASE, self.disc.axis)
        } else {
            plus(&times(-FROM_BASE, self.disc.axis), &times(factor, &across))
        }
    }
}
