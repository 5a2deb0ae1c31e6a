//! The distance between two closed triangles, as certain bounds, and the closest points.
//!
//! # Why the bounds hold
//!
//! *Upper bound:* the distance between two points on the triangles. Any two points give a valid bound, so rounding in
//! the search for them cannot invalidate it. Only the evaluation of the points and of their distance has an error,
//! which is at most `32 u size`.
//!
//! *Lower bound:* triangles A and B are at least as far apart as their projections on any axis n,
//!
//! ```text
//! distance >= (min n . A - max n . B) / |n|
//! ```
//!
//! Any axis gives a valid bound. Only the evaluation of six dot products has an error: again at most `32 u size`. Here
//! `size` is the largest coordinate of any corner relative to the first corner of A, and u bounds the relative error of
//! an operation. A dot product of local coordinates is off by at most `(3 + 1) u sqrt(3) |n| size` (three products and
//! two sums; the coordinates themselves). A difference of two of them is off by twice that and one more rounding, and
//! the length of n by `3 u`: below `24 u size` in all.
//!
//! The best axis follows from the closest points: the normal of the face, the common normal of the edges, or the line
//! between the points. So the bounds usually meet to within rounding. If they do not, because the triangles almost
//! touch or the pair is ill-conditioned, [`overlap`] decides whether the distance is 0. If it is not, the computation
//! is repeated in double-double (u = 2^-98 instead of 2^-53). The result has `upper <= (1 + 2^-42) lower`, unless the
//! triangles are needles that almost touch: the direction of a normal is accurate to `u size / altitude` only, so the
//! bounds are certain to meet only while `distance * altitude` is above 2^-56 `size^2`.

use super::double_double::DoubleDouble;
use super::features::{
    Closest, Corners, FacePlane, OnEdges, Real, Vector, closest_on_edges, greatest, least, rejection,
};
use super::interval::Wedge;
use super::overlap::{in_range, overlap};
use super::sides::Triangle;
use crate::exact::power_of_two;
use crate::primitive::Separation;
use crate::vector::{cross, difference, dot};

/// Bounds whose relative difference is at most this count as equal: 2^-42.
pub(crate) const TIGHT: f64 = power_of_two(-42);

/// Allowance for rounding in each of the two bounds, in units of `u size`.
pub(super) const ROUNDINGS: f64 = 32.0;

/// The distance between two closed triangles, to twelve digits, and their closest points. Zero if and only if they
/// meet.
///
/// The coordinates must be within the [range](super#range); corners may coincide or be collinear.
///
/// # Panics
/// With debug assertions only: if a coordinate is out of range.
///
/// # Examples
///
/// ```
/// use simdop::primitive::triangle::distance::separation;
/// let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let standing = [[1.0, 1.0, 0.5], [1.0, 1.0, 3.0], [2.0, 1.0, 3.0]];
/// let apart = separation(&floor, &standing);
/// assert!((apart.upper - 0.5).abs() < 1e-12 && apart.lower <= apart.upper);
/// assert_eq!((apart.a, apart.b), ([1.0, 1.0, 0.0], [1.0, 1.0, 0.5]));
/// ```
#[must_use]
pub fn separation(a: &Triangle, b: &Triangle) -> Separation {
    nearer(a, b, f64::INFINITY, TIGHT, &mut 0)
        .unwrap_or_else(|| unreachable!("no distance is above infinity"))
}

/// The [`separation`], or `None` if it is certainly greater than `limit`. The relative difference of the bounds is at
/// most `tolerance`, if that is at least 2^-42. Adds 1 to `exact` if `f64` did not suffice.
#[inline(always)]
pub fn nearer(a: &Triangle, b: &Triangle, limit: f64, tolerance: f64, exact: &mut u64) -> Option<Separation> {
    debug_assert!(in_range(a) && in_range(b), "coordinate out of range");
    let local = Local::<f64>::new(a, b);
    let faces = local.faces();
    if local.beyond_faces(&faces, limit) {
        return None;
    }
    let found = local.separation(&faces, None, tolerance);
    if found.is_tight(tolerance) || found.lower > limit {
        Some(found)
    } else {
        *exact += 1;
        Some(refined(a, b, &found, tolerance))
    }
}

/// Whether two triangles are at most `margin` apart. Certain if the distance differs from the margin by more than 2^-90
/// of the triangles' extent; otherwise true.
#[inline(never)]
pub fn within(a: &Triangle, b: &Triangle, margin: f64, exact: &mut u64) -> bool {
    let local = Local::<f64>::new(a, b);
    let faces = local.faces();
    if local.beyond_faces(&faces, margin) || local.beyond_edges(&faces, margin) {
        return false;
    }
    let found = local.separation(&faces, None, TIGHT);
    if found.upper <= margin || found.lower > margin {
        return found.upper <= margin;
    }
    *exact += 1;
    (found.lower <= 0.0 && overlap(a, b, &mut 0)) || refined(a, b, &found, 0.0).lower <= margin
}

#[cold]
#[inline(never)]
fn refined(a: &Triangle, b: &Triangle, rough: &Separation, tolerance: f64) -> Separation {
    let local = Local::<DoubleDouble>::new(a, b);
    if rough.lower <= 0.0 && overlap(a, b, &mut 0) {
        let pierced = |face, corners| FacePlane::new(face, corners).piercing(corners);
        let (p, q) = match pierced(&local.a, &local.b).or_else(|| pierced(&local.b, &local.a)) {
            Some(point) => (local.placed(&point), local.placed(&point)),
            // They touch, or lie in one plane: the closest points coincide up to rounding.
            None => {
                let closest = fine_separation(&local, None, 0.0);
                (closest.a, closest.b)
            }
        };
        return Separation { lower: 0.0, upper: 0.0, a: p, b: q };
    }
    // The closest edges in `f64` are most likely the closest.
    let rough_local = Local::<f64>::new(a, b);
    let likely = closest_on_edges(&rough_local.a, &rough_local.b, None).pair;
    let fine = fine_separation(&local, Some(likely), tolerance);
    Separation { lower: fine.lower.max(rough.lower), ..fine }
}

/// [`Local::separation`] in double-double, compiled once.
#[inline(never)]
fn fine_separation(local: &Local<DoubleDouble>, likely: Option<[usize; 2]>, tolerance: f64) -> Separation {
    local.separation(&local.faces(), likely, tolerance)
}

impl Separation {
    fn is_tight(&self, tolerance: f64) -> bool {
        self.upper - self.lower <= tolerance * self.lower
    }
}

/// Two triangles relative to the first corner of the first, scaled where fourth powers would over- or underflow.
struct Local<R> {
    a: Corners<R>,
    b: Corners<R>,
    origin: [f64; 3],
    scale: f64,
    /// Largest coordinate.
    size: f64,
}

/// Sizes whose fourth powers are normal, with all their error terms.
pub(super) const COMFORTABLE: core::ops::Range<f64> = power_of_two(-100)..power_of_two(100);

/// If an axis is longer than this, its square is normal, with all its error terms.
pub(super) const SHORT: f64 = power_of_two(-400);

impl<R: Real> Local<R> {
    #[inline(always)]
    fn new(a: &Triangle, b: &Triangle) -> Self {
        let origin = a[0];
        let far = |p: &[f64; 3]| {
            let [x, y, z] = [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
            greatest(greatest(x.abs(), y.abs()), z.abs())
        };
        let of_b = greatest(greatest(far(&b[0]), far(&b[1])), far(&b[2]));
        let size = greatest(greatest(far(&a[1]), far(&a[2])), of_b);
        let scale = if COMFORTABLE.contains(&size) || size == 0.0 { 1.0 } else { unit_scale(size) };
        let local = |p: &[f64; 3]| {
            [
                R::scaled_difference(p[0], origin[0], scale),
                R::scaled_difference(p[1], origin[1], scale),
                R::scaled_difference(p[2], origin[2], scale),
            ]
        };
        Self {
            a: [local(&a[0]), local(&a[1]), local(&a[2])],
            b: [local(&b[0]), local(&b[1]), local(&b[2])],
            origin,
            scale,
            size: size * scale,
        }
    }

    #[inline(always)]
    fn faces(&self) -> [FacePlane<R>; 2] {
        [FacePlane::new(&self.a, &self.b), FacePlane::new(&self.b, &self.a)]
    }

    /// Rounding allowance of a bound.
    #[inline(always)]
    fn slack(&self) -> f64 {
        ROUNDINGS * R::ROUNDOFF * self.size
    }

    /// Tries the features in turn until the bounds meet. Tries the edges `likely` before all others.
    #[inline(always)]
    fn separation(
        &self,
        faces: &[FacePlane<R>; 2],
        likely: Option<[usize; 2]>,
        tolerance: f64,
    ) -> Separation {
        let mut best = Separation { lower: 0.0, upper: f64::INFINITY, a: self.origin, b: self.origin };
        if let Some((q, p)) = faces[0].foot(&self.b) {
            best = self.bounded(best, &Closest { p, q, axis: faces[0].normal });
        }
        if !best.is_tight(tolerance)
            && let Some((p, q)) = faces[1].foot(&self.a)
        {
            best = self.bounded(best, &Closest { p, q, axis: faces[1].normal });
        }
        if !best.is_tight(tolerance) && likely.is_some() {
            best = self.bounded(best, &self.closest_on_edges(likely).closest);
        }
        if best.is_tight(tolerance) {
            return best;
        }
        let found = self.closest_on_edges(None);
        best = self.bounded(best, &found.closest);
        // Almost parallel edges have no accurate common normal, and a corner may be classified as the inside of an
        // edge.
        let between = difference(&found.closest.p, &found.closest.q);
        for axis in [between, rejection(&between, &found.edges[0]), rejection(&between, &found.edges[1])] {
            if best.is_tight(tolerance) {
                break;
            }
            best = self.bounded(best, &Closest { axis, ..found.closest });
        }
        best
    }

    #[inline(always)]
    fn closest_on_edges(&self, only: Option<[usize; 2]>) -> OnEdges<R> {
        R::call(|local: &Self| closest_on_edges(&local.a, &local.b, only), self)
    }

    /// `best`, improved by the bounds from two points and an axis.
    #[inline(always)]
    fn bounded(&self, best: Separation, found: &Closest<R>) -> Separation {
        R::call(|found: &Closest<R>| self.improved(best, found), found)
    }

    #[inline(always)]
    fn improved(&self, best: Separation, found: &Closest<R>) -> Separation {
        let unscale = 1.0 / self.scale;
        let length = R::length(&difference(&found.p, &found.q)).to_f64();
        let upper = (length + self.slack()) * (1.0 + 4.0 * f64::EPSILON) * unscale;
        let lower = greatest(best.lower, self.gap_along(&found.axis) * unscale);
        if upper < best.upper {
            Separation { lower, upper, a: self.placed(&found.p), b: self.placed(&found.q) }
        } else {
            Separation { lower, ..best }
        }
    }

    /// Lower bound of the distance of the projections on an axis; at least 0.
    #[inline(always)]
    fn gap_along(&self, axis: &Vector<R>) -> f64 {
        let length = R::length(axis);
        if length.to_f64() > SHORT {
            let gap = self.gap(axis) / length;
            greatest((gap.to_f64() - self.slack()) * (1.0 - 4.0 * f64::EPSILON), 0.0)
        } else {
            0.0
        }
    }

    /// The distance of the projections on an axis, times the axis's length; negative if they overlap.
    #[inline(always)]
    fn gap(&self, axis: &Vector<R>) -> R {
        let range = |t: &Corners<R>| {
            let [x, y, z] = [dot(axis, &t[0]), dot(axis, &t[1]), dot(axis, &t[2])];
            (least(least(x, y), z), greatest(greatest(x, y), z))
        };
        let ((a_low, a_high), (b_low, b_high)) = (range(&self.a), range(&self.b));
        greatest(a_low - b_high, b_low - a_high)
    }

    /// Converts to the triangles' own coordinates.
    #[inline(always)]
    fn placed(&self, p: &Vector<R>) -> [f64; 3] {
        let (origin, unscale) = (self.origin, 1.0 / self.scale);
        [p[0].placed(origin[0], unscale), p[1].placed(origin[1], unscale), p[2].placed(origin[2], unscale)]
    }
}

impl Local<f64> {
    /// Whether the plane of a face proves that the distance is above `limit`.
    ///
    /// The heights over a face take its own corners to be in its plane. Rounding of the normal puts them off it: by at
    /// most `32 u size^2` in each component, so `192 u size^3` for an edge. For a needle, the normal may be nothing but
    /// this error.
    #[inline(always)]
    fn beyond_faces(&self, [over_a, over_b]: &[FacePlane<f64>; 2], limit: f64) -> bool {
        let off_plane = 256.0 * f64::ROUNDOFF * (self.size * self.size * self.size);
        self.beyond(over_a.gap() - off_plane, &over_a.normal, limit)
            || self.beyond(over_b.gap() - off_plane, &over_b.normal, limit)
    }

    /// Whether the common normal of two edges proves that the distance is above `limit`, for triangles that cross each
    /// other's planes. Where the intervals that the triangles cut out of the planes' common line are disjoint, these
    /// are the edges that bound them.
    #[inline(always)]
    fn beyond_edges(&self, [over_a, over_b]: &[FacePlane<f64>; 2], limit: f64) -> bool {
        if over_a.gap() > 0.0 || over_b.gap() > 0.0 {
            return false;
        }
        // Signs in `f64` only: a wrong side gives a less useful axis, but the bound stays valid.
        let side = |height: f64| i8::from(height > 0.0) - i8::from(height < 0.0);
        let sides = |face: &FacePlane<f64>| {
            let [x, y, z] = face.heights;
            [side(x), side(y), side(z)]
        };
        let (a, b) = (Wedge::new(&self.a, sides(over_b)), Wedge::new(&self.b, sides(over_a)));
        let beyond = |p: &Vector<f64>, q: &Vector<f64>| {
            let axis = cross(&difference(p, &a.apex), &difference(q, &b.apex));
            self.beyond(self.gap(&axis), &axis, limit)
        };
        beyond(&a.left, &b.left) || beyond(&a.right, &b.right)
    }

    /// Whether the gap along an axis proves that the distance is above `limit`. Cheaper than [`Local::gap_along`]: no
    /// root, no division.
    #[inline(always)]
    fn beyond(&self, gap: f64, axis: &Vector<f64>, limit: f64) -> bool {
        let [x, y, z] = axis;
        let gap = gap - self.slack() * ((x.abs() + y.abs()) + z.abs());
        let reach = limit * self.scale;
        let square = dot(axis, axis) * (1.0 + 8.0 * f64::EPSILON);
        (gap > 0.0) & (square > SHORT * SHORT) & (gap * gap > (reach * reach) * square)
    }
}

/// The power of two that scales `size` to 1 .. 2.
#[cold]
pub(super) fn unit_scale(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    power_of_two(-exponent)
}
