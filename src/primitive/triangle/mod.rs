//! Exact test of whether two closed triangles meet.
//!
//! The result depends only on the signs of determinants of the given coordinates. Each sign is first computed in plain
//! `f64` with a bound on its rounding error. Only if the bound does not decide is the determinant evaluated in
//! integers. So the verdict is correct for the given coordinates.
//!
//! 1. *Plane sides.* If the three vertices of one triangle lie strictly on one side of the other's plane, the triangles
//!    are disjoint. Nearly every pair ends here.
//! 2. *Intervals.* Otherwise each triangle cuts an interval out of the line shared by the two planes, and two more
//!    determinants compare the interval ends without constructing them (Devillers & Guigue, *Faster triangle-triangle
//!    intersection tests*, INRIA RR-4488, 2002).
//! 3. *Flat cases.* A separate module tests coplanar pairs, and triangles that are a segment or a point.
//!
//! # Range
//!
//! Every coordinate must be zero or have a magnitude in [`MIN_COORDINATE`] `..=` [`MAX_MOVED`]. The upper limit is four
//! times that of a body's own coordinates, since poses move them; poses flush smaller coordinates to zero. Then nothing
//! under- or overflows, as the error analysis assumes. Each coordinate is a multiple of 2^-302, the last place of
//! [`MIN_COORDINATE`]; so is each difference of two and its rounding error; so a product of three of them is a multiple
//! of 2^-906 and not subnormal. A difference is at most 2^303, so a sum of six products of three is below 2^912. The
//! exact integers have room for all of this.

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

/// Three vertices, in any unit of length, in any order. Vertices may coincide or be collinear.
pub type Triangle = [Point; 3];

/// Relative error bound of a 3 by 3 determinant of coordinate differences, in units of its permanent (the same sum with
/// absolute values, itself rounded).
///
/// This is `o3derrboundA` of Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates*, 1997, section 4.3. His proof applies because the expression has the same shape: nine rounded
/// differences, three 2 by 2 minors, each multiplied by a difference, summed from left to right. Here the cofactors are
/// taken along the tested point's row instead of a column, which only renames the entries.
pub(crate) const DETERMINANT_ERROR: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// [`Probe::away`] for a margin of 1, with an allowance that exceeds the roundings of the permanent and of the normal.
const AWAY: f64 = (1.0 + power_of_two(-40)) / DETERMINANT_ERROR;

/// Half a unit in the last place of 1: 2^-53.
pub(crate) const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;

/// Whether two closed triangles have a point in common. Touching triangles meet.
///
/// Exact for the given coordinates, whatever the shape: coplanar pairs, needles, points, shared vertices. The result
/// does not depend on the order of the triangles or of their vertices.
///
/// Adds 1 to `exact_calls` if floating point could not decide some sign, so that integers were needed.
///
/// The coordinates must be within the [range](self#range). Outside it, and for NaN, the result may be wrong.
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

/// A triangle to test against many others, with its plane computed once.
#[derive(Debug)]
pub struct Probe<'t> {
    pub(crate) triangle: &'t Triangle,
    pub(crate) plane: Plane,
    /// [`Probe::is_apart`] adds this to the magnitude of each coordinate of a point, relative to a plane, in the error
    /// bound of a determinant. The bound so grows by the margin times the sum of the normal's magnitudes, and hence by
    /// more than the determinant of a point at the distance `margin` from the plane.
    pub(crate) away: f64,
}

impl<'t> Probe<'t> {
    /// For a triangle within the [range](self#range).
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &'t Triangle) -> Self {
        Self::with_margin(triangle, 0.0)
    }

    /// For a triangle within the [range](self#range), and others that count as near within `margin`.
    #[inline(always)]
    #[must_use]
    pub fn with_margin(triangle: &'t Triangle, margin: f64) -> Self {
        debug_assert!(in_range(triangle), "coordinate out of range");
        Self { triangle, plane: Plane::of(triangle), away: margin * AWAY }
    }

    /// Whether the plane of one of the triangles certainly separates them by more than the margin. [`Probe::overlaps`]
    /// starts with this test, without a margin; nearly every pair ends here.
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

/// Whether a triangle has no area: its vertices are collinear or coincide. Exact, for coordinates within the
/// [range](self#range).
#[must_use]
pub fn is_degenerate(t: &Triangle) -> bool {
    flat::has_no_area(t, &mut Signs { exact: false })
}

/// Whether every coordinate is zero or has a magnitude that the error analysis covers.
fn in_range(t: &Triangle) -> bool {
    t.as_flattened().iter().all(|x| *x == 0.0 || (MIN_COORDINATE..=MAX_MOVED).contains(&x.abs()))
}

/// A triangle's plane: the part of the determinants that all points have in common.
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

    /// `normal . (p - origin)`, positive above the plane, and a bound on its error, widened by `away`.
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

/// The determinants of three points against one plane, with their error bounds.
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

/// Computes exact signs: -1, 0 or 1. Records whether any of them needed integers.
struct Signs {
    exact: bool,
}

impl Signs {
    /// The side of the plane of `t` on which `p` lies: positive where `t` appears counterclockwise.
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
        // Nothing underflows, so if the permanent vanishes, each product has a factor that is exactly zero.
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
    // A nonzero sign proves that the plane it refers to is well-defined. Two such planes cross in a line.
    if a_signs == [0; 3] || b_signs == [0; 3] {
        return flat::overlap(a, b, a_signs, b_signs, signs);
    }
    interval::meet(&Wedge::new(a, a_signs), &Wedge::new(b, b_signs), signs)
}

/// Comparisons only, so exact. Saves the integer arithmetic for coplanar neighbours.
fn boxes_apart(a: &Triangle, b: &Triangle) -> bool {
    let least = |x: f64, y: f64| if x < y { x } else { y };
    let greatest = |x: f64, y: f64| if x > y { x } else { y };
    let mut apart = false;
    // No branch per axis: it would be unpredictable.
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
