//! The closest points of two disjoint triangles: between a corner and a face, or between two edges. Generic over the
//! number type.
//!
//! No result here needs to be right: for an ill-conditioned pair the points may not be the closest. But they are always
//! *on* the triangles, up to rounding, so their distance is an upper bound. The axis returned with them gives the lower
//! bound (`super::distance`), and comparing the two shows whether the points were right.

use crate::vector::{cross, difference, dot};
use core::ops::{Add, Div, Mul, Sub};

/// The number type of the algorithm.
pub(super) trait Real:
    Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;
    /// Bounds the relative error of an operation.
    const ROUNDOFF: f64;

    /// `(x - y) * scale`, for a power of two.
    fn scaled_difference(x: f64, y: f64, scale: f64) -> Self;
    fn length(v: &Vector<Self>) -> Self;
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// `origin + self * unscale`, rounded once where the type can.
    fn placed(self, origin: f64, unscale: f64) -> f64;
    /// Calls a function that is to be inlined where `f64` suffices. Wider numbers are rarer, and each of their
    /// operations takes many instructions.
    fn call<X, Y>(f: impl Fn(X) -> Y, x: X) -> Y;
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const ROUNDOFF: Self = super::sides::UNIT_ROUNDOFF;

    #[inline(always)]
    fn scaled_difference(x: f64, y: f64, scale: f64) -> Self {
        (x - y) * scale
    }

    #[inline(always)]
    fn length(v: &Vector<Self>) -> Self {
        glam::DVec3::from_array(*v).length()
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn placed(self, origin: f64, unscale: f64) -> f64 {
        origin + self * unscale
    }

    #[inline(always)]
    fn call<X, Y>(f: impl Fn(X) -> Y, x: X) -> Y {
        f(x)
    }
}

pub(super) type Vector<R> = [R; 3];
pub(super) type Corners<R> = [Vector<R>; 3];

/// `p + s u`.
#[inline(always)]
pub(super) fn along<R: Real>(p: &Vector<R>, s: R, u: &Vector<R>) -> Vector<R> {
    [p[0] + s * u[0], p[1] + s * u[1], p[2] + s * u[2]]
}

#[inline(always)]
pub(super) fn least<R: Real>(x: R, y: R) -> R {
    if y < x { y } else { x }
}

#[inline(always)]
pub(super) fn greatest<R: Real>(x: R, y: R) -> R {
    if y > x { y } else { x }
}

/// Clamps to 0 ..= 1; NaN becomes 0.
#[inline(always)]
pub(super) fn clamped<R: Real>(x: R) -> R {
    let x = if x > R::ZERO { x } else { R::ZERO };
    if x < R::ONE { x } else { R::ONE }
}

/// Two points and a direction. If the points are the closest, the projections of the triangles on this direction are as
/// far apart as the triangles.
#[derive(Copy, Clone, Debug)]
pub(super) struct Closest<R> {
    /// On the first triangle.
    pub(super) p: Vector<R>,
    /// On the second.
    pub(super) q: Vector<R>,
    /// Not normalized, of either sign.
    pub(super) axis: Vector<R>,
}

/// The closest points of the edges of two triangles.
#[derive(Copy, Clone, Debug)]
pub(super) struct OnEdges<R> {
    pub(super) closest: Closest<R>,
    /// Indices of the edges' first corners.
    pub(super) pair: [usize; 2],
    pub(super) edges: [Vector<R>; 2],
}

/// A triangle's plane, and the heights of the other triangle's corners over it.
#[derive(Debug)]
pub(super) struct FacePlane<R> {
    origin: Vector<R>,
    edges: [Vector<R>; 2],
    pub(super) normal: Vector<R>,
    /// Heights over the plane, times the length of the normal.
    pub(super) heights: [R; 3],
}

impl<R: Real> FacePlane<R> {
    #[inline(always)]
    pub(super) fn new(face: &Corners<R>, corners: &Corners<R>) -> Self {
        let origin = face[0];
        let edges = [difference(&face[1], &origin), difference(&face[2], &origin)];
        let normal = cross(&edges[0], &edges[1]);
        let height = |p: &Vector<R>| dot(&normal, &difference(p, &origin));
        let heights = [height(&corners[0]), height(&corners[1]), height(&corners[2])];
        Self { origin, edges, normal, heights }
    }

    /// Least distance of the corners from the plane if all are on one side, times the length of the normal; else not
    /// positive.
    #[inline(always)]
    pub(super) fn gap(&self) -> R {
        let [x, y, z] = self.heights;
        greatest(least(least(x, y), z), R::ZERO - greatest(greatest(x, y), z))
    }

    /// The nearest corner, if it is over the face itself, and its foot point in the face.
    ///
    /// If a corner and the inside of a face are closest, the face's plane separates the triangles and no other corner
    /// is nearer to it. So only this corner needs a test.
    #[inline(always)]
    pub(super) fn foot(&self, corners: &Corners<R>) -> Option<(Vector<R>, Vector<R>)> {
        let gap = self.gap();
        if gap <= R::ZERO {
            return None;
        }
        let nearest = (0..3).find(|&i| self.heights[i] == gap || R::ZERO - self.heights[i] == gap)?;
        let corner = corners[nearest];
        let square = dot(&self.normal, &self.normal);
        let w = difference(&corner, &self.origin);
        let s = dot(&w, &cross(&self.edges[1], &self.normal)) / square;
        let t = dot(&w, &cross(&self.normal, &self.edges[0])) / square;
        let inside = s >= R::ZERO && t >= R::ZERO && s + t <= R::ONE;
        inside.then(|| (corner, along(&along(&self.origin, s, &self.edges[0]), t, &self.edges[1])))
    }

    /// Where an edge of the other triangle passes through the face: a common point of triangles that cross.
    pub(super) fn piercing(&self, corners: &Corners<R>) -> Option<Vector<R>> {
        let square = dot(&self.normal, &self.normal);
        (0..3).find_map(|i| {
            let (k, p) = ((i + 1) % 3, &corners[i]);
            let (from, to) = (self.heights[i], self.heights[k]);
            if (from > R::ZERO && to > R::ZERO) || (from < R::ZERO && to < R::ZERO) {
                return None;
            }
            let point = along(p, clamped(from / (from - to)), &difference(&corners[k], p));
            let w = difference(&point, &self.origin);
            let s = dot(&w, &cross(&self.edges[1], &self.normal)) / square;
            let t = dot(&w, &cross(&self.normal, &self.edges[0])) / square;
            (s >= R::ZERO && t >= R::ZERO && s + t <= R::ONE).then_some(point)
        })
    }
}

/// Nine pairs of edges. Cramer's rule gives the parameters, in the form that divides by the square of the cross
/// product: it keeps twice as many digits as the usual difference of squares where edges are almost parallel. One step
/// of alternating projections follows. `only` restricts the search to one pair of edges.
#[inline(always)]
pub(super) fn closest_on_edges<R: Real>(
    a: &Corners<R>,
    b: &Corners<R>,
    only: Option<[usize; 2]>,
) -> OnEdges<R> {
    let v = [difference(&b[1], &b[0]), difference(&b[2], &b[1]), difference(&b[0], &b[2])];
    let vv = [dot(&v[0], &v[0]), dot(&v[1], &v[1]), dot(&v[2], &v[2])];
    let mut least_square = None;
    let mut best = (0, 0, R::ZERO, R::ZERO);
    for i in 0..3 {
        if only.is_some_and(|[first, _]| first != i) {
            continue;
        }
        let u = difference(&a[(i + 1) % 3], &a[i]);
        let uu = dot(&u, &u);
        // In arrays of three, for autovectorization.
        let (mut s, mut t, mut square) = ([R::ZERO; 3], [R::ZERO; 3], [R::ZERO; 3]);
        for j in 0..3 {
            if only.is_some_and(|[_, second]| second != j) {
                continue;
            }
            let w = difference(&b[j], &a[i]);
            let n = cross(&u, &v[j]);
            let (uv, uw, vw) = (dot(&u, &v[j]), dot(&u, &w), dot(&v[j], &w));
            // Zero denominators give NaN or infinity, and so an end of the edge.
            let on_line = clamped(dot(&cross(&w, &v[j]), &n) / dot(&n, &n));
            t[j] = clamped((on_line * uv - vw) / vv[j]);
            s[j] = clamped((uw + t[j] * uv) / uu);
            let d = difference(&along(&w, t[j], &v[j]), &along(&[R::ZERO; 3], s[j], &u));
            square[j] = dot(&d, &d);
        }
        for j in 0..3 {
            if only.is_none_or(|[_, second]| second == j)
                && least_square.is_none_or(|least| square[j] < least)
            {
                least_square = Some(square[j]);
                best = (i, j, s[j], t[j]);
            }
        }
    }
    let (i, j, s, t) = best;
    let u = difference(&a[(i + 1) % 3], &a[i]);
    // Corners are returned unchanged: the line between two corners then has the error of one difference only.
    let at =
        |p: &Vector<R>, end: &Vector<R>, s: R, u: &Vector<R>| if s < R::ONE { along(p, s, u) } else { *end };
    let (p, q) = (at(&a[i], &a[(i + 1) % 3], s, &u), at(&b[j], &b[(j + 1) % 3], t, &v[j]));
    let inside = |x: R| x > R::ZERO && x < R::ONE;
    let between = difference(&p, &q);
    let axis = match (inside(s), inside(t)) {
        (true, true) => cross(&u, &v[j]),
        (true, false) => rejection(&between, &u),
        (false, true) => rejection(&between, &v[j]),
        (false, false) => between,
    };
    OnEdges { closest: Closest { p, q, axis }, pair: [i, j], edges: [u, v[j]] }
}

/// The part of `d` orthogonal to `u`, for a `d` almost orthogonal to it. The point on the edge is off by a rounding
/// error relative to the edge, which may be large compared with `d`. On an axis that is oblique by this much, the edge
/// would have a projection of that length.
#[inline(always)]
pub(super) fn rejection<R: Real>(d: &Vector<R>, u: &Vector<R>) -> Vector<R> {
    along(d, R::ZERO - dot(d, u) / dot(u, u), u)
}
