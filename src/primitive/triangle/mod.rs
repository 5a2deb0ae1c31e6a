//! Whether two closed triangles meet: the exact leaf test.
//!
//! The answer depends on nothing but the signs of determinants of the coordinates as given. Each sign is
//! first computed in plain `f64` together with a bound on its rounding error; only when the bound does not
//! decide is the determinant evaluated in integers. So the verdict is the true one for the given coordinates.
//!
//! 1. *Plane sides.* If the three vertices of one triangle lie strictly on one side of the other's plane, the
//!    triangles are disjoint. Nearly every pair ends here.
//! 2. *Intervals.* Otherwise each triangle cuts the line shared by the two planes in an interval, and two
//!    more determinants compare the interval ends without constructing them (Devillers & Guigue, *Faster
//!    triangle-triangle intersection tests*, INRIA RR-4488, 2002).
//! 3. *Flat cases.* Coplanar pairs and triangles that are a segment or a point go to a module of their own.
//!
//! # Range
//!
//! Every coordinate must be zero or have a magnitude in [`MIN_COORDINATE`] `..=` [`MAX_MOVED`]: four times
//! what a body's own may have, since poses move them, which flush smaller ones to zero. Then nothing under-
//! or overflows, and the error analysis (which knows neither) holds: each coordinate is a multiple of 2^-302,
//! the last place of [`MIN_COORDINATE`]; so is each difference of two and its rounding error; so a product of
//! three of them is a multiple of 2^-906 and not subnormal. A difference is at most 2^303, so a sum of six
//! products of three is below 2^912. The integers that decide what this cannot have room for all of it.

mod crossing;
#[cfg(feature = "alloc")]
pub(crate) mod deep;
pub mod distance;
mod double_double;
mod features;
mod flat;
mod interval;
mod on_lattice;
pub(crate) mod point;
#[cfg(test)]
mod tests;
mod triangles;

use crate::exact::{determinant, power_of_two};
use crate::range::{MAX_MOVED, MIN_COORDINATE, Point};
use crate::vector::difference;
use interval::Wedge;

pub(crate) use on_lattice::LatticeProbe;
pub use triangles::Triangles;

/// Three vertices, in any unit of length; the order carries no meaning. Vertices may coincide or be
/// collinear.
pub type Triangle = [Point; 3];

/// Relative error bound of a 3 by 3 determinant of coordinate differences, in units of its permanent
/// (the same sum with absolute values, itself rounded).
///
/// This is `o3derrboundA` of Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust
/// Geometric Predicates*, 1997, section 4.3. His proof fits because the expression has the same shape: nine
/// rounded differences, three 2 by 2 minors, each multiplied by a difference, summed from left to right. That
/// the cofactors are taken along the tested point's row and not along a column only renames the entries.
pub(crate) const DETERMINANT_ERROR: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// [`Probe::away`] of a margin of 1, with more than the roundings of the permanent and of the normal in it.
const AWAY: f64 = (1.0 + power_of_two(-40)) / DETERMINANT_ERROR;

/// Half a unit in the last place of 1: 2^-53.
pub(crate) const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;

/// Whether two closed triangles have a point in common. Touching is overlapping.
///
/// Exact for the coordinates as given, whatever the shape: coplanar pairs, needles, points, shared vertices.
/// The answer does not depend on the order of the triangles or of their vertices.
///
/// Adds 1 to `exact_calls` if floating point could not decide some sign, so that integers had to.
///
/// The coordinates must keep to the [range](self#range). Outside it, and for NaN, the answer may be wrong.
///
/// # Panics
///
/// With debug assertions only: if a coordinate is out of range.
///
/// # Examples
///
/// ```
/// use simdop::primitive::triangle::overlap;
///
/// let floor = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let standing = [[0.5, 0.5, 0.0], [0.5, 0.5, 1.0], [1.0, 0.5, 1.0]];
/// let hovering = standing.map(|[x, y, z]| [x, y, z + f64::EPSILON]);
/// let mut exact_calls = 0;
/// assert!(overlap(&floor, &standing, &mut exact_calls));
/// assert!(!overlap(&floor, &hovering, &mut exact_calls));
/// ```
#[inline]
#[must_use]
pub fn overlap(a: &Triangle, b: &Triangle, exact_calls: &mut u64) -> bool {
    Probe::new(a).overlaps(b, exact_calls)
}

/// One triangle that is to be tested against many: its plane is computed once.
#[derive(Debug)]
pub struct Probe<'t> {
    pub(crate) triangle: &'t Triangle,
    pub(crate) plane: Plane,
    /// What [`Probe::is_apart`] adds to each of a point's coordinates, relative to a plane, where it bounds the error of a
    /// determinant: the bound grows by the margin times the sum of the normal's magnitudes, and so by more than the
    /// determinant of a point which is as far as the margin from the plane.
    pub(crate) away: f64,
}

impl<'t> Probe<'t> {
    /// For a triangle within the [range](self#range).
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &'t Triangle) -> Self {
        Self::with_margin(triangle, 0.0)
    }

    /// For a triangle within the [range](self#range), which others come near to that are at most `margin` away.
    #[inline(always)]
    #[must_use]
    pub fn with_margin(triangle: &'t Triangle, margin: f64) -> Self {
        debug_assert!(in_range(triangle), "coordinate out of range");
        Self { triangle, plane: Plane::of(triangle), away: margin * AWAY }
    }

    /// Whether the plane of one of the triangles certainly separates them, by more than the margin. What
    /// [`Probe::overlaps`] asks first, without a margin; nearly every pair ends here.
    #[inline]
    #[must_use]
    pub fn is_apart(&self, b: &Triangle) -> bool {
        self.plane.sides(b, self.away).strictly_one()
            || Plane::of(b).sides(self.triangle, self.away).strictly_one()
    }

    /// [`overlap`] with triangle `b`.
    #[inline]
    #[must_use]
    pub fn overlaps(&self, b: &Triangle, exact_calls: &mut u64) -> bool {
        debug_assert!(in_range(b), "coordinate out of range");
        let b_sides = self.plane.sides(b, 0.0);
        if b_sides.strictly_one() {
            return false;
        }
        let a_sides = Plane::of(b).sides(self.triangle, 0.0);
        if a_sides.strictly_one() {
            return false;
        }
        let mut signs = Signs { exact: false };
        let verdict = crossing(self.triangle, b, &a_sides, &b_sides, &mut signs);
        *exact_calls += u64::from(signs.exact);
        verdict
    }
}

/// Whether a triangle has no area: its vertices lie on one line, or coincide. Exact, for coordinates within
/// the [range](self#range).
#[must_use]
pub fn is_degenerate(t: &Triangle) -> bool {
    flat::has_no_area(t, &mut Signs { exact: false })
}

/// Whether every coordinate is zero or has a magnitude that the error analysis covers.
fn in_range(t: &Triangle) -> bool {
    t.as_flattened().iter().all(|x| *x == 0.0 || (MIN_COORDINATE..=MAX_MOVED).contains(&x.abs()))
}

/// A triangle's plane: what the determinants of all points against it have in common.
#[derive(Debug)]
pub(crate) struct Plane {
    pub(crate) origin: [f64; 3],
    /// The 2 by 2 minors of the two edges at `origin`: the cross product.
    pub(crate) normal: [f64; 3],
    /// The same with absolute values, for the error bound.
    pub(crate) magnitude: [f64; 3],
}

impl Plane {
    #[inline(always)]
    fn of([origin, p, q]: &Triangle) -> Self {
        let (u, v) = (difference(p, origin), difference(q, origin));
        let (mut normal, mut magnitude) = ([0.0; 3], [0.0; 3]);
        for (axis, (i, j)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
            let (plus, minus) = (u[i] * v[j], u[j] * v[i]);
            normal[axis] = plus - minus;
            magnitude[axis] = plus.abs() + minus.abs();
        }
        Self { origin: *origin, normal, magnitude }
    }

    /// `normal . (p - origin)`, positive above the plane, and a bound on its error, for points `away` farther.
    #[inline(always)]
    fn side(&self, p: &[f64; 3], away: f64) -> (f64, f64) {
        let w = difference(p, &self.origin);
        let [nx, ny, nz] = self.normal;
        let [mx, my, mz] = self.magnitude;
        let determinant = nx * w[0] + ny * w[1] + nz * w[2];
        let permanent = mx * (w[0].abs() + away) + my * (w[1].abs() + away) + mz * (w[2].abs() + away);
        (determinant, DETERMINANT_ERROR * permanent)
    }

    #[inline(always)]
    fn sides(&self, points: &Triangle, away: f64) -> Sides {
        let (mut determinant, mut bound) = ([0.0; 3], [0.0; 3]);
        for (i, p) in points.iter().enumerate() {
            (determinant[i], bound[i]) = self.side(p, away);
        }
        Sides { determinant, bound }
    }
}

/// The determinants of three points against one plane, and how far off each may be.
struct Sides {
    determinant: [f64; 3],
    bound: [f64; 3],
}

impl Sides {
    /// Whether all three points are certainly on the same side, and off the plane.
    #[inline(always)]
    fn strictly_one(&self) -> bool {
        let ([d, e, f], [p, q, r]) = (self.determinant, self.bound);
        ((d > p) & (e > q) & (f > r)) | ((-d > p) & (-e > q) & (-f > r))
    }
}

/// Exact signs: -1, 0 or 1. Remembers whether any of them needed integers.
struct Signs {
    exact: bool,
}

impl Signs {
    /// The side of `p` of the plane of `t`, positive where `t` is seen counterclockwise.
    #[inline]
    fn side(&mut self, t: &Triangle, p: &[f64; 3]) -> i8 {
        let (determinant, bound) = Plane::of(t).side(p, 0.0);
        self.refine(determinant, bound, t, p)
    }

    /// The sides of all three `points`, from the filter's result where that decides.
    #[inline]
    fn sides(&mut self, filtered: &Sides, t: &Triangle, points: &Triangle) -> [i8; 3] {
        core::array::from_fn(|i| self.refine(filtered.determinant[i], filtered.bound[i], t, &points[i]))
    }

    #[inline]
    fn refine(&mut self, determinant: f64, bound: f64, t: &Triangle, p: &[f64; 3]) -> i8 {
        if determinant.abs() > bound {
            return if determinant > 0.0 { 1 } else { -1 };
        }
        // Nothing underflows, so a vanishing permanent means that each product has a factor that is exactly
        // zero.
        if bound == 0.0 || t.contains(p) {
            return 0;
        }
        self.exact_side(t, p)
    }

    #[cold]
    fn exact_side(&mut self, t: &Triangle, p: &[f64; 3]) -> i8 {
        self.exact = true;
        determinant::side(t, p)
    }
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

/// The rest of the test, for a pair that the plane filter did not separate.
#[inline(never)]
fn crossing(a: &Triangle, b: &Triangle, a_sides: &Sides, b_sides: &Sides, signs: &mut Signs) -> bool {
    if boxes_apart(a, b) {
        return false;
    }
    let b_signs = signs.sides(b_sides, a, b);
    if separated(b_signs) {
        return false;
    }
    let a_signs = signs.sides(a_sides, b, a);
    if separated(a_signs) {
        return false;
    }
    // A sign off zero proves that the plane it belongs to is one. Both planes then cross in a line.
    if a_signs == [0; 3] || b_signs == [0; 3] {
        return flat::overlap(a, b, a_signs, b_signs, signs);
    }
    interval::meet(&Wedge::new(a, a_signs), &Wedge::new(b, b_signs), signs)
}

/// Comparisons only, so exact; it spares neighbours in one plane the integers.
fn boxes_apart(a: &Triangle, b: &Triangle) -> bool {
    let least = |x: f64, y: f64| if x < y { x } else { y };
    let greatest = |x: f64, y: f64| if x > y { x } else { y };
    let mut apart = false;
    // No branch on an axis: none of them is foreseen.
    for axis in 0..3 {
        let low = |t: &Triangle| least(least(t[0][axis], t[1][axis]), t[2][axis]);
        let high = |t: &Triangle| greatest(greatest(t[0][axis], t[1][axis]), t[2][axis]);
        apart |= (low(a) > high(b)) | (low(b) > high(a));
    }
    apart
}

fn separated(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}
