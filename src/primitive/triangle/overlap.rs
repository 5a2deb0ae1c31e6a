//! The test of two triangles, from the plane filter to the intervals.

use super::flat;
use super::interval::{self, Wedge};
use super::sides::{DETERMINANT_ERROR, Plane, Sides, Signs, Triangle, separated};
use crate::exact::power_of_two;
use crate::range::{MAX_MOVED, MIN_COORDINATE};

/// [`Probe::away`] for a margin of 1, with an allowance that exceeds the roundings of the permanent and of the normal.
const AWAY: f64 = (1.0 + power_of_two(-40)) / DETERMINANT_ERROR;

/// Whether two closed triangles have a point in common. Touching triangles meet.
///
/// Exact for the given coordinates, whatever the shape: coplanar pairs, needles, points, shared vertices. The result
/// does not depend on the order of the triangles or of their vertices.
///
/// Adds 1 to `exact_calls` if floating point could not decide some sign, so that integers were needed.
///
/// The coordinates must be within the [range](super#range). Outside it, and for NaN, the result may be wrong.
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
    /// bound of a determinant. So the bound grows by the margin times the sum of the normal's magnitudes, and hence by
    /// more than the determinant of a point at the distance `margin` from the plane.
    pub(crate) away: f64,
}

impl<'t> Probe<'t> {
    /// For a triangle within the [range](super#range).
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &'t Triangle) -> Self {
        Self::with_margin(triangle, 0.0)
    }

    /// For a triangle within the [range](super#range). Others within `margin` count as near.
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
/// [range](super#range).
#[must_use]
pub fn is_degenerate(t: &Triangle) -> bool {
    flat::has_no_area(t, &mut Signs { exact: false })
}

/// Whether every coordinate is zero or has a magnitude that the error analysis covers.
pub(super) fn in_range(t: &Triangle) -> bool {
    t.as_flattened().iter().all(|x| *x == 0.0 || (MIN_COORDINATE..=MAX_MOVED).contains(&x.abs()))
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
