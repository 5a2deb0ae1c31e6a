//! The size of a body, and its bounding box in the world.
//! A point p of a body, at most h from the centre c of its frame along each axis, stands at `R c + t + R (p - c)`.
//! Along axis i this is at most `sum abs(R_ij) h_j` from where c stands. Spheres keep their radius, though R may
//! shorten vectors by up to 1.5e-4 of their length. The sums are in `f64`, with a dozen roundings of 2^-53 of the
//! coordinates, which 2^-40 of the coordinates covers. The boxes are `f32`, rounded outwards.

use super::body::{Body, BodyTree};
use crate::exact::power_of_two;
use crate::motion::CarriedBall;
use crate::node::{Box3, Dop};
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::primitive::shape::{Core, hull_of};
use crate::range::Point;
use crate::vector::{difference, length};

/// Rounding allowance, relative to the coordinates.
const ROUNDING: f64 = power_of_two(-40);
/// Allowance for how much an accepted matrix may shorten vectors, relative to a body's size.
const SKEW: f64 = power_of_two(-12);

/// Half the width of a half-space: beyond all bodies, with room for products.
const UNBOUNDED: f64 = power_of_two(900);

/// A body's size in its own frame, from which its box in the world follows.
#[derive(Copy, Clone, Debug)]
pub(super) struct BodySize {
    /// Centre of the tree's frame.
    centre: Point,
    /// Half widths about the centre; negative for a body without primitives.
    half: Point,
    /// Upper bound of the distance of any point from the centre.
    radius: f64,
    /// The box is widened by this: the body's radius, and the rounding of a body at the origin.
    reach: f64,
    /// Largest absolute coordinate.
    pub(super) max_coordinate: f64,
    /// Upper bound of the radii of the tree's primitives.
    pub(super) greatest_radius: f64,
}

impl BodySize {
    /// The size of an empty slot.
    pub(super) const NOTHING: Self = Self {
        centre: [0.0; 3],
        half: [-1.0; 3],
        radius: 0.0,
        reach: 0.0,
        max_coordinate: 0.0,
        greatest_radius: 0.0,
    };

    pub(super) fn of<N: Dop>(body: &Body<'_, N>) -> Self {
        if body.tree.is_empty() {
            return Self::NOTHING;
        }
        let Some(extent) = body.tree.extent() else {
            let BodyTree::Shape(shape) = &body.tree else { return Self::NOTHING };
            return Self::of_shape(shape, body.radius);
        };
        let [x, y, z] = extent.half_width;
        let least_width = f64::from(x.min(y).min(z)) / extent.frame.scale();
        let unscale = (1.0 + SKEW) / extent.frame.scale();
        Self {
            centre: extent.frame.centre,
            half: extent.half_width.map(|x| f64::from(x) * unscale),
            radius: extent.radius * (1.0 + SKEW),
            // No row of a matrix is longer than 1.0001.
            reach: body.radius + 2.0 * ROUNDING * extent.max_coordinate,
            max_coordinate: extent.max_coordinate,
            greatest_radius: if body.tree.is_round() { least_width } else { 0.0 },
        }
    }

    /// The size of one shape, with a radius around it.
    fn of_shape(shape: &Shape, widened: f64) -> Self {
        if let Core::HalfSpace { offset, .. } = *shape.core() {
            // Its largest coordinate depends on the other body: `AskedPair::new`.
            let max_coordinate = offset.abs() + shape.radius();
            return Self {
                half: [UNBOUNDED; 3],
                radius: UNBOUNDED,
                reach: widened + 2.0 * ROUNDING * max_coordinate,
                max_coordinate,
                ..Self::NOTHING
            };
        }
        let (corners, radius) = hull_of(shape);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in corners.clone() {
            for i in 0..3 {
                (low[i], high[i]) = (low[i].min(p[i] - radius), high[i].max(p[i] + radius));
            }
        }
        let centre = [0, 1, 2].map(|i| 0.5 * low[i] + 0.5 * high[i]);
        let size = low.into_iter().chain(high).fold(0.0, |most: f64, x| most.max(x.abs()));
        let farthest = corners.map(|p| length(&difference(&p, &centre))).fold(0.0, f64::max) + radius;
        let rounding = ROUNDING * size;
        Self {
            centre,
            half: [0, 1, 2].map(|i| (high[i] - low[i]) * (0.5 * (1.0 + SKEW)) + rounding),
            radius: farthest * (1.0 + SKEW) + rounding,
            reach: widened + 2.0 * rounding,
            max_coordinate: size * (1.0 + ROUNDING),
            greatest_radius: farthest + rounding,
        }
    }

    /// The ball around the body's primitives in the world.
    #[inline]
    pub(super) fn ball(&self, world: &Pose) -> CarriedBall {
        CarriedBall { centre: world.unflushed(&self.centre), radius: self.radius }
    }

    /// Upper bound of the distance of any point of the body from the centre, its radius included.
    pub(super) fn whole_reach(&self) -> f64 {
        self.radius + self.reach
    }

    /// The box around the body in the world. Empty if the body has no primitives.
    #[inline]
    pub(super) fn bounds(&self, world: &Pose) -> Box3 {
        if self.half[0] < 0.0 {
            return Box3::EMPTY;
        }
        let (m, t, centre, half) =
            (world.rows(), world.translation(), world.unflushed(&self.centre), &self.half);
        let mut around = Box3::EMPTY;
        for i in 0..3 {
            let side = (m[i][0].abs() * half[0] + m[i][1].abs() * half[1]) + m[i][2].abs() * half[2];
            let side = side + (self.reach + ROUNDING * t[i].abs());
            (around.lower[i], around.upper[i]) = (below(centre[i] - side), -below(-centre[i] - side));
        }
        around
    }
}

/// Whether the oriented boxes of two bodies are certainly more than `margin` apart along one of the axes of either. A
/// direction of length at most 1.0001 separates the bodies if the gap of their projections is large enough. The axes of
/// a body are perpendicular up to the tolerance of a scene's poses; 2^-14 of the widths covers the rest.
#[inline]
pub(super) fn are_turned_boxes_apart(
    (a, world_a): (&BodySize, &Pose),
    (b, world_b): (&BodySize, &Pose),
    margin: f64,
) -> bool {
    let (m, n) = (world_a.rows(), world_b.rows());
    let (s, t) = (world_a.translation(), world_b.translation());
    let (centre_a, centre_b) = (world_a.unflushed(&a.centre), world_b.unflushed(&b.centre));
    let mut d = [0.0; 3];
    let mut coordinates = 0.0;
    for i in 0..3 {
        d[i] = centre_b[i] - centre_a[i];
        coordinates += s[i].abs() + t[i].abs();
    }
    let widths = ((a.half[0] + a.half[1]) + a.half[2]) + ((b.half[0] + b.half[1]) + b.half[2]);
    let reach = (margin + (a.reach + b.reach)) + (ROUNDING * coordinates + power_of_two(-14) * widths);
    let reach = reach * (1.0 + SKEW);
    let mut cosines = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            cosines[i][j] = ((m[0][i] * n[0][j] + m[1][i] * n[1][j]) + m[2][i] * n[2][j]).abs();
        }
    }
    let mut apart = false;
    for i in 0..3 {
        let along_a = ((m[0][i] * d[0] + m[1][i] * d[1]) + m[2][i] * d[2]).abs();
        let turned = (cosines[i][0] * b.half[0] + cosines[i][1] * b.half[1]) + cosines[i][2] * b.half[2];
        let along_b = ((n[0][i] * d[0] + n[1][i] * d[1]) + n[2][i] * d[2]).abs();
        let other = (cosines[0][i] * a.half[0] + cosines[1][i] * a.half[1]) + cosines[2][i] * a.half[2];
        apart |= (along_a > (a.half[i] + turned) + reach) | (along_b > (b.half[i] + other) + reach);
    }
    apart
}

/// A smaller number in `f32`, or -infinity.
#[inline(always)]
fn below(x: f64) -> f32 {
    const MOST: f64 = 0.5 * f32::MAX as f64;
    let x = if x < MOST { x } else { MOST };
    (x - (x.abs() * power_of_two(-23) + power_of_two(-140))) as f32
}

/// A box around all points within `margin` of `of`.
#[inline(always)]
pub(super) fn widened(of: &Box3, margin: f64) -> Box3 {
    let ([x, y, z], [p, q, r]) = (of.lower, of.upper);
    let lower = |x: f32| below(f64::from(x) - margin);
    let upper = |x: f32| -below(-f64::from(x) - margin);
    Box3 { lower: [lower(x), lower(y), lower(z)], upper: [upper(p), upper(q), upper(r)] }
}
