//! Distances of rows of points from simple shapes, in closed form.
//!
//! The points of a row share x and y. Loops over them that call no library become vectors of two or more numbers on
//! every machine, with the same bits: no operation is fused.
//!
//! **Error.** Let u = 2^-53. S is the distance of the point from the shape's centre, plus its distance from the origin,
//! plus the reach of the shape's core. A coordinate along a unit axis is off by less than 8u S: a difference, three
//! products, two sums, and the axis. Squares, sums and the root add less than 8u S. If the axes of a cuboid are
//! perpendicular only within s, its points move by less than 4s S. [`RowShape::error`] allows (2^-47 + 8s) S.

use crate::exact::power_of_two;
use crate::primitive::shape::{Core, Shape};
use crate::range::Point;
use crate::vector::{difference, dot, length};

/// A sphere, capsule, cuboid or cylinder.
#[derive(Copy, Clone, Debug)]
pub(super) struct RowShape {
    core: RowCore,
    centre: Point,
    radius: f64,
    /// The greatest distance of a point of the core from the centre.
    reach: f64,
    /// Error relative to S.
    error: f64,
}

/// Axes have unit length.
#[derive(Copy, Clone, Debug)]
enum RowCore {
    Point,
    Segment { axis: Point, half: f64 },
    Cuboid { axes: [Point; 3], half: Point },
    Cylinder { axis: Point, half: f64, radius: f64 },
}

impl RowShape {
    /// `None` for other shapes, and for those whose lengths have no squares.
    pub(super) fn new(shape: &Shape) -> Option<Self> {
        let unit = |v: &Point| {
            let length = length(v);
            (1e-100..1e100).contains(&length).then(|| (v.map(|x| x / length), length))
        };
        let mut skew = 0.0_f64;
        let (core, centre, reach) = match shape.core() {
            Core::Point(p) => (RowCore::Point, *p, 0.0),
            Core::Segment([p, q]) => {
                let (axis, length) = unit(&difference(q, p))?;
                let half = 0.5 * length;
                (RowCore::Segment { axis, half }, [0, 1, 2].map(|i| p[i] + half * axis[i]), half)
            }
            Core::Cuboid { centre, half } => {
                let [a, b, c] = [unit(&half[0])?, unit(&half[1])?, unit(&half[2])?];
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    skew = skew.max(dot(&p.0, &q.0).abs());
                }
                let half = [a.1, b.1, c.1];
                (RowCore::Cuboid { axes: [a.0, b.0, c.0], half }, *centre, 1.01 * length(&half))
            }
            Core::Cylinder { centre, half_axis, radius } => {
                let (axis, half) = unit(half_axis)?;
                (RowCore::Cylinder { axis, half, radius: *radius }, *centre, length(&[half, *radius, 0.0]))
            }
            _ => return None,
        };
        let error = power_of_two(-47) + 8.0 * skew;
        Some(Self { core, centre, radius: shape.radius(), reach, error })
    }

    /// Bound of the error of a distance, at points at most so far from `p`.
    pub(super) fn error(&self, p: &Point, away: f64) -> f64 {
        let size = length(&difference(p, &self.centre)) + length(p) + away + self.reach;
        self.error * size + power_of_two(-52) * self.radius
    }

    /// The distance of each point `from + (0, 0, i step)`, where it is less than the one given.
    pub(super) fn lessen(&self, from: &Point, step: f64, distances: &mut [f64]) {
        let w = difference(from, &self.centre);
        match self.core {
            RowCore::Point => {
                let beside = w[0] * w[0] + w[1] * w[1];
                self.lessen_by(w[2], step, distances, |z| beside + z * z);
            }
            RowCore::Segment { axis, half } => {
                let beside = w[0] * axis[0] + w[1] * axis[1];
                self.lessen_by(w[2], step, distances, |z| {
                    let along = (beside + z * axis[2]).clamp(-half, half);
                    let off = [w[0] - along * axis[0], w[1] - along * axis[1], z - along * axis[2]];
                    dot(&off, &off)
                });
            }
            RowCore::Cuboid { axes, half } => {
                let beside = axes.map(|axis| w[0] * axis[0] + w[1] * axis[1]);
                self.lessen_by(w[2], step, distances, |z| {
                    let out = |i: usize| ((beside[i] + z * axes[i][2]).abs() - half[i]).max(0.0);
                    let out = [out(0), out(1), out(2)];
                    dot(&out, &out)
                });
            }
            RowCore::Cylinder { axis, half, radius } => {
                let beside = w[0] * axis[0] + w[1] * axis[1];
                self.lessen_by(w[2], step, distances, |z| {
                    let along = beside + z * axis[2];
                    let off = [w[0] - along * axis[0], w[1] - along * axis[1], z - along * axis[2]];
                    let round = (dot(&off, &off).sqrt() - radius).max(0.0);
                    let flat = (along.abs() - half).max(0.0);
                    round * round + flat * flat
                });
            }
        }
    }

    /// [`Self::lessen`] by the square of the distance from the core, at an offset along z from the centre.
    #[inline(always)]
    fn lessen_by(&self, first: f64, step: f64, distances: &mut [f64], square: impl Fn(f64) -> f64) {
        for (i, distance) in distances.iter_mut().enumerate() {
            let found = (square(first + step * i as f64).sqrt() - self.radius).max(0.0);
            *distance = if found < *distance { found } else { *distance };
        }
    }
}
