//! On which side of a triangle's plane a point lies: a filter in plain `f64`, and the exact sign.

use crate::exact::determinant;
use crate::range::Point;
use crate::vector::difference;

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

/// Half a unit in the last place of 1: 2^-53.
pub(crate) const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;

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
    pub(super) fn of([origin, p, q]: &Triangle) -> Self {
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
    pub(super) fn side(&self, p: &[f64; 3], away: f64) -> (f64, f64) {
        let w = difference(p, &self.origin);
        let [nx, ny, nz] = self.normal;
        let [mx, my, mz] = self.magnitude;
        let determinant = nx * w[0] + ny * w[1] + nz * w[2];
        let permanent = mx * (w[0].abs() + away) + my * (w[1].abs() + away) + mz * (w[2].abs() + away);
        (determinant, DETERMINANT_ERROR * permanent)
    }

    #[inline(always)]
    pub(super) fn sides(&self, points: &Triangle, away: f64) -> Sides {
        let (mut determinant, mut bound) = ([0.0; 3], [0.0; 3]);
        for (i, p) in points.iter().enumerate() {
            (determinant[i], bound[i]) = self.side(p, away);
        }
        Sides { determinant, bound }
    }
}

/// The determinants of three points against one plane, with their error bounds.
pub(super) struct Sides {
    determinant: [f64; 3],
    bound: [f64; 3],
}

impl Sides {
    /// Whether all three points are certainly on the same side, and off the plane.
    #[inline(always)]
    pub(super) fn strictly_one(&self) -> bool {
        let ([d, e, f], [p, q, r]) = (self.determinant, self.bound);
        ((d > p) & (e > q) & (f > r)) | ((-d > p) & (-e > q) & (-f > r))
    }
}

/// Computes exact signs: -1, 0 or 1. Records whether any of them needed integers.
pub(super) struct Signs {
    pub(super) exact: bool,
}

impl Signs {
    /// The side of the plane of `t` on which `p` lies: positive where `t` appears counterclockwise.
    #[inline]
    pub(super) fn side(&mut self, t: &Triangle, p: &[f64; 3]) -> i8 {
        let (determinant, bound) = Plane::of(t).side(p, 0.0);
        self.refine(determinant, bound, t, p)
    }

    /// The sides of all three `points`, from the filter's result where that decides.
    #[inline]
    pub(super) fn sides(&mut self, filtered: &Sides, t: &Triangle, points: &Triangle) -> [i8; 3] {
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
    pub(super) fn exact_side(&mut self, t: &Triangle, p: &[f64; 3]) -> i8 {
        self.exact = true;
        determinant::side(t, p)
    }
}

pub(super) fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

pub(super) fn separated(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}
